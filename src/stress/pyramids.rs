//! X19 and X20: means that drift and sums that round.

use texunit_hw::{AddressMode, Filter, I12F20, LodSource, PyramidKind, Request};

use super::{
    Case, LSB, Options, Row,
    lab::{self, Lab},
};
use crate::{
    error::Result,
    experiment::verify::SplitMix,
    pyramid::{
        Build, PlaneImage,
        drift::{Averaging, Channel},
    },
};

pub(super) const DRIFT: Case = Case {
    name: "X19",
    title: "the mean of a pyramid over six levels",
    wrong: "an average cut off at every level loses 3/8 of a step each time",
    run: drift,
};

pub(super) const SUMS: Case = Case {
    name: "X20",
    title: "a summed-area table of 512 x 512",
    wrong: "sums in f32 have no room for the last bits of 2^26: a box of one texel is off by steps",
    run: sums,
};

/// Noise, all channels alike.
fn noise(side: u32, seed: u64) -> PlaneImage {
    let mut random = SplitMix(seed);
    PlaneImage::top(side, side, (0..side * side).map(|_| [(random.draw() >> 56) as u8; 4]).collect())
}

fn drift(_: &Options) -> Result<Vec<Row>> {
    let image = noise(256, 19);
    let pyramid = Build::default().pyramid(PyramidKind::Mipmap, &image)?;
    let mean = |plane: &PlaneImage| {
        let sum: u64 = plane.texels.iter().map(|texel| u64::from(texel[1])).sum();
        sum as f64 / plane.texels.len() as f64
    };
    let ideal = mean(&image);
    let truncated = Channel::of_image(&image, 8).drift(Averaging::Truncate, 6);
    let rows = truncated.iter().enumerate().map(|(number, drift)| Row {
        input: format!("mean of 256 x 256 noise at level {}, against halving and cutting off", number + 1),
        unit: LSB,
        careless: ideal + drift,
        ours: mean(&pyramid.planes[number + 1]),
        ideal,
        // The roundings of few texels do not cancel as those of many do: three standard deviations of 1/sqrt(12) a texel.
        allowed: 0.01 + 3.0 * 0.2887 / libm::sqrt(pyramid.planes[number + 1].texels.len() as f64),
    });
    Ok(rows.collect())
}

fn sums(_: &Options) -> Result<Vec<Row>> {
    const SIDE: u32 = 512;
    let image = noise(SIDE, 20);
    let lab = Lab::new(PyramidKind::Sat, &image)?;
    let side = SIDE as usize;
    // Rows and columns summed in f32.
    let mut table = vec![0f32; side * side];
    for y in 0..side {
        let mut row = 0f32;
        for x in 0..side {
            row += f32::from(image.texels[y * side + x][0]);
            table[y * side + x] = row + if y > 0 { table[(y - 1) * side + x] } else { 0.0 };
        }
    }
    let entry = |x: usize, y: usize| table[(y - 1) * side + x - 1];
    let sampler = lab::sampler(Filter::Sat, AddressMode::Clamp, LodSource::Gradient);
    let mut rows = Vec::new();
    for width in [1usize, 2, 8] {
        let mut worst = [0.0f64; 2];
        for step in 0..64 {
            // Near the far corner, where sums are largest.
            let [x, y] = [side - width - step % 8, side - width - step / 8];
            let exact: u32 = (y..y + width)
                .flat_map(|j| (x..x + width).map(move |i| j * side + i))
                .map(|at| u32::from(image.texels[at][0]))
                .sum();
            let area = (width * width) as f64;
            let ideal = f64::from(exact) / area;
            let of_floats = entry(x + width, y + width) - entry(x, y + width) - entry(x + width, y) + entry(x, y);
            let careless = f64::from(of_floats) / area;
            let centre = |from: usize| I12F20::from_bits(((2 * from + width) << 10) as i32);
            let extent = I12F20::from_bits((width << 11) as i32);
            let axes = [[extent, I12F20::ZERO], [I12F20::ZERO, extent]];
            let request = Request { axes, ..Request::at(centre(x), centre(y)) };
            let ours = lab::grey(lab.ask_one(&sampler, request)?);
            worst = [worst[0].max((careless - ideal).abs()), worst[1].max((ours - ideal).abs())];
        }
        let input = format!("boxes of {width} x {width} near the far corner, the worst of 64");
        rows.push(Row { input, unit: LSB, careless: worst[0], ours: worst[1], ideal: 0.0, allowed: 0.5 });
    }
    Ok(rows)
}
