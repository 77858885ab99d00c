//! The float reference against numbers worked out by hand from docs/numerics.md, and against its own limit, the ideal.

mod planes;

use planes::{columns, pyramid};
use proptest::prelude::*;
use texunit::{
    pyramid::Pyramid,
    reference::{
        Reference,
        ideal::{Detail, Ideal, IdealSampler},
    },
};
use texunit_hw::{
    AddressMode::{self, Clamp, Clip, Mirror, Wrap},
    Filter, I12F20, LevelRounding, LodSource, Log2, PyramidKind, Request, Response, Rounding, Sampler,
};

const MODES: [AddressMode; 4] = [Wrap, Clamp, Clip, Mirror];
const FILTERS: [Filter; 5] = [Filter::Point, Filter::Bilinear, Filter::NearestMip, Filter::Trilinear, Filter::Dipmap];
const ROUNDINGS: [Rounding; 3] = [Rounding::Once, Rounding::StagedRound, Rounding::StagedTruncate];

/// Floored to 12.20, as section 1.1 has it (`I12F20::from_num` rounds to nearest).
fn at(u: f64, v: f64) -> Request {
    let fixed = |c: f64| I12F20::from_bits((c * 1_048_576.0).floor() as i32);
    Request::at(fixed(u), fixed(v))
}

fn answer(pyramid: &Pyramid, sampler: &Sampler, request: &Request) -> Response {
    Reference::new(pyramid, sampler).unwrap().sample(request)
}

fn red(pyramid: &Pyramid, sampler: &Sampler, request: &Request) -> u8 {
    answer(pyramid, sampler, request).texel[0]
}

fn sampler(filter: Filter, mode: AddressMode) -> Sampler {
    Sampler { filter, address: [mode; 2], ..Sampler::default() }
}

/// A column 65536 texels high, so that levels 0 to 16 can be seen; every texel of level l is 10 l.
fn tower() -> Pyramid {
    pyramid(PyramidKind::Mipmap, 1, 1 << 16, |_, lv, _, _| [10 * lv; 4])
}

#[test]
fn a_point_tap_takes_the_texel_under_the_coordinate() {
    let texture = columns(&[10, 20, 30, 40]);
    let tiny = f64::exp2(-20.0);
    let rows = [
        (0.0, [10, 10, 10, 10]),
        (0.25 - tiny, [10, 10, 10, 10]),
        (0.25, [20, 20, 20, 20]),
        (1.0 - tiny, [40, 40, 40, 40]),
        (1.0, [10, 40, 0, 40]),
        (1.3, [20, 40, 0, 30]),
        (2.0, [10, 40, 0, 10]),
        (-tiny, [40, 10, 0, 10]),
        (-0.3, [30, 10, 0, 20]),
        (-2048.0, [10, 10, 0, 10]),
        (2048.0 - tiny, [40, 40, 0, 10]),
    ];
    for (u, expected) in rows {
        for (mode, expected) in MODES.into_iter().zip(expected) {
            // Along v there is one texel, which only clip leaves.
            assert_eq!(red(&texture, &sampler(Filter::Point, mode), &at(u, 0.5)), expected, "{mode:?} at {u}");
        }
    }
}

#[test]
fn a_bilinear_tap_weighs_the_texels_around_the_coordinate() {
    let texture = columns(&[0, 200]);
    // p = 2u - 1/2: the fraction is that of p.
    let rows = [
        (0.25, [0, 0, 0, 0]),
        (0.5, [100, 100, 100, 100]),
        (0.75, [200, 200, 200, 200]),
        (0.375, [50, 50, 50, 50]),
        (1.0, [100, 200, 100, 200]), // between texel 1 and index 2: texel 0, texel 1, nothing, texel 1
        (0.0, [100, 0, 0, 0]),       // between index -1 and texel 0
        (-0.25, [200, 0, 0, 0]),     // on index -1
        (1.25, [0, 200, 0, 200]),    // on index 2
    ];
    for (u, expected) in rows {
        for (mode, expected) in MODES.into_iter().zip(expected) {
            assert_eq!(red(&texture, &sampler(Filter::Bilinear, mode), &at(u, 0.5)), expected, "{mode:?} at {u}");
        }
    }
}

