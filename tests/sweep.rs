//! Sweeps from the command line: what they say is what single runs say; they stop and go on; they tell what is missing.

use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    process::{Command, Output},
};

use texunit::{machine::Machine, names::Named, scene::Scene, sweep::traffic};
use texunit_hw::{Filter, Geometry};

const SWEEP: &str = r#"
name = "small"
scenes = ["floor", "magnified"]
sizes = [[40, 30]]
filters = ["bilinear", "trilinear"]

[set]
cache.policy = ["lru", "fifo", "plru"]
cache.sets = [1, 3, 4, 16]
cache.ways = [1, 2, 5, 24]
"#;

fn texunit(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_texunit")).args(arguments).current_dir(folder).output().unwrap()
}

fn good(folder: &Path, arguments: &[&str]) -> String {
    let output = texunit(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = texunit(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

fn folder_with(sweep: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), sweep).unwrap();
    folder
}

/// Misses by everything they depend on.
fn misses(csv: &str) -> BTreeMap<String, f64> {
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|known| known == name).unwrap();
    let key = ["scene", "filter", "cache.policy", "cache.sets", "cache.ways"].map(column);
    let (metric, value) = (column("metric"), column("value"));
    reader
        .records()
        .map(Result::unwrap)
        .filter(|row| &row[metric] == "misses")
        .map(|row| (key.map(|column| row[column].to_owned()).join(" "), row[value].parse().unwrap()))
        .collect()
}

#[test]
fn every_cache_of_a_sweep_counts_what_a_run_of_it_alone_counts() {
    let folder = folder_with(SWEEP);
    good(folder.path(), &["sweep", "run", "s.toml", "-o", "out"]);
    let found = misses(&fs::read_to_string(folder.path().join("out/sweep.csv")).unwrap());
    let mut expected = BTreeMap::new();
    for scene in ["floor", "magnified"] {
        let mut small = Scene::builtin(scene).unwrap();
        small.size = [40, 30];
        for filter in [Filter::Bilinear, Filter::Trilinear] {
            for policy in ["lru", "fifo", "plru"] {
                for sets in [1, 3, 4, 16] {
                    for ways in [1, 2, 5, 24] {
                        let machine = Machine::load("herf-12.20", &[format!("cache.policy={policy}")]).unwrap();
                        let geometry = Geometry { sets, ways, line: 64 };
                        let measured = traffic(&small, &machine, filter, &[geometry]).unwrap();
                        let metric = measured.cells[0].metrics.iter().find(|metric| metric.name == "misses");
                        let key = format!("{scene} {} {policy} {sets} {ways}", filter.name());
                        expected.insert(key, metric.unwrap().value.unwrap());
                    }
                }
            }
        }
    }
    assert_eq!(found, expected);
}

#[test]
fn a_sweep_of_everything_agrees_with_a_sweep_of_the_traffic() {
    let small = "name = \"s\"\nscenes = [\"magnified\"]\nsizes = [[24, 16]]\nfilters = [\"trilinear\"]\n";
    let set = "[set]\ncache.policy = [\"lru\"]\ncache.sets = [2, 8]\ncache.ways = [1, 3]\n";
    let of = |measure: &str| {
        let folder = folder_with(&format!("{small}measure = \"{measure}\"\n{set}"));
        good(folder.path(), &["sweep", "run", "s.toml", "-o", "out"]);
        fs::read_to_string(folder.path().join("out/sweep.csv")).unwrap()
    };
    let [traffic, error, all] = ["traffic", "error", "all"].map(of);
    assert_eq!(misses(&traffic), misses(&all));
    assert_eq!(misses(&traffic), misses(&error));
    let rmse = |csv: &str| -> Vec<String> {
        let row = csv.lines().find(|line| line.contains(",rmse,")).unwrap();
        row.rsplit(',').take(3).map(str::to_owned).collect()
    };
    assert_eq!(rmse(&error), rmse(&all));
}

