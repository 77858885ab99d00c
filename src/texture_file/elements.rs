//! How the elements of a container become ours.

use std::path::Path;

use texunit_hw::{Format, PyramidKind, surface::planes_of};

use crate::{
    error::{Error, Result},
    pyramid::image_file::check_size,
    texel_format::{Stored, StoredPlane},
};

/// What is to be done with the elements of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Elements {
    /// They are those of a format.
    As(Format),
    /// Four bytes: blue, green, red, alpha.
    Bgra8,
    /// Four bytes: red, green, blue, one of no meaning.
    Rgbx8,
    /// Four bytes: blue, green, red, one of no meaning.
    Bgrx8,
    /// Three bytes: red, green, blue.
    Rgb8,
    /// Three bytes: blue, green, red.
    Bgr8,
    /// BC1 whose fourth colour, where it has one, is opaque black.
    OpaqueBc1,
}

impl Elements {
    /// The format they are kept in.
    const fn format(self) -> Format {
        match self {
            Self::As(format) => format,
            Self::OpaqueBc1 => Format::Bc1,
            _ => Format::Rgba8,
        }
    }

    /// Bytes of an element in the file.
    const fn bytes(self) -> u32 {
        match self {
            Self::Rgb8 | Self::Bgr8 => 3,
            other => other.format().element_bytes(),
        }
    }

    fn bytes_of(self, width: u32, height: u32) -> u64 {
        let format = self.format();
        u64::from(format.elements(width)) * u64::from(format.elements(height)) * u64::from(self.bytes())
    }

    fn convert(self, bytes: &[u8]) -> Vec<u8> {
        let four =
            |texel: fn([u8; 4]) -> [u8; 4]| bytes.as_chunks().0.iter().flat_map(|&element| texel(element)).collect();
        let three =
            |texel: fn([u8; 3]) -> [u8; 4]| bytes.as_chunks().0.iter().flat_map(|&element| texel(element)).collect();
        match self {
            Self::As(_) | Self::OpaqueBc1 => bytes.to_vec(),
            Self::Bgra8 => four(|[b, g, r, a]| [r, g, b, a]),
            Self::Rgbx8 => four(|[r, g, b, _]| [r, g, b, 255]),
            Self::Bgrx8 => four(|[b, g, r, _]| [r, g, b, 255]),
            Self::Rgb8 => three(|[r, g, b]| [r, g, b, 255]),
            Self::Bgr8 => three(|[b, g, r]| [r, g, b, 255]),
        }
    }
}

/// What a container says of itself.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    pub width: u32,
    pub height: u32,
    pub elements: Elements,
}

/// Puts the levels of a container together; `level` gives the bytes of a level, of which a number is asked for. Levels beyond 1 x 1
/// are an error, levels not there are not.
///
/// # Errors
/// Sizes no texture can have, too many levels, levels that are too short.
pub fn stored<'b>(
    path: &Path,
    shape: Shape,
    levels: usize,
    mut level: impl FnMut(usize, u64) -> Option<&'b [u8]>,
) -> Result<Stored> {
    let Shape { width, height, elements } = shape;
    check_size(path, width, height)?;
    let chain = planes_of(PyramidKind::Mipmap, width, height);
    if !(1..=chain.len()).contains(&levels) {
        let problem = format!("{levels} levels of a texture of {width} x {height}");
        return Err(Error::file(path, "levels", problem, format!("such a texture has 1 to {}", chain.len())));
    }
    let mut planes = Vec::with_capacity(levels);
    for (number, &(lu, lv)) in chain.iter().take(levels).enumerate() {
        let (width, height) = ((width >> lu).max(1), (height >> lv).max(1));
        let wanted = elements.bytes_of(width, height);
        let bytes = level(number, wanted).filter(|bytes| bytes.len() as u64 == wanted).ok_or_else(|| {
            let problem = format!("is not the {wanted} bytes that {width} x {height} texels take");
            Error::file(path, format!("level {number}"), problem, "the file is damaged or cut short: write it anew")
        })?;
        planes.push(StoredPlane { lu, lv, width, height, elements: elements.convert(bytes) });
    }
    let stored = Stored { kind: PyramidKind::Mipmap, width, height, format: elements.format(), palette: None, planes };
    Ok(if elements == Elements::OpaqueBc1 { opaque(stored) } else { stored })
}

/// BC1 of opaque colours: as it is where no texel is transparent, otherwise RGBA8 with those black.
fn opaque(stored: Stored) -> Stored {
    let mut pyramid = stored.decode();
    let mut texels = pyramid.planes.iter_mut().flat_map(|plane| &mut plane.texels);
    if texels.all(|texel| texel[3] == 255) {
        return stored;
    }
    for texel in pyramid.planes.iter_mut().flat_map(|plane| &mut plane.texels) {
        texel[3] = 255;
    }
    Stored::encode(&pyramid, Format::Rgba8)
}

/// The error for a format that is not stored.
pub fn unsupported(path: &Path, format: impl std::fmt::Display) -> Error {
    Error::file(
        path,
        "format",
        format!("{format} is none the unit stores"),
        "write it as RGBA8, BGRA8, RGB565, ARGB1555, ARGB4444, L8, A8, LA8, BC1, BC3 or BC7",
    )
}
