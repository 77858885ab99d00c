//! Textures from image files, and planes into them.

use std::{
    fs::File,
    io::{BufRead, BufReader, Seek, SeekFrom},
    path::Path,
};

use image::{
    DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageReader, Limits, codecs::png::PngEncoder,
};

use super::PlaneImage;
use crate::{
    error::{Error, Result},
    output::write_whole,
};

/// Longest side of a texture: 2^20 texels, all that a 12.20 coordinate can tell apart.
pub const LONGEST_SIDE: u32 = 1 << 20;

/// Most texels of a texture: 2^30, 4 GiB of RGBA8.
pub const MOST_TEXELS: u64 = 1 << 30;

/// No compression of an image packs more texels than this into a byte: deflate makes 1032 bytes of one, of 8 texels each at 1 bit.
const TEXELS_OF_A_BYTE: u64 = 8 * 1032;

/// No decoder needs more memory than this for each of them: four channels of 32 bits.
const BYTES_OF_A_TEXEL: u64 = 16;

/// What a header may claim without a file to match.
const TEXELS_OF_ANY_FILE: u64 = 1 << 22;

/// Reads a texture from any file `image` reads, told apart by content first and name second.
///
/// Texels are the file's sRGB values as they are: no colour profile, gamma or orientation is applied, alpha is not
/// multiplied in. Grey becomes three equal channels, a missing alpha 255, 16-bit channels are rounded to 8.
///
/// # Errors
/// A missing or unreadable file; a file that is no image or a damaged one; a zero-sized or too large one, before its texels
/// are allocated.
pub fn load(path: &Path) -> Result<PlaneImage> {
    read(path, BufReader::new(File::open(path).map_err(Error::io(path))?))
}

/// The same from any source; `path` is for messages, and its extension for formats without a signature.
///
/// # Errors
/// As [`load`].
pub fn read(path: &Path, mut source: impl BufRead + Seek) -> Result<PlaneImage> {
    let bytes = source.seek(SeekFrom::End(0)).and_then(|end| source.rewind().map(|()| end)).map_err(Error::io(path))?;
    let damaged = |error: image::ImageError| {
        Error::file(
            path,
            "image",
            format!("cannot be read as an image: {error}"),
            "give a whole PNG, JPEG, BMP, TGA, PNM, GIF, KTX2 or DDS file",
        )
    };
    let mut reader = ImageReader::new(source).with_guessed_format().map_err(Error::io(path))?;
    if reader.format().is_none() {
        // TGA has no signature: its name is all there is.
        if let Ok(format) = image::ImageFormat::from_path(path) {
            reader.set_format(format);
        }
    }
    reader.no_limits();
    let mut decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    check_size(path, width, height)?;
    let texels = u64::from(width) * u64::from(height);
    let most_texels = TEXELS_OF_ANY_FILE.saturating_add(bytes.saturating_mul(TEXELS_OF_A_BYTE));
    if texels > most_texels {
        let problem = format!("{width} x {height} texels in a file of {bytes} bytes");
        return Err(Error::file(path, "size", problem, "the file is damaged or cut short: take it from where it came"));
    }
    // The frame of a GIF has a size of its own, whatever the image's.
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(most_texels.saturating_mul(BYTES_OF_A_TEXEL));
    decoder.set_limits(limits).map_err(damaged)?;
    Ok(PlaneImage::of_image(&DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgba8()))
}

/// Refuses sizes no texture can have.
pub(crate) fn check_size(path: &Path, width: u32, height: u32) -> Result<()> {
    let size = format!("{width} x {height} texels");
    if width == 0 || height == 0 {
        return Err(Error::file(path, "size", size, "a texture has at least one texel on each side"));
    }
    if width.max(height) > LONGEST_SIDE || u64::from(width) * u64::from(height) > MOST_TEXELS {
        let remedy = format!(
            "scale it down: at most {LONGEST_SIDE} texels on a side and {MOST_TEXELS} (2^30) in all can be read"
        );
        return Err(Error::file(path, "size", size, remedy));
    }
    Ok(())
}

/// Writes a plane as PNG, RGBA8, no colour profile.
///
/// # Errors
/// [`Error::Io`] naming the file, which is then as it was.
pub fn write_png(path: &Path, plane: &PlaneImage) -> Result<()> {
    write_whole(path, |file| {
        PngEncoder::new(file)
            .write_image(plane.texels.as_flattened(), plane.width, plane.height, ExtendedColorType::Rgba8)
            .map_err(|error| match error {
                image::ImageError::IoError(error) => error,
                other => std::io::Error::other(other),
            })
    })
}
