//! `texunit run`.

use std::{
    fs,
    process::{Output, Stdio},
};

use texunit::names::Named;
use texunit_hw::Filter;

use crate::{command, good, refused, texunit};

const SMALL: [&str; 4] = ["run", "rectangle-pane", "--size", "160x120"];

#[test]
fn it_writes_reports_and_images_and_finds_no_mismatch() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let table = good(&command(at, &SMALL).args(["-o", "out"]).output().unwrap());
    let report: serde_json::Value = serde_json::from_slice(&fs::read(at.join("out/report.json")).unwrap()).unwrap();
    assert_eq!(report["schema"], 1);
    assert_eq!(report["texunit"], env!("CARGO_PKG_VERSION"));
    assert_eq!(report["machine"]["cache"]["ways"], 4);
    assert!(report["command"].as_array().unwrap().iter().any(|word| word == "160x120"));
    let scene = &report["scenes"][0];
    assert_eq!(scene["scene"]["name"], "rectangle-pane");
    assert_eq!(scene["scene"]["size"], serde_json::json!([160, 120]));
    let covered = scene["coverage"]["covered"].as_u64().unwrap();
    assert!(covered > 1000);
    let csv = fs::read_to_string(at.join("out/report.csv")).unwrap();
    assert_eq!(csv.lines().next(), Some("design,scene,filter,metric,value,unit"));
    let filters = scene["filters"].as_array().unwrap();
    let names: Vec<&str> = filters.iter().map(|filter| filter["filter"].as_str().unwrap()).collect();
    let (floats_only, of_the_unit) = names.split_last().unwrap();
    assert_eq!(of_the_unit, Filter::ALL.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    assert_eq!(*floats_only, "ewa");
    for filter in &filters[..filters.len() - 1] {
        let name = filter["filter"].as_str().unwrap();
        let metric = |metric: &str| filter["metrics"][metric]["value"].as_f64().unwrap();
        assert_eq!(metric("pixels"), covered as f64);
        assert_eq!(metric("mismatches"), 0.0, "{name}");
        assert_eq!(metric("hits") + metric("misses"), metric("lookups"));
        let classes = ["compulsory_misses", "capacity_misses", "conflict_misses"].map(metric);
        assert_eq!(classes.iter().sum::<f64>(), metric("misses"));
        assert_eq!(metric("bytes_fetched"), 64.0 * metric("misses"));
        let planes = filter["planes"].as_array().unwrap();
        let of_planes: u64 = planes.iter().map(|plane| plane["misses"].as_u64().unwrap()).sum();
        assert_eq!(of_planes as f64, metric("misses"));
        for key in ["rmse", "psnr", "worst", "host_ns_per_pixel", "pyramid_multiple", "bytes_per_pixel_cached"] {
            assert!(metric(key) > 0.0, "{key} of {name}");
        }
        for image in [format!("{name}.png"), format!("{name}-difference.png")] {
            let image = image::open(at.join("out/rectangle-pane").join(image)).unwrap();
            assert_eq!((image.width(), image.height()), (160, 120));
        }
        assert!(csv.contains(&format!("herf-12.20,rectangle-pane,{name},misses,{},read\n", metric("misses"))));
        assert!(table.lines().any(|line| line.contains(&format!(" {name} "))), "{name} in {table}");
    }
    assert!(at.join("out/rectangle-pane/truth.png").exists());
}

#[test]
fn a_second_run_into_a_folder_replaces_everything_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    good(&command(at, &SMALL).args(["-f", "point", "-o", "out"]).output().unwrap());
    good(&texunit(at, &["run", "rectangle-pane", "--size", "80x60", "-f", "point", "-o", "out"]));
    for name in ["truth", "point", "point-difference"] {
        let image = image::open(at.join(format!("out/rectangle-pane/{name}.png"))).unwrap();
        assert_eq!((image.width(), image.height()), (80, 60), "{name}");
    }
}

#[test]
fn two_runs_into_one_folder_at_once_do_not_mix() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("out")).unwrap();
    let lock = fs::File::create(at.join("out/.texunit-lock")).unwrap();
    lock.lock().unwrap();
    let second = command(at, &SMALL).args(["-f", "point", "-o", "out"]).output().unwrap();
    refused(&second, &["--output = out", "another texunit run", "another folder"]);
    drop(lock);
    good(&command(at, &SMALL).args(["-f", "point", "-o", "out"]).output().unwrap());
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_the_filters_that_were_finished() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let run = ["run", "floor", "walk", "-o", "out"];
    let child = command(at, &run).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let begin = std::time::Instant::now();
    while !at.join("out/floor/truth.png").exists() {
        assert!(begin.elapsed().as_secs() < 120, "the first scene never begins");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let kill = format!("kill -INT {}", child.id());
    assert!(std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("interrupted; what was finished is in out"), "{message}");
    let report: serde_json::Value = serde_json::from_slice(&fs::read(at.join("out/report.json")).unwrap()).unwrap();
    assert_eq!(report["scenes"].as_array().unwrap().len(), 1);
    let finished = report["scenes"][0]["filters"].as_array().unwrap();
    assert!(finished.len() < Filter::ALL.len() + 1, "all were finished");
    for filter in finished {
        let name = filter["filter"].as_str().unwrap();
        assert!(image::open(at.join(format!("out/floor/{name}.png"))).is_ok(), "{name}");
    }
}

