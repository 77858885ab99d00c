//! X7 to X9: coordinates far from the texture, short of bits, and below zero.

use texunit_hw::{AddressMode, Filter, I12F20, LodSource, Request, Sampler, coordinate::from_f32_bits};

use super::{
    Case, LSB, Options, Row, TEXEL,
    lab::{self, Lab},
};
use crate::{error::Result, front_end::coordinates};

pub(super) const FAR: Case = Case {
    name: "X7",
    title: "coordinates at the ends of 12.20",
    wrong: "a saturating conversion loses the place under wrap, a wrapping one turns the right edge into the left under clamp; half a texel off the lowest flips the sign",
    run: far,
};

pub(super) const FLOATS: Case = Case {
    name: "X8",
    title: "coordinates of 1000 repeats in f32",
    wrong: "f32 keeps 13 fraction bits there: 5 sub-texel bits on 256 texels, none on 32768",
    run: floats,
};

pub(super) const NEGATIVE: Case = Case {
    name: "X9",
    title: "coordinates just below zero and just below one",
    wrong: "truncation doubles texel 0, rounding to nearest jumps across the whole texture",
    run: negative,
};

const TURN: f64 = 1_048_576.0;

fn point(mode: AddressMode) -> Sampler {
    lab::sampler(Filter::Point, mode, LodSource::Gradient)
}

/// A row for a unit that differs in its conversion only: the careless coordinate goes through the same chip.
fn converted(lab: &Lab, sampler: &Sampler, u: f64, careless: i32, input: String) -> Result<Row> {
    let careless = Request::at(I12F20::from_bits(careless), I12F20::ZERO);
    Ok(Row {
        input,
        unit: LSB,
        careless: lab::grey(lab.ask_one(sampler, careless)?),
        ours: lab::grey(lab.at(sampler, u, 0.0)?),
        ideal: lab.ideal_at(sampler, u, 0.0)?,
        allowed: 0.0,
    })
}

fn far(_: &Options) -> Result<Vec<Row>> {
    let lab = Lab::mipmap(&lab::row(256, |i| i as u8))?;
    let saturating = |u: f64| libm::floor(u * TURN) as i32;
    let wrapping = |u: f64| libm::floor(u * TURN) as i64 as i32;
    let mut rows = Vec::new();
    for (mode, name, u) in [
        (AddressMode::Wrap, "wrap", 2048.25),
        (AddressMode::Wrap, "wrap", -2048.25),
        (AddressMode::Wrap, "wrap", 1e6 + 0.6),
        (AddressMode::Mirror, "mirror", 2049.75),
        (AddressMode::Mirror, "mirror", -3000.4),
    ] {
        rows.push(converted(&lab, &point(mode), u, saturating(u), format!("{name}, u = {u}, against saturation"))?);
    }
    for (mode, name, u) in [
        (AddressMode::Clamp, "clamp", 2048.0),
        (AddressMode::Clamp, "clamp", -2049.0),
        (AddressMode::Clip, "clip", 4096.5),
    ] {
        rows.push(converted(
            &lab,
            &point(mode),
            u,
            wrapping(u),
            format!("{name}, u = {u}, against 32 bits that wrap"),
        )?);
    }
    // Half a texel of 256 less, in 32 bits.
    let sampler = lab::sampler(Filter::Bilinear, AddressMode::Clamp, LodSource::Gradient);
    for (end, half, ideal) in [(i32::MIN, -(1 << 11), 0.0), (i32::MAX, 1 << 11, 255.0)] {
        let careless = Request::at(I12F20::from_bits(end.wrapping_add(half)), I12F20::ZERO);
        let ours = Request::at(I12F20::from_bits(end), I12F20::ZERO);
        rows.push(Row {
            input: format!("clamp, coordinate {end:#X} and half a texel in 32 bits"),
            unit: LSB,
            careless: lab::grey(lab.ask_one(&sampler, careless)?),
            ours: lab::grey(lab.ask_one(&sampler, ours)?),
            ideal,
            allowed: 0.0,
        });
    }
    Ok(rows)
}

