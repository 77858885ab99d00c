//! The filters of docs/numerics.md, sections 5.1 and 5.2, in the float reference: worked out by hand, and against the ideal.

use proptest::prelude::*;
use texunit::{
    pyramid::Pyramid,
    reference::{
        Reference,
        footprint::Footprint,
        ideal::{Detail, Ideal, IdealSampler},
    },
};
use texunit_hw::{AddressMode::Clip, Filter, I12F20, LodSource, PyramidKind, Request, Response, Rounding, Sampler};

use crate::{
    MODES, ROUNDINGS, answer, at, fixed,
    planes::{noise, pyramid},
    tower,
};

const ANISOTROPIC: [Filter; 3] = [Filter::Texram, Filter::Feline, Filter::Fast];

/// A filter that is told levels.
fn explicit(filter: Filter) -> Sampler {
    Sampler { filter, lod_source: LodSource::Explicit, ..Sampler::default() }
}

/// 16 columns with these greys at some of them, black between; coarser levels are black.
fn sixteen(grey: &[(u32, u8)]) -> Pyramid {
    let of = |column| grey.iter().find(|(known, _)| *known == column).map_or(0, |(_, grey)| *grey);
    pyramid(PyramidKind::Mipmap, 16, 1, |lu, _, x, _| if lu == 0 { [of(x); 4] } else { [0; 4] })
}

#[test]
fn brilinear_takes_one_level_near_it_and_stretches_the_rest() {
    let tower = tower();
    // Threshold, level in, level out, in 1/256.
    let rows = [
        (64, 64, 0),
        (64, 65, 2),    // 256 * 1 / 128
        (64, 191, 254), // 256 * 127 / 128
        (64, 192, 256),
        (64, 0x580, 0x580),
        (64, 0x5c0, 0x600),
        (64, 0x7fff, 0x1000),
        (0, 0, 0),
        (0, 1, 1),
        (0, 255, 255),
        (85, 86, 2), // 256 / 86 = 2.98
        (127, 127, 0),
        (127, 128, 128), // 256 * 1 / 2
        (127, 129, 256),
    ];
    for (brilinear_threshold, level, expected) in rows {
        let sampler = Sampler { brilinear_threshold, ..explicit(Filter::Brilinear) };
        let response = answer(&tower, &sampler, &Request { scale: [level, 0], ..Request::default() });
        let texel = (10 * u32::from(expected) + 128) / 256;
        assert_eq!(response, Response { texel: [texel as u8; 4], lod: [expected; 2] }, "{brilinear_threshold} {level}");
    }
}

#[test]
fn mip_double_averages_two_levels_of_one_chain() {
    let texture = pyramid(PyramidKind::Mipmap, 8, 1, |lu, _, _, _| [10 * lu; 4]);
    // Each level is its floor and ends where the chain does, not where its own axis does.
    let rows = [([0x100, 0x300], 20, [0x100, 0x300]), ([0x1ff, 0x80], 5, [0x100, 0]), ([0, 0x7fff], 15, [0, 0x300])];
    for (scale, texel, lod) in rows {
        let response = answer(&texture, &explicit(Filter::MipDouble), &Request { scale, ..at(0.5, 0.5) });
        assert_eq!(response, Response { texel: [texel; 4], lod }, "{scale:x?}");
    }
}

#[test]
fn two_level_dipmap_and_ripmap_blend_the_levels_of_each_axis() {
    let rows = [
        // 10 * 1.5 along u and 100 * 0.25 along v: halved by the dipmap, summed by the ripmap.
        ([0x180, 0x40], 20, 40, [0x180, 0x40]),
        ([0x7fff, 0x7fff], 115, 230, [0x300, 0x200]),
        ([0, 0x1c0], 88, 175, [0, 0x1c0]), // 87.5, half up
    ];
    for (scale, dip, rip, lod) in rows {
        for (filter, expected) in [(Filter::DipmapTrilinear, dip), (Filter::Ripmap, rip)] {
            let texture = pyramid(filter.pyramid(), 8, 4, |lu, lv, _, _| [10 * lu + 100 * lv; 4]);
            let response = answer(&texture, &explicit(filter), &Request { scale, ..at(0.25, 0.5) });
            assert_eq!(response, Response { texel: [expected; 4], lod }, "{filter:?} {scale:x?}");
        }
    }
    // The four planes by their products, not by sums: 255 at (1, 1) alone, 1/2 and 1/4 of the way there.
    let corner = pyramid(PyramidKind::Ripmap, 8, 4, |lu, lv, _, _| [if (lu, lv) == (1, 1) { 255 } else { 0 }; 4]);
    let request = Request { scale: [0x80, 0x40], ..Request::default() };
    assert_eq!(answer(&corner, &explicit(Filter::Ripmap), &request).texel, [32; 4]); // 255 / 8 = 31.9
}

