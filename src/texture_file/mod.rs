//! Textures from any file: images, and the containers that bring stored elements and levels of their own.

mod dds;
mod elements;
mod ktx2;

use std::{
    fs::File,
    io::{Cursor, Read},
    path::Path,
    sync::Arc,
};

use crate::{
    error::{Error, Result},
    pyramid::{PlaneImage, image_file},
    texel_format::Stored,
};

/// A texture as it was given.
///
/// ```
/// use texunit::{pyramid::PlaneImage, texture_file::TextureImage};
/// let texture: TextureImage = PlaneImage::top(1, 1, vec![[1, 2, 3, 255]]).into();
/// assert!(texture.own.is_none());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TextureImage {
    /// Its texels.
    pub top: PlaneImage,
    /// The levels its file brought, from level 0 on, as they were stored there: the first planes of a mipmap, or all of them.
    pub own: Option<Arc<Stored>>,
}

impl From<PlaneImage> for TextureImage {
    fn from(top: PlaneImage) -> Self {
        Self { top, own: None }
    }
}

impl TextureImage {
    fn of_levels(own: Stored) -> Self {
        Self { top: own.decode_plane(&own.planes[0]), own: Some(Arc::new(own)) }
    }
}

/// Reads a texture from a KTX2 or DDS file, told by its first bytes, or from an image (see [`image_file::load`]).
///
/// # Errors
/// A missing, damaged or truncated file; a container of what is not one two-dimensional texture, supercompressed, or in a format
/// the unit does not store; sizes no texture can have.
pub fn load(path: &Path) -> Result<TextureImage> {
    let mut start = Vec::new();
    let mut file = File::open(path).map_err(Error::io(path))?;
    file.by_ref().take(12).read_to_end(&mut start).map_err(Error::io(path))?;
    if container(&start).is_none() {
        return image_file::load(path).map(TextureImage::from);
    }
    let mut bytes = start;
    file.read_to_end(&mut bytes).map_err(Error::io(path))?;
    read(path, &bytes)
}

/// The same from the bytes of a file; `path` is for messages, and its extension for formats without a signature.
///
/// # Errors
/// As [`load`].
pub fn read(path: &Path, bytes: &[u8]) -> Result<TextureImage> {
    match container(bytes) {
        Some(read) => read(path, bytes).map(TextureImage::of_levels),
        None => image_file::read(path, Cursor::new(bytes)).map(TextureImage::from),
    }
}

/// Reads the levels of a container; the path is for messages.
type Container = fn(&Path, &[u8]) -> Result<Stored>;

/// The reader of a container that begins so.
fn container(bytes: &[u8]) -> Option<Container> {
    if bytes.starts_with(&::ktx2::MAGIC) {
        Some(ktx2::read)
    } else if bytes.starts_with(b"DDS ") {
        Some(dds::read)
    } else {
        None
    }
}
