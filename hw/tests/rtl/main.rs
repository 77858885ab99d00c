//! The RTL twin (hw/rtl) against the Rust units: generated files and golden traces are up to date, and Verilator and Icarus replay
//! the traces without a difference. Simulations are child processes of `make -C hw`; the same commands work by hand (hw/README.md).
//!
//! `TEXUNIT_BLESS=1` writes the generated files and traces instead of comparing them.

mod clocks;
mod lines;
mod package;
mod trace;
mod vectors;
mod whole;

use std::{env, fs, path::PathBuf, process::Command};

use texunit_hw::{Rounding, Sampler, datapath::lerp, lod::raw_level};

use clocks::Machine;
use package::Profile;
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

fn machine() -> Machine {
    Machine { fifo: profile().fragment_fifo as usize, latency: LATENCY }
}

/// The whole-unit traces: name, widths, sets, ways, textures and requests of each.
fn whole_units() -> Vec<(&'static str, Sampler, u64, usize, usize, usize)> {
    let profile = profile();
    let (sets, ways) = (profile.sets, profile.ways as usize);
    let widths = Sampler::default();
    vec![
        ("unit", widths, sets, ways, 30, 40),
        ("unit-small", Sampler { filter_bits: 6, lod_bits: 4, rounding: Rounding::StagedRound, ..widths }, 4, 2, 20, 40),
    ]
}

#[test]
fn the_package_and_the_log2_table_are_those_of_the_default_machine() {
    keep("hw/rtl/tex_pkg.sv", &package::package(&profile()));
    keep("hw/rtl/log2_table.sv", &package::log2_table());
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
    for (rounding, name) in ROUNDINGS.into_iter().zip(["datapath", "datapath-staged-round", "datapath-staged-truncate"]) {
        write(name, vectors::datapath(8, rounding));
    }
    write("datapath-bits4", vectors::datapath(4, Rounding::Once));
    write("datapath-bits6", vectors::datapath(6, Rounding::Once));
    for (name, widths, sets, ways, textures, requests) in whole_units() {
        write(name, whole::unit(&widths, sets, ways, textures, requests, machine()).0);
    }
}
