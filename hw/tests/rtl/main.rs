//! The RTL twin (hw/rtl) against the Rust units: generated files and golden traces are up to date, and Verilator and Icarus replay
//! the traces without a difference. Simulations are child processes of `make -C hw`; the same commands work by hand (hw/README.md).
//!
//! `TEXUNIT_BLESS=1` writes the generated files and traces instead of comparing them.

mod clocks;
mod hardware_page;
mod lines;
mod package;
mod tools;
mod trace;
mod vectors;
mod whole;

use std::{env, fs, path::PathBuf};

use texunit_hw::{Log2, Rounding, Sampler, lod::raw_level};

use clocks::Machine;
use package::Profile;
use tools::{make, program};
use vectors::{LOG2S, ROUNDINGS};

fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().expect("hw lies in the repository").to_owned()
}

/// Compares a committed file with what it should be, or writes it.
fn keep(path: &str, wanted: &str) {
    let path = repository().join(path);
    if env::var_os("TEXUNIT_BLESS").is_some() {
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder to write to");
        return fs::write(&path, wanted).expect("a file to write");
    }
    let found = fs::read_to_string(&path).unwrap_or_default();
    let differs = found.lines().zip(wanted.lines()).position(|(left, right)| left != right);
    assert!(
        found == wanted,
        "{} is out of date (first at line {:?}): TEXUNIT_BLESS=1 cargo test --release -p texunit-hw --test rtl",
        path.display(),
        differs.map(|index| index + 1)
    );
}

fn profile() -> Profile {
    Profile::read(include_str!("../../profiles/herf-12.20.toml"))
}

/// Latency of the memory in the testbenches when they count clocks.
const LATENCY: u64 = 40;

/// A whole-unit trace and the parameters it is replayed with (those of hw/Makefile).
struct WholeUnit {
    name: &'static str,
    widths: Sampler,
    sets: u64,
    ways: usize,
    fragment_fifo: usize,
    textures: usize,
}

impl WholeUnit {
    fn trace(&self, latency: u64) -> (trace::Trace, Vec<whole::Totals>) {
        let machine = Machine { fragment_fifo: self.fragment_fifo, latency };
        whole::unit(&self.widths, self.sets, self.ways, self.textures, machine)
    }
}

/// The default machine, and one so small that its FIFO fills and its lines are thrown out.
fn whole_units() -> [WholeUnit; 2] {
    let Profile { sets, ways, fragment_fifo, .. } = profile();
    let widths = Sampler::default();
    let small = Sampler { filter_bits: 6, lod_bits: 4, rounding: Rounding::StagedRound, ..widths };
    [
        WholeUnit {
            name: "unit",
            widths,
            sets,
            ways: ways as usize,
            fragment_fifo: fragment_fifo as usize,
            textures: 30,
        },
        WholeUnit { name: "unit-small", widths: small, sets: 4, ways: 2, fragment_fifo: 4, textures: 20 },
    ]
}

#[test]
fn the_package_and_the_log2_table_are_those_of_the_default_machine() {
    keep("hw/rtl/tex_pkg.sv", &package::package(&profile()));
    keep("hw/rtl/log2_table.sv", &package::log2_table());
}

