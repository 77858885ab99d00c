//! Texels into elements: the nearest code of every channel, the nearest colour of a palette, a good block.

use rayon::prelude::*;
use texpresso::{Algorithm, COLOUR_WEIGHTS_UNIFORM, Params};
use texunit_hw::{Format, Palette};

use super::{bc7_encode, palette};
use crate::pyramid::PlaneImage;

/// Codes of 8-bit values for each width of channel.
#[derive(Debug)]
pub struct Encoder<'p> {
    format: Format,
    palette: Option<&'p Palette>,
    five: [u16; 256],
    six: [u16; 256],
}

/// For each 8-bit value the code of `bits` bits whose 8-bit meaning is nearest, the lower one of two.
fn nearest_codes(bits: u32) -> [u16; 256] {
    let meaning = |code: u16| i32::from(code << (8 - bits) | code >> (2 * bits - 8));
    std::array::from_fn(|value| {
        (0..1 << bits).min_by_key(|&code| (meaning(code) - value as i32).abs()).unwrap_or_default()
    })
}

/// Grey of a colour, the weights of ITU-R BT.601 in 1/256; three equal channels are that grey.
fn grey([red, green, blue, _]: [u8; 4]) -> u8 {
    ((77 * u32::from(red) + 150 * u32::from(green) + 29 * u32::from(blue) + 128) >> 8) as u8
}

impl<'p> Encoder<'p> {
    /// For one format; `palette` is read by [`Format::Palette8`] only.
    pub fn new(format: Format, palette: Option<&'p Palette>) -> Self {
        Self { format, palette, five: nearest_codes(5), six: nearest_codes(6) }
    }

    /// The elements of a plane, row after row.
    pub fn plane(&self, plane: &PlaneImage) -> Vec<u8> {
        let five = |value: u8| self.five[usize::from(value)];
        let six = |value: u8| self.six[usize::from(value)];
        // Nearest multiple of 17; there is no tie, 17 being odd.
        let four = |value: u8| (u16::from(value) + 8) / 17;
        let one = |value: u8| u16::from(value >> 7);
        match self.format {
            Format::Rgba8 => plane.texels.as_flattened().to_vec(),
            Format::Rgb565 => each(plane, |[r, g, b, _]| (five(r) << 11 | six(g) << 5 | five(b)).to_le_bytes()),
            Format::Argb1555 => {
                each(plane, |[r, g, b, a]| (one(a) << 15 | five(r) << 10 | five(g) << 5 | five(b)).to_le_bytes())
            }
            Format::Argb4444 => {
                each(plane, |[r, g, b, a]| (four(a) << 12 | four(r) << 8 | four(g) << 4 | four(b)).to_le_bytes())
            }
            Format::L8 => each(plane, |texel| [grey(texel)]),
            Format::A8 => each(plane, |texel| [texel[3]]),
            Format::La8 => each(plane, |texel| [grey(texel), texel[3]]),
            Format::Palette8 => {
                let colours = self.palette.unwrap_or(&[[0; 4]; 256]);
                plane.texels.par_iter().map(|texel| palette::nearest(colours, *texel)).collect()
            }
            Format::Bc1 => squish(plane, texpresso::Format::Bc1),
            Format::Bc3 => squish(plane, texpresso::Format::Bc3),
            Format::Bc7 => bc7_encode::plane(plane),
        }
    }
}

fn each<const BYTES: usize>(plane: &PlaneImage, element: impl Fn([u8; 4]) -> [u8; BYTES]) -> Vec<u8> {
    plane.texels.iter().flat_map(|&texel| element(texel)).collect()
}

/// Cluster fit, channels weighing the same (the crate's port of libsquish).
fn squish(plane: &PlaneImage, format: texpresso::Format) -> Vec<u8> {
    let (width, height) = (plane.width as usize, plane.height as usize);
    let params =
        Params { algorithm: Algorithm::ClusterFit, weights: COLOUR_WEIGHTS_UNIFORM, weigh_colour_by_alpha: false };
    let mut elements = vec![0; format.compressed_size(width, height)];
    format.compress(plane.texels.as_flattened(), width, height, params, &mut elements);
    elements
}
