//! The footprint of a pixel in the texture (docs/numerics.md, section 9), in real numbers: what the front end's vectors and
//! scales come from, before they are rounded to what a request holds.

use texunit_hw::Filter;

use crate::scene::Gradient;

/// What a filter is told about the footprint of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// Texels of level 0 per pixel, squared: of the major and the minor axis, or of the u and the v axis.
    pub squared: [f64; 2],
    /// The vectors the filter looks along, (du, dv) in turns.
    pub axes: [[f64; 2]; 2],
    /// Screen x and y, for the hash of FAST.
    pub pixel: [u16; 2],
}

impl Footprint {
    /// The footprint as a filter wants it, on a texture of `size` texels.
    ///
    /// Texram, Feline and FAST: the table of section 9. Filters with a level per axis: the longest step along each texture
    /// axis (E10). All others: both singular values (E3). The last two look along nothing.
    ///
    /// ```
    /// use texunit::{reference::footprint::Footprint, scene::Gradient};
    /// use texunit_hw::Filter;
    /// // A step in x crosses 2 texels of 64, a step in y 8 of 32.
    /// let gradient = Gradient { ux: 2.0 / 64.0, vy: 8.0 / 32.0, ..Gradient::default() };
    /// let footprint = Footprint::new(Filter::Texram, gradient, [64, 32], [0, 0]);
    /// assert_eq!(footprint.squared, [64.0, 4.0]);
    /// assert_eq!(footprint.axes, [[0.0, 0.25], [0.0, 0.0]]);
    /// ```
    #[must_use]
    pub fn new(filter: Filter, gradient: Gradient, size: [u32; 2], pixel: [u16; 2]) -> Self {
        let Gradient { ux, uy, vx, vy } = gradient;
        let texels = gradient.in_texels(size);
        let length = |u: f64, v: f64| u * u + v * v;
        // Equal or undefined: the x axis.
        let y_is_longer = length(texels.uy, texels.vy) > length(texels.ux, texels.vx);
        let [longer, shorter] = if y_is_longer { [[uy, vy], [ux, vx]] } else { [[ux, vx], [uy, vy]] };
        let ellipse = Ellipse::of(texels);
        let singular = ellipse.radius.map(|radius| radius * radius);
        let none = [0.0; 2];
        let (squared, axes) = match filter {
            Filter::Texram => {
                let [u, v] = [longer[0] * f64::from(size[0]), longer[1] * f64::from(size[1])];
                let across = across(ellipse.area, libm::sqrt(length(u, v)));
                ([length(u, v), across * across], [longer, none])
            }
            Filter::Feline => {
                let [cosine, sine] = ellipse.direction;
                let major = [cosine / f64::from(size[0]), sine / f64::from(size[1])].map(|one| one * ellipse.radius[0]);
                (singular, [major, none])
            }
            Filter::Fast | Filter::Sat => (singular, [longer, shorter]),
            _ if filter.level_per_axis() => {
                let longest = |a: f64, b: f64| if a > b || a.is_nan() { a * a } else { b * b };
                let squared = [longest(texels.ux.abs(), texels.uy.abs()), longest(texels.vx.abs(), texels.vy.abs())];
                (squared, [none; 2])
            }
            _ => (singular, [none; 2]),
        };
        Self { squared, axes, pixel }
    }
}

/// The image of the unit circle under a 2 x 2 matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ellipse {
    /// Half the major and half the minor axis: the singular values.
    pub radius: [f64; 2],
    /// The major axis, of length 1, to the right or straight down.
    pub direction: [f64; 2],
    /// The determinant's magnitude.
    area: f64,
}

impl Ellipse {
    /// The ellipse of a gradient in texels.
    pub fn of(texels: Gradient) -> Self {
        let Gradient { ux, uy, vx, vy } = texels;
        // J J^T = (E F; F G), whose first eigenvector is turned by half the angle of (E - G, 2 F).
        let (e, f, g) = (ux * ux + uy * uy, ux * vx + uy * vy, vx * vx + vy * vy);
        let angle = libm::atan2(2.0 * f, e - g) / 2.0;
        let major = libm::sqrt((e + g + libm::hypot(e - g, 2.0 * f)) / 2.0);
        let area = (ux * vy - uy * vx).abs();
        Self { radius: [major, across(area, major)], direction: [libm::cos(angle), libm::sin(angle)], area }
    }
}

/// The width of what has an area and a length; nothing is nothing wide.
fn across(area: f64, length: f64) -> f64 {
    if area == 0.0 { 0.0 } else { area / length }
}
