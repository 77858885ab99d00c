//! KTX2 files (the Khronos KTX 2.0 specification).

use std::path::Path;

use ktx2::{Format as Vulkan, Reader};
use texunit_hw::Format;

use super::elements::{Elements, Shape, stored, unsupported};
use crate::{
    error::{Error, Result},
    texel_format::Stored,
};

/// The levels of a KTX2 file. Its transfer function is not looked at: `texture.srgb` of the machine says what codes mean.
///
/// # Errors
/// See [`super::load`].
pub fn read(path: &Path, bytes: &[u8]) -> Result<Stored> {
    let damaged = |error: ktx2::ParseError| {
        Error::file(path, "KTX2", error.to_string(), "the file is damaged or cut short: write it anew")
    };
    let reader = Reader::new(bytes).map_err(damaged)?;
    let header = reader.header();
    if let Some(scheme) = header.supercompression_scheme {
        let remedy = "write it without supercompression, for instance `ktx transcode` and no --zstd";
        return Err(Error::file(path, "supercompression", format!("{scheme:?} levels are not unpacked"), remedy));
    }
    if header.pixel_depth > 1 || header.layer_count > 1 || header.face_count > 1 || header.pixel_height == 0 {
        let problem = format!(
            "{} x {} x {} texels, {} layers, {} faces",
            header.pixel_width, header.pixel_height, header.pixel_depth, header.layer_count, header.face_count
        );
        return Err(Error::file(path, "shape", problem, "give one two-dimensional texture"));
    }
    let swizzle = reader
        .key_value_data()
        .find(|(key, _)| *key == "KTXswizzle")
        .map_or_else(|| "rgba".into(), |(_, value)| String::from_utf8_lossy(value).trim_end_matches('\0').to_owned());
    let elements = elements(header.format, &swizzle).ok_or_else(|| {
        let name = header.format.map_or_else(|| "an undefined (Basis) format".into(), |format| format!("{format:?}"));
        unsupported(path, format!("{name} with channels {swizzle}"))
    })?;
    let shape = Shape { width: header.pixel_width, height: header.pixel_height, elements };
    let levels: Vec<_> = reader.levels().collect();
    stored(path, shape, levels.len(), |number, _| Some(levels[number].data))
}

fn elements(format: Option<Vulkan>, swizzle: &str) -> Option<Elements> {
    Some(match (format?, swizzle) {
        (Vulkan::R8_UNORM | Vulkan::R8_SRGB, "rrr1") => Elements::As(Format::L8),
        (Vulkan::R8_UNORM | Vulkan::R8_SRGB, "000r") => Elements::As(Format::A8),
        (Vulkan::R8G8_UNORM | Vulkan::R8G8_SRGB, "rrrg") => Elements::As(Format::La8),
        (Vulkan::R8G8B8A8_UNORM | Vulkan::R8G8B8A8_SRGB, "rgb1") => Elements::Rgbx8,
        (Vulkan::B8G8R8A8_UNORM | Vulkan::B8G8R8A8_SRGB, "rgb1") => Elements::Bgrx8,
        (Vulkan::R8G8B8_UNORM | Vulkan::R8G8B8_SRGB, "rgba" | "rgb1") => Elements::Rgb8,
        (Vulkan::B8G8R8_UNORM | Vulkan::B8G8R8_SRGB, "rgba" | "rgb1") => Elements::Bgr8,
        (Vulkan::R5G6B5_UNORM_PACK16, "rgba" | "rgb1") => Elements::As(Format::Rgb565),
        (Vulkan::BC1_RGB_UNORM_BLOCK | Vulkan::BC1_RGB_SRGB_BLOCK, "rgba" | "rgb1") => Elements::OpaqueBc1,
        (_, other) if other != "rgba" => return None,
        (Vulkan::R8G8B8A8_UNORM | Vulkan::R8G8B8A8_SRGB, _) => Elements::As(Format::Rgba8),
        (Vulkan::B8G8R8A8_UNORM | Vulkan::B8G8R8A8_SRGB, _) => Elements::Bgra8,
        (Vulkan::A1R5G5B5_UNORM_PACK16, _) => Elements::As(Format::Argb1555),
        (Vulkan::A4R4G4B4_UNORM_PACK16, _) => Elements::As(Format::Argb4444),
        (Vulkan::BC1_RGBA_UNORM_BLOCK | Vulkan::BC1_RGBA_SRGB_BLOCK, _) => Elements::As(Format::Bc1),
        (Vulkan::BC3_UNORM_BLOCK | Vulkan::BC3_SRGB_BLOCK, _) => Elements::As(Format::Bc3),
        (Vulkan::BC7_UNORM_BLOCK | Vulkan::BC7_SRGB_BLOCK, _) => Elements::As(Format::Bc7),
        _ => return None,
    })
}