#[test]
fn points_computed_one_by_one_merge_into_the_same_table() {
    let folder = folder_with(SWEEP);
    good(folder.path(), &["sweep", "run", "s.toml", "-o", "at-once"]);
    let points = good(folder.path(), &["sweep", "plan", "s.toml"]).lines().count() - 1;
    assert_eq!(points, 12);
    good(folder.path(), &["sweep", "point", "s.toml", "3-99", "-o", "apart"]);
    let complaint = refused(folder.path(), &["sweep", "merge", "s.toml", "-o", "apart"]);
    assert!(complaint.contains("3 of 12 points") && complaint.contains("0, 1, 2"), "{complaint}");
    assert!(!folder.path().join("apart/sweep.csv").exists());
    for point in ["2", "0", "1"] {
        good(folder.path(), &["sweep", "point", "s.toml", point, "-o", "apart", "-j", "1"]);
    }
    good(folder.path(), &["sweep", "merge", "s.toml", "-o", "apart"]);
    let table = |name: &str| fs::read(folder.path().join(name).join("sweep.csv")).unwrap();
    assert_eq!(table("at-once"), table("apart"));
}

#[test]
fn a_sweep_goes_on_with_what_is_missing_or_was_of_another_configuration() {
    let folder = folder_with(SWEEP);
    let path = |number: usize| folder.path().join(format!("out/point-{number:06}.json"));
    good(folder.path(), &["sweep", "run", "s.toml", "-o", "out"]);
    let first = fs::read(folder.path().join("out/sweep.csv")).unwrap();
    fs::remove_file(path(5)).unwrap();
    fs::write(path(6), "{\"schema\": 1, \"cut").unwrap();
    let other = fs::read_to_string(path(7)).unwrap().replace("\"ilog2\"", "\"exact\"").replace("\"exact\"", "\"herf\"");
    fs::write(path(7), other).unwrap();
    let output = texunit(folder.path(), &["sweep", "run", "s.toml", "-o", "out"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("9 of 12 points are there already"));
    assert_eq!(first, fs::read(folder.path().join("out/sweep.csv")).unwrap());
}

#[test]
fn bad_sweeps_are_refused_with_the_place() {
    let start = "name = \"x\"\nscenes = [\"floor\"]\nfilters = [\"point\"]\n";
    let (many, sizes) = ("1, ".repeat(300), "[4, 4], ".repeat(70_000));
    for (sweep, expected) in [
        ("name = \"x\"\nscenes = []\nfilters = [\"point\"]", "a list is empty"),
        ("name = \"x\"\nscenes = [\"floor\"]\nfilters = [\"pint\"]", "no filter is named `pint`"),
        ("name = \"x\"\nscenes = [\"flor\"]\nfilters = [\"point\"]", "flor"),
        ("name = \"x\"\nscenes = [\"floor\"]\nfilters = [\"point\"]\nset.cache.ways = [0]", "set.cache.ways"),
        ("name = \"x\"\nscenes = [\"floor\"]\nfilters = [\"point\"]\nset.cache.line = [48]", "48"),
        ("name = \"x\"\nscenes = [\"floor\"]\nfilters = [\"point\"]\nset.lod.blas = [1]", "blas"),
        ("name = \"x\"\nscenes = [\"floor\"]\nfilters = [\"point\"]\nset.lod.bits = []", "set.lod.bits"),
        ("name = \"x\"\nscenes = [\"floor\"]\nfilters = [\"point\"]\nsizes = [[0, 4]]", "[0, 4]"),
        ("name = \"x\"\nscene = [\"floor\"]", "scene"),
        (&format!("{start}set.cache.sets = [{many}]\nset.cache.ways = [{many}]"), "set.cache: more than 65536"),
        (&format!("{start}set.lod.bits = [{many}]\nset.filter.bits = [{many}]"), "set: more than 65536"),
        (&format!("{start}sizes = [{sizes}]"), "scenes, sizes: more than 65536"),
    ] {
        let folder = folder_with(sweep);
        let complaint = refused(folder.path(), &["sweep", "plan", "s.toml"]);
        assert!(complaint.contains(expected), "{expected}: {complaint}");
    }
    let folder = folder_with(SWEEP);
    assert!(refused(folder.path(), &["sweep", "point", "s.toml", "12"]).contains("12 points"));
}

#[test]
fn the_sweeps_that_ship_expand() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("sweeps");
    let files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(files.len() >= 4);
    for file in files {
        let points = good(&folder, &["sweep", "plan", file.to_str().unwrap()]).lines().count();
        assert!(points > 1, "{}", file.display());
    }
}
