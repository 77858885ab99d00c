//! A natural-looking texture: a mandrill-like face in fur. The papers' baboon is hard to filter because it has detail at all
//! scales, hairs in all directions and strong colours; so has this. It repeats without a seam in its noise.

use std::sync::{Arc, Mutex, PoisonError};

use image::{Rgb, RgbImage, RgbaImage, buffer::ConvertBuffer};
use rayon::prelude::*;

use super::{
    noise::{Octaves, hash, unit_hash},
    texture::Procedural,
    whole::whole,
};

type Colour = [f64; 3];

const OLIVE: Colour = [150.0, 128.0, 78.0];
const GREY: Colour = [126.0, 128.0, 132.0];
const BEARD: Colour = [214.0, 178.0, 96.0];
const BLUE: Colour = [104.0, 158.0, 214.0];
const RED: Colour = [222.0, 62.0, 40.0];
const DARK: Colour = [34.0, 28.0, 26.0];
const AMBER: Colour = [224.0, 164.0, 44.0];

/// Half the length of a hair, in steps of one texel.
const HAIR: i32 = 12;

/// The one made last: it takes a while, is asked for by several who look at one scene, and two scenes in a row may share it.
static LAST: Mutex<Option<(Procedural, Arc<RgbaImage>)>> = Mutex::new(None);

/// The texels.
pub(super) fn image(texture: &Procedural) -> Arc<RgbaImage> {
    // Whoever panicked while holding it has left it as it was. Not held while painting, which other tasks may be waited for in.
    let last = || LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((known, image)) = &*last()
        && known == texture
    {
        return Arc::clone(image);
    }
    let image = Arc::new(painted(texture));
    *last() = Some((*texture, Arc::clone(&image)));
    image
}

