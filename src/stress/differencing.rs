//! X4 and X5: adding a step a pixel along a span.

use texunit_hw::{AddressMode, Filter, LodSource, Request};

use super::{
    Case, LSB, Row, TEXEL,
    lab::{self, Lab},
};
use crate::{error::Result, front_end::coordinates};

pub(super) const PERSPECTIVE: Case = Case {
    name: "X4",
    title: "forward differencing across 4096 pixels in perspective",
    wrong: "f32 accumulators of u' and w' drift by half an ulp a pixel, always the same way: texels off at the end of a span",
    run: perspective,
};

pub(super) const AFFINE: Case = Case {
    name: "X5",
    title: "an affine step of 12.20",
    wrong: "a step rounded to 2^-20 is off by up to N/2 units after N pixels: 8 texels of 4096",
    run: affine,
};

/// Texels of the texture that the span crosses once.
const TEXELS: u32 = 4096;

/// u' rises and w' falls from 1 to 0.1 over a span of n pixels; u ends at 1.
#[derive(Clone, Copy)]
struct Span {
    pixels: u32,
}

impl Span {
    fn numerator(self, x: f64) -> f64 {
        0.1 * x / f64::from(self.pixels)
    }

    fn denominator(self, x: f64) -> f64 {
        1.0 - 0.9 * x / f64::from(self.pixels)
    }

    fn exact(self, x: u32) -> f64 {
        self.numerator(x.into()) / self.denominator(x.into())
    }

    /// By addition in f32, computed anew every `restart` pixels.
    fn single(self, restart: u32) -> Vec<f64> {
        let step = [self.numerator(1.0), self.denominator(1.0) - 1.0].map(|step| step as f32);
        let mut at = [0f32; 2];
        (0..self.pixels)
            .map(|x| {
                if x % restart == 0 {
                    at = [self.numerator(x.into()), self.denominator(x.into())].map(|start| start as f32);
                }
                let [u, w] = at;
                at = [u + step[0], w + step[1]];
                f64::from(u / w)
            })
            .collect()
    }

    /// By addition in f64.
    fn double(self) -> Vec<f64> {
        let step = [self.numerator(1.0), self.denominator(1.0) - 1.0];
        let mut at = [self.numerator(0.0), self.denominator(0.0)];
        let mut next = |_| {
            let [u, w] = at;
            at = [u + step[0], w + step[1]];
            u / w
        };
        (0..self.pixels).map(&mut next).collect()
    }

    /// By addition of integers with so many fraction bits.
    fn fixed(self, bits: i32) -> Vec<f64> {
        let scale = libm::exp2(f64::from(bits));
        let to_fixed = |x: f64| libm::round(x * scale) as i64;
        let step = [self.numerator(1.0), self.denominator(1.0) - 1.0].map(to_fixed);
        let mut at = [self.numerator(0.0), self.denominator(0.0)].map(to_fixed);
        let mut next = |_| {
            let [u, w] = at;
            at = [u + step[0], w + step[1]];
            u as f64 / w as f64
        };
        (0..self.pixels).map(&mut next).collect()
    }

    /// Anew at every pixel, floored to 12.20 by the front end.
    fn ours(self) -> Vec<f64> {
        (0..self.pixels).map(|x| fixed_point(self.exact(x))).collect()
    }

    /// The farthest from where it should be, in texels.
    fn worst(self, found: &[f64]) -> f64 {
        (0..self.pixels).zip(found).map(|(x, u)| (u - self.exact(x)).abs() * f64::from(TEXELS)).fold(0.0, f64::max)
    }
}

/// A coordinate as the front end hands it on.
fn fixed_point(u: f64) -> f64 {
    let ([u, _], _) = coordinates(u, 0.0, [AddressMode::Clamp; 2]);
    f64::from(u.to_bits()) / 1_048_576.0
}

/// The worst of the chip's answers at `found` against the ideal filter at `exact`.
fn worst_lsb(lab: &Lab, found: &[f64], exact: impl Fn(u32) -> f64) -> Result<f64> {
    let sampler = lab::sampler(Filter::Bilinear, AddressMode::Clamp, LodSource::Gradient);
    let requests: Vec<Request> = found
        .iter()
        .map(|&u| {
            let ([u, v], _) = coordinates(u, 0.5, sampler.address);
            Request::at(u, v)
        })
        .collect();
    let mut worst: f64 = 0.0;
    for (x, response) in (0..).zip(lab.ask(&sampler, &requests)?) {
        worst = worst.max((lab::grey(response) - lab.ideal_at(&sampler, exact(x), 0.5)?).abs());
    }
    Ok(worst)
}

