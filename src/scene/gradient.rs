//! The change of (u, v) per pixel step, and the three ways of finding it (E24).

/// Change of the normalised texture coordinates (1.0 is one repeat) per step of one pixel in screen x and y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gradient {
    /// du/dx.
    pub ux: f64,
    /// du/dy.
    pub uy: f64,
    /// dv/dx.
    pub vx: f64,
    /// dv/dy.
    pub vy: f64,
}

impl Gradient {
    /// The same change in texels of level 0: du times the width, dv times the height (E26).
    #[must_use]
    pub fn in_texels(self, size: [u32; 2]) -> Self {
        let [width, height] = size.map(f64::from);
        Self { ux: self.ux * width, uy: self.uy * width, vx: self.vx * height, vy: self.vy * height }
    }

    /// Whether any of the four is not a number.
    #[must_use]
    pub fn is_nan(self) -> bool {
        [self.ux, self.uy, self.vx, self.vy].into_iter().any(f64::is_nan)
    }
}

/// How the gradient of a fragment is found. On a floor, a difference falls short of the derivative by d/(d+1), d pixels below
/// the horizon: one level at d = 1, 0.014 at 100 (E24).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GradientMethod {
    /// The derivative at the pixel centre (Herf 1999, part 2).
    #[default]
    Analytic,
    /// F(x+1) - F(x) and F(y+1) - F(y) (Du & Wan, equation 2).
    Forward,
    /// The forward differences of the top left pixel of an aligned 2x2 quad, shared by its four pixels (GPUs).
    Quad,
}

impl GradientMethod {
    /// The pixel whose forward differences pixel (x, y) takes; `None` where it takes the derivative.
    #[must_use]
    pub(crate) fn anchor(self, x: u32, y: u32) -> Option<(u32, u32)> {
        match self {
            Self::Analytic => None,
            Self::Forward => Some((x, y)),
            Self::Quad => Some((x & !1, y & !1)),
        }
    }
}