#[test]
fn the_filter_fraction_is_truncated_to_its_bits() {
    let texture = columns(&[0, 255]);
    // u = 0.25 + 0.31 / 2: the fraction is 0.31.
    let request = at(0.405, 0.5);
    // floor(0.31 * 2^b) * 255 / 2^b, half up: 0; 1/4; 2/8; 4/16; 79/256; 1269/4096.
    for (bits, expected) in [(1, 0), (2, 64), (3, 64), (4, 64), (8, 79), (12, 79)] {
        let sampler = Sampler { filter_bits: bits, ..sampler(Filter::Bilinear, Clamp) };
        assert_eq!(red(&texture, &sampler, &request), expected, "{bits} bits");
    }
}

#[test]
fn a_texture_of_five_by_three_is_scaled_exactly() {
    let texture = pyramid(PyramidKind::Mipmap, 5, 3, |lu, _, x, y| [50 * x as u8, [0, 50, 200][y as usize], lu, 255]);
    // u = 0.5 is p = 2, texel 2 exactly; v = 2/3 (floored to 12.20) is p = 1.4999..., fraction 127/256.
    let bilinear = answer(&texture, &sampler(Filter::Bilinear, Clamp), &at(0.5, 2.0 / 3.0));
    assert_eq!(bilinear.texel, [100, 124, 0, 255]); // 50 + 150 * 127/256 = 124.4
    // u = 0.6 floors below texel 3 of 5: 629145 * 5 = 3145725 < 3 * 2^20.
    assert_eq!(answer(&texture, &sampler(Filter::Point, Wrap), &at(0.6, 0.0)).texel, [100, 0, 0, 255]);
    let a_step_up = Request::at(I12F20::from_bits(629_146), I12F20::ZERO);
    assert_eq!(answer(&texture, &sampler(Filter::Point, Wrap), &a_step_up).texel, [150, 0, 0, 255]);
    // 5 x 3 halves to 2 x 1, then to 1 x 1: the level count is floor(log2 5) + 1 = 3.
    assert_eq!(texture.planes.iter().map(|p| (p.width, p.height)).collect::<Vec<_>>(), [(5, 3), (2, 1), (1, 1)]);
    let coarsest = Request { scale: [f32::INFINITY.to_bits(); 2], ..at(0.5, 0.5) };
    assert_eq!(answer(&texture, &sampler(Filter::Trilinear, Wrap), &coarsest).lod, [512; 2]);
}

#[test]
fn a_one_texel_texture_is_its_texel_everywhere_but_fades_in_clip() {
    let texture = columns(&[200]);
    for filter in FILTERS {
        let kind = filter.pyramid();
        let texture = pyramid(kind, 1, 1, |_, _, _, _| [200; 4]);
        for mode in [Wrap, Clamp, Mirror] {
            for (u, v) in [(0.0, 0.0), (0.5, 0.5), (-3.7, 1999.1), (0.999, -0.001)] {
                let request = Request { scale: [u32::MAX, 0x3f80_0000], ..at(u, v) };
                assert_eq!(answer(&texture, &sampler(filter, mode), &request).texel, [200; 4], "{filter:?} {mode:?}");
            }
        }
    }
    for (u, v, expected) in [(0.5, 0.5, 200), (0.0, 0.5, 100), (0.0, 0.0, 50), (-0.25, 0.5, 50), (-0.5, 0.5, 0)] {
        assert_eq!(red(&texture, &sampler(Filter::Bilinear, Clip), &at(u, v)), expected, "clip at {u}, {v}");
    }
}