#[test]
fn texram_doubles_its_probes_with_the_ratio_of_the_axes() {
    // A quarter of the texture, 4 texels, around the border of texels 7 and 8.
    let texture = sixteen(&[(6, 10), (7, 20), (8, 40), (9, 80)]);
    let probes = |scale: [u32; 2], max_anisotropy| {
        let request = Request { scale, axes: [[fixed(0.25), fixed(0.0)], [fixed(0.5); 2]], ..at(0.5, 0.5) };
        answer(&texture, &Sampler { max_anisotropy, ..explicit(Filter::Texram) }, &request)
    };
    let found = |texel, lod| Response { texel: [texel; 4], lod: [lod; 2] };
    assert_eq!(probes([0x200, 0], 16), found(38, 0), "four probes at the centres of texels 6 to 9: 37.5");
    assert_eq!(probes([0x180, 0], 16), found(38, 0), "one half rounds up");
    assert_eq!(probes([0x17f, 0], 16), found(38, 0), "two probes a texel apart from the middle: 15, 60");
    assert_eq!(probes([0x7f, 0], 16), found(30, 0), "one");
    assert_eq!(probes([0x200, 0], 1).lod, [0x200; 2], "a cap of 1 is trilinear at the major axis");
    // A cap of 7 is 4 probes: two levels below the major axis and no further.
    assert_eq!(probes([0x2c0, 0], 7).lod, [0xc0; 2]);
    assert_eq!(probes([0x2c0, 0x100], 7).lod, [0x100; 2]);
    assert_eq!(probes([0x2c0, 0x1_0000], 7).lod, [0x400; 2], "the minor axis is the level, though it be the longer");
    assert_eq!(probes([(-0x100_i32) as u32, (-0x200_i32) as u32], 7), found(30, 0));
}

#[test]
fn feline_weighs_its_probes_by_a_gaussian() {
    let weigh = |texel: (u32, u8), level: u32, axis: f64| {
        let request = Request { scale: [level, 0], axes: [[fixed(axis), fixed(0.0)]; 2], ..at(8.5 / 16.0, 0.5) };
        answer(&sixteen(&[texel]), &explicit(Filter::Feline), &request).texel[0]
    };
    // 256 log2 5/4 = 82.4 and 256 log2 7/4 = 206.7: from there on two and three probes.
    assert_eq!([weigh((8, 255), 82, 0.375), weigh((8, 255), 83, 0.375)], [255, 0]);
    // Two of half the weight at a third of 6 texels from the centre of texel 8.
    assert_eq!([6, 10].map(|texel| weigh((texel, 255), 206, 0.375)), [128; 2]);
    // Three at 4, 8 and 12 of weight 70, 116, 70 (69.5 would be 70.16 and 115.68 unrounded).
    assert_eq!([4, 8, 12].map(|texel| weigh((texel, 255), 207, 0.5)), [70, 116, 70]);
    assert_eq!([4, 8, 12].map(|texel| weigh((texel, 128), 207, 0.5)), [35, 58, 35]);
    // 31 of 256 for the outer and 60 for the next of five, and what the rounding misses or has too much in the middle.
    assert_eq!([4, 6, 8, 10, 12].map(|texel| weigh((texel, 128), 374, 0.375)), [16, 30, 37, 30, 16]);
    // round(256 log2 8.5) = 790 is as far as sixteen probes reach.
    let lod = |level| answer(&tower(), &explicit(Filter::Feline), &Request { scale: [level, 0], ..Request::default() });
    assert_eq!([lod(789), lod(791), lod(1280)].map(|response| response.lod[0]), [0, 1, 490]);
}

