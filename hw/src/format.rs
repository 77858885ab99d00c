//! Texel formats: how many bytes a fetch takes and how they become four 8-bit channels.

/// What one texel is stored as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Format {
    /// Red, green, blue, alpha, one byte each, in this order of addresses.
    #[default]
    Rgba8,
}

impl Format {
    /// Bytes of one element: a texel, or a block of texels.
    #[must_use]
    pub const fn element_bytes(self) -> u32 {
        match self {
            Self::Rgba8 => 4,
        }
    }
}
