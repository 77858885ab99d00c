//! What a glTF file refers to: buffers (3.6.1), and images (3.8.2) as textures.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};

use ::gltf::{Document, Material, buffer, image};
use base64::{Engine, engine::general_purpose::STANDARD};

use super::{super::mesh::plain, REMEDY};
use crate::{
    error::{Error, Result},
    stream::NamedTexture,
    texture_file,
};

/// Which colour a material has: equal ones are one texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Colour {
    /// That of an image.
    Image(usize),
    /// That of a material, or of none.
    Factor(Option<usize>),
}

impl Colour {
    /// The base colour of a material.
    pub fn of(material: &Material<'_>) -> Self {
        match material.pbr_metallic_roughness().base_color_texture() {
            Some(info) => Self::Image(info.texture().source().index()),
            None => Self::Factor(material.index()),
        }
    }
}

/// A file and its buffers.
#[derive(Debug)]
pub struct Resources<'r> {
    /// The file.
    pub path: &'r Path,
    buffers: Vec<Vec<u8>>,
}

/// Where the bytes of a URI are.
enum Place {
    /// In it.
    Data(Vec<u8>),
    /// In a file beside the mesh.
    File(PathBuf),
}

impl<'r> Resources<'r> {
    /// Reads all buffers; `blob` is that of a binary file.
    pub fn new(path: &'r Path, document: &Document, mut blob: Option<Vec<u8>>) -> Result<Self> {
        let mut resources = Self { path, buffers: Vec::new() };
        for buffer in document.buffers() {
            let place = format!("buffers[{}]", buffer.index());
            let mut bytes = match buffer.source() {
                buffer::Source::Bin => blob.take().ok_or_else(|| resources.wrong(&place, "it has no bytes".into()))?,
                buffer::Source::Uri(uri) => match resources.locate(&place, uri)? {
                    Place::Data(bytes) => bytes,
                    Place::File(file) => bytes_of(&file)?,
                },
            };
            if bytes.len() < buffer.length() {
                let problem = format!("{} bytes, not {}", bytes.len(), buffer.length());
                return Err(resources.wrong(&place, problem));
            }
            bytes.truncate(buffer.length());
            resources.buffers.push(bytes);
        }
        Ok(resources)
    }

    /// Something wrong at a place in the file.
    pub fn wrong(&self, place: &str, problem: String) -> Error {
        Error::file(self.path, place, problem, REMEDY)
    }

    /// The bytes of a buffer view.
    pub fn view(&self, view: &buffer::View<'_>) -> Result<&[u8]> {
        let buffer = &self.buffers[view.buffer().index()];
        let bytes = buffer.get(view.offset()..).and_then(|bytes| bytes.get(..view.length()));
        bytes.ok_or_else(|| {
            let (place, offset, length) = (format!("bufferViews[{}]", view.index()), view.offset(), view.length());
            self.wrong(&place, format!("{length} bytes from {offset} on are not in a buffer of {}", buffer.len()))
        })
    }

    /// The base colour of a material: its texture, or one texel of its factor.
    pub fn texture(&self, material: &Material<'_>) -> Result<NamedTexture> {
        let colour = material.pbr_metallic_roughness();
        let Some(info) = colour.base_color_texture() else {
            let name = material.name().map_or_else(
                || material.index().map_or_else(|| "no material".into(), |index| format!("material {index}")),
                str::to_owned,
            );
            return Ok(NamedTexture { name, image: plain(coded(colour.base_color_factor())) });
        };
        let image = info.texture().source();
        let place = format!("images[{}]", image.index());
        let name = |other: Option<&str>| image.name().or(other).unwrap_or(&place).to_owned();
        // For messages; the path of the mesh would tell nobody which of its images is meant.
        let within = PathBuf::from(format!("{}, {place}", self.path.display()));
        match image.source() {
            image::Source::View { view, .. } => {
                let image = texture_file::read(&within, self.view(&view)?)?;
                Ok(NamedTexture { name: name(None), image })
            }
            image::Source::Uri { uri, .. } => match self.locate(&place, uri)? {
                Place::Data(bytes) => {
                    Ok(NamedTexture { name: name(None), image: texture_file::read(&within, &bytes)? })
                }
                Place::File(file) => Ok(NamedTexture { name: name(Some(uri)), image: texture_file::load(&file)? }),
            },
        }
    }

    /// Takes a URI apart (RFC 2397 for data).
    fn locate(&self, place: &str, uri: &str) -> Result<Place> {
        if let Some(data) = uri.strip_prefix("data:") {
            let coded = data.split_once(',').and_then(|(kind, data)| kind.ends_with(";base64").then_some(data));
            let coded = coded.ok_or_else(|| self.wrong(place, "its data URI is not in base64".into()))?;
            let bytes = STANDARD.decode(coded).map_err(|error| self.wrong(place, format!("base64: {error}")))?;
            return Ok(Place::Data(bytes));
        }
        if uri.contains("://") {
            return Err(self.wrong(place, format!("`{uri}` is no file of this computer")));
        }
        let name = urlencoding::decode(uri).map_err(|error| self.wrong(place, format!("`{uri}`: {error}")))?;
        Ok(Place::File(self.path.parent().unwrap_or(Path::new("")).join(&*name)))
    }
}

/// The whole of a file that is there to its end: a folder, a pipe or a device is none.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    let mut file = File::open(path).map_err(Error::io(path))?;
    if !file.metadata().map_err(Error::io(path))?.is_file() {
        return Err(Error::file(path, "its name", "no file of a known end", REMEDY));
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(Error::io(path))?;
    Ok(bytes)
}

/// A factor is linear (3.9.2), and textures are sRGB codes (IEC 61966-2-1).
fn coded([red, green, blue, alpha]: [f32; 4]) -> [f32; 4] {
    let code = |linear: f32| {
        let linear = f64::from(linear);
        let code = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 };
        code as f32
    };
    [code(red), code(green), code(blue), alpha]
}
