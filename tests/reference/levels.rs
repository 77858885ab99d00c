//! Levels: the logarithm, bias, limits and roundings.

use texunit::reference::Reference;
use texunit_hw::{AddressMode::Wrap, Filter, LevelRounding, LodSource, Log2, Request, Response, Sampler};

use crate::{answer, sampler, tower};

#[test]
fn trilinear_blends_two_levels_by_the_fraction_of_the_level() {
    let tower = tower();
    let sampler = Sampler { lod_source: LodSource::Explicit, ..Sampler::default() };
    let rows = [
        (0, 0, 0),
        (64, 3, 64), // (0 * 192 + 10 * 64) / 256 = 2.5, half up
        (256, 10, 256),
        (0x3c0, 38, 0x3c0), // 3.75: 37.5, half up
        (16 << 8, 160, 16 << 8),
        (17 << 8, 160, 16 << 8),
        (i32::MAX, 160, 16 << 8),
        (-1, 0, 0),
        (i32::MIN, 0, 0),
    ];
    for (level, expected, lod) in rows {
        let response = answer(&tower, &sampler, &Request { scale: [level as u32, 0], ..Request::default() });
        assert_eq!(response, Response { texel: [expected; 4], lod: [lod; 2] }, "level {level}");
    }
}

#[test]
fn the_log2_units_read_a_squared_ratio() {
    let tower = tower();
    let bits = f32::to_bits;
    // Levels in 1/256 after clamping to 0..=16, by the exact, Herf's and the whole-level unit.
    let rows = [
        (bits(1.0), [0, 0, 0]),
        (bits(1.5), [75, 64, 0]), // 128 log2 1.5 = 74.88
        (bits(2.0), [128, 128, 0]),
        (bits(3.0), [203, 192, 0]),
        (bits(4.0), [256, 256, 256]),
        (bits(8.0), [384, 384, 256]),
        (bits(f32::from_bits(0x407f_ffff)), [256, 255, 0]), // just below 4
        (bits(-8.0), [384, 384, 256]),
        (bits(0.5), [0, 0, 0]),
        (bits(0.0), [0, 0, 0]),
        (bits(-0.0), [0, 0, 0]),
        (1, [0, 0, 0]),
        (bits(f32::MIN_POSITIVE), [0, 0, 0]),
        (bits(f32::MAX), [4096, 4096, 4096]),
        (bits(f32::INFINITY), [4096, 4096, 4096]),
        (bits(f32::NEG_INFINITY), [4096, 4096, 4096]),
        (bits(f32::NAN), [4096, 4096, 4096]),
        (0xffff_ffff, [4096, 4096, 4096]),
    ];
    for (scale, expected) in rows {
        for (log2, expected) in [Log2::Exact, Log2::Herf, Log2::Ilog2].into_iter().zip(expected) {
            let sampler = Sampler { log2, ..Sampler::default() };
            let request = Request { scale: [scale, 0], ..Request::default() };
            assert_eq!(answer(&tower, &sampler, &request).lod, [expected; 2], "{log2:?} of {scale:#x}");
        }
    }
}

#[test]
fn a_bias_reveals_levels_below_the_texture_itself() {
    let tower = tower();
    let lod = |scale: f32, log2, bias| {
        let sampler = Sampler { log2, bias, ..Sampler::default() };
        answer(&tower, &sampler, &Request { scale: [scale.to_bits(); 2], ..Request::default() }).lod[0]
    };
    let eight = 8 << 8;
    assert_eq!(lod(0.5, Log2::Exact, eight), eight as u16 - 128);
    assert_eq!(lod(0.75, Log2::Exact, eight), eight as u16 - 53); // 128 log2 0.75 = -53.12
    assert_eq!(lod(0.75, Log2::Herf, eight), eight as u16 - 64); // -128 + 64
    assert_eq!(lod(0.75, Log2::Ilog2, eight), eight as u16 - 256); // floor(-1 / 2) = -1
    assert_eq!(lod(0.25, Log2::Ilog2, eight), eight as u16 - 256);
    // Zero and infinity lie beyond any bias.
    assert_eq!(lod(0.0, Log2::Exact, 16 << 8), 0);
    assert_eq!(lod(f32::INFINITY, Log2::Exact, -16 << 8), 16 << 8);
}

