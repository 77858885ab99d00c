//! Every reader of texunit, given bytes: true if it took them. What it takes must hold together, what it refuses must say why.

use std::{io::Cursor, path::Path};

use texunit::{
    address_trace::{AddressFormat, AddressTrace},
    coordinate_rows::Rows,
    error::Error,
    machine::Machine,
    scene::Scene,
    texture_file,
    trace::Trace,
};

/// A name and a function.
pub type Reader = (&'static str, fn(&[u8]) -> bool);

/// All of them.
pub const READERS: [Reader; 6] = [
    ("scene", scene),
    ("machine", machine),
    ("trace", trace),
    ("coordinates", coordinates),
    ("texture", texture),
    ("addresses", addresses),
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
