//! The quick half of every proof, and broken chips that the proofs must catch.

use std::{process::Command, sync::atomic::AtomicBool};

use texunit::prove::{Bound, Built, Chip, Tally, Work, proofs};
use texunit_hw::{
    AddressMode, Footprint, I12F20, Log2, Request, Response, Rounding, Unit,
    address::AddressUnit,
    coordinate::{Converted, from_f32_bits},
    lod::{LevelRange, raw_level},
};

fn prove<C: Chip>(chip: &C, name: &str) -> Tally {
    let stop = AtomicBool::new(false);
    let work = Work { quick: true, bar: indicatif::ProgressBar::hidden(), stop: &stop };
    let proof = proofs::<C>().into_iter().find(|proof| proof.name == name).unwrap_or_else(|| panic!("no proof {name}"));
    proof.run(chip, &work).unwrap()
}

/// A mismatch is found, and told where.
fn caught<C: Chip>(chip: &C, name: &str, told: &str) {
    let tally = prove(chip, name);
    let first = tally.first.expect("the first mismatch is told");
    assert!(tally.mismatches > 0 && tally.mismatches <= tally.compared);
    assert!(first.contains(told), "{first}");
}

#[test]
fn the_chip_passes_the_quick_half_of_every_proof_whatever_the_number_of_threads() {
    for proof in proofs::<Built>() {
        let tally = prove(&Built, &proof.name);
        assert_eq!((tally.mismatches, &tally.first), (0, &None), "{}", proof.name);
        assert!(tally.compared > 10_000, "{} compares {} inputs only", proof.name, tally.compared);
        if proof.name == "bilinear" {
            let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            assert_eq!(one.install(|| prove(&Built, "bilinear")), tally);
        }
    }
}

#[test]
fn a_stopped_proof_says_nothing() {
    let stop = AtomicBool::new(true);
    let work = Work { quick: true, bar: indicatif::ProgressBar::hidden(), stop: &stop };
    assert!(proofs::<Built>().iter().all(|proof| proof.run(&Built, &work).is_none()));
}

/// Wrong at one mantissa of one exponent: the last before the logarithm reaches 1/128.
struct OneBoundaryLate;

impl Chip for OneBoundaryLate {
    fn raw_level(&self, squared_ratio: u32, log2: Log2) -> i32 {
        let boundary = 0x3F80_0000 + 0x58D8;
        raw_level(if squared_ratio == boundary { boundary - 1 } else { squared_ratio }, log2)
    }
}

#[test]
fn one_mantissa_on_the_wrong_side_of_a_boundary_is_caught() {
    caught(&OneBoundaryLate, "lod-exact", "0x3F8058D8: 0 instead of 1");
}

/// Herf's ilog2clamp forgets the sign (E5).
struct SignNotMasked;

impl Chip for SignNotMasked {
    fn raw_level(&self, squared_ratio: u32, log2: Log2) -> i32 {
        if squared_ratio >> 31 == 1 { 128 << 7 } else { raw_level(squared_ratio, log2) }
    }
}

#[test]
fn a_sign_that_is_not_masked_is_caught_on_every_rung() {
    for rung in ["lod-exact", "lod-quadratic", "lod-herf", "lod-herf-plain", "lod-ilog2", "lod-table-16", "lod-fourth"]
    {
        caught(&SignNotMasked, rung, "0x8");
    }
}

/// The level fraction is cut off instead of rounded.
struct CutOff;

impl Chip for CutOff {
    fn fractional(&self, range: &LevelRange, raw: i32) -> i32 {
        range.clamp(raw) & !15
    }
}

#[test]
fn a_level_that_is_not_rounded_is_caught() {
    caught(&CutOff, "lod-select", "raw level");
}

/// The weights 255 - f and f (E23).
struct SumsTo255;

impl Chip for SumsTo255 {
    fn lerp(&self, a: u64, b: u64, fraction: u64, bits: u32, half: u64) -> u64 {
        (a * (255 - fraction) + b * fraction + half) >> bits
    }
}

#[test]
fn weights_that_sum_to_255_are_caught() {
    caught(&SumsTo255, "lerp", "/256");
}