#[test]
fn levels_are_limited_before_they_are_rounded() {
    let tower = tower();
    let lod = |level: i32, sampler: Sampler| {
        let sampler = Sampler { lod_source: LodSource::Explicit, ..sampler };
        answer(&tower, &sampler, &Request { scale: [level as u32; 2], ..Request::default() }).lod[0]
    };
    let limits = |min_lod, max_lod| Sampler { min_lod, max_lod, ..Sampler::default() };
    assert_eq!(lod(0, limits(300, 600)), 300);
    assert_eq!(lod(4000, limits(300, 600)), 600);
    assert_eq!(lod(450, limits(600, 300)), 300, "the upper bound wins");
    assert_eq!(lod(100, Sampler { bias: -50, ..limits(60, 600) }), 60);
    let bits = |lod_bits| Sampler { lod_bits, ..Sampler::default() };
    for (lod_bits, expected) in [(8, 0x1a7), (7, 0x1a8), (4, 0x1a0), (2, 0x1c0), (1, 0x180), (0, 0x200)] {
        assert_eq!(lod(0x1a7, bits(lod_bits)), expected, "{lod_bits} bits");
    }
    assert_eq!(lod(0xfff, bits(0)), 16 << 8);
    assert_eq!(lod(0x180, bits(0)), 2 << 8, "half up");
    // Rounding may leave the sampler's range, though never the pyramid's.
    assert_eq!(lod(0, Sampler { lod_bits: 0, ..limits(0x180, 0x180) }), 2 << 8);
}

#[test]
fn a_whole_level_is_rounded_by_one_of_three_rules() {
    let tower = tower();
    // Levels in 1/256, answers by floor, nearest and gl.
    let rows = [
        (0x100, [1, 1, 1]),
        (0x17f, [1, 1, 1]),
        (0x180, [1, 2, 1]),
        (0x181, [1, 2, 2]),
        (0x1ff, [1, 2, 2]),
        (0, [0, 0, 0]),
        (0x80, [0, 1, 0]),
        (0xfff, [15, 16, 16]),
        (0x1000, [16, 16, 16]),
    ];
    for (level, expected) in rows {
        let rules = [LevelRounding::Floor, LevelRounding::Nearest, LevelRounding::Gl];
        for (level_rounding, expected) in rules.into_iter().zip(expected) {
            // The fraction's width plays no part.
            for lod_bits in [0, 8] {
                let sampler = Sampler {
                    filter: Filter::NearestMip,
                    lod_source: LodSource::Explicit,
                    level_rounding,
                    lod_bits,
                    ..Sampler::default()
                };
                let response = answer(&tower, &sampler, &Request { scale: [level; 2], ..Request::default() });
                let lod = [u16::from(expected) << 8; 2];
                assert_eq!(response, Response { texel: [10 * expected; 4], lod }, "{level_rounding:?} of {level:#x}");
            }
        }
    }
}

#[test]
fn the_exact_logarithm_changes_at_the_mantissa_where_the_256th_power_does() {
    let tower = tower();
    let reference = Reference::new(&tower, &Sampler::default()).unwrap();
    let lod =
        |mantissa: u32| reference.sample(&Request { scale: [0x3f80_0000 + mantissa; 2], ..Request::default() }).lod[0];
    for k in 1..=128_u32 {
        // 128 log2(s / 2^23) + 1/2 >= k is s^256 >= 2^(23 * 256 + 2k - 1), in integers of any size.
        let reached = |mantissa: u32| bit_length_of_256th_power((1 << 23) + mantissa) > 23 * 256 + 2 * k - 1;
        let first = (0..23).rev().fold(
            0_u32,
            |below, bit| {
                if reached(below + (1 << bit)) { below } else { below + (1 << bit) }
            },
        ) + 1;
        assert_eq!([lod(first - 1), lod(first)], [k as u16 - 1, k as u16], "boundary {k}");
    }
}

fn bit_length_of_256th_power(x: u32) -> u32 {
    let mut power = vec![x];
    for _ in 0..8 {
        let mut square = vec![0_u32; 2 * power.len()];
        for (i, &a) in power.iter().enumerate() {
            let mut carry = 0_u64;
            for (j, &b) in power.iter().enumerate() {
                carry += u64::from(a) * u64::from(b) + u64::from(square[i + j]);
                square[i + j] = carry as u32;
                carry >>= 32;
            }
            square[i + power.len()] = carry as u32;
        }
        while square.last() == Some(&0) {
            square.pop();
        }
        power = square;
    }
    32 * power.len() as u32 - power.last().unwrap().leading_zeros()
}

#[test]
fn filters_without_a_level_report_zero() {
    let tower = tower();
    for filter in [Filter::Point, Filter::Bilinear] {
        let sampler = Sampler { bias: 512, min_lod: 512, ..sampler(filter, Wrap) };
        let request = Request { scale: [f32::INFINITY.to_bits(); 2], ..Request::default() };
        assert_eq!(answer(&tower, &sampler, &request), Response::default(), "{filter:?}");
    }
}
