//! X15, X16, X21 to X23: levels on the border, from no number, too large, beyond the chain, and biased.

use texunit_hw::{
    AddressMode, Filter, LevelRounding, LodSource, Request, Sampler,
    lod::{ilog2clamp, trivalsq},
};

use super::{
    Case, LEVEL, LSB, Options, Row,
    horizon::{careless_level, herf_squared},
    lab::{self, Lab},
};
use crate::{
    error::Result,
    experiment::verify::SplitMix,
    scene::{Fragment, Gradient},
};

pub(super) const WHOLE: Case = Case {
    name: "X15",
    title: "a level exactly on an integer",
    wrong: "noise in the last bits of f32 puts 30 to 40 % of the pixels of a 4:1 polygon below 16: salt and pepper of two levels",
    run: whole,
};

pub(super) const SPECIAL: Case = Case {
    name: "X16",
    title: "ratios of zero, denormal, infinite and not a number, with and without flush-to-zero",
    wrong: "Herf's routines as printed: half a level of blur at zero, level 64 at -0, 0 times infinity is NaN",
    run: special,
};

pub(super) const OVERFLOW: Case = Case {
    name: "X21",
    title: "squared derivatives in fixed point",
    wrong: "a derivative of 4096 in 12.20 squared is 2^64: nothing is left in 64 bits, less in 32",
    run: overflow,
};

pub(super) const BEYOND: Case = Case {
    name: "X22",
    title: "a level beyond the chain",
    wrong: "the level is clamped and its fraction is not: a level that does not exist is blended in",
    run: beyond,
};

pub(super) const BIAS: Case = Case {
    name: "X23",
    title: "a bias of 16 levels",
    wrong: "added after the clamp, or to NaN, or in a word that wraps",
    run: bias,
};

fn checkered() -> Result<Lab> {
    Lab::mipmap(&lab::picture([256, 256], |x, y| (x ^ y) as u8))
}

fn whole(_: &Options) -> Result<Vec<Row>> {
    const PIXELS: usize = 20_000;
    let lab = checkered()?;
    let mut random = SplitMix(15);
    let mut pixels = Vec::with_capacity(PIXELS);
    for _ in 0..PIXELS {
        let w = (0.01 + (random.draw() >> 11) as f64 / 9_007_199_254_740_992.0) as f32;
        // 4 texels a pixel.
        pixels.push((4.0 * w * w, w));
    }
    let second = |j: f32, w: f32| {
        let inverse = 1.0 / w;
        let ratio = j * (inverse * inverse);
        ratio * ratio
    };
    let mut rows = Vec::new();
    let ratios =
        |squared: &dyn Fn(f32, f32) -> f32| -> Vec<f32> { pixels.iter().map(|&(j, w)| squared(j, w)).collect() };
    for (name, ratios) in [("(j j) invw4", ratios(&herf_squared)), ("(j invw2)^2", ratios(&second))] {
        let share = |wrong: usize| 100.0 * wrong as f64 / PIXELS as f64;
        let flipped = |ratio: &&f32| (libm::floor(libm::log2(f64::from(**ratio)) / 2.0) - 2.0).abs() > 0.0;
        let careless = share(ratios.iter().filter(flipped).count());
        let mut sampler = lab::sampler(Filter::NearestMip, AddressMode::Wrap, LodSource::Gradient);
        sampler.level_rounding = LevelRounding::Floor;
        let requests: Vec<Request> =
            ratios.iter().map(|ratio| Request { scale: [ratio.to_bits(), 0], ..Request::default() }).collect();
        let wrong = lab.ask(&sampler, &requests)?.into_iter().filter(|response| response.lod[0] != 512).count();
        let input = format!("4:1 everywhere, {name} in f32: pixels at another level than 2");
        rows.push(Row { input, unit: "% of pixels", careless, ours: share(wrong), ideal: 0.0, allowed: 0.0 });
    }
    // The tie of a whole level at a squared ratio of 2: one level by default, none for OpenGL. A float unit's rounding to even, and
    // floor(L + 1/2), get one of them wrong each.
    let half = libm::log2(2.0) / 2.0;
    let ties = [
        ("nearest", LevelRounding::Nearest, 1.0, libm::rint(half)),
        ("gl", LevelRounding::Gl, 0.0, libm::floor(half + 0.5)),
    ];
    for (name, rounding, ideal, careless) in ties {
        let sampler = Sampler {
            level_rounding: rounding,
            ..lab::sampler(Filter::NearestMip, AddressMode::Wrap, LodSource::Gradient)
        };
        let request = Request { scale: [2f32.to_bits(), 0], ..Request::default() };
        let ours = lab::levels(lab.ask_one(&sampler, request)?);
        let input = format!("half way between two levels, rule {name}");
        rows.push(Row { input, unit: LEVEL, careless, ours, ideal, allowed: 0.0 });
    }
    Ok(rows)
}

