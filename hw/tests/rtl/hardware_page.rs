//! The table of docs/hardware.md: what an option costs in cells beside what it costs in error.

/// Unit, option, error. Bounds are numerics.md's own arithmetic; 8-bit colour steps ("LSB") and levels.
const ERRORS: &[(&str, &str, &str)] = &[
    ("lod", "exact", "1/512 level"),
    ("lod", "herf", "-0.0469 to 0 level (mean -0.031)"),
    ("lod", "ilog2", "-1 to 0 level"),
    ("lod", "exact-4-level-bits", "1/512 + 1/32 level"),
    ("datapath", "once-8-bits", "0.5 LSB; fraction: 1.0 LSB an axis"),
    ("datapath", "once-6-bits", "0.5 LSB; fraction: 4.0 LSB an axis"),
    ("datapath", "once-4-bits", "0.5 LSB; fraction: 16 LSB an axis"),
    ("datapath", "staged-round-8-bits", "bilinear 1.00, trilinear 1.35 LSB; fraction: 1.0 LSB an axis"),
    ("datapath", "staged-round-6-bits", "as with 8 bits; fraction: 4.0 LSB an axis"),
    ("datapath", "staged-round-4-bits", "as with 8 bits; fraction: 16 LSB an axis"),
    ("datapath", "staged-truncate-8-bits", "bilinear -1.98, trilinear -2.83 LSB; fraction: 1.0 LSB an axis"),
    ("lerp", "once", "0"),
    ("lerp", "staged-round", "0.5 LSB, mean +0.006"),
    ("lerp", "staged-truncate", "-0.996 LSB, mean -0.485"),
];

const BEGIN: &str = "<!-- generated from hw/syn/area.csv -->\n";
const END: &str = "<!-- end -->\n";

/// The page with its table as the measured areas have it.
pub fn with_table(page: &str, areas: &str) -> String {
    let (before, rest) = page.split_once(BEGIN).expect("the page has a place for the table");
    let (_, after) = rest.split_once(END).expect("the place has an end");
    let mut table = String::from(
        "| unit | option | error at worst | transistors | flops | depth | LUT | CARRY4 | DSP |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    for line in areas.lines().skip(2) {
        let [unit, option, _, numbers @ ..] = &line.split(',').collect::<Vec<_>>()[..] else {
            panic!("a line of the area table: {line}")
        };
        let error = ERRORS.iter().find(|(of, with, _)| of == unit && with == option).map_or("", |(_, _, error)| error);
        table += &format!("| {unit} | {option} | {error} | {} |\n", numbers.join(" | "));
    }
    format!("{before}{BEGIN}{table}{END}{after}")
}