#[test]
fn the_roundings_differ_where_the_page_says_so() {
    // c00, c10, c01, c11 at f = g = 1/2, answers in the order of ROUNDINGS.
    let rows = [
        ([0, 1, 0, 1], [1, 1, 0]), // 0.5 along u
        ([0, 1, 0, 0], [0, 1, 0]), // 0.25; along u 0.5 -> 1, along v 0.5 -> 1
        ([1, 1, 0, 1], [1, 1, 0]), // 0.75; truncated 1 and 0, then 0
        ([255, 255, 255, 255], [255; 3]),
    ];
    for (texels, expected) in rows {
        let texture = pyramid(PyramidKind::Mipmap, 2, 2, |_, _, x, y| {
            [texels.get((2 * y + x) as usize).copied().unwrap_or(0); 4]
        });
        for (rounding, expected) in ROUNDINGS.into_iter().zip(expected) {
            let sampler = Sampler { rounding, ..sampler(Filter::Bilinear, Clamp) };
            assert_eq!(red(&texture, &sampler, &at(0.5, 0.5)), expected, "{texels:?} {rounding:?}");
        }
    }
    // Over the taps: 0 and 1 in halves.
    let texture = pyramid(PyramidKind::Mipmap, 2, 1, |lu, _, _, _| [lu; 4]);
    for (rounding, expected) in ROUNDINGS.into_iter().zip([1, 1, 0]) {
        let sampler = Sampler { rounding, lod_source: LodSource::Explicit, ..Sampler::default() };
        assert_eq!(red(&texture, &sampler, &Request { scale: [128; 2], ..at(0.5, 0.5) }), expected, "{rounding:?}");
    }
}

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
fn dipmap_averages_a_column_plane_and_a_row_plane() {
    let texture = pyramid(PyramidKind::Dipmap, 8, 4, |lu, lv, _, _| [10 * lu + 100 * lv; 4]);
    let sampler = Sampler { filter: Filter::Dipmap, lod_source: LodSource::Explicit, ..Sampler::default() };
    // Level of u, of v; texel of (lu, 0) and (0, lv) halved, half up; each level its own floor, 0..=3 and 0..=2.
    let rows = [
        ([0, 0], 0, [0, 0]),
        ([0x100, 0], 5, [0x100, 0]),
        ([0x1ff, 0x80], 5, [0x100, 0]),
        ([0x300, 0x200], 115, [0x300, 0x200]),
        ([0x7fff, 0x7fff], 115, [0x300, 0x200]),
        ([0, 0x100], 50, [0, 0x100]),
    ];
    for (scale, expected, lod) in rows {
        let response = answer(&texture, &sampler, &Request { scale, ..at(0.3, 0.7) });
        assert_eq!(response, Response { texel: [expected; 4], lod }, "{scale:x?}");
    }
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

#[test]
fn a_pyramid_without_the_planes_of_the_filter_is_refused() {
    let mipmap = pyramid(PyramidKind::Mipmap, 8, 8, |_, _, _, _| [0; 4]);
    let refused = |texture: &Pyramid, filter| Reference::new(texture, &sampler(filter, Wrap)).unwrap_err().to_string();
    assert!(refused(&mipmap, Filter::Dipmap).contains("has no plane (1, 0) of 4 x 8 texels"));
    let mut short = mipmap.clone();
    short.planes[1].texels.pop();
    assert!(refused(&short, Filter::Trilinear).contains("has no plane (1, 1) of 4 x 4 texels"));
    let empty = Pyramid { width: 0, ..mipmap.clone() };
    assert!(refused(&empty, Filter::Point).contains("0 texels"));
    let wide = Sampler { filter_bits: 13, ..Sampler::default() };
    assert!(Reference::new(&mipmap, &wide).unwrap_err().to_string().contains("filter_bits = 13"));
}

#[test]
fn the_ideal_reads_what_is_no_number_as_the_chip_does() {
    let texture = columns(&[10, 20, 30, 40]);
    let sample = |u: f64, mode| {
        let ideal = Ideal::new(&texture, IdealSampler::from(&sampler(Filter::Point, mode))).unwrap();
        ideal.sample([u, 0.5], Detail::Level([0.0; 2])).texel[0]
    };
    // The modes in the order of MODES.
    let rows = [
        (f64::NAN, [10.0; 4]),
        (f64::INFINITY, [10.0, 40.0, 0.0, 10.0]),
        (f64::NEG_INFINITY, [10.0, 10.0, 0.0, 10.0]),
        (1e300, [10.0, 40.0, 0.0, 10.0]),
        (-1e-300, [10.0, 10.0, 0.0, 10.0]), // wrap: 1 - 1e-300 is 1 in f64, a full turn
    ];
    for (u, expected) in rows {
        for (mode, expected) in MODES.into_iter().zip(expected) {
            assert_eq!(sample(u, mode), expected, "{mode:?} at {u}");
        }
    }
    let tower = tower();
    let ideal = Ideal::new(&tower, IdealSampler::from(&Sampler::default())).unwrap();
    for (squared, lod) in
        [(f64::NAN, 16.0), (f64::INFINITY, 16.0), (-16.0, 2.0), (0.0, 0.0), (f64::exp2(0.3), 0.15), (1e-310, 0.0)]
    {
        let response = ideal.sample([0.0; 2], Detail::SquaredRatio([squared; 2]));
        assert!((response.lod[0] - lod).abs() < 1e-15, "{squared}: {response:?}");
        assert!((response.texel[0] - 10.0 * lod).abs() < 1e-12, "{squared}: {response:?}");
    }
}

fn mode() -> impl Strategy<Value = AddressMode> {
    proptest::sample::select(MODES.to_vec())
}

fn any_sampler() -> impl Strategy<Value = Sampler> {
    (
        proptest::sample::select(FILTERS.to_vec()),
        [mode(), mode()],
        (1..=12_u8, 0..=8_u8),
        proptest::sample::select(ROUNDINGS.to_vec()),
        any::<bool>(),
        proptest::sample::select(vec![LevelRounding::Floor, LevelRounding::Nearest, LevelRounding::Gl]),
        (-600..=600_i16, 0..=700, 0..=1500),
    )
        .prop_map(|(filter, address, bits, rounding, explicit, level_rounding, levels)| Sampler {
            filter,
            address,
            filter_bits: bits.0,
            lod_bits: bits.1,
            rounding,
            lod_source: if explicit { LodSource::Explicit } else { LodSource::Gradient },
            log2: Log2::Exact,
            level_rounding,
            bias: levels.0,
            min_lod: levels.1,
            max_lod: levels.2,
            ..Sampler::default()
        })
}

/// A coordinate anywhere, or near the texture; and a scale for either source.
fn any_request() -> impl Strategy<Value = (i32, i32, [(f32, i16); 2])> {
    let coordinate = || prop_oneof![any::<i32>(), -0x30_0000..=0x30_0000];
    let scale = || (-4.0_f32..=14.0, -500..=2000_i16).prop_map(|(octaves, level)| (octaves.exp2(), level));
    (coordinate(), coordinate(), [scale(), scale()])
}

fn noise(kind: PyramidKind, size: (u32, u32), seed: u32) -> Pyramid {
    let mut state = seed;
    pyramid(kind, size.0, size.1, |_, _, _, _| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state ^ (state >> 16)).to_le_bytes()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn the_reference_stays_within_the_error_its_widths_allow(
        sampler in any_sampler(),
        (u, v, scale) in any_request(),
        size in (1..=40_u32, 1..=40_u32),
        seed in any::<u32>(),
    ) {
        let texture = noise(sampler.filter.pyramid(), size, seed);
        let explicit = sampler.lod_source == LodSource::Explicit;
        let request = Request {
            scale: scale.map(|(ratio, level)| if explicit { i32::from(level) as u32 } else { ratio.to_bits() }),
            ..Request::at(I12F20::from_bits(u), I12F20::from_bits(v))
        };
        let response = answer(&texture, &sampler, &request);
        let ideal = Ideal::new(&texture, IdealSampler::from(&sampler)).unwrap();
        let at = [u, v].map(|c| f64::from(c) * f64::exp2(-20.0));
        let detail = if explicit {
            Detail::Level(scale.map(|(_, level)| f64::from(level) / 256.0))
        } else {
            Detail::SquaredRatio(scale.map(|(ratio, _)| f64::from(ratio)))
        };
        let truth = ideal.sample(at, detail);

        // The logarithm is off by half a unit of 1/256 level, the level fraction by half of its own.
        let log2_error = if explicit { 0.0 } else { 1.0 / 512.0 };
        let whole = sampler.filter != Filter::Trilinear;
        let fraction_error = if whole || sampler.lod_bits == 8 { 0.0 } else { 0.5 / f64::from(1 << sampler.lod_bits) };
        let level_error = log2_error + fraction_error + 1e-12;
        let reported = response.lod.map(|lod| f64::from(lod) / 256.0);
        if whole && reported != truth.lod {
            // The logarithm's error carried a level over a whole or a half: both raw levels lie by it.
            prop_assert!(!explicit);
            for axis in 0..2 {
                let raw = f64::from(scale[axis * usize::from(sampler.filter.level_per_axis())].0).log2() / 2.0
                    + f64::from(sampler.bias) / 256.0;
                let near = (2.0 * raw - (2.0 * raw).round()).abs() / 2.0 <= log2_error + 1e-12;
                prop_assert!(reported[axis] == truth.lod[axis] || near, "{reported:?} {truth:?}");
            }
            return Ok(());
        }
        for axis in 0..2 {
            prop_assert!((reported[axis] - truth.lod[axis]).abs() <= level_error, "{reported:?} {truth:?}");
        }

        // Full swing over one texel of each axis, and over one level.
        let bilinear_error = if sampler.filter == Filter::Point { 0.0 } else { 2.0 / f64::from(1 << sampler.filter_bits) };
        let level_error = if whole { 0.0 } else { level_error };
        let rounding_error = match sampler.rounding {
            _ if sampler.filter == Filter::Point => 0.0,
            Rounding::Once => 0.5,
            Rounding::StagedRound => 1.5,
            Rounding::StagedTruncate => 3.0,
        };
        let bound = 255.0 * (bilinear_error + level_error) + rounding_error + 1e-9;
        for channel in 0..4 {
            let error = f64::from(response.texel[channel]) - truth.texel[channel];
            prop_assert!(error.abs() <= bound, "{error} beyond {bound}: {response:?} {truth:?}");
        }
    }

    #[test]
    fn a_flat_colour_stays_what_it_is(
        sampler in any_sampler(),
        (u, v, scale) in any_request(),
        size in (1..=40_u32, 1..=40_u32),
        colour in any::<[u8; 4]>(),
    ) {
        let texture = pyramid(sampler.filter.pyramid(), size.0, size.1, |_, _, _, _| colour);
        let request = Request {
            scale: scale.map(|(ratio, _)| ratio.to_bits()),
            ..Request::at(I12F20::from_bits(u), I12F20::from_bits(v))
        };
        let texel = answer(&texture, &sampler, &request).texel;
        if sampler.address.contains(&Clip) {
            prop_assert!(texel.iter().zip(colour).all(|(&a, b)| a <= b));
        } else {
            prop_assert_eq!(texel, colour);
        }
    }

    #[test]
    fn wrap_and_mirror_repeat_exactly(
        (u, v, scale) in any_request(),
        turns in -2000..=2000_i32,
        size in (1..=40_u32, 1..=40_u32),
        mirror in any::<bool>(),
        seed in any::<u32>(),
    ) {
        let texture = noise(PyramidKind::Mipmap, size, seed);
        let sampler = sampler(Filter::Trilinear, if mirror { Mirror } else { Wrap });
        let request = |u: i32| Request {
            scale: scale.map(|(ratio, _)| ratio.to_bits()),
            ..Request::at(I12F20::from_bits(u), I12F20::from_bits(v))
        };
        let period = if mirror { 1 << 21 } else { 1 << 20 };
        let here = answer(&texture, &sampler, &request(u));
        prop_assert_eq!(here, answer(&texture, &sampler, &request(u.wrapping_add(turns.wrapping_mul(period)))));
        // A mirror point tap is symmetric about 0, if no texel edge lies between a coordinate and the next.
        let point = Sampler { filter: Filter::Point, ..sampler };
        if mirror && size.0.is_power_of_two() {
            prop_assert_eq!(answer(&texture, &point, &request(u)), answer(&texture, &point, &request(!u)));
        }
    }
}
