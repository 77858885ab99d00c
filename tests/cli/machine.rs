//! Machines: `texunit explain`, `--machine` and `--set`.

use std::{fs, path::Path};

use texunit::machine::Machine;

use crate::{good, refused, texunit};

#[test]
fn an_explained_machine_is_a_machine_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let explained = good(&texunit(at, &["explain", "--set", "cache.ways=24", "--set", "lod.bias=-0.5"]));
    let machine = Machine::parse(Path::new("x"), &explained).unwrap();
    assert_eq!((machine.cache.ways, machine.lod.bias), (24, -0.5));
    fs::write(at.join("mine.toml"), &explained).unwrap();
    assert_eq!(good(&texunit(at, &["explain", "mine.toml"])), explained);
}

#[test]
fn explain_says_what_follows() {
    let folder = tempfile::tempdir().unwrap();
    let explained = good(&texunit(folder.path(), &["explain"]));
    for part in ["256 lines, 16384 bytes", "4 x 4 texels", "herf-12.20", "ways = 4"] {
        assert!(explained.contains(part), "no `{part}` in {explained}");
    }
    // Twenty bits less the sixteen of a texel index.
    let row = explained.lines().find(|line| line.contains(" 65536 ")).unwrap();
    assert_eq!(row.split_whitespace().skip(1).collect::<Vec<_>>(), ["65536", "4", "4"]);
    let rows = good(&texunit(folder.path(), &["explain", "--set", "texture.layout=row-major"]));
    assert!(rows.contains("16 x 1 texels"), "{rows}");
    assert!(good(&texunit(folder.path(), &["explain", "--list"])).lines().any(|name| name == "herf-12.20"));
}

#[test]
fn a_setting_that_cannot_be_is_refused_with_key_value_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let set = |setting: &str, parts: &[&str]| {
        for command in [["run", "floor"].as_slice(), &["explain"], &["verify"]] {
            refused(&texunit(folder.path(), &[command, &["--set", setting]].concat()), parts);
        }
    };
    set("filter.bits=13", &["filter.bits = 13", "1 to 12"]);
    set("filter.bits=0", &["filter.bits = 0", "1 to 12"]);
    set("filter.bits=300", &["filter.bits=300", "300"]);
    set("filter.bits=many", &["filter.bits=many", "many"]);
    set("lod.bits=9", &["lod.bits = 9", "0 to 8"]);
    set("lod.bias=99", &["lod.bias = 99", "-16 to 16"]);
    set("lod.bias=nan", &["lod.bias = NaN", "-16 to 16"]);
    set("lod.min=-1", &["lod.min = -1", "0 to 32"]);
    set("filter.max-anisotropy=65", &["filter.max-anisotropy = 65", "1 to 64"]);
    set("filter.brilinear-threshold=128", &["filter.brilinear-threshold = 128", "0 to 127"]);
    set("cache.ways=0", &["cache.ways = 0", "at least one way"]);
    set("cache.sets=0", &["cache.sets = 0", "at least one set"]);
    set("cache.line=48", &["cache.line = 48", "power of two"]);
    set("cache.policy=mru", &["cache.policy = mru", "plru"]);
    set("cache.wayz=4", &["cache.wayz=4", "wayz", "ways"]);
    set("cash.ways=4", &["cash.ways=4", "cache"]);
    set("cache.ways", &["cache.ways", "section.key=value"]);
    set("cache.ways.more=1", &["ways", "not a section"]);
    set("texture.layout=spiral", &["spiral", "morton"]);
    set("texture.pyramid.width=3", &["3"]);
}

#[test]
fn a_key_without_a_default_value_can_be_set() {
    let settings = ["texture.pyramid.kernel=lanczos".to_owned(), "texture.pyramid.width=8".to_owned()];
    assert_eq!(Machine::load("herf-12.20", &settings).unwrap().texture.pyramid.width, Some(8));
}

#[test]
fn a_machine_file_with_a_mistake_is_shown_with_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let file = |text: &str, parts: &[&str]| {
        fs::write(at.join("mine.toml"), text).unwrap();
        refused(&texunit(at, &["run", "floor", "--machine", "mine.toml"]), parts);
    };
    file("name = \"mine\"\n[cache]\nwayz = 4\n", &["mine.toml:3", "wayz", "ways", "texunit explain"]);
    file("name = \"mine\"\n[filter]\nbits = 13\n", &["mine.toml:3", "`filter.bits` is 13", "1 to 12"]);
    file("[lod]\nbits = 8\nbias = -20\n", &["mine.toml:3", "lod.bias", "-20", "-16 to 16"]);
    file("cache = { sets = 1, ways = 0 }\n", &["mine.toml:1", "cache.ways", "at least one way"]);
    file("[cache]\npolicy = \"mru\"\n", &["mine.toml:2", "mru", "plru"]);
    file("[lod]\nlog2 = \"approximate\"\n", &["mine.toml:2", "approximate", "herf"]);
    file("[cache]\nways = \"four\"\n", &["mine.toml:2", "four"]);
    file("[cache\n", &["mine.toml:1"]);
}
