//! `texunit scenes`, as a user runs it.

use std::process::{Command, Output};

use texunit::scene::Scene;

fn texunit(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_texunit")).args(arguments).output().unwrap()
}

#[test]
fn the_list_names_every_scene_with_its_covered_pixels() {
    let list = String::from_utf8(texunit(&["scenes"]).stdout).unwrap();
    for name in Scene::builtin_names() {
        let covered = Scene::builtin(name).unwrap().coverage().covered.to_string();
        assert!(list.lines().any(|line| line.contains(name) && line.contains(&covered)), "{name} in\n{list}");
    }
}

#[test]
fn a_shown_scene_is_a_scene_file() {
    let shown = String::from_utf8(texunit(&["scenes", "--show", "floor"]).stdout).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, shown).unwrap();
    assert_eq!(Scene::load(&path).unwrap(), Scene::builtin("floor").unwrap());
}

#[test]
fn a_texture_is_written_as_png_and_an_unknown_scene_is_bad_use() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pane.png");
    let output = texunit(&["scenes", "--texture", "ellipsoid-pane", "-o", path.to_str().unwrap()]);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(0), 0));
    let written = image::open(&path).unwrap().into_rgba8();
    assert_eq!(written, *Scene::builtin("ellipsoid-pane").unwrap().texture.image());
    let unknown = texunit(&["scenes", "--show", "nope"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(String::from_utf8(unknown.stderr).unwrap().contains("floor"));
}
