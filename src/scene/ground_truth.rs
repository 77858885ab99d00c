//! What a pixel should show: the unfiltered texture, sampled many times over the pixel's square and averaged.

use std::sync::LazyLock;

use image::RgbaImage;
use rayon::prelude::*;
use serde::Serialize;
use texunit_hw::AddressMode;

use super::{
    Fragment, Gradient, GradientMethod, Norm, Plane, Quadric, Scene, Surface, noise::SeededHash, order::Span,
    whole::whole,
};

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
        match &surface {
            Surface::Plane(plane) => Self::of_shape(scene, texture, &surface, plane),
            Surface::Quadric(quadric) => Self::of_shape(scene, texture, &surface, quadric),
        }
    }

    /// The same for one shape: what is under a sub-sample is asked for every one.
    fn of_shape(scene: &Scene, texture: &RgbaImage, surface: &Surface, shape: &(impl UvAt + Sync)) -> Self {
        let (source, _) = texture.as_raw().as_chunks::<4>();
        let texel = |x: u32, y: u32| source[y as usize * texture.width() as usize + x as usize];
        let places = Places::new(scene.ground_truth.jitter);
        let mut texels = vec![[0.0; 4]; scene.size[0] as usize * scene.size[1] as usize];
        let rows = texels.par_chunks_exact_mut(scene.size[0] as usize).zip(0..scene.size[1]);
        // Rows at a horizon have most of the work.
        rows.with_max_len(4).for_each_init(Vec::new, |fragments, (row, y)| {
            fragments.clear();
            let span = Span { x: 0, y, length: scene.size[0] };
            surface.span(span, GradientMethod::Analytic, fragments, &mut super::Coverage::default());
            for fragment in fragments {
                row[usize::from(fragment.x)] = average(
                    scene.ground_truth.samples,
                    places,
                    shape,
                    texel,
                    texture.dimensions().into(),
                    scene.texture.wrap,
                    fragment,
                );
            }
        });
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
    texel: impl Fn(u32, u32) -> [u8; 4] + Copy,
    size: [u32; 2],
    wrap: [AddressMode; 2],
    fragment: &Fragment,
) -> [f32; 4] {
    average(supersampling.samples, Places::new(supersampling.jitter), fragment, texel, size, wrap, fragment)
}

/// Whatever lies under points of the screen.
trait UvAt {
    /// Normalised (u, v), `None` where the shape is not.
    fn uv_at(&self, x: f64, y: f64) -> Option<(f64, f64)>;
}

impl UvAt for Plane {
    #[inline(always)]
    fn uv_at(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        self.uv_at(x, y)
    }
}

impl UvAt for Quadric {
    #[inline(always)]
    fn uv_at(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        self.uv_at(x, y)
    }
}

/// The plane that touches an unknown surface in a fragment.
impl UvAt for Fragment {
    #[inline(always)]
    fn uv_at(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let Gradient { ux, uy, vx, vy } = self.gradient;
        let (right, below) = (x - f64::from(self.x) - 0.5, y - f64::from(self.y) - 0.5);
        Some((self.u + ux * right + uy * below, self.v + vx * right + vy * below))
    }
}

/// Sub-samples looked at side by side: plain loops over so many, which the compiler turns into vectors.
const LANES: usize = 8;

/// By number of a sub-sample, the hashes that place it in its cell along x and along y.
static HASHES: LazyLock<Vec<[SeededHash; 2]>> = LazyLock::new(|| {
    let numbers = 0..(MOST_SAMPLES * MOST_SAMPLES).next_multiple_of(LANES as u32);
    numbers.map(|number| [0, 1].map(|axis| SeededHash::new(number, axis))).collect()
});

/// Where sub-samples lie in their cells of a pixel's grid.
#[derive(Clone, Copy)]
struct Places {
    /// None at the centres.
    jitter: Option<&'static [[SeededHash; 2]]>,
}

impl Places {
    fn new(jitter: bool) -> Self {
        Self { jitter: jitter.then(|| HASHES.as_slice()) }
    }

    /// Of the sub-samples from the one numbered `first`, within the cell.
    #[inline(always)]
    fn within(&self, pixel: u32, first: u32) -> [[f64; LANES]; 2] {
        let mut within = [[0.5; LANES]; 2];
        if let Some(hashes) = self.jitter {
            let hashes = &hashes[first as usize..][..LANES];
            for (lane, [x, y]) in hashes.iter().enumerate() {
                within[0][lane] = x.unit(pixel);
                within[1][lane] = y.unit(pixel);
            }
        }
        within
    }
}

/// Sub-samples along an axis for a footprint of `sigma1` texels: one per texel, within the limits.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates, then the limits hold")]
fn samples_for(squared_sigma1: f32, least: u32) -> u32 {
    (f64::from(squared_sigma1).sqrt().ceil() as u32).clamp(least.min(MOST_SAMPLES), MOST_SAMPLES)
}

