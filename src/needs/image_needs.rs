//! Which channels of a texture say something.

use crate::pyramid::PlaneImage;

/// What the texels of some planes have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageNeeds {
    /// Alpha is 255 everywhere.
    pub opaque: bool,
    /// Red, green and blue are equal everywhere.
    pub grey: bool,
}

impl ImageNeeds {
    /// Looks at every texel once.
    pub fn of<'p>(planes: impl IntoIterator<Item = &'p PlaneImage>) -> Self {
        let mut seen = Self { opaque: true, grey: true };
        for texel in planes.into_iter().flat_map(|plane| &plane.texels) {
            let [red, green, blue, alpha] = *texel;
            seen.opaque &= alpha == 255;
            seen.grey &= red == green && green == blue;
            if !seen.opaque && !seen.grey {
                break;
            }
        }
        seen
    }

    /// Channels to filter: 4; 3 without alpha; 1 where they are all alike as well.
    #[must_use]
    pub const fn channels(self) -> u8 {
        match (self.opaque, self.grey) {
            (true, true) => 1,
            (true, false) => 3,
            (false, _) => 4,
        }
    }
}