#[test]
fn fast_scatters_as_many_samples_as_each_level_has_texels() {
    let texture =
        pyramid(PyramidKind::Mipmap, 256, 256, |lu, _, x, y| if lu == 0 { [x as u8, y as u8, 0, 0] } else { [0; 4] });
    let sampler = Sampler { filter_bits: 12, ..explicit(Filter::Fast) };
    let axes = |a: [f64; 2], b: [f64; 2]| [a.map(fixed), b.map(fixed)];
    let request = |level| Request {
        scale: [level, 0],
        axes: axes([32.0 / 256.0, 64.0 / 256.0], [16.0 / 256.0, -8.0 / 256.0]),
        pixel: [5, 7],
        ..at(100.5 / 256.0, 150.5 / 256.0)
    };
    let texel = |level| answer(&texture, &sampler, &request(level)).texel;
    // 256 log2 3/2 = 149.75: one sample without jitter below it.
    assert_eq!(texel(149), [100, 150, 0, 0]);
    // Two at and above it. Hash of (5, 7), sample 0 and 1: (181, 54) and (224, 182). Along: (181 - 256) / 512 = -0.14648 and
    // (256 + 224 - 256) / 512 = 0.4375, together 0.14551 halved; across: -74/256 and 54/256, together -0.039 halved.
    // u: 100 + 32 * 0.145508 - 16 * 0.0390625 = 104.03; v: 150 + 64 * 0.145508 + 8 * 0.0390625 = 159.63.
    assert_eq!(texel(150), [104, 160, 0, 0]);
    assert_eq!(texel(338), [104, 160, 0, 0]);
    // Three from 256 log2 5/2 = 338.4 on, of weights 85, 85 and 86; sample 2: (5, 98). Along: (181 - 384) / 768 = -0.26432,
    // (480 - 384) / 768 = 0.125, (517 - 384) / 768 = 0.17318; across: -0.28906, 0.21094, -0.11719. Weighted: 0.01193, -0.06530.
    // u: 100 + 32 * 0.01193 - 16 * 0.06530 = 99.34; v: 150 + 64 * 0.01193 + 8 * 0.06530 = 151.29.
    assert_eq!(texel(339), [99, 151, 0, 0]);
    // The coarser level has a quarter of the texels and needs a quarter of the samples: its own logarithm is two less.
    let flat = pyramid(PyramidKind::Mipmap, 256, 256, |lu, _, _, _| [lu.saturating_mul(40); 4]);
    let capped = Sampler { max_anisotropy: 4, ..sampler };
    let response = answer(&flat, &capped, &request(0x280));
    assert_eq!(response, Response { texel: [20; 4], lod: [0x80; 2] }, "256 log2 4 below the major axis");
}

#[test]
fn a_ripmap_without_its_inner_planes_is_refused() {
    let dipmap = pyramid(PyramidKind::Dipmap, 8, 8, |_, _, _, _| [0; 4]);
    let refused = Reference::new(&dipmap, &explicit(Filter::Ripmap)).unwrap_err().to_string();
    assert!(refused.contains("has no plane (1, 1) of 4 x 4 texels"), "{refused}");
}

#[test]
fn the_ideal_of_an_anisotropic_filter_looks_along_the_gradient() {
    let ramp = pyramid(PyramidKind::Mipmap, 256, 256, |lu, _, x, _| [((x << lu) + (1 << lu) / 2) as u8; 4]);
    for filter in ANISOTROPIC {
        let ideal = Ideal::new(&ramp, IdealSampler::from(&explicit(filter))).unwrap();
        let gradient = texunit::scene::Gradient { ux: 8.0 / 256.0, vy: 1.0 / 256.0, ..Default::default() };
        let footprint = Footprint::new(filter, gradient, [256, 256], [5, 7]);
        let response = ideal.sample([0.5; 2], Detail::Footprint(footprint));
        assert_eq!(response.lod, [0.0; 2], "{filter:?}: the minor axis is one texel");
        // Probes that lie symmetrically on a ramp cancel; jitter moves the mean by less than half a stratum.
        let bound = if filter == Filter::Fast { 0.5 } else { 1e-9 };
        assert!((response.texel[0] - 127.5).abs() < bound, "{filter:?} {response:?}");
        let beside = ideal.sample([0.5; 2], Detail::Footprint(Footprint { axes: [[f64::NAN; 2]; 2], ..footprint }));
        assert!((beside.texel[0] - 127.5).abs() < 1e-9, "{filter:?} {beside:?}");
    }
}

/// A request with axes of any length; the levels are odd and even 1/256, so that no difference is exactly a half.
fn any_request() -> impl Strategy<Value = Request> {
    let vector = || prop_oneof![any::<[i32; 2]>(), [-0x8_0000..=0x8_0000_i32, -0x8_0000..=0x8_0000_i32]];
    (any::<[i32; 2]>(), [-300..=1200_i32, -300..=700_i32], [vector(), vector()], any::<[u16; 2]>()).prop_map(
        |(at, [major, minor], axes, pixel)| Request {
            scale: [(2 * major + 1) as u32, (2 * minor) as u32],
            axes: axes.map(|axis| axis.map(I12F20::from_bits)),
            pixel,
            ..Request::at(I12F20::from_bits(at[0]), I12F20::from_bits(at[1]))
        },
    )
}