fn painted(texture: &Procedural) -> RgbaImage {
    let [width, height] = texture.size;
    let strands = Strands::new(texture);
    let centres: Vec<f64> = (0..width).map(|x| (f64::from(x) + 0.5) / f64::from(width)).collect();
    let cells = texture.size.map(|axis| (axis / texture.cell).max(1));
    let noise = |count, seed| Octaves::new(&centres, cells, count, seed);
    let (coarse, warp) = (noise(texture.cell.max(2).ilog2(), texture.seed), noise(3, texture.seed + 101));
    let mut rgb = RgbImage::new(width, height);
    rgb.par_chunks_exact_mut(3 * width as usize).enumerate().for_each(|(y, row)| {
        let t = (y as f64 + 0.5) / f64::from(height);
        let (coarse, warp) = (coarse.row(t), warp.row(t));
        for (x, texel) in row.chunks_exact_mut(3).enumerate() {
            #[allow(clippy::cast_possible_truncation, reason = "within the image")]
            let at = (x as u32, y as u32);
            texel.copy_from_slice(&shade(texture, &strands, at, [centres[x], t], [coarse.at(x), warp.at(x) - 0.5]).0);
        }
    });
    rgb.convert()
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0..=255 before the cast")]
fn shade(
    texture: &Procedural,
    strands: &Strands,
    (x, y): (u32, u32),
    [s, t]: [f64; 2],
    [coarse, warp]: [f64; 2],
) -> Rgb<u8> {
    let aside = (s - 0.5).abs() + 0.06 * warp;

    let fibre = strands.hairs(x, y, libm::atan2(t - 0.42, s - 0.5) + 5.0 * warp);
    let (mut colour, mut softness) = (fur_colour(s, t, coarse), 1.0);
    // Cheeks: ridged blue skin beside the nose, where hair is short.
    let swell = ((t - 0.56) / 0.25) * ((t - 0.56) / 0.25) + ((aside - 0.10) / 0.13) * ((aside - 0.10) / 0.13);
    let cheek = smooth(1.15, 0.8, swell);
    let ridge = 0.75 + 0.25 * libm::sin((aside * 5.0 - t * 0.8 + 0.25 * warp) * 40.0);
    colour = mix(colour, BLUE.map(|channel| channel * ridge), cheek);
    softness *= 1.0 - 0.65 * cheek;
    // Nose: a red stripe that widens downwards.
    let half_width = 0.035 + 0.07 * smooth(0.40, 0.78, t);
    let nose = smooth(half_width + 0.012, half_width - 0.012, aside) * smooth(0.22, 0.28, t) * smooth(0.84, 0.79, t);
    colour = mix(colour, RED.map(|channel| channel * (0.7 + 0.6 * coarse)), nose);
    softness *= 1.0 - 0.7 * nose;
    // Nostrils, eyes.
    for (side, down, radius, inner, outer) in [(0.05, 0.785, 0.022, DARK, DARK), (0.135, 0.255, 0.05, AMBER, DARK)] {
        let distance = libm::hypot(aside - side, (t - down) * 1.25) / radius;
        colour = mix(colour, outer, smooth(1.25, 0.95, distance));
        colour = mix(colour, inner, smooth(0.72, 0.62, distance));
        colour = mix(colour, DARK, smooth(0.34, 0.26, distance));
        softness *= 1.0 - 0.9 * smooth(1.2, 0.9, distance);
    }

    let grain = unit_hash(x, y, texture.seed + 7) - 0.5;
    let light = (0.62 + 0.76 * coarse) * (1.0 + softness * fibre) * (1.0 + 0.10 * grain);
    Rgb(colour.map(|channel| (channel * light).clamp(0.0, 255.0) as u8))
}

/// Olive at the sides, grey on the forehead, a yellow beard below.
fn fur_colour(s: f64, t: f64, coarse: f64) -> Colour {
    let centre = 1.0 - (2.0 * s - 1.0).abs();
    let forehead = smooth(0.34, 0.12, t) * centre;
    let beard = smooth(0.72, 0.92, t + 0.2 * (coarse - 0.5)) * centre;
    mix(mix(OLIVE, GREY, forehead), BEARD, beard)
}

/// White noise at two widths, hashed once per texel: hairs read every texel many times.
struct Strands {
    size: [i32; 2],
    /// By rows; a hair of the second is three texels wide.
    noise: [(i32, Vec<u16>); 2],
}

impl Strands {
    #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "sizes are at most 8192")]
    fn new(texture: &Procedural) -> Self {
        let [width, height] = texture.size;
        let noise = [(1, 31), (3, 37)].map(|(thickness, seed)| {
            let texels = (0..height).into_par_iter().flat_map_iter(|y| {
                (0..width).map(move |x| (hash(x / thickness, y / thickness, texture.seed + seed) >> 16) as u16)
            });
            (thickness as i32, texels.collect())
        });
        Self { size: [width as i32, height as i32], noise }
    }

    /// Hairs: white noise averaged along a flow that leaves the face and curls (a line integral convolution). Contrast -0.7
    /// to 0.9.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "reduced to the image before the cast")]
    fn hairs(&self, x: u32, y: u32, direction: f64) -> f64 {
        let (along_x, along_y) = (libm::cos(direction), libm::sin(direction));
        let [width, height] = self.size;
        let within = |index: i32, size: i32| if (0..size).contains(&index) { index } else { index.rem_euclid(size) };
        let [fine, wide] = [&self.noise[0], &self.noise[1]].map(|(thickness, noise)| {
            let sum: u32 = (-HAIR..HAIR + 1)
                .map(|step| {
                    let reach = f64::from(step * thickness);
                    let column = within(whole(f64::from(x) + along_x * reach + 0.5) as i32, width);
                    let row = within(whole(f64::from(y) + along_y * reach + 0.5) as i32, height);
                    u32::from(noise[row as usize * width as usize + column as usize])
                })
                .sum();
            f64::from(sum) / (65536.0 * f64::from(2 * HAIR + 1)) - 0.5
        });
        (4.5 * fine + 2.5 * wide).clamp(-0.7, 0.9)
    }
}

fn mix(a: Colour, b: Colour, share: f64) -> Colour {
    std::array::from_fn(|channel| a[channel] + (b[channel] - a[channel]) * share)
}

/// 0 at `from`, 1 at `to`, smooth between; either may be the larger.
fn smooth(from: f64, to: f64, value: f64) -> f64 {
    let share = ((value - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}
