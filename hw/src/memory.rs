//! The texels behind the addresses: bytes as a layout and a format put them.

use crate::{
    datapath::{Texel, TexelSource},
    format::Format,
    layout::Layout,
    surface::Surface,
};

/// RGBA8 texels, four bytes at an address.
#[derive(Clone, Copy, Debug)]
pub struct Rgba8<'m>(pub &'m [u8]);

impl TexelSource for Rgba8<'_> {
    #[inline]
    fn texel(&self, address: u64, _plane: u16) -> Texel {
        let at = address as usize;
        let mut texel = [0; 4];
        texel.copy_from_slice(&self.0[at..at + 4]);
        texel
    }
}

/// Red, green and blue bytes in quadrants of their own (Williams 1983): three reads a texel, alpha is always opaque.
#[derive(Clone, Copy, Debug)]
pub struct Quadrants<'m> {
    /// The square.
    pub bytes: &'m [u8],
    /// For the distance between a plane's quadrants.
    pub surface: &'m Surface,
}

impl TexelSource for Quadrants<'_> {
    #[inline]
    fn texel(&self, address: u64, plane: u16) -> Texel {
        let [green, blue] = self.surface.planes[usize::from(plane)].channels;
        let byte = |distance: u64| self.bytes[(address + distance) as usize];
        [byte(0), byte(green), byte(blue), 255]
    }
}

/// Runs `$call` with the texel source of a surface: the one place where layout and format choose code.
macro_rules! with_source {
    ($surface:expr, $bytes:expr, $source:ident => $call:expr) => {
        match ($surface.layout, $surface.format) {
            ($crate::layout::Layout::Williams, $crate::format::Format::Rgba8) => {
                let $source = $crate::memory::Quadrants { bytes: $bytes, surface: $surface };
                $call
            }
            (_, $crate::format::Format::Rgba8) => {
                let $source = $crate::memory::Rgba8($bytes);
                $call
            }
        }
    };
}
pub(crate) use with_source;

/// A texel the layout has no room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreError {
    /// Plane halvings and texel.
    pub plane: (u8, u8),
    /// Its column.
    pub x: u32,
    /// Its row.
    pub y: u32,
    /// Its value.
    pub texel: Texel,
}

impl core::fmt::Display for StoreError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { plane: (lu, lv), x, y, texel } = self;
        write!(f, "the williams layout has no place for alpha, and texel ({x}, {y}) of plane ({lu}, {lv}) is {texel:?}")
    }
}

impl core::error::Error for StoreError {}

/// Stores one plane's texels (row by row) at their addresses.
///
/// # Errors
/// A translucent texel under [`Layout::Williams`], which holds three channels.
///
/// # Panics
/// If `texels` is not the size of the plane or `bytes` not that of the surface.
pub fn store_plane(surface: &Surface, plane: usize, texels: &[Texel], bytes: &mut [u8]) -> Result<(), StoreError> {
    let place = &surface.planes[plane];
    assert_eq!(texels.len() as u64, u64::from(place.width) * u64::from(place.height));
    assert_eq!(bytes.len() as u64, surface.bytes);
    for (y, row) in (0..).zip(texels.chunks_exact(place.width as usize)) {
        let row_address = place.base + place.offset(1, y);
        for (x, texel) in (0..).zip(row) {
            let address = (row_address + place.offset(0, x)) as usize;
            match (surface.layout, surface.format) {
                (Layout::Williams, Format::Rgba8) => {
                    if texel[3] != 255 {
                        return Err(StoreError { plane: (place.lu, place.lv), x, y, texel: *texel });
                    }
                    bytes[address] = texel[0];
                    bytes[address + place.channels[0] as usize] = texel[1];
                    bytes[address + place.channels[1] as usize] = texel[2];
                }
                (_, Format::Rgba8) => bytes[address..address + 4].copy_from_slice(texel),
            }
        }
    }
    Ok(())
}
