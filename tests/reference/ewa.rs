//! The elliptical weighted average: what can be counted by hand.

use proptest::prelude::*;
use texunit::{
    pyramid::Pyramid,
    reference::{
        ewa::Ewa,
        ideal::{Detail, Ideal, IdealSampler},
    },
    scene::Gradient,
};
use texunit_hw::{
    AddressMode::{Clamp, Clip, Mirror, Wrap},
    Filter, PyramidKind, Sampler,
};

use crate::planes::pyramid;

/// Red is the column, green the row, blue the level.
fn places() -> Pyramid {
    pyramid(PyramidKind::Mipmap, 64, 64, |l, _, x, y| [x as u8, y as u8, 10 * l, 255])
}

fn steps(x: [f64; 2], y: [f64; 2]) -> Gradient {
    Gradient { ux: x[0] / 64.0, vx: x[1] / 64.0, uy: y[0] / 64.0, vy: y[1] / 64.0 }
}

#[test]
fn an_ellipse_reads_the_texels_it_covers() {
    let texture = places();
    let ewa = Ewa::new(&texture, &IdealSampler::from(&Sampler::default())).unwrap();
    // Steps in texels, level, texels read around the middle of the texture, where four texels meet.
    let rows = [
        // A circle of radius sqrt 2 in level 2: four texels half a texel off, the next are at sqrt 2.5.
        (steps([4.0, 0.0], [0.0, 4.0]), 2.0, 4),
        // 8 x 1 in level 0: two rows, |dx| below sqrt(65 * 7/8) = 7.54, so 16 of each.
        (steps([8.0, 0.0], [0.0, 1.0]), 0.0, 32),
        (steps([0.0, 8.0], [-1.0, 0.0]), 0.0, 32),
        // 64 x 1 with a cap of 16: 4 is the minor axis, level 2 the level, and 16 x 1 texels there. sqrt(257 * 7/8) = 15.0.
        (steps([64.0, 0.0], [0.0, 1.0]), 2.0, 60),
    ];
    for (gradient, lod, texels) in rows {
        let response = ewa.sample([0.5; 2], gradient);
        assert!((response.lod - lod).abs() < 1e-12, "{gradient:?} {response:?}");
        assert_eq!(response.texels_read, texels, "{gradient:?}");
        let middle = 32.0 / f64::exp2(lod) - 0.5;
        for (value, expected) in response.texel.into_iter().zip([middle, middle, 10.0 * lod, 255.0]) {
            assert!((value - expected).abs() < 1e-9, "{gradient:?} {response:?}");
        }
    }
}

#[test]
fn a_magnified_or_undefined_footprint_is_trilinear() {
    let texture = places();
    let at = [0.3, 0.7];
    for (gradient, squared) in [
        (steps([0.7, 0.0], [0.0, 0.2]), 0.0),
        (Gradient::default(), 0.0),
        (steps([f64::NAN, 0.0], [0.0, 1.0]), f64::INFINITY),
        (steps([f64::INFINITY, 0.0], [0.0, 1.0]), f64::INFINITY),
    ] {
        let sampler = IdealSampler::from(&Sampler { filter: Filter::Trilinear, ..Sampler::default() });
        let trilinear = Ideal::new(&texture, sampler).unwrap().sample(at, Detail::SquaredRatio([squared; 2]));
        let response = Ewa::new(&texture, &sampler).unwrap().sample(at, gradient);
        assert_eq!((response.texel, response.lod, response.texels_read), (trilinear.texel, trilinear.lod[0], 4));
    }
}

#[test]
fn a_footprint_along_u_leaves_rows_alone() {
    // Rows of two texels black and white: trilinear at 16 texels a pixel sees grey.
    let texture =
        pyramid(PyramidKind::Mipmap, 64, 64, |l, _, _, y| [if l == 0 { (y / 2 % 2) as u8 * 255 } else { 127 }; 4]);
    let ewa = Ewa::new(&texture, &IdealSampler::from(&Sampler::default())).unwrap();
    let [dark, light] =
        [4.0, 6.0].map(|rows| ewa.sample([0.37, (rows + 1.0) / 64.0], steps([16.0, 0.0], [0.0, 1.0])).texel[0]);
    assert!(dark < 20.0 && light > 235.0, "{dark} {light}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn a_flat_colour_stays_and_the_work_is_bounded(
        at in [-3.0..3.0_f64, -3.0..3.0_f64],
        x in [-1.0..1.0_f64, -1.0..1.0_f64],
        y in [-1.0..1.0_f64, -1.0..1.0_f64],
        octaves in -12.0..40.0_f64,
        bias in -4096..=4096_i16,
        max_anisotropy in 1..=16_u8,
        mode in proptest::sample::select(vec![Wrap, Clamp, Clip, Mirror]),
        size in (1..=40_u32, 1..=40_u32),
    ) {
        let texture = pyramid(PyramidKind::Mipmap, size.0, size.1, |_, _, _, _| [7, 70, 200, 255]);
        let sampler = Sampler { address: [mode; 2], bias, max_anisotropy, ..Sampler::default() };
        let length = octaves.exp2();
        let gradient = Gradient { ux: x[0] * length, vx: x[1] * length, uy: y[0] * length, vy: y[1] * length };
        let response = Ewa::new(&texture, &IdealSampler::from(&sampler)).unwrap().sample(at, gradient);
        for (value, expected) in response.texel.into_iter().zip([7.0, 70.0, 200.0, 255.0]) {
            if mode == Clip {
                prop_assert!(value <= expected + 1e-9);
            } else {
                prop_assert!((value - expected).abs() < 1e-9, "{response:?}");
            }
        }
        // Two levels, no axis of an ellipse beyond twice the cap and the texel's own filter.
        let widest = 2.0 * (4.0 * f64::from(max_anisotropy).powi(2) + 1.0).sqrt() + 1.0;
        prop_assert!(response.texels_read as f64 <= 2.0 * widest * widest);
    }
}