#[allow(clippy::cast_possible_truncation, reason = "stored as f32: 24 bits for an average of 8-bit values")]
fn average(
    least: u32,
    places: Places,
    shape: &impl UvAt,
    texel: impl Fn(u32, u32) -> [u8; 4] + Copy,
    size: [u32; 2],
    wrap: [AddressMode; 2],
    fragment: &Fragment,
) -> [f32; 4] {
    let footprint = Norm::Sigma1.squared_ratio(fragment.gradient.in_texels(size));
    let samples = samples_for(footprint, least);
    let (left, top) = (f64::from(fragment.x), f64::from(fragment.y));
    let cell = f64::from(samples).recip();
    let pixel = u32::from(fragment.x) | u32::from(fragment.y) << 16;
    let (mut sum, mut count) = ([0_u32; 4], 0);
    let (mut column, mut row) = (0, 0);
    for first in (0..samples * samples).step_by(LANES) {
        let [mut x, mut y] = places.within(pixel, first);
        let mut there = [false; LANES];
        for lane in 0..LANES {
            x[lane] = left + (f64::from(column) + x[lane]) * cell;
            y[lane] = top + (f64::from(row) + y[lane]) * cell;
            there[lane] = row < samples;
            column += 1;
            if column == samples {
                (column, row) = (0, row + 1);
            }
        }
        let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let (seen, uv) = shape.uv_at(x[lane], y[lane]).map_or((false, (0.0, 0.0)), |uv| (true, uv));
            (u[lane], v[lane]) = uv;
            there[lane] &= seen;
        }
        count += there.iter().map(|&there| u32::from(there)).sum::<u32>();
        add(&mut sum, there, [u, v], texel, size, wrap);
    }
    // A sliver between the grid points covers the centre alone: the centre then stands for the pixel.
    if count == 0 {
        let mut there = [false; LANES];
        there[0] = true;
        add(&mut sum, there, [[fragment.u; LANES], [fragment.v; LANES]], texel, size, wrap);
        count = 1;
    }
    sum.map(|channel| (f64::from(channel) / f64::from(count)) as f32)
}

/// Adds the texels under the sub-samples that are there. Outside, when clipped, is transparent black: it adds nothing.
#[inline(always)]
fn add(
    sum: &mut [u32; 4],
    there: [bool; LANES],
    uv: [[f64; LANES]; 2],
    texel: impl Fn(u32, u32) -> [u8; 4],
    size: [u32; 2],
    wrap: [AddressMode; 2],
) {
    let (x, x_inside) = texels_under(wrap[0], uv[0], size[0]);
    let (y, y_inside) = texels_under(wrap[1], uv[1], size[1]);
    // Channels 0 and 2, and 1 and 3: eight bytes added fit into 16 bits.
    const EVEN: u32 = 0x00FF_00FF;
    let (mut even, mut odd) = (0, 0);
    for lane in 0..LANES {
        let counts = there[lane] & x_inside[lane] & y_inside[lane];
        let bits = u32::from_le_bytes(texel(x[lane], y[lane])) & if counts { u32::MAX } else { 0 };
        even += bits & EVEN;
        odd += bits >> 8 & EVEN;
    }
    for (sum, channel) in sum.iter_mut().zip([even & 0xFFFF, odd & 0xFFFF, even >> 16, odd >> 16]) {
        *sum += channel;
    }
}

/// The texels of an axis of `texels` under normalised coordinates, not quantised, and whether they are inside: all are but clipped
/// ones. Infinity and NaN are outside too: there is no truth for them.
#[inline(always)]
fn texels_under(wrap: AddressMode, coordinates: [f64; LANES], texels: u32) -> ([u32; LANES], [bool; LANES]) {
    let size = f64::from(texels);
    // A cast to i32 is one instruction for several lanes, one to u32 is not; both saturate far above any index.
    let texel = |position: f64, last: u32| (position as i32 as u32).min(last);
    let (mut indices, mut inside) = ([0; LANES], [false; LANES]);
    let lanes = indices.iter_mut().zip(coordinates);
    match wrap {
        AddressMode::Wrap => lanes.for_each(|(index, c)| *index = texel((c - whole(c)) * size, texels - 1)),
        AddressMode::Clamp | AddressMode::Clip => {
            lanes.for_each(|(index, c)| *index = texel((c * size).max(0.0), texels - 1));
        }
        AddressMode::Mirror => lanes.for_each(|(index, c)| {
            let turn = texel((c - 2.0 * whole(c / 2.0)) * size, 2 * texels - 1);
            *index = if turn < texels { turn } else { 2 * texels - 1 - turn };
        }),
    }
    for (inside, c) in inside.iter_mut().zip(coordinates) {
        *inside = if wrap == AddressMode::Clip { (0.0..1.0).contains(&c) } else { c.is_finite() };
    }
    (indices, inside)
}
