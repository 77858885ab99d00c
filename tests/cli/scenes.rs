//! `texunit scenes`, as a user runs it.

use std::path::Path;

use texunit::scene::Scene;

use super::{good, refused, texunit};

#[test]
fn the_list_names_every_scene_with_its_covered_pixels() {
    let list = good(&texunit(Path::new("."), &["scenes"]));
    for name in Scene::builtin_names() {
        let covered = Scene::builtin(name).unwrap().coverage().covered.to_string();
        assert!(list.lines().any(|line| line.contains(name) && line.contains(&covered)), "{name} in\n{list}");
    }
}

#[test]
fn a_shown_scene_is_a_scene_file() {
    let folder = tempfile::tempdir().unwrap();
    let shown = good(&texunit(folder.path(), &["scenes", "--show", "floor"]));
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, shown).unwrap();
    assert_eq!(Scene::load(&path).unwrap(), Scene::builtin("floor").unwrap());
}

#[test]
fn a_texture_is_written_as_png_and_an_unknown_scene_is_bad_use() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pane.png");
    let output = texunit(folder.path(), &["scenes", "--texture", "ellipsoid-pane", "-o", "pane.png"]);
    assert_eq!(good(&output), "");
    let written = image::open(&path).unwrap().into_rgba8();
    assert_eq!(written, *Scene::builtin("ellipsoid-pane").unwrap().texture.image());
    refused(&texunit(folder.path(), &["scenes", "--show", "nope"]), &["floor"]);
}
