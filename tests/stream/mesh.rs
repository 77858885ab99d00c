//! Meshes: what is seen of them, and what of OBJ files is refused.

use std::fs;

use texunit::{
    scene::{Camera, Rotation, Scene},
    stream::{
        mesh::{Corner, Mesh, Triangle},
        raster::rasterize,
    },
};

use crate::{texunit, write_texture};

/// A rectangle of two triangles, wound either way.
fn rectangle(size: [f64; 2], turn: Rotation, away: [f64; 3]) -> Mesh {
    let corner = |u: f64, v: f64| {
        let flat = glam::dvec3((u - 0.5) * size[0], (0.5 - v) * size[1], 0.0);
        Corner { position: turn.matrix() * flat + glam::DVec3::from_array(away), uv: glam::dvec2(u, v) }
    };
    let [a, b, c, d] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
    let triangles = vec![Triangle { corners: [a, b, c], texture: 0 }, Triangle { corners: [a, d, c], texture: 0 }];
    Mesh { triangles, textures: vec![] }
}

#[test]
fn two_triangles_have_the_fragments_of_their_rectangle() {
    let scene = Scene { size: [160, 120], ..Scene::builtin("rectangle-natural").unwrap() };
    let texunit::scene::Shape::Rectangle(shape) = scene.shape else { unreachable!() };
    let mesh = rectangle(shape.size, shape.pose.rotation, shape.pose.translation);
    let stream = rasterize(mesh, scene.camera, scene.size);
    let mut found: Vec<_> = stream.requests.iter().map(|request| request.fragment).collect();
    found.sort_by_key(|fragment| (fragment.y, fragment.x));
    let mut expected: Vec<_> = scene.fragments().collect();
    expected.sort_by_key(|fragment| (fragment.y, fragment.x));
    assert!(expected.len() > 1000);
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!((found.x, found.y), (expected.x, expected.y));
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(near(found.u, expected.u) && near(found.v, expected.v), "{found:?} {expected:?}");
        assert!(near(found.gradient.ux, expected.gradient.ux) && near(found.gradient.vy, expected.gradient.vy));
        assert!(near(found.gradient.uy, expected.gradient.uy) && near(found.gradient.vx, expected.gradient.vx));
    }
}

#[test]
fn what_is_nearer_hides_what_comes_later_and_what_is_behind_the_eye_is_not_seen() {
    let camera = Camera { field_of_view: 60.0 };
    let flat = Rotation::Euler([0.0; 3]);
    let mut mesh = rectangle([1.0, 1.0], flat, [0.0, 0.0, -2.0]);
    let front = rasterize(mesh.clone(), camera, [64, 64]).requests.len();
    mesh.triangles.extend(rectangle([1.0, 1.0], flat, [0.0, 0.0, -4.0]).triangles);
    mesh.triangles.extend(rectangle([1.0, 1.0], flat, [0.0, 0.0, 4.0]).triangles);
    assert!(front > 100);
    assert_eq!(rasterize(mesh, camera, [64, 64]).requests.len(), front);
    // A floor that passes under the eye covers the lower half of the picture, to the horizon.
    let floor = rectangle([1e4, 1e4], Rotation::Euler([-90.0, 0.0, 0.0]), [0.0, -1.0, 0.0]);
    let stream = rasterize(floor, camera, [64, 64]);
    assert_eq!(stream.requests.len(), 64 * 32);
    assert!(stream.requests.iter().all(|request| request.fragment.y >= 32));
}

#[test]
fn a_mesh_is_drawn_with_the_textures_of_its_materials() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_texture(&path.join("brick.png"), [200, 80, 60, 255]);
    fs::write(path.join("box.mtl"), "newmtl wall\nmap_Kd brick.png\nnewmtl lid\nKd 0.0 0.5 1.0\n").unwrap();
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 1 -1\nv 1 1 -1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let faces = "usemtl wall\nf 1/1 2/2 3/3 4/4\nusemtl lid\nf 4/1 3/2 6/3 5/4\n";
    fs::write(path.join("box.obj"), format!("mtllib box.mtl\no box\n{corners}{faces}")).unwrap();
    let (code, told, error) =
        texunit(path, &["stream", "--mesh", "box.obj", "--turn", "30,20,0", "--size", "64x48", "-o", "out"]);
    assert_eq!(code, 0, "{error}");
    assert!(told.contains("wall") && told.contains("lid") && told.contains("0 mismatches"), "{told}");
    let picture = image::open(path.join("out/trilinear.png")).unwrap().to_rgba8();
    assert!(picture.pixels().any(|pixel| pixel.0 == [0, 128, 255, 255]), "the lid is seen");

    for (text, expected) in [
        ("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "no texture coordinates"),
        ("v 0 0 0\n", "no face"),
        ("v 0 0\nf 1 2 3\n", "bad.obj"),
        ("v 0 0 0\nv 1 0 0\nvt 0 0\nf 1/1 2/1 9/1\n", "bad.obj"),
    ] {
        fs::write(path.join("bad.obj"), text).unwrap();
        let (code, _, error) = texunit(path, &["stream", "--mesh", "bad.obj"]);
        assert!(code == 2 && error.contains(expected), "{text}: {error}");
    }
    let (code, _, error) = texunit(path, &["stream", "--mesh", "absent.obj"]);
    assert!(code == 2 && error.contains("absent.obj"), "{error}");
}

#[test]
fn what_the_obj_loader_would_compute_with_unchecked_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.obj");
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n";
    for (faces, expected) in [
        ("f 1/1 2/2 3", "line 7: `3` has no texture coordinates"),
        ("f 1/1 2/2 /3", "line 7"),
        ("f 1/1 2/2 -4/3", "line 7"),
        ("f 1/1 2/2 9223372036854775807/3", "line 7"),
        ("f 1/1 2/2 3/-9223372036854775808", "line 7"),
        ("f 0/1 2/2 3/3", "line 7"),
    ] {
        fs::write(&path, format!("{corners}{faces}\n")).unwrap();
        let error = Mesh::load(&path).unwrap_err().to_string();
        assert!(error.contains("bad.obj") && error.contains(expected), "{faces}: {error}");
    }
    fs::write(folder.path().join("bad.mtl"), "newmtl wall\nKd 0.5 0.5\n").unwrap();
    fs::write(&path, format!("mtllib bad.mtl\n{corners}f -3/-3 -2/-2 -1/-1\n")).unwrap();
    let error = Mesh::load(&path).unwrap_err().to_string();
    assert!(error.contains("bad.mtl") && error.contains("line 2"), "{error}");
    fs::write(folder.path().join("bad.mtl"), "newmtl wall\nKd 0.5 0.5 1\n").unwrap();
    assert_eq!(Mesh::load(&path).unwrap().triangles.len(), 1);
}

#[cfg(not(feature = "gltf"))]
#[test]
fn without_its_feature_gltf_is_refused_by_name() {
    let error = Mesh::load(std::path::Path::new("model.glb")).unwrap_err().to_string();
    assert!(error.contains("--features gltf"), "{error}");
}
