//! What a pixel should show: the unfiltered texture, sampled many times over the pixel's square and averaged.

use image::RgbaImage;
use rayon::prelude::*;
use serde::Serialize;
use texunit_hw::AddressMode;

use super::{Fragment, Gradient, GradientMethod, Norm, Scene, noise::unit_hash, order::Span};

/// The most sub-samples along one axis of a pixel.
pub const MOST_SAMPLES: u32 = 32;

/// How the ground truth of a scene is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Supersampling {
    /// At least this many sub-samples along each axis of a pixel; more, up to [`MOST_SAMPLES`], where a step covers more texels.
    pub samples: u32,
    /// Each sub-sample anywhere in its cell of the grid (by a hash of its place) instead of at the cell's centre.
    pub jitter: bool,
}

/// An image of averages, in units of the texture's 8-bit channels, 0.0 to 255.0; all zero where no fragment is.
///
/// ```
/// use texunit::scene::{GroundTruth, Scene};
/// let mut scene = Scene::builtin("magnified").unwrap();
/// scene.size = [64, 48];
/// let truth = GroundTruth::render(&scene, &scene.texture.image());
/// for fragment in scene.fragments() {
///     assert_eq!(truth.at(fragment.x, fragment.y)[3], 255.0); // the texture is opaque
/// }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GroundTruth {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Red, green, blue, alpha of every pixel, by rows.
    pub texels: Vec<[f32; 4]>,
}

impl GroundTruth {
    /// Averages point samples of `texture`, the level 0 of the scene's texture, in every pixel that has a fragment. Sub-samples
    /// beside the shape do not count, as coverage is not the filter's business.
    #[must_use]
    pub fn render(scene: &Scene, texture: &RgbaImage) -> Self {
        let surface = scene.surface();
        let (uv_at, texel) = (|x, y| surface.uv_at(x, y), |x, y| texture.get_pixel(x, y).0);
        let mut texels = vec![[0.0; 4]; scene.size[0] as usize * scene.size[1] as usize];
        texels.par_chunks_exact_mut(scene.size[0] as usize).zip(0..scene.size[1]).for_each_init(
            Vec::new,
            |fragments, (row, y)| {
                fragments.clear();
                let span = Span { x: 0, y, length: scene.size[0] };
                surface.span(span, GradientMethod::Analytic, fragments, &mut super::Coverage::default());
                for fragment in fragments {
                    row[usize::from(fragment.x)] = average(
                        scene.ground_truth,
                        uv_at,
                        texel,
                        texture.dimensions().into(),
                        scene.texture.wrap,
                        fragment,
                    );
                }
            },
        );
        Self { size: scene.size, texels }
    }

    /// The average of a pixel.
    #[must_use]
    pub fn at(&self, x: u16, y: u16) -> [f32; 4] {
        self.texels[usize::from(y) * self.size[0] as usize + usize::from(x)]
    }

    /// Rounded to 8 bits, half up, for looking at.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "averages of 8-bit values")]
    pub fn image(&self) -> RgbaImage {
        RgbaImage::from_fn(self.size[0], self.size[1], |x, y| {
            image::Rgba(self.at(x as u16, y as u16).map(|channel| (channel + 0.5) as u8))
        })
    }
}

/// The average of the unfiltered texture over a fragment's parallelogram: the truth where no surface is known, only what a request
/// says of it.
#[must_use]
pub fn footprint_average(
    supersampling: Supersampling,
    texel: impl Fn(u32, u32) -> [u8; 4],
    size: [u32; 2],
    wrap: [AddressMode; 2],
    fragment: &Fragment,
) -> [f32; 4] {
    let Gradient { ux, uy, vx, vy } = fragment.gradient;
    let uv_at = |x: f64, y: f64| {
        let (right, below) = (x - f64::from(fragment.x) - 0.5, y - f64::from(fragment.y) - 0.5);
        Some((fragment.u + ux * right + uy * below, fragment.v + vx * right + vy * below))
    };
    average(supersampling, uv_at, texel, size, wrap, fragment)
}

