//! The RTL (hw/rtl) against the traces that `texunit trace record` writes: every texel, level, read and miss of every golden
//! trace whose filter it implements, in Verilator and in Icarus (`make -C hw golden`).
//!
//! A simulator that is not installed (Debian: `apt-get install verilator iverilog make g++`) is said to be missing and its test
//! passes, unless `RTL=require` is in the environment, as in CI.

use std::{collections::BTreeSet, env, fs, path::Path, process::Command};

/// The filters of hw/rtl/tex_pkg.sv.
const FILTERS: [&str; 5] = ["point", "bilinear", "nearest-mip", "trilinear", "dipmap"];

/// Golden traces of machines that the RTL is not, with what it lacks.
const REFUSED: [(&str, &str); 3] = [
    ("ellipsoid.dipmap", "machine.texture.layout = morton"),
    ("ellipsoid.point", "machine.cache.policy = fifo"),
    ("floor.trilinear", "machine.cache.line = 16"),
];

const RECORDS: usize = 64;

/// The number before a word.
fn number_before<'a>(said: &'a str, word: &str) -> &'a str {
    let words: Vec<&str> = said.split_whitespace().collect();
    let at = words.iter().position(|found| found.trim_end_matches(',') == word).unwrap_or_else(|| panic!("{said}"));
    words[at - 1]
}

/// Reads and misses of a trace file, counted here from its text.
fn totals(trace: &Path) -> [usize; 2] {
    let text = fs::read_to_string(trace).unwrap();
    let records = text.lines().filter(|line| !line.starts_with("//"));
    records.fold([0; 2], |[reads, misses], record| {
        let mut fields = record.rsplit('_').map(|field| usize::from_str_radix(field, 16).unwrap());
        let (missed, read) = (fields.next().unwrap(), fields.next().unwrap());
        [reads + read, misses + missed]
    })
}

fn replay(simulator: &str, program: &str) {
    let found = Command::new(program).arg("-V").output().is_ok();
    if !found {
        assert_ne!(env::var("RTL").as_deref(), Ok("require"), "{program} is not installed");
        eprintln!("SKIPPED: {program} is not installed (apt-get install {program})");
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // A folder each: the tests run side by side. It stays, so that the next run finds the programs built.
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("rtl-golden-{simulator}"));
    let mut make = Command::new("make");
    make.arg("--no-print-directory").arg("-C").arg(root.join("hw")).arg(format!("golden-{simulator}"));
    make.arg(format!("OUT={}", folder.display())).arg(concat!("TEXUNIT=", env!("CARGO_BIN_EXE_texunit")));
    let output = make.env_remove("MAKEFLAGS").env_remove("CARGO_MAKEFLAGS").output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}\n{}", String::from_utf8_lossy(&output.stderr));
    print!("{said}");

    let mut names = BTreeSet::new();
    for entry in fs::read_dir(root.join("traces")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let Some(name) = name.strip_suffix(".trace") else { continue };
        let Some((_, filter)) = name.split_once('.') else { continue };
        if !FILTERS.contains(&filter) {
            continue;
        }
        let passed = said.lines().find(|line| line.starts_with(&format!("{name} ")) && line.contains("PASS"));
        let passed = passed.unwrap_or_else(|| panic!("{name} was not replayed:\n{said}"));
        assert!(passed.contains(simulator), "{passed}");
        assert_eq!(number_before(passed, "responses"), (2 * RECORDS).to_string(), "{passed}");
        let refused = REFUSED.iter().find(|(refused, _)| *refused == name);
        assert_eq!(refused.is_some(), passed.contains("NEAREST"), "{passed}");
        let replayed = match refused {
            Some((_, why)) => {
                let line = said.lines().find(|line| line.starts_with(&format!("{name} REFUSED"))).unwrap();
                assert!(line.contains(why), "{line}");
                folder.join(format!("golden/{name}.nearest.trace"))
            }
            None => root.join(format!("traces/{name}.trace")),
        };
        let [reads, misses] = totals(&replayed);
        assert_eq!(number_before(passed, "reads"), (2 * reads).to_string(), "{passed}");
        assert_eq!(number_before(passed, "misses"), (2 * misses).to_string(), "{passed}");
        names.insert(name.to_owned());
    }
    assert_eq!(names.len(), 3 * FILTERS.len(), "{names:?}");
}

#[test]
fn verilator_answers_and_misses_as_every_golden_trace_says() {
    replay("verilator", "verilator");
}

#[test]
fn icarus_answers_and_misses_as_every_golden_trace_says() {
    replay("icarus", "iverilog");
}
