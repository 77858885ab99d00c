//! The reference against its own limit, the ideal, over samplers, requests and textures of any kind.

use proptest::prelude::*;
use texunit::reference::ideal::{Detail, Ideal, IdealSampler};
use texunit_hw::{
    AddressMode::{self, Clip, Mirror, Wrap},
    Filter, I12F20, LevelRounding, LodSource, Log2, PyramidKind, Request, Rounding, Sampler,
};

use crate::{
    FILTERS, MODES, ROUNDINGS, answer,
    planes::{columns, noise, pyramid},
    sampler, tower,
};

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
