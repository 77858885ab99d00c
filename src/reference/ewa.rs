//! The elliptical weighted average (Heckbert 1989; Greene & Heckbert 1986): real numbers only, no chip has it. What the
//! anisotropic filters come near to, each in its way.
//!
//! A round pixel is an ellipse in the texture. Texels within it are weighted by a Gaussian of the ellipse's own distance; to
//! bound their number the minor axis is raised until the ellipse is at most `max_anisotropy` times as long as wide, and read
//! from the two levels at which it is one to two texels wide. Adding the unit matrix to the ellipse's (Heckbert's
//! convolution with the texel's own filter) keeps it from falling between texels; subtracting the Gaussian's value at the
//! rim lets it end in zero (Pharr, Jakob & Humphreys do the same).

use texunit_hw::AddressMode;

use super::{
    coordinate::{anywhere, floor, reduce},
    datapath,
    footprint::Ellipse,
    ideal::{IdealSampler, defined},
    lod::Limits,
    planes::{Plane, Planes, Reading},
};
use crate::{error::Result, pyramid::Pyramid, scene::Gradient};

/// The exponent of the Gaussian at the rim of the ellipse.
const ALPHA: f64 = 2.0;

/// A filtered texel and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EwaResponse {
    /// Red, green, blue, alpha, each 0.0 to 255.0.
    pub texel: [f64; 4],
    /// The level used.
    pub lod: f64,
    /// Texels read: those within the ellipses and the texture, four a level where it interpolates.
    pub texels_read: u64,
}

/// A mipmap read by ellipses.
///
/// ```
/// use texunit::{pyramid::{PlaneImage, Pyramid}, reference::{ewa::Ewa, ideal::IdealSampler}, scene::Gradient};
/// use texunit_hw::{PyramidKind, Sampler};
/// let pyramid = Pyramid {
///     kind: PyramidKind::Mipmap,
///     width: 1,
///     height: 1,
///     planes: vec![PlaneImage::top(1, 1, vec![[40, 80, 120, 255]])],
/// };
/// let ewa = Ewa::new(&pyramid, &IdealSampler::from(&Sampler::default()))?;
/// let response = ewa.sample([0.3, 0.7], Gradient { ux: 4.0, vy: 1.5, ..Gradient::default() });
/// assert!((response.texel[2] - 120.0).abs() < 1e-9);
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ewa<'a> {
    planes: Planes<'a>,
    size: [u32; 2],
    address: [AddressMode; 2],
    limits: Limits,
    cap: f64,
}

impl<'a> Ewa<'a> {
    /// Reads `pyramid`, a mipmap, with the address modes, level limits and cap of `sampler`; its filter is not asked for.
    ///
    /// # Errors
    /// A pyramid without the planes of a mipmap.
    pub fn new(pyramid: &'a Pyramid, sampler: &IdealSampler) -> Result<Self> {
        let planes = Planes::new(pyramid, texunit_hw::Filter::Trilinear)?;
        let limits = Limits::new(sampler.bias, sampler.min_lod, sampler.max_lod, None);
        let limits = Limits { coarsest: planes.coarsest(0), ..limits };
        Ok(Self {
            planes,
            size: [pyramid.width, pyramid.height],
            address: sampler.address,
            limits,
            cap: f64::from(sampler.max_anisotropy).max(1.0),
        })
    }

    /// The average over the footprint of a pixel at normalised (u, v). What is magnified (or has no defined size) is
    /// interpolated as trilinear does.
    #[must_use]
    pub fn sample(&self, at: [f64; 2], gradient: Gradient) -> EwaResponse {
        let at = [0, 1].map(|axis| reduce(defined(at[axis], self.address[axis]), self.address[axis]));
        let ellipse = Ellipse::of(gradient.in_texels(self.size));
        let [major, minor] = ellipse.radius;
        let raised = if minor >= major / self.cap { minor } else { major / self.cap };
        let lod = self.limits.fractional(if raised.is_finite() { libm::log2(raised) } else { f64::INFINITY });
        let level = floor(lod);
        let blur = lod - level;
        let [cosine, sine] = ellipse.direction;
        let axes = [[cosine * major, sine * major], [-sine * raised, cosine * raised]];
        let shape = (major > 1.0 && major.is_finite()).then_some(axes);
        let mut response = EwaResponse { texel: [0.0; 4], lod, texels_read: 0 };
        for (level, share) in [(level, 1.0 - blur), (level + 1.0, blur)] {
            if share > 0.0 {
                let plane = &self.planes.along_u[level as usize];
                let (texel, texels_read) = match shape {
                    Some(axes) => self.average(plane, at, axes),
                    None => self.interpolated(plane, at),
                };
                response.texels_read += texels_read;
                for (total, value) in response.texel.iter_mut().zip(texel) {
                    *total += share * value;
                }
            }
        }
        response
    }

    /// One plane, by an ellipse whose semi-axes are given in texels of level 0.
    fn average(&self, plane: &Plane<'_>, at: [f64; 2], axes: [[f64; 2]; 2]) -> ([f64; 4], u64) {
        let mut axes = axes.map(|axis| [0, 1].map(|i| axis[i] / f64::from(self.size[i]) * plane.size[i]));
        // Where bias, limits or the end of the chain keep the level too fine, the ellipse shrinks and the filter aliases, as
        // any other does. Without them no axis is longer than this.
        let longest = axes.iter().map(|axis| libm::hypot(axis[0], axis[1])).fold(0.0, f64::max);
        let shrunk = (2.0 * self.cap / longest).min(1.0);
        for component in axes.as_flattened_mut() {
            *component *= shrunk;
        }
        let [[px, py], [qx, qy]] = axes;
        let (xx, xy, yy) = (px * px + qx * qx + 1.0, px * py + qx * qy, py * py + qy * qy + 1.0);
        let area = xx * yy - xy * xy;
        // Texel i has its centre at i + 1/2; these are the first and last centres the ellipse can hold.
        let centre = [0, 1].map(|i| at[i] * plane.size[i] - 0.5);
        let reach = [libm::sqrt(xx), libm::sqrt(yy)];
        let first = [0, 1].map(|i| -floor(reach[i] - centre[i]));
        let last = [0, 1].map(|i| floor(centre[i] + reach[i]));
        let indices = |axis: usize| {
            let count = (last[axis] - first[axis]) as u64 + 1;
            (0..count).map(move |step| first[axis] + step as f64)
        };
        let rim = libm::exp(-ALPHA);
        let (mut total, mut weights, mut texels_read) = ([0.0; 4], 0.0, 0);
        for j in indices(1) {
            let dy = j - centre[1];
            let row = anywhere(j, plane.size[1], self.address[1]);
            for i in indices(0) {
                let dx = i - centre[0];
                let squared = (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / area;
                if squared >= 1.0 {
                    continue;
                }
                let weight = libm::exp(-ALPHA * squared) - rim;
                let column = anywhere(i, plane.size[0], self.address[0]);
                texels_read += u64::from(row.is_some() && column.is_some());
                weights += weight;
                for (sum, value) in total.iter_mut().zip(plane.texel(column, row)) {
                    *sum += weight * f64::from(value);
                }
            }
        }
        // The ellipse has a radius of a texel at least, so the nearest texel lies well inside.
        (total.map(|sum| sum / weights), texels_read)
    }

    fn interpolated(&self, plane: &Plane<'_>, at: [f64; 2]) -> ([f64; 4], u64) {
        let tap = plane.bilinear(at, &Reading { address: self.address, fractions: None }, 1.0);
        (datapath::sum(&[tap]), 4)
    }
}
