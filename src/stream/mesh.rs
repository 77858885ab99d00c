//! Textured triangles, and where they come from: OBJ ([`obj`]), or glTF with the feature of that name.

use std::path::Path;

use glam::{DMat3, DVec2, DVec3, dvec3};

use super::{NamedTexture, obj};
#[cfg(not(feature = "gltf"))]
use crate::error::Error;
use crate::{error::Result, pyramid::PlaneImage, texture_file::TextureImage};

/// A corner: where it is, and what of the texture is there (v down, as in images).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// In the camera's space: x right, y up, looking along -z.
    pub position: DVec3,
    /// Normalised texture coordinates.
    pub uv: DVec2,
}

/// Three corners and their texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// In the file's order; both sides are seen.
    pub corners: [Corner; 3],
    /// Which texture of the mesh.
    pub texture: usize,
}

/// Triangles in the order of the file.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// The triangles; faces of more corners are fans.
    pub triangles: Vec<Triangle>,
    /// Their textures.
    pub textures: Vec<NamedTexture>,
}

impl Mesh {
    /// Reads a mesh: glTF by its extension (`.gltf`, `.glb`; with the feature of that name), otherwise OBJ. A material without an
    /// image is its colour; faces without a material are white.
    ///
    /// # Errors
    /// A missing or damaged file, a mesh without texture coordinates or without faces, an image that cannot be read, glTF in a build
    /// without it.
    pub fn load(path: &Path) -> Result<Self> {
        let is_gltf = path
            .extension()
            .is_some_and(|extension| ["gltf", "glb"].iter().any(|known| extension.eq_ignore_ascii_case(known)));
        if is_gltf { load_gltf(path) } else { obj::load(path) }
    }

    /// Turns the mesh and moves it before the camera, so that the sphere around its box just fits a vertical `field_of_view` (degrees).
    pub fn put_in_view(&mut self, turn: DMat3, field_of_view: f64) {
        let corners = || self.triangles.iter().flat_map(|triangle| triangle.corners);
        let low = corners().fold(DVec3::INFINITY, |low, corner| low.min(corner.position));
        let high = corners().fold(DVec3::NEG_INFINITY, |high, corner| high.max(corner.position));
        let (centre, radius) = ((low + high) / 2.0, ((high - low).length() / 2.0).max(f64::MIN_POSITIVE));
        let away = dvec3(0.0, 0.0, -radius / libm::sin(field_of_view.to_radians() / 2.0));
        for corner in self.triangles.iter_mut().flat_map(|triangle| &mut triangle.corners) {
            corner.position = turn * (corner.position - centre) + away;
        }
    }
}

#[cfg(feature = "gltf")]
fn load_gltf(path: &Path) -> Result<Mesh> {
    super::gltf::load(path)
}

#[cfg(not(feature = "gltf"))]
fn load_gltf(path: &Path) -> Result<Mesh> {
    let problem = "this texunit was built without glTF";
    Err(Error::file(path, "its name", problem, "build it with `--features gltf`, or give the mesh as OBJ"))
}

/// One texel of a colour (red, green, blue, alpha, 0 to 1), rounded to the nearest of 255 steps.
pub(super) fn plain(colour: [f32; 4]) -> TextureImage {
    let texel = colour.map(|channel| (channel.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
    PlaneImage::top(1, 1, vec![texel]).into()
}
