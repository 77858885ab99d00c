//! The names of the address modes in files and on the command line.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use texunit_hw::AddressMode;

/// What happens to a coordinate outside the texture; see [`AddressMode`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Wrap {
    /// Repeat.
    #[default]
    Wrap,
    /// The edge texel.
    Clamp,
    /// Transparent black outside.
    Clip,
    /// Repeat, every second time mirrored.
    Mirror,
}

impl From<Wrap> for AddressMode {
    fn from(wrap: Wrap) -> Self {
        match wrap {
            Wrap::Wrap => Self::Wrap,
            Wrap::Clamp => Self::Clamp,
            Wrap::Clip => Self::Clip,
            Wrap::Mirror => Self::Mirror,
        }
    }
}

impl Wrap {
    /// The texel of an axis of `texels` under a normalised coordinate, not quantised; `None` outside, when clipped. Infinite
    /// coordinates and NaN are outside too: the ground truth has no texel for them.
    #[must_use]
    #[inline]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "reduced to 0..texels before the cast")]
    pub fn texel_under(self, coordinate: f64, texels: u32) -> Option<u32> {
        if !coordinate.is_finite() {
            return None;
        }
        let size = f64::from(texels);
        let last = texels - 1;
        match self {
            Self::Wrap => Some((((coordinate - coordinate.floor()) * size) as u32).min(last)),
            Self::Clamp => Some(((coordinate * size).max(0.0) as u32).min(last)),
            Self::Clip => (0.0..1.0).contains(&coordinate).then(|| ((coordinate * size) as u32).min(last)),
            Self::Mirror => {
                let turn = coordinate - 2.0 * (coordinate / 2.0).floor();
                let index = ((turn * size) as u32).min(2 * texels - 1);
                Some(if index < texels { index } else { 2 * texels - 1 - index })
            }
        }
    }
}
