//! X10: how many bits are left between two texels.

use texunit_hw::{AddressMode, Filter, LodSource, Request};

use super::{
    Case, LSB, Options, Q, Row,
    lab::{self, Lab},
};
use crate::{error::Result, front_end::coordinates};

pub(super) const FILTER_BITS: Case = Case {
    name: "X10",
    title: "filter bits from 256 to 65536 texels, and wider formats",
    wrong: "of 16 fraction bits (or of 20, above 4096 texels) too few are left between texels: magnified steps",
    run: filter_bits,
};

/// Fraction bits of the chip's coordinate.
const BITS: u32 = 20;
/// Bits of the bilinear fraction.
const WEIGHT: u32 = 8;

/// A bilinear answer between a black and a white texel, of a unit with so many fraction bits: floor, truncate, round half up.
fn answer(u: f64, size: u32, fraction_bits: u32) -> f64 {
    let fixed = libm::floor(u * libm::exp2(f64::from(fraction_bits)));
    let position = fixed * f64::from(size) / libm::exp2(f64::from(fraction_bits)) - 0.5;
    let fraction = libm::floor((position - libm::floor(position)) * 256.0) / 256.0;
    libm::floor(255.0 * fraction + 0.5)
}

/// The step that so many bits leave, up to the width of the fraction, and half a step of rounding.
fn allowed(size: u32, fraction_bits: u32) -> f64 {
    let left = fraction_bits.saturating_sub(size.ilog2()).min(WEIGHT);
    // Below the width of the fraction the floor of the coordinate is the step; at it, floor and truncation may add up.
    let floor = 255.0 * libm::exp2(f64::from(size.ilog2()) - f64::from(fraction_bits));
    255.0 / libm::exp2(f64::from(left)) + 0.5 + if left == WEIGHT { floor } else { 0.0 }
}

fn filter_bits(options: &Options) -> Result<Vec<Row>> {
    let sampler = lab::sampler(Filter::Bilinear, AddressMode::Wrap, LodSource::Gradient);
    let mut rows = Vec::new();
    for log2 in [8, 10, 12, 13, 14, 15, 16] {
        let size = 1u32 << log2;
        // The white texel stands where the fraction has its worst bits: not at a round coordinate.
        let white = (size / 3) | 1;
        let lab = Lab::mipmap(&lab::row(size, |i| if i == white { 255 } else { 0 }))?;
        let places: Vec<(f64, f64)> = (0..2048)
            .map(|step| (f64::from(step) + 0.37) / 2048.0)
            .map(|fraction| ((f64::from(white) - 0.5 + fraction) / f64::from(size), 255.0 * fraction))
            .collect();
        let requests: Vec<Request> = places
            .iter()
            .map(|&(u, _)| {
                let ([u, v], _) = coordinates(u, 0.5, sampler.address);
                Request::at(u, v)
            })
            .collect();
        let worst = |answers: &mut dyn Iterator<Item = f64>| {
            places.iter().zip(answers).map(|((_, ideal), found)| (found - ideal).abs()).fold(0.0, f64::max)
        };
        let of_format = |bits: u32| worst(&mut places.iter().map(|&(u, _)| answer(u, size, bits)));
        let chip = worst(&mut lab.ask(&sampler, &requests)?.into_iter().map(lab::grey));
        let left = BITS - log2;
        rows.push(Row {
            input: format!("{size} texels: 16 fraction bits against the chip's 12.20, {left} bits left"),
            unit: LSB,
            careless: of_format(16),
            ours: chip,
            ideal: 0.0,
            allowed: allowed(size, BITS),
        });
        for &Q { integer, fraction } in &options.formats {
            rows.push(Row {
                input: format!(
                    "{size} texels: the chip's 12.20 against {integer}.{fraction}, {} bits left",
                    fraction.saturating_sub(log2)
                ),
                unit: LSB,
                careless: chip,
                ours: of_format(fraction),
                ideal: 0.0,
                allowed: allowed(size, fraction),
            });
        }
    }
    Ok(rows)
}