#[test]
fn the_hardware_page_shows_the_measured_areas() {
    let read =
        |path: &str| fs::read_to_string(repository().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
    let page = "docs/hardware.md";
    keep(page, &hardware_page::with_table(&read(page), &read("hw/syn/area.csv")));
}

#[test]
fn the_golden_traces_are_those_of_the_rust_units() {
    let write = |name: &str, trace: trace::Trace| keep(&format!("traces/rtl/{name}.trace"), &trace.to_string());
    for (log2, name) in LOG2S.into_iter().zip(["lod", "lod-herf", "lod-ilog2"]) {
        write(name, vectors::lod(log2, 8));
    }
    write("lod-bits4", vectors::lod(LOG2S[0], 4));
    write("coordinate", vectors::coordinates(8));
    write("address", vectors::addresses());
    write("surface", vectors::surfaces());
    write("taps", vectors::taps());
    for ways in [1, 2, 4, 8] {
        write(&format!("cache-ways{ways}"), vectors::cache(4, ways));
    }
    write("fragment_fifo", vectors::fragment_fifo(8));
    write("memory", vectors::memory(8));
    for (rounding, name) in ROUNDINGS.into_iter().zip(["lerp", "lerp-staged-round", "lerp-staged-truncate"]) {
        write(name, vectors::lerps(rounding));
    }
    for (rounding, name) in ROUNDINGS.into_iter().zip(["datapath", "datapath-staged-round", "datapath-staged-truncate"])
    {
        write(name, vectors::datapath(8, rounding));
    }
    write("datapath-bits4", vectors::datapath(4, Rounding::Once));
    write("datapath-bits6", vectors::datapath(6, Rounding::Once));
    for unit in whole_units() {
        write(unit.name, unit.trace(LATENCY).0);
    }
}

/// Every trace must have been replayed to its end: a PASS line each, not just an exit status.
fn all_pass(output: &str) {
    for name in make("names").split_whitespace() {
        let passed = output.lines().any(|line| {
            let mut words = line.split_whitespace();
            words.next() == Some(name) && words.next() == Some("PASS")
        });
        assert!(passed, "no PASS line for {name} in\n{output}");
    }
}

#[test]
#[cfg_attr(not(verilator), ignore = "verilator not installed: apt-get install verilator")]
fn every_unit_is_lint_clean_for_every_option() {
    make("lint");
}

#[test]
#[cfg_attr(not(verilator), ignore = "verilator not installed: apt-get install verilator")]
fn verilator_replays_every_golden_trace_without_a_difference() {
    all_pass(&make("verilator"));
}

#[test]
#[cfg_attr(not(iverilog), ignore = "iverilog not installed: apt-get install iverilog")]
fn icarus_replays_every_golden_trace_without_a_difference() {
    all_pass(&make("icarus"));
}

#[test]
#[cfg_attr(not(verilator), ignore = "verilator not installed: apt-get install verilator")]
fn the_whole_unit_takes_the_clocks_of_its_recurrence_and_of_the_timing_model() {
    make("verilator-unit");
    make("verilator-unit-small");
    for latency in [1, 2, 7, LATENCY, 300] {
        for unit in whole_units() {
            let (name, wanted) = (unit.name, unit.trace(latency).1);
            let output = program(
                &format!("{name}/tb"),
                &[&format!("traces/rtl/{name}.trace"), "--clocks", &latency.to_string()],
            );
            let clocks: Vec<u64> = output
                .lines()
                .filter_map(|line| line.strip_prefix("clocks ")?.split_once(' ')?.1.parse().ok())
                .collect();
            let recurrence: Vec<_> = wanted.iter().map(|totals| totals.recurrence).collect();
            assert_eq!(clocks, recurrence, "{name} with a memory latency of {latency}");
            if latency >= 2 {
                let timing_model: Vec<_> = wanted.iter().map(|totals| totals.timing_model).collect();
                assert_eq!(clocks, timing_model, "the timing model of {name} with a memory latency of {latency}");
            }
        }
    }
}

/// FNV-1a over 64-bit values.
fn digest(values: impl Iterator<Item = u64>) -> u64 {
    values.fold(0xcbf2_9ce4_8422_2325, |digest, value| (digest ^ value).wrapping_mul(0x100_0000_01b3))
}

/// The answers of one block of 2^24 ratios, two to a value as the testbench has them.
fn lod_block(block: u32, log2: Log2) -> u64 {
    let level = |input: u32| u64::from(raw_level(block << 24 | input, log2).cast_unsigned() & 0xffff);
    digest((0..1 << 23).map(|pair| level(2 * pair + 1) << 16 | level(2 * pair)))
}

/// Both sides of the sweep of some blocks, the RTL's in processes of their own.
fn sweep_lod(log2: Log2, blocks: std::ops::RangeInclusive<u32>) {
    let option = LOG2S.iter().position(|other| *other == log2).expect("a rung");
    let halves = [
        (*blocks.start(), (blocks.start() + blocks.end()) / 2),
        ((blocks.start() + blocks.end()) / 2 + 1, *blocks.end()),
    ];
    std::thread::scope(|scope| {
        for (first, last) in halves {
            scope.spawn(move || {
                let path = format!("lod_sweep-{option}/sweep");
                let output = program(&path, &[&first.to_string(), &last.to_string()]);
                let blocks: Vec<_> = output.lines().collect();
                assert_eq!(blocks.len() as u32, last - first + 1, "a line a block");
                for (block, found) in (first..=last).zip(blocks) {
                    assert_eq!(
                        found,
                        format!("{block:02x} {:016x}", lod_block(block, log2)),
                        "{log2:?}, ratios {block:02x}000000 on"
                    );
                }
            });
        }
    });
}

#[test]
#[cfg_attr(not(verilator), ignore = "verilator not installed: apt-get install verilator")]
fn the_lod_unit_answers_ratios_around_one_like_the_rust_unit() {
    make("sweep");
    // Whole exponents on both sides of 1.0, and infinity and NaN; the next test takes all.
    for log2 in LOG2S {
        sweep_lod(log2, 0x3f..=0x40);
        sweep_lod(log2, 0x7f..=0x80);
    }
}

#[test]
#[ignore = "all 2^32 ratios: cargo test --release -p texunit-hw --test rtl -- --ignored all_ratios"]
fn the_lod_unit_answers_all_ratios_like_the_rust_unit() {
    make("sweep");
    sweep_lod(Log2::Exact, 0..=255);
}

#[test]
#[cfg_attr(not(verilator), ignore = "verilator not installed: apt-get install verilator")]
fn the_lerp_answers_all_inputs_like_the_rust_unit() {
    make("sweep");
    for (option, rounding) in ROUNDINGS.into_iter().enumerate() {
        let wanted =
            digest((0..1 << 24).map(|input| vectors::lerp_of(input >> 16, input >> 8 & 255, input & 255, rounding)));
        assert_eq!(
            program(&format!("lerp_sweep-{option}/sweep"), &[]).trim(),
            format!("{wanted:016x}"),
            "{rounding:?}"
        );
    }
}

#[test]
#[cfg_attr(not(yosys), ignore = "yosys not installed: apt-get install yosys")]
fn yosys_proves_what_the_units_promise() {
    let output = make("prove");
    let proved = output.lines().filter(|line| line.starts_with("PASS ")).count();
    assert!(proved >= 21, "{proved} properties proved\n{output}");
}
