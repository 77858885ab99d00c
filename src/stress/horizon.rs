//! X1 to X3: where w' goes to zero.

use texunit_hw::{AddressMode, Filter, LodSource};

use super::{
    Case, LEVEL, Row,
    lab::{self, Lab},
};
use crate::{
    error::Result,
    scene::{Fragment, Gradient, Scene, Surface},
};

pub(super) const RECIPROCAL: Case = Case {
    name: "X1",
    title: "w' near zero, and far from it",
    wrong: "1/w'^4 in f32 overflows below w' = 2.3e-10, j^2 above 1.8e19: the level jumps to the coarsest",
    run: reciprocal,
};

pub(super) const BEHIND: Case = Case {
    name: "X2",
    title: "w' at or below zero",
    wrong: "u'/w' behind the eye is a fine number, and 1/w'^4 hides the sign; at w' = 0 a NaN casts to the finest level",
    run: behind,
};

pub(super) const RATE: Case = Case {
    name: "X3",
    title: "the level falls by 2.9 a pixel at the horizon",
    wrong: "a forward difference, or one level a quad or span, is up to a level too sharp in the last rows",
    run: rate,
};

/// Herf 1999, part 3, in f32 as printed: `j*j*invw4`.
pub(super) fn herf_squared(j: f32, w: f32) -> f32 {
    let inverse = 1.0 / w;
    let invw2 = inverse * inverse;
    let invw4 = invw2 * invw2;
    (j * j) * invw4
}

/// A level from a squared ratio by `log2` and comparisons, as C code has them: NaN falls through to the finest.
pub(super) fn careless_level(squared: f64, last: f64) -> f64 {
    let level = libm::log2(squared) / 2.0;
    let level = if level > 0.0 { level } else { 0.0 };
    if level > last { last } else { level }
}

fn reciprocal(_: &super::Options) -> Result<Vec<Row>> {
    let lab = Lab::mipmap(&lab::picture([256, 256], |x, y| (x ^ y) as u8))?;
    [1.0, 1e-4, 1e-9, 2e-10, 1e-12, 1e-15, 3e9, 1e10, 1e15]
        .into_iter()
        .map(|w: f64| {
            // 1.5 texels a pixel, whatever w' is.
            let j = 1.5 * w * w;
            let ours = lab.level(Gradient { ux: j / (w * w), ..Gradient::default() })?;
            let careless = careless_level(f64::from(herf_squared(j as f32, w as f32)), 8.0);
            let input = format!("w' = {w:e}, j = {j:.2e}");
            Ok(Row { input, unit: LEVEL, careless, ours, ideal: libm::log2(1.5), allowed: 1.0 / 256.0 })
        })
        .collect()
}

fn behind(_: &super::Options) -> Result<Vec<Row>> {
    let mut scene = Scene::builtin("floor")?;
    scene.size = [160, 120];
    let Surface::Plane(plane) = scene.surface() else { unreachable!("the floor is a plane") };
    let depth = |x: u32, y: u32| plane.matrix.projective(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let is_behind = |x: u32, y: u32| depth(x, y)[2] <= 0.0;
    let pixels = (0..scene.size[1]).flat_map(|y| (0..scene.size[0]).map(move |x| (x, y)));
    let shaded = |&(x, y): &(u32, u32)| {
        let [u, v, w] = depth(x, y);
        w <= 0.0 && (u / w).is_finite() && (v / w).is_finite()
    };
    let careless = pixels.filter(shaded).count() as f64;
    let ours = scene.fragments().filter(|fragment| is_behind(fragment.x.into(), fragment.y.into())).count() as f64;
    let mut rows = vec![Row {
        input: "a floor beyond its horizon: pixels textured with w' <= 0".into(),
        unit: "pixels",
        careless,
        ours,
        ideal: 0.0,
        allowed: 0.0,
    }];
    // What slips through must have an answer all the same: the coarsest level.
    let lab = Lab::mipmap(&lab::picture([256, 256], |x, y| (x ^ y) as u8))?;
    for (name, derivative) in [("0/0", f64::NAN), ("1/0", f64::INFINITY), ("-1/0", f64::NEG_INFINITY)] {
        let gradient = Gradient { ux: derivative, uy: derivative, vx: derivative, vy: derivative };
        let fragment = Fragment { x: 0, y: 0, u: derivative, v: derivative, gradient };
        let (request, _) = lab.front_end(Filter::Trilinear).request(&fragment);
        let ours = lab.level_of(request)?;
        let infinite = f64::from(f32::INFINITY);
        let squared = if derivative.is_nan() { derivative } else { infinite };
        // The cast makes 0 of NaN, and 255 of infinity before any clamp.
        let careless = f64::from((libm::log2(squared) / 2.0) as u8);
        let input = format!("derivatives {name} at w' = 0");
        rows.push(Row { input, unit: LEVEL, careless, ours, ideal: 8.0, allowed: 0.0 });
    }
    Ok(rows)
}

fn rate(_: &super::Options) -> Result<Vec<Row>> {
    let lab = Lab::mipmap(&lab::picture([256, 256], |x, y| (x ^ y) as u8))?;
    // v = 200 texels / d, d pixels below the horizon.
    let v = |d: f64| 200.0 / d;
    let derivative = |d: f64| 200.0 / (d * d);
    let mut rows = Vec::new();
    for d in [1.0, 2.0, 3.0, 4.0, 8.0, 12.0] {
        let ours = lab.level(Gradient { vy: derivative(d), ..Gradient::default() })?;
        let ideal = libm::log2(derivative(d)).clamp(0.0, 8.0);
        let difference = v(d) - v(d + 1.0);
        let careless = careless_level(difference * difference, 8.0);
        let input = format!("d = {d}: against a forward difference");
        rows.push(Row { input, unit: LEVEL, careless, ours, ideal, allowed: 1.0 / 256.0 });
    }
    for d in [1.0, 5.0, 8.0] {
        // One level for a span of eight rows, that of its last.
        let ours = lab.level(Gradient { vy: derivative(d), ..Gradient::default() })?;
        let of_span = derivative(8.0 * libm::ceil(d / 8.0));
        let careless = careless_level(of_span * of_span, 8.0);
        let input = format!("d = {d}: against one level for 8 rows");
        rows.push(Row { input, unit: LEVEL, careless, ours, ideal: libm::log2(derivative(d)), allowed: 1.0 / 256.0 });
    }
    // The chip reads what it is given: nearest-mip at the horizon is the nearest level.
    let sampler = lab::sampler(Filter::NearestMip, AddressMode::Wrap, LodSource::Gradient);
    let gradient = Gradient { vy: derivative(2.0) / 256.0, ..Gradient::default() };
    let fragment = Fragment { x: 0, y: 0, u: 0.5, v: 0.5, gradient };
    let (request, _) = lab.front_end(Filter::NearestMip).request(&fragment);
    let ours = lab::levels(lab.ask_one(&sampler, request)?);
    let difference = v(2.0) - v(3.0);
    let careless = libm::floor(careless_level(difference * difference, 8.0) + 0.5);
    let ideal = libm::floor(libm::log2(derivative(2.0)) + 0.5);
    rows.push(Row { input: "d = 2: nearest level".into(), unit: LEVEL, careless, ours, ideal, allowed: 0.0 });
    Ok(rows)
}
