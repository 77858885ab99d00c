//! Texel formats: how many bytes a fetch takes and how they become four 8-bit channels (docs/numerics.md, section 10).

use crate::{bc7, block_compression, datapath::Texel};

/// What one texel, or one block of texels, is stored as. Numbers of more than a byte are little-endian.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Format {
    /// Red, green, blue, alpha, one byte each, in this order of addresses.
    #[default]
    Rgba8,
    /// 16 bits: red 15..11, green 10..5, blue 4..0.
    Rgb565,
    /// 16 bits: alpha 15, red 14..10, green 9..5, blue 4..0.
    Argb1555,
    /// 16 bits: alpha 15..12, red 11..8, green 7..4, blue 3..0.
    Argb4444,
    /// One byte: grey, opaque.
    L8,
    /// One byte: alpha of black.
    A8,
    /// Two bytes: grey, then alpha.
    La8,
    /// One byte: index into 256 RGBA8 colours, which are state of the unit and never pass through the cache.
    Palette8,
    /// 4 x 4 texels in 8 bytes: two colours and what lies between.
    Bc1,
    /// 4 x 4 texels in 16 bytes: alpha of its own, then colours as in BC1.
    Bc3,
    /// 4 x 4 texels in 16 bytes, eight modes.
    Bc7,
}

/// The colours of a [`Format::Palette8`] texture.
pub type Palette = [Texel; 256];

impl Format {
    /// Bytes of one element: a texel, or a block of texels.
    #[must_use]
    pub const fn element_bytes(self) -> u32 {
        match self {
            Self::L8 | Self::A8 | Self::Palette8 => 1,
            Self::Rgb565 | Self::Argb1555 | Self::Argb4444 | Self::La8 => 2,
            Self::Rgba8 => 4,
            Self::Bc1 => 8,
            Self::Bc3 | Self::Bc7 => 16,
        }
    }

    /// log2 of an element's side in texels: 2 for blocks, 0 for everything else.
    #[must_use]
    pub const fn log2_block(self) -> u32 {
        match self {
            Self::Bc1 | Self::Bc3 | Self::Bc7 => 2,
            _ => 0,
        }
    }

    /// Elements along an axis of so many texels.
    #[must_use]
    pub const fn elements(self, texels: u32) -> u32 {
        texels.div_ceil(1 << self.log2_block())
    }

    /// The texel at a position of an element: `4 (y mod 4) + (x mod 4)` in a block, 0 otherwise.
    ///
    /// ```
    /// use texunit_hw::Format;
    /// assert_eq!(Format::Rgb565.decode(&0xF81Fu16.to_le_bytes(), 0, &[[0; 4]; 256]), [255, 0, 255, 255]);
    /// ```
    ///
    /// # Panics
    /// If there are fewer bytes than [`Self::element_bytes`], or the position is above 15.
    #[inline]
    #[must_use]
    pub fn decode(self, element: &[u8], position: u32, palette: &Palette) -> Texel {
        let word = || u16::from_le_bytes([element[0], element[1]]);
        match self {
            Self::Rgba8 => [element[0], element[1], element[2], element[3]],
            Self::Rgb565 => {
                let word = word();
                [expand::<5>(word >> 11), expand::<6>(word >> 5), expand::<5>(word), 255]
            }
            Self::Argb1555 => {
                let word = word();
                [expand::<5>(word >> 10), expand::<5>(word >> 5), expand::<5>(word), expand::<1>(word >> 15)]
            }
            Self::Argb4444 => {
                let word = word();
                [expand::<4>(word >> 8), expand::<4>(word >> 4), expand::<4>(word), expand::<4>(word >> 12)]
            }
            Self::L8 => [element[0], element[0], element[0], 255],
            Self::A8 => [0, 0, 0, element[0]],
            Self::La8 => [element[0], element[0], element[0], element[1]],
            Self::Palette8 => palette[usize::from(element[0])],
            Self::Bc1 => block_compression::bc1(element, position),
            Self::Bc3 => block_compression::bc3(element, position),
            Self::Bc7 => bc7::texel(element, position),
        }
    }
}

/// The low `BITS` of a code as 8 bits, by repeating them from the top down: 0 stays 0 and all ones become 255.
#[inline]
const fn expand<const BITS: u32>(code: u16) -> u8 {
    let code = code & ((1 << BITS) - 1);
    let eight = match BITS {
        1 => code * 255,
        4 => code * 17,
        _ => code << (8 - BITS) | code >> (2 * BITS - 8),
    };
    eight as u8
}
