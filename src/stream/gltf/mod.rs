//! A mesh from a glTF 2.0 file, text (`.gltf`) or binary (`.glb`): the triangles of its scene with their base colours (Khronos, glTF
//! 2.0 Specification; sections are of version 2.0.1).
//!
//! Taken are the transforms of nodes (3.5.3), texture coordinates of the set that the base colour texture names, and that texture, or
//! the base colour factor where there is none (3.9.2). Not taken are wrap and filter modes of samplers, skins, morph targets, cameras,
//! vertex colours, and extensions: a file that requires one is refused.

mod resources;
mod values;

use std::{collections::BTreeMap, path::Path};

use ::gltf::{Document, Gltf, Node, Primitive, Semantic, accessor::DataType, mesh::Mode, scene::Transform};
use glam::{DMat4, DQuat, DVec2, DVec3};

use self::resources::{Colour, Resources};
use super::mesh::{Corner, Mesh, Triangle};
use crate::error::{Error, Result};

/// Nodes may show one mesh any number of times; so many triangles (2 GiB) is where that ends.
pub const TRIANGLES_MAX: usize = 1 << 24;

const REMEDY: &str = "a glTF 2.0 file of triangles with texture coordinates is meant";

/// Reads a glTF file, and the buffers and images it names beside it.
///
/// # Errors
/// A missing or damaged file, one that needs an extension, primitives that are no triangles, missing texture coordinates, an accessor
/// that reaches beyond its buffer or is sparse, a node that is its own ancestor, an image that cannot be read, no triangle at all.
pub fn load(path: &Path) -> Result<Mesh> {
    read(path, &resources::bytes_of(path)?)
}

/// The same from the bytes of a file; `path` is for messages, and the folder of what it names.
///
/// # Errors
/// As [`load`].
pub fn read(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let wrong = |place: &str, problem: String| Error::file(path, place, problem, REMEDY);
    let (document, blob) = parse(path, bytes)?;
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| wrong("its text", "there is no scene".into()))?;
    let resources = Resources::new(path, &document, blob)?;
    let mut loader = Loader { path, resources, mesh: Mesh::default(), known: BTreeMap::new() };
    let mut is_seen = vec![false; document.nodes().len()];
    // In the order of the file, parents first.
    let mut open: Vec<(Node<'_>, DMat4)> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
    open.reverse();
    while let Some((node, parent)) = open.pop() {
        let place = format!("nodes[{}]", node.index());
        if std::mem::replace(&mut is_seen[node.index()], true) {
            return Err(wrong(&place, "it is reached twice: nodes are a tree".into()));
        }
        let world = parent * local(&node.transform());
        for primitive in node.mesh().iter().flat_map(::gltf::Mesh::primitives) {
            let mesh = node.mesh().map_or(0, |mesh| mesh.index());
            loader.add(&format!("{place}, meshes[{mesh}].primitives[{}]", primitive.index()), &primitive, world)?;
        }
        let first = open.len();
        open.extend(node.children().map(|child| (child, world)));
        open[first..].reverse();
    }
    if loader.mesh.triangles.is_empty() {
        return Err(wrong("its scene", "there is no triangle".into()));
    }
    Ok(loader.mesh)
}

/// What the file says, checked by the crate as far as it checks.
fn parse(path: &Path, bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>)> {
    let wrong = |place: &str, problem: String| Error::file(path, place, problem, REMEDY);
    // The length of a binary file counts its head of 12 bytes; gltf 1.4.1 subtracts them unasked.
    let length = bytes.get(8..).and_then(<[u8]>::first_chunk).map(|length| u32::from_le_bytes(*length));
    if bytes.starts_with(b"glTF") && length.is_some_and(|length| length < 12) {
        return Err(wrong("its header", "it is shorter than its own header".into()));
    }
    let file = Gltf::from_slice_without_validation(bytes).map_err(|error| wrong("its text", error.to_string()))?;
    let json = file.document.into_json();
    // gltf-json 1.4.1 looks up the positions of a primitive before it knows that they are there.
    let accessors = json.accessors.len();
    for (number, mesh) in json.meshes.iter().enumerate() {
        let mut named = mesh.primitives.iter().flat_map(|primitive| primitive.attributes.values());
        if let Some(index) = named.find(|index| index.value() >= accessors) {
            let problem = format!("accessors[{}] is not there", index.value());
            return Err(wrong(&format!("meshes[{number}]"), problem));
        }
    }
    // And takes it for granted that an image is somewhere (3.8.2).
    let is_nowhere =
        |image: &::gltf::json::Image| image.uri.is_none() && (image.buffer_view.is_none() || image.mime_type.is_none());
    if let Some(number) = json.images.iter().position(is_nowhere) {
        let problem = "it has neither a URI nor a buffer view with a type";
        return Err(wrong(&format!("images[{number}]"), problem.into()));
    }
    let document = Document::from_json(json).map_err(|error| wrong("its text", error.to_string()))?;
    Ok((document, file.blob))
}

