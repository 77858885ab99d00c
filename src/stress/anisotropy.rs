//! X6: footprints up to a million times as long as wide.

use texunit_hw::{AddressBatch, Filter, Log2, Sink, Unit, lod::raw_level};

use super::{
    Case, LEVEL, Row,
    lab::{self, Lab},
};
use crate::{
    error::{Error, Result},
    scene::{Fragment, Gradient},
};

pub(super) const MILLION: Case = Case {
    name: "X6",
    title: "anisotropy up to 1 : 1 000 000",
    wrong: "the minor axis as the difference of two nearly equal squares in f32 has lost every digit at 1 : 10 000; probes without a cap never end",
    run: million,
};

/// `(A + C - sqrt((A - C)^2 + B^2)) / 2` in f32: the textbook's smaller eigenvalue.
fn naive_minor_squared(gradient: Gradient) -> f32 {
    let [ux, uy, vx, vy] = [gradient.ux, gradient.uy, gradient.vx, gradient.vy].map(|d| d as f32);
    let (a, b, c) = (vx * vx + vy * vy, -2.0 * (ux * vx + uy * vy), ux * ux + uy * uy);
    let root = ((a - c) * (a - c) + b * b).sqrt();
    (a + c - root) / 2.0
}

struct Taps(usize);

impl Sink for Taps {
    fn take(&mut self, batch: AddressBatch<'_>) {
        self.0 += batch.taps();
    }
}

fn million(_: &super::Options) -> Result<Vec<Row>> {
    const MINOR: f64 = 4.0;
    let lab = Lab::mipmap(&lab::picture([256, 256], |x, y| (x ^ y) as u8))?;
    let front_end = lab.front_end(Filter::Feline);
    let memory = &lab.held.memory;
    let sampler = lab::sampler(Filter::Feline, texunit_hw::AddressMode::Wrap, texunit_hw::LodSource::Gradient);
    let mut rows = Vec::new();
    for ratio in [10.0, 1e3, 4e3, 1e4, 1e5, 1e6] {
        let major = MINOR * ratio;
        // Turned by 30 degrees in the texture and 20 on the screen.
        let (s, c) = libm::sincos(0.523_598_775_598_298_8);
        let (t, d) = libm::sincos(0.349_065_850_398_865_9);
        let texels = Gradient {
            ux: c * major * d + s * MINOR * t,
            uy: c * major * t - s * MINOR * d,
            vx: s * major * d - c * MINOR * t,
            vy: s * major * t + c * MINOR * d,
        };
        let gradient =
            Gradient { ux: texels.ux / 256.0, uy: texels.uy / 256.0, vx: texels.vx / 256.0, vy: texels.vy / 256.0 };
        let (request, _) = front_end.request(&Fragment { x: 0, y: 0, u: 0.5, v: 0.5, gradient });
        let log2_of = |squared: f32| libm::log2(f64::from(squared)) / 2.0;
        rows.push(Row {
            input: format!("1 : {ratio}, the logarithm of the minor axis"),
            unit: LEVEL,
            careless: log2_of(naive_minor_squared(texels)),
            ours: f64::from(raw_level(request.scale[1], Log2::Exact)) / 256.0,
            ideal: libm::log2(MINOR),
            allowed: 1.0 / 256.0,
        });
        let mut unit = Unit::new(&sampler, &memory.surface, &memory.bytes)
            .map_err(|error| Error::setting("X6", "a unit", error.to_string(), "report this: it should be possible"))?;
        let mut taps = Taps(0);
        unit.addresses(&[request], &mut taps);
        let wanted = libm::round(2.0 * ratio - 1.0);
        rows.push(Row {
            input: format!("1 : {ratio}, Feline's probes (cap 16)"),
            unit: "probes",
            careless: wanted,
            ours: taps.0 as f64 / 2.0,
            ideal: wanted.min(16.0),
            allowed: 0.0,
        });
    }
    // A footprint without area: nothing to divide by, and the cap decides.
    let line = Gradient { ux: 64.0, uy: 32.0, vx: 64.0, vy: 32.0 };
    let gradient = Gradient { ux: 0.25, uy: 0.125, vx: 0.25, vy: 0.125 };
    let (request, _) = front_end.request(&Fragment { x: 0, y: 0, u: 0.5, v: 0.5, gradient });
    let careless = libm::log2(f64::from(naive_minor_squared(line))) / 2.0;
    let ours = lab::levels(lab.ask_one(&sampler, request)?);
    let major = libm::sqrt(2.0 * (64.0 * 64.0 + 32.0 * 32.0));
    // Feline's cap of 16 spreads 16 probes over 8.5 widths.
    let ideal = libm::log2(major / 8.5);
    rows.push(Row {
        input: "no area: the level probes use".into(),
        unit: LEVEL,
        careless,
        ours,
        ideal,
        allowed: 1.5 / 256.0,
    });
    Ok(rows)
}