#[test]
fn json_on_standard_output_is_the_report_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let printed = good(&command(at, &SMALL).args(["-f", "point,dipmap", "--json", "-o", "out"]).output().unwrap());
    assert_eq!(printed, fs::read_to_string(at.join("out/report.json")).unwrap());
}

#[test]
fn a_scene_that_passes_behind_the_eye_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = "name = \"behind\"\ndescription = \"passes under the camera\"\nwidth = 64\nheight = 48\n\
                 [rectangle]\nsize = [40.0, 40.0]\nrotation = { euler = [-80.0, 0.0, 0.0] }\n\
                 translation = [0.0, -1.0, -2.0]\n[texture]\npattern = \"pane\"\nsize = [64, 64]\n";
    fs::write(at.join("behind.toml"), scene).unwrap();
    let table = good(&texunit(at, &["run", "behind.toml", "-f", "trilinear", "-o", "out"]));
    let report: serde_json::Value = serde_json::from_slice(&fs::read(at.join("out/report.json")).unwrap()).unwrap();
    let behind = report["scenes"][0]["coverage"]["behind"].as_u64().unwrap();
    assert!(behind > 0);
    assert!(table.contains(&format!("{behind} behind the eye and left out")), "{table}");
}

#[test]
fn what_cannot_be_run_is_refused_with_its_place_and_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    refused(&texunit(at, &["run", "nowhere"]), &["nowhere", "rectangle-pane"]);
    refused(&texunit(at, &["run", "no.toml"]), &["no.toml", "No such file", "check the path"]);
    refused(&texunit(at, &["run", "-f", "cubic"]), &["cubic", "trilinear", "dipmap"]);
    refused(&texunit(at, &["run", "--size", "0x10"]), &["0x10", "1 to 16384"]);
    refused(&texunit(at, &["run", "floor", "floor"]), &["floor", "two scenes have this name"]);
    refused(&texunit(at, &["run", "--machine", "nothing"]), &["nothing", "herf-12.20"]);
    fs::write(at.join("file"), "").unwrap();
    refused(&command(at, &SMALL).args(["-o", "file"]).output().unwrap(), &["file", "folder"]);
    refused(&command(at, &SMALL).args(["-o", "file/out"]).output().unwrap(), &["file/out", "folder"]);
}

#[test]
fn a_scene_file_with_a_mistake_is_shown_with_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let floor = good(&texunit(at, &["scenes", "--show", "floor"]));
    let with = |from: &str, to: &str| {
        assert!(floor.contains(from), "{from}");
        let text = floor.replacen(from, to, 1);
        fs::write(at.join("mine.toml"), &text).unwrap();
        let line = 1 + text.lines().zip(floor.lines()).take_while(|(mine, shown)| mine == shown).count();
        (texunit(at, &["run", "mine.toml"]), format!("mine.toml:{line}"))
    };
    let check = |(output, place): (Output, String), parts: &[&str]| {
        refused(&output, &[[place.as_str()].as_slice(), parts].concat());
    };
    check(with("width = 640", "widht = 640"), &["widht", "unknown field", "texunit scenes --show"]);
    check(with("width = 640", "width = 0"), &["`width` is 0", "1 to 16384"]);
    check(with("size = [1024, 1024]", "size = [1024, 0]"), &["`size` is 0", "1 to 8192"]);
    check(with("\"wrap\", \"wrap\"", "\"wrap\", \"warp\""), &["warp", "mirror"]);
    check(with("pattern = \"checkerboard\"", "pattern = \"chess\""), &["chess", "natural"]);
    check(with("name = \"floor\"", "name = \"floor"), &["mine.toml"]);
    let texture = floor.find("[texture]").unwrap();
    let with_file = |file: &str| {
        fs::write(at.join("mine.toml"), format!("{}[texture]\nfile = \"{file}\"\n", &floor[..texture])).unwrap();
        texunit(at, &["run", "mine.toml"])
    };
    refused(&with_file("lost.png"), &["mine.toml", "lost.png", "No such file", "relative to the scene file"]);
    fs::write(at.join("bad.png"), "no image").unwrap();
    refused(&with_file("bad.png"), &["mine.toml", "bad.png", "image"]);
    fs::write(at.join("mine.toml"), floor.replacen("name = \"floor\"", "name = \"../floor\"", 1)).unwrap();
    refused(&texunit(at, &["run", "mine.toml"]), &["../floor", "without slashes"]);
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = command(folder.path(), &SMALL)
        .args(["-f", "point", "-o", "out"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}
