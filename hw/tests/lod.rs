//! The LOD unit against exact integer arithmetic and against the memo's own words.

use texunit_hw::{
    LevelRounding, Log2, Sampler,
    lod::{LevelRange, ilog2, ilog2clamp, raw_level, trival, trivalsq},
};

/// A natural number in 32-bit limbs, least significant first: enough arithmetic to compare powers exactly.
fn power(base: u64, exponent: u32) -> Vec<u32> {
    let mut product = vec![1u32];
    for _ in 0..exponent {
        let mut carry = 0u64;
        for limb in &mut product {
            let sum = u64::from(*limb) * base + carry;
            *limb = sum as u32;
            carry = sum >> 32;
        }
        while carry > 0 {
            product.push(carry as u32);
            carry >>= 32;
        }
    }
    product
}

fn at_least_power_of_two(number: &[u32], exponent: u32) -> bool {
    let bits = 32 * (number.len() as u32 - 1) + (32 - number.last().unwrap().leading_zeros());
    bits > exponent
}

#[test]
fn exact_log2_is_rounded_to_nearest_for_every_mantissa() {
    // 1.m reaches (k - 1/2)/128 octaves exactly when (2^23 + m)^256 reaches 2^(23*256 + 2k - 1).
    let reaches = |m: u32, k: u32| at_least_power_of_two(&power((1 << 23) + u64::from(m), 256), 23 * 256 + 2 * k - 1);
    let level = |m: u32| raw_level(127 << 23 | m, Log2::Exact) as u32;
    let mut boundaries = Vec::new();
    for m in 1..1u32 << 23 {
        if level(m) != level(m - 1) {
            assert_eq!(level(m), level(m - 1) + 1, "one step at a time, at mantissa {m}");
            boundaries.push(m);
        }
    }
    assert_eq!((level(0), boundaries.len()), (0, 128));
    for (k, &m) in (1..).zip(&boundaries) {
        assert!(reaches(m, k) && !reaches(m - 1, k), "boundary {k} at mantissa {m}");
    }
}

#[test]
fn herf_rung_is_the_memos_exponent_and_fraction_side_by_side() {
    for x in (127u32 << 23..255 << 23).step_by(997) {
        let expected = (ilog2clamp(x) / 2) << 8 | trivalsq(x);
        assert_eq!(raw_level(x, Log2::Herf) as u32, expected, "{}", f32::from_bits(x));
    }
}

/// Every rung, with its least and greatest error against the exact one, in 1/256 level.
const RUNGS: [(Log2, i32, i32); 9] = [
    (Log2::Exact, 0, 0),
    (Log2::Table128, -1, 1),
    (Log2::Table64, -2, 2),
    (Log2::Table16, -5, 6),
    (Log2::Quadratic, -1, 2),
    (Log2::Fourth, -7, 0),
    (Log2::Herf, -12, 0),
    (Log2::HerfPlain, -23, 0),
    (Log2::Ilog2, -256, 0),
];

#[test]
fn every_log2_rung_is_monotone_and_within_its_error_of_the_exact_one() {
    for (log2, least, greatest) in RUNGS {
        let mut last = i32::MIN;
        let mut found = (0, 0);
        for x in (0..=0x7F80_0000u32).step_by(997) {
            let level = raw_level(x, log2);
            assert!(level >= last, "{log2:?} falls at {x:#x}");
            let error = level - raw_level(x, Log2::Exact);
            found = (found.0.min(error), found.1.max(error));
            last = level;
        }
        assert_eq!(found, (least, greatest), "{log2:?}");
    }
}

#[test]
fn the_plain_rung_is_the_memos_exponent_and_fraction_of_the_root() {
    // Squares of numbers with 8 fraction bits have exact roots.
    for significand in 256..512u32 {
        for exponent in [-20, -1, 0, 1, 7, 30] {
            let ratio = significand as f32 * 2f32.powi(exponent - 8);
            let expected = ilog2(ratio.to_bits()) * 256 + trival(ratio.to_bits()) as i32;
            assert_eq!(raw_level((ratio * ratio).to_bits(), Log2::HerfPlain), expected, "{ratio}");
        }
    }
}

