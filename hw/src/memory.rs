//! The texels behind the addresses: bytes as a layout and a format put them.

use crate::{
    datapath::{Texel, TexelSource},
    format::Palette,
    layout::Layout,
    srgb,
    surface::Surface,
};

/// RGBA8 texels, four bytes at an address.
#[derive(Clone, Copy, Debug)]
pub struct Rgba8<'m>(pub &'m [u8]);

impl TexelSource for Rgba8<'_> {
    #[inline]
    fn texel(&self, address: u64, _plane: u16, _position: u32) -> Texel {
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
    fn texel(&self, address: u64, plane: u16, _position: u32) -> Texel {
        let [green, blue] = self.surface.planes[usize::from(plane)].channels;
        let byte = |distance: u64| self.bytes[(address + distance) as usize];
        [byte(0), byte(green), byte(blue), 255]
    }
}

/// Any format, and colours made linear where they are sRGB codes.
#[derive(Clone, Copy, Debug)]
pub struct Stored<'m> {
    /// The elements.
    pub bytes: &'m [u8],
    /// What they are.
    pub surface: &'m Surface,
}

/// What an index means where nobody gave a palette.
const NO_PALETTE: Palette = [[0; 4]; 256];

impl TexelSource for Stored<'_> {
    #[inline]
    fn texel(&self, address: u64, plane: u16, position: u32) -> Texel {
        let Self { bytes, surface } = *self;
        let texel = if surface.layout == Layout::Williams {
            Quadrants { bytes, surface }.texel(address, plane, position)
        } else {
            surface.format.decode(
                &bytes[address as usize..],
                position,
                surface.palette.as_deref().unwrap_or(&NO_PALETTE),
            )
        };
        if surface.srgb { srgb::linear(texel) } else { texel }
    }
}

/// Runs `$call` with the texel source of a surface: the one place where layout and format choose code. The common ones are loops of
/// their own; the others share one.
macro_rules! with_source {
    ($surface:expr, $bytes:expr, $source:ident => $call:expr) => {
        match ($surface.layout, $surface.format, $surface.srgb) {
            ($crate::layout::Layout::Williams, $crate::format::Format::Rgba8, false) => {
                let $source = $crate::memory::Quadrants { bytes: $bytes, surface: $surface };
                $call
            }
            (_, $crate::format::Format::Rgba8, false) => {
                let $source = $crate::memory::Rgba8($bytes);
                $call
            }
            _ => {
                let $source = $crate::memory::Stored { bytes: $bytes, surface: $surface };
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

/// Stores one plane's elements (texels, or blocks of them, row by row) at their addresses.
///
/// # Errors
/// A translucent texel under [`Layout::Williams`], which holds three channels.
///
/// # Panics
/// If `elements` is not the size of the plane or `bytes` not that of the surface.
pub fn store_plane(surface: &Surface, plane: usize, elements: &[u8], bytes: &mut [u8]) -> Result<(), StoreError> {
    let place = &surface.planes[plane];
    let [columns, rows] = place.elements();
    let size = surface.format.element_bytes() as usize;
    assert_eq!(elements.len() as u64, u64::from(columns) * u64::from(rows) * size as u64, "bytes of plane {plane}");
    assert_eq!(bytes.len() as u64, surface.bytes);
    for (y, row) in (0..).zip(elements.chunks_exact(columns as usize * size)) {
        let row_address = place.base + place.element_offset(1, y);
        for (x, element) in (0..).zip(row.chunks_exact(size)) {
            let address = (row_address + place.element_offset(0, x)) as usize;
            if surface.layout == Layout::Williams {
                let &[red, green, blue, alpha] = element else { unreachable!("Surface::new admits RGBA8 only") };
                if alpha != 255 {
                    let texel = [red, green, blue, alpha];
                    return Err(StoreError { plane: (place.lu, place.lv), x, y, texel });
                }
                bytes[address] = red;
                bytes[address + place.channels[0] as usize] = green;
                bytes[address + place.channels[1] as usize] = blue;
            } else {
                bytes[address..address + size].copy_from_slice(element);
            }
        }
    }
    Ok(())
}
