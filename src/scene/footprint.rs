//! From a gradient to the squared scaling ratio that selects a level: the norms of E3 and the axis rules of E9 and E10.
//!
//! All arithmetic is f64, rounded once to f32 at the end; what is too large for f32 becomes infinity, which the LOD unit
//! answers with the coarsest level. The result is NaN only where the gradient is.

use super::Gradient;

/// Which number stands for the whole 2x2 matrix J = (ux uy; vx vy), in texels per pixel, when a filter has one level.
/// The truth for an isotropic filter is sigma1; the first three only ever fall short of it (E3), so they alias, never blur.
///
/// ```
/// use texunit::scene::{Gradient, Norm};
/// // A floor 8 times minified along v: 8 squared, whatever the norm but the area.
/// let gradient = Gradient { ux: 1.0, vy: 8.0, ..Gradient::default() };
/// assert_eq!(Norm::Heckbert.squared_ratio(gradient.in_texels([1, 1])), 64.0);
/// assert_eq!(Norm::Area.squared_ratio(gradient.in_texels([1, 1])), 8.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// The longer of the two screen-axis vectors (ux, vx) and (uy, vy): Heckbert, Flavell, OpenGL. Up to half a level short.
    #[default]
    Heckbert,
    /// The longer of the two texture-axis vectors (ux, uy) and (vx, vy): Herf 1999, part 3. Up to half a level short.
    Herf,
    /// The largest of the four magnitudes (Du & Wan, equation 3; the Nintendo 64). Up to one level short.
    Max,
    /// The area of the footprint, |det J|: Flavell, Herf's per-polygon level. Short without bound when it is elongated.
    Area,
    /// The largest singular value: the longest axis of the footprint ellipse.
    Sigma1,
    /// The smaller of the screen-axis magnitudes of equation 3, Du & Wan's figure 2b: sharp along the minor axis, and aliased
    /// along the major one, without bound.
    Min,
}

impl Norm {
    /// Every norm, in the order of the table of E3.
    pub const ALL: [Self; 6] = [Self::Heckbert, Self::Herf, Self::Max, Self::Area, Self::Sigma1, Self::Min];

    /// The squared scaling ratio, (texels of level 0 per pixel)^2, of a gradient already [in texels](Gradient::in_texels).
    #[must_use]
    pub fn squared_ratio(self, texels: Gradient) -> f32 {
        let Gradient { ux, uy, vx, vy } = texels;
        let squared = match self {
            Self::Heckbert => larger(ux * ux + vx * vx, uy * uy + vy * vy),
            Self::Herf => larger(ux * ux + uy * uy, vx * vx + vy * vy),
            Self::Max => larger(larger(ux * ux, uy * uy), larger(vx * vx, vy * vy)),
            Self::Min => {
                let [x, y] = [larger(ux * ux, vx * vx), larger(uy * uy, vy * vy)];
                if x < y || x.is_nan() { x } else { y }
            }
            Self::Area => (ux * vy - uy * vx).abs(),
            Self::Sigma1 => {
                // Eigenvalue of J^T J = (A B; B C). A sum of non-negative terms: nothing cancels.
                let (a, b, c) = (ux * ux + vx * vx, ux * uy + vx * vy, uy * uy + vy * vy);
                (a + c + libm::hypot(a - c, 2.0 * b)) / 2.0
            }
        };
        saturated(squared, texels)
    }
}

/// Which scaling ratio drives which pyramid when each texture axis has a level of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AxisRule {
    /// The column pyramid follows the u axis, max(|ux|, |uy|), the row pyramid the v axis, max(|vx|, |vy|): right under any
    /// rotation (E10).
    #[default]
    TextureAxes,
    /// Du & Wan, main step 3 as printed: L_x for the row pyramid, L_y for the column pyramid (E9).
    PaperStep3,
    /// Du & Wan, II-A: L_y = log2 max(|uy|, |vy|) for the row pyramid, L_x for the column pyramid. Right without rotation.
    Paper2a,
}

impl AxisRule {
    /// The squared ratios, texels of level 0 per pixel, of a gradient [in texels](Gradient::in_texels): `[0]` drives the
    /// column pyramid (halved width), `[1]` the row pyramid (halved height), as `scale` of a request does.
    #[must_use]
    pub fn squared_ratios(self, texels: Gradient) -> [f32; 2] {
        let Gradient { ux, uy, vx, vy } = texels;
        let screen_x = larger(ux * ux, vx * vx);
        let screen_y = larger(uy * uy, vy * vy);
        match self {
            Self::TextureAxes => [larger(ux * ux, uy * uy), larger(vx * vx, vy * vy)],
            Self::Paper2a => [screen_x, screen_y],
            Self::PaperStep3 => [screen_y, screen_x],
        }
        .map(|squared| saturated(squared, texels))
    }
}

/// The maximum, and NaN if either is: `f64::max` would hide one.
fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// Rounded to f32. Infinity minus infinity, out of an overflow on the way, is an infinite ratio and not NaN.
#[allow(clippy::cast_possible_truncation, reason = "the one rounding, to nearest; too large becomes infinity")]
fn saturated(squared: f64, texels: Gradient) -> f32 {
    if squared.is_nan() && !texels.is_nan() { f32::INFINITY } else { squared as f32 }
}
