//! DDS files (Microsoft's DirectDraw surface, with either header).

use std::path::Path;

use ddsfile::{Caps2, D3D10ResourceDimension, D3DFormat, Dds, DxgiFormat, PixelFormat, PixelFormatFlags};
use texunit_hw::Format;

use super::elements::{Elements, Shape, stored, unsupported};
use crate::{
    error::{Error, Result},
    texel_format::Stored,
};

/// The levels of a DDS file, rows without padding between them. Whether its format says sRGB is not looked at: `texture.srgb` of the
/// machine says what codes mean.
///
/// # Errors
/// See [`super::load`].
pub fn read(path: &Path, bytes: &[u8]) -> Result<Stored> {
    let damaged = |error: ddsfile::Error| {
        Error::file(path, "DDS", error.to_string(), "the file is damaged or cut short: write it anew")
    };
    let dds = Dds::read(bytes).map_err(damaged)?;
    let header = &dds.header;
    let flat = dds.header10.as_ref().is_none_or(|header10| {
        header10.resource_dimension == D3D10ResourceDimension::Texture2D && header10.array_size <= 1
    });
    if !flat || dds.get_num_array_layers() > 1 || header.caps2.intersects(Caps2::CUBEMAP | Caps2::VOLUME) {
        let remedy = "give one two-dimensional texture";
        return Err(Error::file(path, "shape", "a volume, a cube map or an array of textures", remedy));
    }
    let elements = match (&dds.header10, dds.get_d3d_format()) {
        (Some(header10), _) => {
            let format = header10.dxgi_format;
            dxgi(format).ok_or_else(|| unsupported(path, format!("DXGI format {format:?}")))?
        }
        (None, Some(format)) => d3d(format).ok_or_else(|| unsupported(path, format!("D3D format {format:?}")))?,
        (None, None) => luminance(&header.spf).ok_or_else(|| unsupported(path, "this pixel format"))?,
    };
    let shape = Shape { width: header.width, height: header.height, elements };
    let levels = header.mip_map_count.unwrap_or(1).max(1) as usize;
    let mut rest = dds.data.as_slice();
    stored(path, shape, levels, |_, wanted| {
        let (level, below) = rest.split_at_checked(usize::try_from(wanted).ok()?)?;
        rest = below;
        Some(level)
    })
}

/// Grey with and without alpha, which `ddsfile` 0.6 writes but does not recognise: it asks for a red mask it did not read.
fn luminance(format: &PixelFormat) -> Option<Elements> {
    match (format.flags.contains(PixelFormatFlags::LUMINANCE), format.rgb_bit_count, format.a_bit_mask) {
        (true, Some(8), None) => Some(Elements::As(Format::L8)),
        (true, Some(16), Some(0xFF00)) => Some(Elements::As(Format::La8)),
        _ => None,
    }
}

fn d3d(format: D3DFormat) -> Option<Elements> {
    Some(match format {
        D3DFormat::A8B8G8R8 => Elements::As(Format::Rgba8),
        D3DFormat::X8B8G8R8 => Elements::Rgbx8,
        D3DFormat::A8R8G8B8 => Elements::Bgra8,
        D3DFormat::X8R8G8B8 => Elements::Bgrx8,
        D3DFormat::R8G8B8 => Elements::Bgr8,
        D3DFormat::R5G6B5 => Elements::As(Format::Rgb565),
        D3DFormat::A1R5G5B5 => Elements::As(Format::Argb1555),
        D3DFormat::A4R4G4B4 => Elements::As(Format::Argb4444),
        D3DFormat::A8 => Elements::As(Format::A8),
        D3DFormat::DXT1 => Elements::As(Format::Bc1),
        D3DFormat::DXT5 => Elements::As(Format::Bc3),
        _ => return None,
    })
}

fn dxgi(format: DxgiFormat) -> Option<Elements> {
    Some(match format {
        DxgiFormat::R8G8B8A8_UNorm | DxgiFormat::R8G8B8A8_UNorm_sRGB => Elements::As(Format::Rgba8),
        DxgiFormat::B8G8R8A8_UNorm | DxgiFormat::B8G8R8A8_UNorm_sRGB => Elements::Bgra8,
        DxgiFormat::B8G8R8X8_UNorm | DxgiFormat::B8G8R8X8_UNorm_sRGB => Elements::Bgrx8,
        DxgiFormat::B5G6R5_UNorm => Elements::As(Format::Rgb565),
        DxgiFormat::B5G5R5A1_UNorm => Elements::As(Format::Argb1555),
        DxgiFormat::B4G4R4A4_UNorm => Elements::As(Format::Argb4444),
        DxgiFormat::A8_UNorm => Elements::As(Format::A8),
        DxgiFormat::BC1_UNorm | DxgiFormat::BC1_UNorm_sRGB => Elements::As(Format::Bc1),
        DxgiFormat::BC3_UNorm | DxgiFormat::BC3_UNorm_sRGB => Elements::As(Format::Bc3),
        DxgiFormat::BC7_UNorm | DxgiFormat::BC7_UNorm_sRGB => Elements::As(Format::Bc7),
        _ => return None,
    })
}
