//! Every reader of texunit, given bytes: true if it took them. What it takes must hold together, what it refuses must say why.

use std::{fs, io::Cursor, path::Path};

use texunit::{
    address_trace::{AddressFormat, AddressTrace},
    coordinate_rows::Rows,
    error::Error,
    machine::Machine,
    scene::Scene,
    stream::{mesh::Mesh, obj, requests_file},
    sweep::Plan,
    texture_file,
    trace::Trace,
};

/// A name and a function.
pub type Reader = (&'static str, fn(&[u8]) -> bool);

/// All of them.
pub const READERS: &[Reader] = &[
    ("scene", scene),
    ("machine", machine),
    ("trace", trace),
    ("coordinates", coordinates),
    ("texture", texture),
    ("addresses", addresses),
    ("requests", requests),
    ("sweep", sweep),
    ("obj", obj),
    ("mtl", mtl),
    #[cfg(feature = "gltf")]
    ("gltf", gltf),
];

/// A refusal says something.
fn refused(error: &Error) -> bool {
    assert!(!error.to_string().trim().is_empty(), "{error:?}");
    false
}

/// A line of TOML up to its comment, if no string can hold the mark.
fn without_comment(line: &str) -> &str {
    let (before, _) = line.split_once('#').unwrap_or((line, ""));
    if before.matches('"').count() % 2 == 0 && !before.contains('\'') { before } else { line }
}

/// A scene file. One that names a texture file is passed over: it may name any file of this computer.
pub fn scene(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let names_a_file = text.lines().map(without_comment).any(|line| {
        line.split("file").skip(1).any(|rest| rest.trim_start_matches([' ', '\t', '"', '\'']).starts_with('='))
    });
    if names_a_file || text.contains('\\') {
        return false;
    }
    match Scene::parse(Path::new("fuzz/scene.toml"), text) {
        Ok(scene) => {
            assert!(scene.size.iter().all(|side| (1..=16384).contains(side)), "{:?}", scene.size);
            true
        }
        Err(error) => refused(&error),
    }
}

/// A machine file. What it says survives being written.
pub fn machine(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let path = Path::new("fuzz/machine.toml");
    match Machine::parse(path, text) {
        Ok(machine) => {
            machine.check().expect("it was checked");
            // Any f64 but NaN, which no value of a machine may be.
            assert_eq!(machine, machine.with_settings(&[]).expect("nothing was set"));
            true
        }
        Err(error) => refused(&error),
    }
}

/// A trace. What it says survives being written.
pub fn trace(bytes: &[u8]) -> bool {
    match Trace::parse("fuzz/a.trace", bytes) {
        Ok(trace) => {
            let mut text = Vec::new();
            trace.write(&mut text).expect("to memory");
            let again = Trace::parse("fuzz/again.trace", text.as_slice()).unwrap_or_else(|error| panic!("{error}"));
            assert!(trace.records == again.records && trace.profile == again.profile, "not the same twice");
            true
        }
        Err(error) => refused(&error),
    }
}

/// Coordinates in CSV.
pub fn coordinates(bytes: &[u8]) -> bool {
    let mut rows = match Rows::new("fuzz/coordinates.csv", bytes) {
        Ok(rows) => rows,
        Err(error) => return refused(&error),
    };
    let mut block = Vec::new();
    loop {
        match rows.block(&mut block) {
            Ok(()) if block.is_empty() => return true,
            Ok(()) => {}
            Err(error) => return refused(&error),
        }
    }
}

/// A texture: image, KTX2 or DDS; without a signature it is a TGA.
pub fn texture(bytes: &[u8]) -> bool {
    match texture_file::read(Path::new("fuzz/texture.tga"), bytes) {
        Ok(texture) => {
            let top = &texture.top;
            assert_eq!(top.texels.len() as u64, u64::from(top.width) * u64::from(top.height));
            true
        }
        Err(error) => refused(&error),
    }
}

/// A trace of addresses, in each of its formats.
pub fn addresses(bytes: &[u8]) -> bool {
    let mut taken = false;
    for format in [AddressFormat::U64, AddressFormat::U32, AddressFormat::Din] {
        let mut trace = AddressTrace::new("fuzz/addresses", Cursor::new(bytes.to_vec()), format);
        let mut block = Vec::new();
        loop {
            match trace.next_block(&mut block) {
                Ok(true) => {}
                Ok(false) => {
                    taken = true;
                    break;
                }
                Err(error) => {
                    refused(&error);
                    break;
                }
            }
        }
    }
    taken
}

/// A stream of requests in CSV; a texture it names is a file of an empty folder, and rows that name none have one of a texel.
pub fn requests(bytes: &[u8]) -> bool {
    if bytes.contains(&b'/') {
        return false;
    }
    let folder = tempfile::tempdir().expect("a folder of its own");
    let texture = folder.path().join("texel.ppm");
    fs::write(&texture, TEXEL).expect("a texture of one texel");
    match requests_file::read(&folder.path().join("fuzz.csv"), bytes, &[("it".into(), texture)]) {
        Ok(stream) => {
            assert!(stream.requests.iter().all(|request| request.texture < stream.textures.len()));
            assert!(stream.size.is_none_or(|size| size.iter().all(|side| (1..=16384).contains(side))));
            true
        }
        Err(error) => refused(&error),
    }
}

/// A portable pixmap.
const TEXEL: &[u8] = b"P6\n1 1\n255\nabc";

/// A sweep file. One with a path in it is passed over: it may name any file of this computer.
pub fn sweep(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    if text.lines().map(without_comment).any(|line| line.contains(['/', '\\'])) {
        return false;
    }
    match Plan::parse(Path::new("fuzz/sweep.toml"), text) {
        Ok(plan) => {
            assert!(plan.points.iter().enumerate().all(|(number, point)| point.number == number));
            assert!(plan.points.iter().all(|point| point.stage < plan.stages.len()));
            true
        }
        Err(error) => refused(&error),
    }
}

/// What a reader of meshes made: triangles of textures that are there.
fn mesh(read: texunit::error::Result<Mesh>) -> bool {
    match read {
        Ok(mesh) => {
            assert!(!mesh.triangles.is_empty());
            assert!(mesh.triangles.iter().all(|triangle| triangle.texture < mesh.textures.len()));
            true
        }
        Err(error) => refused(&error),
    }
}

/// A mesh in OBJ. The only library it may name has one material; one with a path in it is passed over.
pub fn obj(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let named = || text.lines().filter(|line| line.trim_start().starts_with("mtllib"));
    if named().any(|line| line.contains('/')) {
        return false;
    }
    let folder = tempfile::tempdir().expect("a folder of its own");
    if named().next().is_some() {
        fs::write(folder.path().join("it.mtl"), "newmtl it\nKd 1 0.5 0\n").expect("a library of one material");
    }
    mesh(obj::read(&folder.path().join("fuzz.obj"), text))
}

/// A library of materials, named by a mesh of one triangle. Its images are files of its folder; one with a path in it is passed over.
pub fn mtl(bytes: &[u8]) -> bool {
    if bytes.split(|byte| *byte == b'\n').any(|line| line.contains(&b'/') || line.contains(&b'\\')) {
        return false;
    }
    let folder = tempfile::tempdir().expect("a folder of its own");
    fs::write(folder.path().join("fuzz.mtl"), bytes).expect("a file of its own");
    fs::write(folder.path().join("texel.ppm"), TEXEL).expect("a texture of one texel");
    let triangle = "mtllib fuzz.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl it\nf 1/1 2/1 3/1\n";
    mesh(obj::read(&folder.path().join("fuzz.obj"), triangle))
}

/// A mesh in glTF, text or binary. One that names a file is passed over: it may name any file of this computer.
#[cfg(feature = "gltf")]
pub fn gltf(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let names_a_file = text
        .split("\"uri\"")
        .skip(1)
        .any(|rest| !rest.trim_start_matches([' ', '\t', '\r', '\n', ':']).starts_with("\"data:"));
    // Escaped letters could hide a key.
    if names_a_file || text.contains('\\') {
        return false;
    }
    mesh(texunit::stream::gltf::read(Path::new("fuzz/mesh.gltf"), bytes))
}