#[test]
fn memo_routines_answer_as_printed_including_their_traps() {
    let bits = f32::to_bits;
    assert_eq!([1.0, 1.99, 2.0, 0.5, 0.0].map(|x| ilog2(bits(x))), [0, 0, 1, -1, -127]);
    assert_eq!([1.0, 4.0, 0.5, 0.0, 1e-40].map(|x| ilog2clamp(bits(x))), [0, 2, 0, 0, 0]);
    // E5: the sign bit is not masked, and infinity and NaN give 128.
    assert_eq!(
        [-0.0, -1e-40, -0.5, -1.0, -2.0, -8.0, -16.0, f32::INFINITY, f32::NAN].map(|x| ilog2clamp(bits(x))),
        [129, 129, 255, 0, 0, 2, 4, 128, 128]
    );
    // E6: below 1 the fractions are not zero, though the level is.
    assert_eq!([0.7, 0.0].map(|x| trivalsq(bits(x))), [179, 128]);
    assert_eq!([1.0, 1.5, 3.0].map(|x| trival(bits(x))), [0, 128, 128]);
    for exponent in 0..255u32 {
        let x = exponent << 23;
        assert_eq!(ilog2clamp(x), exponent.saturating_sub(127), "exponent field {exponent}");
    }
}

#[test]
fn special_ratios_have_defined_levels_whatever_the_bias() {
    for bias in [-4096, 0, 4096] {
        let sampler = Sampler { bias, ..Sampler::default() };
        let range = LevelRange::new(&sampler, 8);
        for (log2, ..) in RUNGS {
            let level = |x: f32| range.fractional(raw_level(x.to_bits(), log2));
            for coarsest in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
                assert_eq!(level(coarsest), 8 << 8);
            }
            for finest in [0.0, -0.0, 1e-45, -1e-40] {
                assert_eq!(level(finest), 0);
            }
            assert_eq!(level(-16.0), level(16.0), "the sign is ignored");
        }
    }
}

#[test]
fn levels_beyond_the_chain_have_no_fraction() {
    let range = LevelRange::new(&Sampler::default(), 8);
    assert_eq!(range.fractional(raw_level(90_000.0f32.to_bits(), Log2::Exact)), 8 << 8); // X22: 300 texels a pixel, 8.23
    assert_eq!(range.fractional(-77), 0); // E8: clamped before it is split
}

#[test]
fn fewer_fraction_bits_round_half_up_and_carry_into_the_level() {
    let sampler = Sampler { lod_bits: 2, ..Sampler::default() };
    let range = LevelRange::new(&sampler, 3);
    assert_eq!(
        [31, 32, 95, 96, 223, 224, 767, 768].map(|raw| range.fractional(raw)),
        [0, 64, 64, 128, 192, 256, 768, 768]
    );
    let whole = Sampler { lod_bits: 0, ..Sampler::default() };
    let range = LevelRange::new(&whole, 3);
    for raw in -300..1200 {
        assert_eq!(range.fractional(raw), range.whole(raw, LevelRounding::Nearest) << 8);
    }
}

#[test]
fn level_rounding_rules_differ_only_where_they_should() {
    let range = LevelRange::new(&Sampler::default(), 5);
    let rounded =
        |raw| [LevelRounding::Floor, LevelRounding::Nearest, LevelRounding::Gl].map(|rule| range.whole(raw, rule));
    assert_eq!(rounded(127), [0, 0, 0]);
    assert_eq!(rounded(128), [0, 1, 0]); // X15: exactly one half
    assert_eq!(rounded(129), [0, 1, 1]);
    assert_eq!(rounded(5 << 8), [5, 5, 5]);
    assert_eq!(rounded(9 << 8), [5, 5, 5]);
}
