//! Meshes in glTF, against the same in OBJ.

use std::{fs, path::Path};

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value, json};
use texunit::{
    scene::{Camera, Rotation},
    stream::{StreamRequest, mesh::Mesh, raster::rasterize},
};

use crate::{texunit, write_texture};

/// Two triangles of a unit square: positions, coordinates (v down), indices.
fn buffer() -> Vec<u8> {
    let positions: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
    let coordinates: [f32; 8] = [0., 1., 1., 1., 1., 0., 0., 0.];
    let mut bytes: Vec<u8> = positions.iter().chain(&coordinates).flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

/// The square turned by a quarter about x, made twice as wide, and moved, through a node and its child.
fn model() -> Value {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [
            { "children": [1], "rotation": [half, 0, 0, half], "translation": [5, 6, 7] },
            { "mesh": 0, "matrix": [2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,3,1] },
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_1": 1 }, "indices": 2, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 1 } } }],
        "textures": [{ "source": 0 }], "images": [{ "uri": "brick%20wall.png" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0,0,0], "max": [1,1,0] },
            { "bufferView": 0, "byteOffset": 48, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "bufferViews": [{ "buffer": 0, "byteLength": 80 }, { "buffer": 0, "byteOffset": 80, "byteLength": 12 }],
        "buffers": [{ "byteLength": 92, "uri": data("application/octet-stream", &buffer()) }],
    })
}

fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

fn with(place: &str, value: Value) -> Value {
    let mut model = model();
    *model.pointer_mut(place).unwrap_or_else(|| panic!("{place}")) = value;
    model
}

fn load(path: &Path, model: &Value) -> texunit::error::Result<Mesh> {
    fs::write(path.join("a.gltf"), model.to_string()).unwrap();
    Mesh::load(&path.join("a.gltf"))
}

#[test]
fn a_mesh_in_gltf_has_the_fragments_of_the_same_mesh_in_obj() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_texture(&path.join("brick wall.png"), [200, 80, 60, 255]);
    let png = fs::read(path.join("brick wall.png")).unwrap();
    // (x, y, z) becomes (2x + 5, -3 + 6, y + 7): turned, y goes to z and z to -y.
    fs::write(path.join("a.mtl"), "newmtl wall\nmap_Kd brick wall.png\n").unwrap();
    let obj = "mtllib a.mtl\nv 5 3 7\nv 7 3 7\nv 7 3 8\nv 5 3 8\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl wall\n\
               f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    fs::write(path.join("a.obj"), obj).unwrap();
    let draw = |mut mesh: Mesh| {
        mesh.put_in_view(Rotation::Euler([70.0, 10.0, 0.0]).matrix(), 45.0);
        rasterize(mesh, Camera { field_of_view: 45.0 }, [96, 64])
    };
    let expected = draw(Mesh::load(&path.join("a.obj")).unwrap());
    assert!(expected.requests.len() > 500);

    // The same in a binary file, its image in a buffer view.
    let mut bytes = buffer();
    bytes.extend(&png);
    let mut inside = model();
    inside["buffers"] = json!([{ "byteLength": bytes.len() }]);
    inside["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "buffer": 0, "byteOffset": 92, "byteLength": png.len() }));
    inside["images"] = json!([{ "bufferView": 2, "mimeType": "image/png" }]);
    let mut text = inside.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let mut glb = b"glTF".to_vec();
    for word in [2, (28 + text.len() + bytes.len()) as u32, text.len() as u32] {
        glb.extend(word.to_le_bytes());
    }
    glb.extend([b"JSON".as_slice(), &text, &(bytes.len() as u32).to_le_bytes(), b"BIN\0", &bytes].concat());
    fs::write(path.join("a.glb"), &glb).unwrap();

    let embedded = with("/images/0", json!({ "uri": data("image/png", &png) }));
    let found =
        [load(path, &model()).unwrap(), load(path, &embedded).unwrap(), Mesh::load(&path.join("a.glb")).unwrap()];
    for mesh in found {
        let found = draw(mesh);
        assert_eq!((found.textures.len(), &found.textures[0].image), (1, &expected.textures[0].image));
        assert_eq!(found.requests.len(), expected.requests.len());
        for (found, expected) in found.requests.iter().zip(&expected.requests) {
            let numbers = |request: &StreamRequest| {
                let fragment = request.fragment;
                let gradient = fragment.gradient;
                [fragment.u, fragment.v, gradient.ux, gradient.uy, gradient.vx, gradient.vy]
            };
            assert_eq!((found.fragment.x, found.fragment.y), (expected.fragment.x, expected.fragment.y));
            // A quarter turn is one in single precision only.
            assert!(numbers(found).iter().zip(numbers(expected)).all(|(a, b)| (a - b).abs() < 1e-6));
        }
    }
    let (code, told, error) = texunit(path, &["stream", "--mesh", "a.glb", "--turn", "70,0,0", "--size", "64x48"]);
    assert!(code == 0 && told.contains("0 mismatches"), "{told}{error}");

    // No binary file cut short is taken, nor does any make the reader panic.
    for length in 0..glb.len() {
        fs::write(path.join("cut.glb"), &glb[..length]).unwrap();
        assert!(Mesh::load(&path.join("cut.glb")).is_err(), "{length}");
    }
    glb[8..12].copy_from_slice(&4_u32.to_le_bytes());
    fs::write(path.join("cut.glb"), &glb).unwrap();
    assert!(Mesh::load(&path.join("cut.glb")).unwrap_err().to_string().contains("header"));
}

#[test]
fn a_base_colour_without_a_texture_is_one_texel_of_its_srgb_code() {
    let folder = tempfile::tempdir().unwrap();
    // 0.2159 is code 128 of 255 (IEC 61966-2-1); alpha is no code.
    let plain = with("/materials/0", json!({ "pbrMetallicRoughness": { "baseColorFactor": [1.0, 0.2159, 0.0, 0.5] } }));
    let mesh = load(folder.path(), &plain).unwrap();
    assert_eq!(mesh.textures[0].image.top.texels, [[255, 128, 0, 128]]);
}

#[test]
fn gltf_that_does_not_hold_together_is_refused_and_says_where() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_texture(&path.join("brick wall.png"), [200, 80, 60, 255]);
    assert_eq!(load(path, &model()).unwrap().triangles.len(), 2);
    let huge = json!(u64::MAX);
    let mut required = model();
    required["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    let mut strip = model();
    strip["meshes"][0]["primitives"][0]["mode"] = json!(5);
    let mut sparse = model();
    sparse["accessors"][1]["sparse"] =
        json!({ "count": 1, "indices": { "bufferView": 1, "componentType": 5123 }, "values": { "bufferView": 0 } });
    let mut stride = model();
    stride["bufferViews"][0]["byteStride"] = json!(4);
    for (model, expected) in [
        (required, "KHR_draco"),
        (strip, "TriangleStrip"),
        (sparse, "sparse"),
        (stride, "accessors[0]"),
        (with("/nodes/1", json!({ "children": [0] })), "reached twice"),
        (with("/nodes/1/mesh", json!(7)), "mesh"),
        (with("/scenes", json!([])), "scene"),
        (with("/meshes/0/primitives/0/attributes", json!({ "POSITION": 9 })), "accessors[9]"),
        (with("/meshes/0/primitives/0/attributes", json!({ "POSITION": 0, "TEXCOORD_0": 1 })), "TEXCOORD_1"),
        (with("/accessors/0/count", json!(1000)), "accessors[0]"),
        (with("/accessors/0/count", huge.clone()), "accessors[0]"),
        (with("/accessors/1/byteOffset", huge.clone()), "accessors[1]"),
        (with("/accessors/1/count", json!(3)), "4 positions and 3"),
        (with("/accessors/2/count", json!(5)), "5 corners"),
        (with("/accessors/2/count", json!(0)), "no triangle"),
        (with("/accessors/2/componentType", json!(5126)), "accessors[2]"),
        (with("/accessors/2/type", json!("MAT4")), "accessors[2]"),
        // The floats of the positions, read as indices.
        (
            with(
                "/accessors/2",
                json!({ "bufferView": 0, "byteOffset": 12, "componentType": 5123, "count": 6, "type": "SCALAR" }),
            ),
            "of 4 corners",
        ),
        (with("/bufferViews/0/byteLength", huge.clone()), "bufferViews[0]"),
        (with("/bufferViews/1/byteOffset", huge.clone()), "bufferViews[1]"),
        (with("/buffers/0/byteLength", huge), "buffers[0]"),
        (with("/buffers/0/uri", json!("data:;base64,@")), "base64"),
        (with("/buffers/0/uri", json!("data:text/plain,a")), "base64"),
        (with("/buffers/0/uri", json!("https://example.invalid/a.bin")), "no file of this computer"),
        (with("/buffers/0/uri", json!("absent.bin")), "absent.bin"),
        (with("/images/0", json!({})), "images[0]"),
        (with("/images/0", json!({ "bufferView": 1 })), "images[0]"),
        (with("/images/0", json!({ "bufferView": 1, "mimeType": "image/png" })), "images[0]"),
        (with("/images/0/uri", json!("absent.png")), "absent.png"),
        (with("/nodes/0/rotation", json!([0, 0, 0, 0])), "corner 0 is at"),
    ] {
        let error = load(path, &model).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}