/// A wave of 16 texels: at most 50 LSB a texel.
fn wave() -> Result<Lab> {
    Lab::mipmap(&lab::row(TEXELS, |i| (127.5 + 127.0 * libm::sin(f64::from(i) * std::f64::consts::PI / 8.0)) as u8))
}

/// 12.20 and 8 bits of fraction on a slope of 50 LSB a texel, and a rounding.
const WAVE_ALLOWED: f64 = 2.0 * 50.0 / 256.0 + 0.5;

fn perspective(_: &super::Options) -> Result<Vec<Row>> {
    // The floor of 12.20.
    let allowed = f64::from(TEXELS) / 1_048_576.0;
    let mut rows = Vec::new();
    for pixels in [64, 256, 1024, 4096] {
        let span = Span { pixels };
        let (careless, ours) = (span.worst(&span.single(u32::MAX)), span.worst(&span.ours()));
        let input = format!("{pixels} pixels, f32 against anew at every pixel");
        rows.push(Row { input, unit: TEXEL, careless, ours, ideal: 0.0, allowed });
    }
    let span = Span { pixels: 4096 };
    let single = span.single(u32::MAX);
    let ways: [(&str, Vec<f64>, f64); 3] = [
        ("f32 restarted every 16", span.single(16), 0.02),
        ("f64", span.double(), 1e-6),
        ("40-bit fixed point", span.fixed(40), 1e-3),
    ];
    for (name, found, allowed) in ways {
        let (careless, ours) = (span.worst(&single), span.worst(&found));
        let input = format!("4096 pixels, f32 against {name}");
        rows.push(Row { input, unit: TEXEL, careless, ours, ideal: 0.0, allowed });
    }
    let lab = wave()?;
    let careless = worst_lsb(&lab, &single, |x| span.exact(x))?;
    let ours = worst_lsb(&lab, &span.ours(), |x| span.exact(x))?;
    let input = "4096 pixels of a wave of 16 texels".into();
    rows.push(Row { input, unit: LSB, careless, ours, ideal: 0.0, allowed: WAVE_ALLOWED });
    Ok(rows)
}

/// The step that a format of so many fraction bits rounds worst.
fn worst_step(bits: u32) -> f64 {
    (100.0 + 0.4999) / libm::exp2(f64::from(bits))
}

/// Coordinates by addition of a step rounded to so many fraction bits.
fn by_addition(step: f64, bits: u32, pixels: u32) -> impl Iterator<Item = f64> {
    let scale = libm::exp2(f64::from(bits));
    let rounded = libm::round(step * scale) as i64;
    (0..pixels).map(move |x| (i64::from(x) * rounded) as f64 / scale)
}

fn affine(_: &super::Options) -> Result<Vec<Row>> {
    let off = |step: f64, size: u32, found: &mut dyn Iterator<Item = f64>| {
        let worst = |worst: f64, (x, u): (u32, f64)| worst.max((u - step * f64::from(x)).abs() * f64::from(size));
        (0..).zip(found).fold(0.0, worst)
    };
    let mut rows = Vec::new();
    let step = worst_step(20);
    for size in [256, 4096] {
        let careless = off(step, size, &mut by_addition(step, 20, 4096));
        let ours = off(step, size, &mut (0..4096).map(|x| fixed_point(step * f64::from(x))));
        let input = format!("4096 pixels on {size} texels, 12.20 added up against anew at every pixel");
        let allowed = f64::from(size) / 1_048_576.0;
        rows.push(Row { input, unit: TEXEL, careless, ours, ideal: 0.0, allowed });
    }
    for (bits, pixels) in [(28, 256), (30, 1024), (32, 4096), (34, 16384)] {
        let careless = off(step, 4096, &mut by_addition(step, 20, pixels));
        let finest = worst_step(bits);
        let ours = off(finest, 4096, &mut by_addition(finest, bits, pixels));
        let input = format!("{pixels} pixels on 4096 texels: 20 fraction bits against {bits}");
        rows.push(Row { input, unit: TEXEL, careless, ours, ideal: 0.0, allowed: 1.0 / 512.0 });
    }
    let lab = wave()?;
    let exact = |x: u32| step * f64::from(x);
    let careless = worst_lsb(&lab, &by_addition(step, 20, 4096).collect::<Vec<_>>(), exact)?;
    let ours = worst_lsb(&lab, &(0..4096).map(|x| fixed_point(exact(x))).collect::<Vec<_>>(), exact)?;
    let input = "4096 pixels of a wave of 16 texels".into();
    rows.push(Row { input, unit: LSB, careless, ours, ideal: 0.0, allowed: WAVE_ALLOWED });
    Ok(rows)
}