/// Sub-samples along an axis for a footprint of `sigma1` texels: one per texel, within the limits.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates, then the limits hold")]
fn samples_for(squared_sigma1: f32, least: u32) -> u32 {
    (f64::from(squared_sigma1).sqrt().ceil() as u32).clamp(least.min(MOST_SAMPLES), MOST_SAMPLES)
}

#[allow(clippy::cast_possible_truncation, reason = "stored as f32: 24 bits for an average of 8-bit values")]
fn average(
    supersampling: Supersampling,
    uv_at: impl Fn(f64, f64) -> Option<(f64, f64)>,
    texel: impl Fn(u32, u32) -> [u8; 4],
    size: [u32; 2],
    wrap: [AddressMode; 2],
    fragment: &Fragment,
) -> [f32; 4] {
    let footprint = Norm::Sigma1.squared_ratio(fragment.gradient.in_texels(size));
    let samples = samples_for(footprint, supersampling.samples);
    let (left, top) = (f64::from(fragment.x), f64::from(fragment.y));
    let (mut sum, mut count) = ([0_u32; 4], 0_u32);
    let add = |sum: &mut [u32; 4], (u, v): (f64, f64)| {
        // Outside, when clipped, is transparent black: it counts and adds nothing.
        let (Some(x), Some(y)) = (texel_under(wrap[0], u, size[0]), texel_under(wrap[1], v, size[1])) else { return };
        for (sum, channel) in sum.iter_mut().zip(texel(x, y)) {
            *sum += u32::from(channel);
        }
    };
    let cell = f64::from(samples).recip();
    let pixel = u32::from(fragment.x) | u32::from(fragment.y) << 16;
    for (row, column) in (0..samples).flat_map(|row| (0..samples).map(move |column| (row, column))) {
        let number = row * samples + column;
        let (within_x, within_y) =
            if supersampling.jitter { (unit_hash(pixel, number, 0), unit_hash(pixel, number, 1)) } else { (0.5, 0.5) };
        let x = left + (f64::from(column) + within_x) * cell;
        let y = top + (f64::from(row) + within_y) * cell;
        if let Some(uv) = uv_at(x, y) {
            add(&mut sum, uv);
            count += 1;
        }
    }
    // A sliver between the grid points covers the centre alone: the centre then stands for the pixel.
    if count == 0 {
        add(&mut sum, (fragment.u, fragment.v));
        count = 1;
    }
    sum.map(|channel| (f64::from(channel) / f64::from(count)) as f32)
}

/// The texel of an axis of `texels` under a normalised coordinate, not quantised; `None` outside, when clipped. Infinity and NaN
/// are outside too: there is no truth for them.
#[inline]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "reduced to 0..texels before the cast")]
fn texel_under(wrap: AddressMode, coordinate: f64, texels: u32) -> Option<u32> {
    if !coordinate.is_finite() {
        return None;
    }
    let size = f64::from(texels);
    let last = texels - 1;
    match wrap {
        AddressMode::Wrap => Some((((coordinate - whole(coordinate)) * size) as u32).min(last)),
        AddressMode::Clamp => Some(((coordinate * size).max(0.0) as u32).min(last)),
        AddressMode::Clip => (0.0..1.0).contains(&coordinate).then(|| ((coordinate * size) as u32).min(last)),
        AddressMode::Mirror => {
            let turn = coordinate - 2.0 * whole(coordinate / 2.0);
            let index = ((turn * size) as u32).min(2 * texels - 1);
            Some(if index < texels { index } else { 2 * texels - 1 - index })
        }
    }
}

/// The largest whole number not above a finite one. What `f64::floor` says, without the call it is where the processor's own
/// rounding cannot be assumed: this is asked for every sub-sample.
#[inline]
#[allow(clippy::cast_possible_truncation, reason = "beyond 2^52 every number is whole")]
fn whole(number: f64) -> f64 {
    if number.abs() >= 4_503_599_627_370_496.0 {
        return number;
    }
    let towards_zero = number as i64 as f64;
    if towards_zero > number { towards_zero - 1.0 } else { towards_zero }
}
