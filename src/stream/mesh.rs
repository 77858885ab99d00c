//! A mesh from an OBJ file, with the textures its MTL file names.

use std::path::Path;

use glam::{DMat3, DVec2, DVec3, dvec2, dvec3};

use super::NamedTexture;
use crate::{
    error::{Error, Result},
    pyramid::PlaneImage,
    texture_file,
};

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
    /// Reads an OBJ file. A material without an image is its diffuse colour; faces without a material are white.
    ///
    /// # Errors
    /// A missing or damaged file, a mesh without texture coordinates or without faces, an image that cannot be read.
    pub fn load(path: &Path) -> Result<Self> {
        if !path.is_file() {
            std::fs::File::open(path).map_err(Error::io(path))?;
        }
        let remedy = "a Wavefront OBJ file with texture coordinates (vt) is meant";
        let wrong = |place: &str, problem: String| Error::file(path, place, problem, remedy);
        let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
        let (models, materials) =
            tobj::load_obj(path, &options).map_err(|error| wrong("its text", error.to_string()))?;
        let materials = materials.map_err(|error| wrong("its material library", error.to_string()))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut mesh = Self::default();
        for material in &materials {
            let image = match &material.diffuse_texture {
                Some(name) => texture_file::load(&folder.join(name.trim().replace('\\', "/")))?,
                None => plain(material.diffuse.unwrap_or([1.0; 3])),
            };
            mesh.textures.push(NamedTexture { name: material.name.clone(), image });
        }
        for model in &models {
            let faces = &model.mesh;
            let texture = faces.material_id.unwrap_or_else(|| {
                mesh.textures.push(NamedTexture { name: format!("{} (white)", model.name), image: plain([1.0; 3]) });
                mesh.textures.len() - 1
            });
            if faces.texcoord_indices.len() != faces.indices.len() {
                return Err(wrong(&format!("object `{}`", model.name), "a face has no texture coordinates".into()));
            }
            let corner = |(&at, &uv): (&u32, &u32)| {
                let position = faces.positions.get(3 * at as usize..)?.first_chunk::<3>()?.map(f64::from);
                let [u, v] = faces.texcoords.get(2 * uv as usize..)?.first_chunk::<2>()?.map(f64::from);
                // OBJ counts v from the bottom.
                Some(Corner { position: DVec3::from_array(position), uv: dvec2(u, 1.0 - v) })
            };
            let corners: Option<Vec<Corner>> = faces.indices.iter().zip(&faces.texcoord_indices).map(corner).collect();
            let corners = corners.ok_or_else(|| {
                wrong(&format!("object `{}`", model.name), "a face names a corner that is not there".into())
            })?;
            let triangles = corners.as_chunks::<3>().0.iter().map(|&corners| Triangle { corners, texture });
            mesh.triangles.extend(triangles);
        }
        if mesh.triangles.is_empty() {
            return Err(wrong("its text", "there is no face".into()));
        }
        Ok(mesh)
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

/// One texel of a colour.
fn plain(colour: [f32; 3]) -> crate::texture_file::TextureImage {
    let [red, green, blue] = colour.map(|channel| (channel.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
    PlaneImage::top(1, 1, vec![[red, green, blue, 255]]).into()
}