/// From a node to its parent, in double precision (3.5.3).
fn local(transform: &Transform) -> DMat4 {
    match *transform {
        Transform::Matrix { matrix } => DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))),
        Transform::Decomposed { translation, rotation, scale } => DMat4::from_scale_rotation_translation(
            DVec3::from_array(scale.map(f64::from)),
            // Of length 1 in single precision only.
            DQuat::from_array(rotation.map(f64::from)).normalize(),
            DVec3::from_array(translation.map(f64::from)),
        ),
    }
}

struct Loader<'l> {
    path: &'l Path,
    resources: Resources<'l>,
    mesh: Mesh,
    /// Textures so far.
    known: BTreeMap<Colour, usize>,
}

impl Loader<'_> {
    /// The triangles of a primitive where a node puts them.
    fn add(&mut self, place: &str, primitive: &Primitive<'_>, world: DMat4) -> Result<()> {
        let path = self.path;
        let wrong = |problem: String| Error::file(path, place, problem, REMEDY);
        if primitive.mode() != Mode::Triangles {
            return Err(wrong(format!("mode {:?}: only separate triangles are drawn", primitive.mode())));
        }
        let material = primitive.material();
        let base = material.pbr_metallic_roughness().base_color_texture();
        let positions = primitive.get(&Semantic::Positions).ok_or_else(|| wrong("it has no POSITION".into()))?;
        let positions = self.resources.values::<3>(&positions, &[DataType::F32])?;
        let set = base.as_ref().map_or(0, ::gltf::texture::Info::tex_coord);
        let uvs = match primitive.get(&Semantic::TexCoords(set)) {
            Some(uvs) => self.resources.values::<2>(&uvs, &[DataType::F32, DataType::U8, DataType::U16])?,
            // A plain colour is the same everywhere.
            None if base.is_none() => vec![[0.0; 2]; positions.len()],
            None => return Err(wrong(format!("it has no TEXCOORD_{set}, which its base colour texture asks for"))),
        };
        if uvs.len() != positions.len() {
            return Err(wrong(format!("{} positions and {} texture coordinates", positions.len(), uvs.len())));
        }
        let indices: Vec<usize> = match primitive.indices() {
            Some(indices) => {
                let indices = self.resources.values::<1>(&indices, &[DataType::U8, DataType::U16, DataType::U32])?;
                indices.into_iter().map(|[index]| index as usize).collect()
            }
            None => (0..positions.len()).collect(),
        };
        let (triangles, rest) = indices.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(wrong(format!("{} corners are not a whole number of triangles", indices.len())));
        }
        if self.mesh.triangles.len() + triangles.len() > TRIANGLES_MAX {
            return Err(wrong(format!("more than {TRIANGLES_MAX} triangles")));
        }
        let corner = |index: usize| {
            let position =
                positions.get(index).ok_or_else(|| wrong(format!("index {index} of {} corners", positions.len())))?;
            let position = world.transform_point3(DVec3::from_array(*position));
            if !position.is_finite() {
                return Err(wrong(format!("corner {index} is at {position}")));
            }
            Ok(Corner { position, uv: DVec2::from_array(uvs[index]) })
        };
        let colour = Colour::of(&material);
        let texture = match self.known.get(&colour) {
            Some(&texture) => texture,
            None => {
                self.mesh.textures.push(self.resources.texture(&material)?);
                *self.known.entry(colour).or_insert(self.mesh.textures.len() - 1)
            }
        };
        for &[a, b, c] in triangles {
            let corners = [corner(a)?, corner(b)?, corner(c)?];
            self.mesh.triangles.push(Triangle { corners, texture });
        }
        Ok(())
    }
}
