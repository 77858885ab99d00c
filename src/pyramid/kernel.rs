//! The kernels planes are made with, as functions of the distance from the centre (docs/numerics.md, section 8).

use std::f64::consts::PI;

use crate::{
    error::{Error, Result},
    names::Named,
};

/// What a texel of a smaller plane is an average of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// Exact area average.
    #[default]
    Box,
    /// The texel under the centre: no filter at all.
    Point,
    /// A triangle.
    Tent,
    /// Sinc under a sinc window (Blow 2001; Blinn).
    Lanczos,
    /// Sinc under a Kaiser window with beta = 4 (Blow 2001, whose "alpha 4" it is: E18).
    Kaiser,
}

/// Shape of the Kaiser window.
const KAISER_BETA: f64 = 4.0;

impl Kernel {
    /// Width in source texels at 2:1 when none is asked for; `None` for the kernels whose width is not a choice.
    #[must_use]
    pub const fn default_width(self) -> Option<u8> {
        match self {
            Self::Box | Self::Point => None,
            Self::Tent => Some(4),
            Self::Lanczos | Self::Kaiser => Some(14),
        }
    }

    /// The width asked for, or this kernel's own.
    ///
    /// # Errors
    /// A width for a kernel that has none, odd, or outside 2..=64.
    pub fn width(self, asked: Option<u8>) -> Result<Option<u8>> {
        match (self.default_width(), asked) {
            (own, None) => Ok(own),
            (None, Some(width)) => Err(Error::setting(
                "width",
                width,
                format!("kernel {} has no width to choose", self.name()),
                "leave it out, or use tent, lanczos or kaiser",
            )),
            (Some(_), Some(width)) if !(2..=64).contains(&width) || width % 2 == 1 => Err(Error::setting(
                "width",
                width,
                "a kernel is an even number of source texels wide",
                "an even number from 2 to 64",
            )),
            (Some(_), Some(width)) => Ok(Some(width)),
        }
    }

    /// Height, not normalised, at `distance` from the centre in texels of the *new* plane and at `reach`, the same distance
    /// as a part of the half width (-1 to 1). Box and point are exact and never come here as functions: they are 1.
    #[must_use]
    pub fn height(self, distance: f64, reach: f64) -> f64 {
        match self {
            Self::Box | Self::Point => 1.0,
            Self::Tent => 1.0 - reach.abs(),
            Self::Lanczos => sinc(distance) * sinc(reach),
            Self::Kaiser => sinc(distance) * bessel_i0(KAISER_BETA * (1.0 - reach * reach).max(0.0).sqrt()),
        }
    }
}

/// sin(pi x) / (pi x): Blow's definition. Van Verth's is sin(x) / x.
fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { libm::sin(PI * x) / (PI * x) }
}

/// The modified Bessel function I0 by its power series; only divisions and additions, so the same on every machine.
fn bessel_i0(x: f64) -> f64 {
    let quarter_square = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..64 {
        term *= quarter_square / f64::from(k * k);
        sum += term;
    }
    sum
}