fn any_sampler() -> impl Strategy<Value = Sampler> {
    use Filter::{Brilinear, DipmapTrilinear, MipDouble, Ripmap};
    let filters = [&ANISOTROPIC[..], &[Brilinear, MipDouble, DipmapTrilinear, Ripmap]].concat();
    let mode = || proptest::sample::select(MODES.to_vec());
    (
        proptest::sample::select(filters),
        [mode(), mode()],
        (1..=12_u8, 0..=8_u8, 1..=16_u8, 0..=100_u8),
        proptest::sample::select(ROUNDINGS.to_vec()),
        (-300..=300_i16, 0..=300, 0..=1500),
    )
        .prop_map(|(filter, address, widths, rounding, (bias, min_lod, max_lod))| Sampler {
            address,
            filter_bits: widths.0,
            lod_bits: widths.1,
            max_anisotropy: widths.2,
            brilinear_threshold: widths.3,
            rounding,
            bias: 2 * bias,
            min_lod,
            max_lod,
            ..explicit(filter)
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn the_reference_stays_within_the_error_its_widths_allow(
        sampler in any_sampler(),
        request in any_request(),
        size in (1..=40_u32, 1..=40_u32),
        seed in any::<u32>(),
    ) {
        let texture = noise(sampler.filter.pyramid(), size, seed);
        let response = answer(&texture, &sampler, &request);
        let ideal = Ideal::new(&texture, IdealSampler::from(&sampler)).unwrap();
        let turns = |c: I12F20| f64::from(c.to_bits()) * f64::exp2(-20.0);
        let footprint = Footprint {
            squared: request.scale.map(|level| f64::exp2(f64::from(level as i32) / 128.0)),
            axes: request.axes.map(|axis| axis.map(turns)),
            pixel: request.pixel,
        };
        let levels = Detail::Level(request.scale.map(|level| f64::from(level as i32) / 256.0));
        let anisotropic = sampler.filter.is_anisotropic();
        let detail = if anisotropic { Detail::Footprint(footprint) } else { levels };
        let truth = ideal.sample([turns(request.u), turns(request.v)], detail);

        // Half a step of the level fraction, of the cap's logarithm where there is one; brilinear stretches what is left.
        let stretched = if sampler.filter == Filter::Brilinear {
            256.0 / (256.0 - 2.0 * f64::from(sampler.brilinear_threshold))
        } else {
            1.0
        };
        let whole = sampler.filter == Filter::MipDouble;
        let fraction = if whole || sampler.lod_bits == 8 { 0.0 } else { 0.5 / f64::from(1 << sampler.lod_bits) };
        let cap = if anisotropic { 1.0 / 512.0 } else { 0.0 };
        let lost = if sampler.filter == Filter::Brilinear { 1.0 / 256.0 } else { 0.0 };
        let level_error = stretched * fraction + cap + lost + 1e-12;
        let reported = response.lod.map(|lod| f64::from(lod) / 256.0);
        for axis in 0..2 {
            prop_assert!((reported[axis] - truth.lod[axis]).abs() <= level_error, "{reported:?} {truth:?}");
        }

        // A full swing over one texel of each axis; over one level of each axis; over the places of probes, floored twice;
        // over the weights of up to cap probes.
        let texel = 2.0 / f64::from(1 << sampler.filter_bits);
        let levels = if sampler.filter == Filter::Ripmap { 2.0 * level_error } else { level_error };
        let [places, weights] = if anisotropic {
            [2.0 * f64::from(size.0 + size.1) * f64::exp2(-20.0), f64::from(sampler.max_anisotropy) / 256.0]
        } else {
            [0.0; 2]
        };
        let rounding = match sampler.rounding {
            Rounding::Once => 0.5,
            Rounding::StagedRound => 1.5,
            Rounding::StagedTruncate => 3.0,
        };
        let bound = 255.0 * (texel + levels + places + weights) + rounding + 1e-9;
        for channel in 0..4 {
            let error = f64::from(response.texel[channel]) - truth.texel[channel];
            prop_assert!(error.abs() <= bound, "{error} beyond {bound}: {response:?} {truth:?}");
        }
    }

    #[test]
    fn a_flat_colour_stays_what_it_is(
        sampler in any_sampler(),
        request in any_request(),
        max_anisotropy in 1..=64_u8,
        size in (1..=40_u32, 1..=40_u32),
        colour in any::<[u8; 4]>(),
    ) {
        let sampler = Sampler { max_anisotropy, ..sampler };
        let texture = pyramid(sampler.filter.pyramid(), size.0, size.1, |_, _, _, _| colour);
        let texel = answer(&texture, &sampler, &request).texel;
        if sampler.address.contains(&Clip) {
            prop_assert!(texel.iter().zip(colour).all(|(&a, b)| a <= b));
        } else {
            prop_assert_eq!(texel, colour);
        }
    }
}