/// Level and fraction as the memo has them, without a mask, a clamp or a rule for zero.
fn as_printed(bits: u32) -> f64 {
    f64::from(ilog2clamp(bits) / 2) + f64::from(trivalsq(bits)) / 256.0
}

/// What a machine with flush-to-zero makes of a float.
fn flushed(bits: u32) -> u32 {
    if bits & 0x7F80_0000 == 0 { bits & 0x8000_0000 } else { bits }
}

fn special(_: &Options) -> Result<Vec<Row>> {
    let lab = checkered()?;
    let mut rows = Vec::new();
    let inputs: [(&str, u32, f64); 11] = [
        ("0", 0, 0.0),
        ("-0", 0x8000_0000, 0.0),
        ("1e-40", 1e-40f32.to_bits(), 0.0),
        ("-1e-40", (-1e-40f32).to_bits(), 0.0),
        ("0.25", 0.25f32.to_bits(), 0.0),
        ("-16", (-16f32).to_bits(), 2.0),
        ("infinity", f32::INFINITY.to_bits(), 8.0),
        ("-infinity", f32::NEG_INFINITY.to_bits(), 8.0),
        ("NaN", 0x7FC0_0000, 8.0),
        ("-NaN, signalling", 0xFF80_0001, 8.0),
        ("3.4e38", f32::MAX.to_bits(), 8.0),
    ];
    for (name, bits, ideal) in inputs {
        for (flush, bits) in [("", bits), (", denormals flushed", flushed(bits))] {
            let ours = lab.level_of(Request { scale: [bits, 0], ..Request::default() })?;
            let input = format!("squared ratio {name}{flush}");
            rows.push(Row { input, unit: LEVEL, careless: as_printed(bits), ours, ideal, allowed: 0.0 });
        }
    }
    // A coordinate that does not change, at the horizon.
    let ours = lab.level(Gradient { ux: 0.0 / (1e-20 * 1e-20), ..Gradient::default() })?;
    let careless = as_printed(herf_squared(0.0, 1e-20).to_bits());
    rows.push(Row { input: "j = 0 at w' = 1e-20".into(), unit: LEVEL, careless, ours, ideal: 0.0, allowed: 0.0 });
    Ok(rows)
}

fn overflow(_: &Options) -> Result<Vec<Row>> {
    let lab = Lab::mipmap(&lab::row(4096, |i| i as u8))?;
    let mut rows = Vec::new();
    let level = |squared: f64| {
        let level = if squared > 0.0 { libm::log2(squared) / 2.0 - 20.0 } else { 0.0 };
        level.clamp(0.0, 12.0)
    };
    for (ux, vx) in [(3.0, 0.0), (100.0, 0.0), (2048.0, 2048.0), (4095.0, 0.0), (4096.0, 0.0)] {
        let ours = lab.level(Gradient { ux, vx, ..Gradient::default() })?;
        let ideal = (libm::log2(ux * ux + vx * vx) / 2.0).clamp(0.0, 12.0);
        let [du, dv] = [ux, vx].map(|d: f64| (d * 1_048_576.0) as i64);
        let in_64 = du.wrapping_mul(du).wrapping_add(dv.wrapping_mul(dv));
        let in_32 = (du as i32).wrapping_mul(du as i32).wrapping_add((dv as i32).wrapping_mul(dv as i32));
        let row = |width: &str, squared: f64| {
            let input = format!("{ux} and {vx} texels a pixel, squared in {width} bits");
            Row { input, unit: LEVEL, careless: level(squared), ours, ideal, allowed: 1.0 / 256.0 }
        };
        rows.extend([row("64", in_64 as f64), row("32", f64::from(in_32))]);
    }
    Ok(rows)
}

