//! A mesh from a Wavefront OBJ file, with the textures its MTL file names.

use std::{collections::HashMap, fs::File, path::Path};

use glam::{DVec3, dvec2};

use super::{
    NamedTexture,
    mesh::{Corner, Mesh, Triangle, plain},
};
use crate::{
    error::{Error, Result},
    texture_file,
};

const REMEDY: &str = "a Wavefront OBJ file with texture coordinates (vt) is meant";

/// Reads an OBJ file, and what it names beside it. A material without an image is its diffuse colour; faces without a material are
/// white.
///
/// # Errors
/// A missing or damaged file, a face without texture coordinates, no face at all, an image that cannot be read.
pub fn load(path: &Path) -> Result<Mesh> {
    read(path, &text_of(path)?)
}

/// The same from the text of a file; `path` is for messages, and the folder of what it names.
///
/// # Errors
/// As [`load`].
pub fn read(path: &Path, text: &str) -> Result<Mesh> {
    check_faces(path, text)?;
    let wrong = |place: &str, problem: String| Error::file(path, place, problem, REMEDY);
    let folder = path.parent().unwrap_or(Path::new(""));
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    // What the loader of libraries may only call an error of reading.
    let library_error = std::cell::RefCell::new(None);
    let library = |name: &Path| {
        materials(&folder.join(name)).map_err(|error| {
            library_error.borrow_mut().get_or_insert(error);
            tobj::LoadError::MaterialParseError
        })
    };
    let (models, materials) = tobj::load_obj_buf(&mut text.as_bytes(), &options, library)
        .map_err(|error| wrong("its text", error.to_string()))?;
    if let Some(error) = library_error.into_inner() {
        return Err(error);
    }
    let materials = materials.map_err(|error| wrong("its material library", error.to_string()))?;
    let mut mesh = Mesh::default();
    for material in &materials {
        let image = match &material.diffuse_texture {
            Some(name) => texture_file::load(&folder.join(name.trim().replace('\\', "/")))?,
            None => {
                let [red, green, blue] = material.diffuse.unwrap_or([1.0; 3]);
                plain([red, green, blue, 1.0])
            }
        };
        mesh.textures.push(NamedTexture { name: material.name.clone(), image });
    }
    for model in &models {
        let faces = &model.mesh;
        let texture = faces.material_id.unwrap_or_else(|| {
            mesh.textures.push(NamedTexture { name: format!("{} (white)", model.name), image: plain([1.0; 4]) });
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

/// A text file of any length that is there to its end: a folder, a pipe or a device is none.
fn text_of(path: &Path) -> Result<String> {
    let file = File::open(path).map_err(Error::io(path))?;
    if !file.metadata().map_err(Error::io(path))?.is_file() {
        return Err(Error::file(path, "its name", "no file of a known end", REMEDY));
    }
    std::io::read_to_string(file).map_err(Error::io(path))
}

/// Refuses what `tobj` 4.0.5 would compute with unchecked (indices far away overflow in its products), or pass over (a corner without
/// texture coordinates would have those of the corner before).
fn check_faces(path: &Path, text: &str) -> Result<()> {
    // Positions, texture coordinates, normals so far.
    let mut counts = [0_i64; 3];
    for (number, line) in (1..).zip(text.lines()) {
        let wrong = |problem: String| Err(Error::file(path, format!("line {number}"), problem, REMEDY));
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => counts[0] += 1,
            Some("vt") => counts[1] += 1,
            Some("vn") => counts[2] += 1,
            Some(kind @ ("f" | "l" | "p")) => {
                for word in words {
                    let mut given = [false; 3];
                    for (index, kind) in word.split('/').zip(0..3) {
                        if index.is_empty() {
                            continue;
                        }
                        // Counted from 1, or back from what there is so far.
                        let is_there =
                            |index: i64| -counts[kind] <= index && index <= i64::from(u32::MAX) && index != 0;
                        if !index.parse().is_ok_and(is_there) {
                            return wrong(format!("`{word}` names a corner that is not there"));
                        }
                        given[kind] = true;
                    }
                    if !given[0] || kind == "f" && !given[1] {
                        return wrong(format!("`{word}` has no texture coordinates"));
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// The materials of a library.
fn materials(path: &Path) -> Result<(Vec<tobj::Material>, HashMap<String, usize>)> {
    let text = text_of(path)?;
    for (number, line) in (1..).zip(text.lines()) {
        let mut words = line.split_whitespace();
        // `tobj` 4.0.5 takes it for granted that there are three.
        if words.next().is_some_and(|key| ["Ka", "Kd", "Ke", "Ks"].contains(&key)) && words.count() < 3 {
            let remedy = "write a colour as red, green and blue, 0 to 1";
            return Err(Error::file(path, format!("line {number}"), format!("`{}` is no colour", line.trim()), remedy));
        }
    }
    tobj::load_mtl_buf(&mut text.as_bytes())
        .map_err(|error| Error::file(path, "its text", error.to_string(), "a Wavefront MTL file is meant"))
}