/// Right but for what `wrong` makes of it.
struct Datapath(fn(&Request, &mut Response));

impl Chip for Datapath {
    fn answer(&self, unit: &mut Unit<'_>, requests: &[Request], responses: &mut [Response]) {
        Built.answer(unit, requests, responses);
        for (request, response) in requests.iter().zip(responses) {
            (self.0)(request, response);
        }
    }
}

/// Rounds in stages where one rounding is asked for.
struct TwoRoundings;

impl Chip for TwoRoundings {
    fn unit<'a>(&self, bound: &Bound<'a>) -> Unit<'a> {
        let mut bound = *bound;
        if bound.sampler.rounding == Rounding::Once {
            bound.sampler.rounding = Rounding::StagedRound;
        }
        Built.unit(&bound)
    }
}

#[test]
fn a_datapath_that_rounds_twice_or_loses_a_constant_is_caught() {
    caught(&TwoRoundings, "bilinear", "once");
    caught(&TwoRoundings, "trilinear", "once");
    let dims_white = Datapath(|_, response| response.texel[3] = response.texel[3].min(254));
    for proof in ["lerp-unit", "bilinear", "trilinear"] {
        caught(&dims_white, proof, "254");
    }
    let off_at_one_ratio = Datapath(|request, response| {
        if request.scale[0] == 0x4000_0000 {
            response.lod[0] += 1;
        }
    });
    caught(&off_at_one_ratio, "lod-unit", "0x40000000");
}

/// One texel of each plane lies where its neighbour does.
struct SharedByte;

impl Chip for SharedByte {
    fn point(&self, unit: &AddressUnit, plane: usize, u: i64, v: i64) -> Footprint {
        unit.point(plane, if u == 3 << 17 { 1 << 17 } else { u }, v, 1)
    }
}

#[test]
fn two_texels_at_one_address_are_caught_in_every_layout() {
    for layout in ["row-major", "tiled-4x4", "morton", "blocked-4x4-16x16", "williams"] {
        caught(&SharedByte, &format!("address-{layout}"), "texel (1, 0)");
    }
}

/// Truncates towards zero instead of flooring: texel 0 twice as wide (X9).
struct Truncates;

impl Chip for Truncates {
    fn bilinear(&self, unit: &AddressUnit, u: i64, v: i64) -> Footprint {
        unit.bilinear(0, if u < 0 { u + 1 } else { u }, v, 1)
    }
    fn convert(&self, bits: u32, mode: AddressMode) -> Converted {
        let mut converted = from_f32_bits(bits & 0x7FFF_FFFF, mode);
        if bits >> 31 == 1 && !converted.undefined {
            converted.value = I12F20::from_bits(converted.value.to_bits().wrapping_neg());
        }
        converted
    }
}

#[test]
fn truncation_towards_zero_is_caught_in_every_address_mode() {
    for mode in ["wrap", "clamp", "clip", "mirror"] {
        caught(&Truncates, &format!("coordinate-{mode}"), "coordinate -");
    }
    caught(&Truncates, "convert", "instead of");
}

#[test]
fn the_command_prints_a_row_a_proof_and_knows_its_names() {
    let texunit = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_texunit")).arg("prove").args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, rows, _) = texunit(&["--quick", "--only", "lerp"]);
    assert_eq!(code, Some(0));
    let names: Vec<&str> = rows.lines().map(|row| row.split_whitespace().next().unwrap()).collect();
    assert_eq!(names[..3], ["proof", "lerp", "lerp-unit"], "{rows}");
    let (code, json, _) = texunit(&["--quick", "--only", "convert", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((code, &report["mismatches"], &report["finished"]), (Some(0), &0.into(), &true.into()));
    assert_eq!(report["proofs"][0]["proof"], "convert");
    let (code, _, message) = texunit(&["--only", "frobnicate"]);
    assert!(code == Some(2) && message.contains("--list"), "{message}");
    let (code, list, _) = texunit(&["--list"]);
    assert_eq!((code, list.lines().count()), (Some(0), proofs::<Built>().len()));
}