fn beyond(_: &Options) -> Result<Vec<Row>> {
    const GREY: f64 = 200.0;
    let lab = Lab::mipmap(&lab::picture([256, 256], |_, _| GREY as u8))?;
    let sampler = lab::sampler(Filter::Trilinear, AddressMode::Wrap, LodSource::Gradient);
    let mut rows = Vec::new();
    for ratio in [300.0, 400.0, 1e6] {
        let gradient = Gradient { ux: ratio / 256.0, ..Gradient::default() };
        let fragment = Fragment { x: 0, y: 0, u: 0.3, v: 0.3, gradient };
        let (request, _) = lab.front_end(Filter::Trilinear).request(&fragment);
        let response = lab.ask_one(&sampler, request)?;
        let level = libm::log2(ratio);
        let fraction = level - libm::floor(level);
        // Level 9 is not there; what lies behind the chain is taken to be zero.
        let blended = GREY * (1.0 - fraction);
        let input = format!("{ratio} texels a pixel on 256");
        let careless = libm::floor(level).min(8.0) + fraction;
        let ours = lab::levels(response);
        rows.push(Row { input: input.clone(), unit: LEVEL, careless, ours, ideal: 8.0, allowed: 0.0 });
        rows.push(Row { input, unit: LSB, careless: blended, ours: lab::grey(response), ideal: GREY, allowed: 0.0 });
    }
    Ok(rows)
}

fn bias(_: &Options) -> Result<Vec<Row>> {
    let lab = checkered()?;
    let level = |bias: i16, source: LodSource, scale: u32| -> Result<f64> {
        let sampler = Sampler { bias, ..lab::sampler(Filter::Trilinear, AddressMode::Wrap, source) };
        Ok(lab::levels(lab.ask_one(&sampler, Request { scale: [scale, 0], ..Request::default() })?))
    };
    const LEAST: i16 = -16 << 8;
    const MOST: i16 = 16 << 8;
    let row = |input: &str, careless: f64, ours: f64, ideal: f64| Row {
        input: input.into(),
        unit: LEVEL,
        careless,
        ours,
        ideal,
        allowed: 0.0,
    };
    // A sum of floats, cast.
    let cast = |squared: f32, bias: f32| f64::from(((libm::log2f(squared) / 2.0 + bias) as i32).clamp(0, 8));
    let not_a_number = cast(f32::NAN, -16.0);
    // Clamped first, biased then.
    let clamped_first = |squared: f64, bias: f64| (careless_level(squared, 8.0) + bias).max(0.0);
    // An unsigned 8.8.
    let unsigned = f64::from(0u16.wrapping_add(LEAST as u16).min(8 << 8)) / 256.0;
    let in_a_word = f64::from(i32::MAX.wrapping_add(MOST.into()).clamp(0, 8 << 8)) / 256.0;
    let gradient = LodSource::Gradient;
    Ok(vec![
        row("NaN, bias -16", not_a_number, level(LEAST, gradient, f32::NAN.to_bits())?, 8.0),
        row(
            "infinity, bias -16",
            clamped_first(f64::INFINITY, -16.0),
            level(LEAST, gradient, f32::INFINITY.to_bits())?,
            8.0,
        ),
        row("1 texel a pixel, bias -16, in an unsigned word", unsigned, level(LEAST, gradient, 1f32.to_bits())?, 0.0),
        row(
            "256 texels a pixel, bias +16",
            clamped_first(65536.0, 16.0),
            level(MOST, gradient, 65536f32.to_bits())?,
            8.0,
        ),
        row(
            "an explicit level of 2^31 - 1, bias +16",
            in_a_word,
            level(MOST, LodSource::Explicit, i32::MAX as u32)?,
            8.0,
        ),
        row(
            "an explicit level of -2^31, bias -16",
            f64::from(i32::MIN.wrapping_add(LEAST.into()).clamp(0, 8 << 8)) / 256.0,
            level(LEAST, LodSource::Explicit, 1 << 31)?,
            0.0,
        ),
    ])
}
