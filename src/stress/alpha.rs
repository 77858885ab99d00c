//! X17: where the texture ends and alpha falls.

use texunit_hw::{AddressMode, Filter, LodSource, PyramidKind};

use super::{
    Case, LSB, Options, Row,
    lab::{self, Lab},
};
use crate::{
    error::Result,
    experiment::verify::SplitMix,
    pyramid::{Build, Kernel, PlaneImage},
};

pub(super) const CLIP_EDGE: Case = Case {
    name: "X17",
    title: "alpha at the edges of clip",
    wrong: "straight alpha darkens the fringe by up to 63.75 LSB; the lobes of a kernel lift colours above their alpha",
    run: clip_edge,
};

fn clip_edge(_: &Options) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let white = Lab::mipmap(&lab::picture([4, 4], |_, _| 255))?;
    let sampler = lab::sampler(Filter::Bilinear, AddressMode::Clip, LodSource::Gradient);
    for (name, u) in [("on the edge", 0.0), ("a quarter texel outside", -0.0625), ("a quarter texel inside", 0.0625)] {
        let [colour, .., alpha] = white.at(&sampler, u, 0.5)?.texel.map(|channel| f64::from(channel) / 255.0);
        let over = |colour: f64| 255.0 * (colour + (1.0 - alpha));
        let input = format!("opaque white over white, {name}");
        // Straight alpha: the colour is multiplied once more.
        rows.push(Row {
            input,
            unit: LSB,
            careless: over(colour * alpha),
            ours: over(colour),
            ideal: 255.0,
            allowed: 0.5,
        });
    }
    // A premultiplied texture through a kernel with lobes.
    let mut random = SplitMix(17);
    let mut texel = || {
        let [r, g, b, a, ..] = random.draw().to_le_bytes();
        [r, g, b, if r & 1 == 0 { 255 } else { a }].map(|channel| channel.min(if r & 1 == 0 { 255 } else { a }))
    };
    let texels: Vec<[u8; 4]> = (0..64 * 64).map(|_| texel()).collect();
    let build = Build { kernel: Kernel::Kaiser, ..Build::default() };
    let build_of = |map: fn([u8; 4]) -> [u8; 4]| {
        build.pyramid(PyramidKind::Mipmap, &PlaneImage::top(64, 64, texels.iter().copied().map(map).collect()))
    };
    let ours = build_of(|texel| texel)?;
    // Colours and alpha made apart, as channels that know nothing of each other: opaque colours are never limited.
    let colours = build_of(|[r, g, b, _]| [r, g, b, 255])?;
    let alphas = build_of(|[.., a]| [a, a, a, 255])?;
    let above = |colour: &[u8; 4], alpha: u8| colour[..3].iter().any(|channel| *channel > alpha);
    let careless: usize = colours
        .planes
        .iter()
        .zip(&alphas.planes)
        .map(|(colours, alphas)| colours.texels.iter().zip(&alphas.texels).filter(|(c, a)| above(c, a[0])).count())
        .sum();
    let broken: usize =
        ours.planes.iter().map(|plane| plane.texels.iter().filter(|texel| above(texel, texel[3])).count()).sum();
    rows.push(Row {
        input: "kaiser on 64 x 64 premultiplied texels: texels with a colour above alpha".into(),
        unit: "texels",
        careless: careless as f64,
        ours: broken as f64,
        ideal: 0.0,
        allowed: 0.0,
    });
    Ok(rows)
}