fn floats(_: &Options) -> Result<Vec<Row>> {
    let places = || (0..4096u32).map(|i| 1024.0 + 0.25 * f64::from(i) + 1.0 / f64::from(i + 3));
    let worst =
        |size: f64, found: &dyn Fn(f64) -> f64| places().map(|u| (found(u) - u).abs() * size).fold(0.0, f64::max);
    let mut rows = Vec::new();
    for size in [256.0, 4096.0, 32768.0] {
        let as_float = |u: f64| f64::from(u as f32);
        let ours = |u: f64| {
            let ([fixed, _], _) = coordinates(u, 0.0, [AddressMode::Clamp; 2]);
            f64::from(fixed.to_bits()) / TURN
        };
        rows.push(Row {
            input: format!("1024 to 2048 repeats of {size} texels: interpolated in f32 against f64, floored to 12.20"),
            unit: TEXEL,
            careless: worst(size, &as_float),
            ours: worst(size, &ours),
            ideal: 0.0,
            allowed: size / TURN,
        });
        // The chip's own conversion of f32 adds nothing to what the f32 has lost, half an ulp.
        let converted = |u: f64| {
            let fixed = from_f32_bits((u as f32).to_bits(), AddressMode::Clamp).value;
            f64::from(fixed.to_bits()) / TURN
        };
        let twice = |u: f64| f64::from(((u as f32) * (size as f32) - 0.5).trunc() + 0.5) / size;
        rows.push(Row {
            input: format!("the same given as f32 bits, against f32 texels minus a half, truncated, on {size}"),
            unit: TEXEL,
            careless: worst(size, &twice),
            ours: worst(size, &converted),
            ideal: 0.0,
            allowed: size * f64::from(f32::EPSILON) * 512.0,
        });
    }
    Ok(rows)
}

fn negative(_: &Options) -> Result<Vec<Row>> {
    let lab = Lab::mipmap(&lab::row(256, |i| i as u8))?;
    let sampler = point(AddressMode::Wrap);
    let truncated = |u: f64| (u * TURN) as i32;
    let to_nearest = |u: f64| libm::rint(u * TURN) as i32;
    let mut rows = Vec::new();
    for u in [-0.3 / 256.0, -1.0 / 4096.0, -257.4 / 256.0] {
        // C's cast of u * size, then the remainder.
        let texel = (u * 256.0) as i64;
        let careless = ((texel & 255) as i32) << 12;
        rows.push(converted(&lab, &sampler, u, careless, format!("wrap, u = {u:.6}, against truncation to a texel"))?);
    }
    let tiny = -libm::exp2(-26.0);
    rows.push(converted(&lab, &sampler, tiny, truncated(tiny), "wrap, u = -2^-26, against truncation".into())?);
    rows.push(converted(&lab, &sampler, tiny, to_nearest(tiny), "wrap, u = -2^-26, against to nearest".into())?);
    let below_one = 1.0 - libm::exp2(-24.0);
    let input = "wrap, u = 1 - 2^-24, against to nearest".into();
    rows.push(converted(&lab, &sampler, below_one, to_nearest(below_one), input)?);
    // A side of five: the remainder of C has the sign of the dividend.
    let five = Lab::mipmap(&lab::row(5, |i| 51 * i as u8))?;
    for u in [-0.3, -0.05, -7.9] {
        let careless = f64::from((libm::floor(u * 5.0) as i32) % 5);
        let ours = lab::grey(five.at(&sampler, u, 0.0)?) / 51.0;
        let ideal = five.ideal_at(&sampler, u, 0.0)? / 51.0;
        let input = format!("wrap on 5 texels, u = {u}, against `%`");
        rows.push(Row { input, unit: TEXEL, careless, ours, ideal, allowed: 0.0 });
    }
    Ok(rows)
}
