//! Pareto fronts, reuse and scenes in motion, from the command line.

use std::{fs, path::Path, process::Command};

use serde_json::Value;
use texunit::{
    experiment::{ImageQuality, Stage},
    scene::{Scene, Shape},
};

fn texunit(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_texunit")).args(arguments).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

fn metric(candidate: &Value, name: &str) -> f64 {
    candidate["metrics"][name]["value"].as_f64().unwrap_or_else(|| panic!("{name} of {candidate}"))
}

#[test]
fn the_front_holds_every_candidate_that_none_beats_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let arguments =
        ["pareto", "floor", "--size", "48x36", "-f", "point,bilinear,nearest-mip,trilinear,texram", "-o", "out"];
    texunit(folder.path(), &arguments);
    let pareto = json(&folder.path().join("out/pareto.json"));
    let candidates = pareto["scenes"][0]["candidates"].as_array().unwrap();
    assert!(candidates.len() > 20, "{} candidates", candidates.len());
    for one in candidates {
        let beaten = candidates.iter().any(|other| {
            let [costs, errors] = ["cycles_per_pixel", "rmse"].map(|name| (metric(other, name), metric(one, name)));
            costs.0 <= costs.1 && errors.0 <= errors.1 && (costs.0 < costs.1 || errors.0 < errors.1)
        });
        assert_eq!(one["front"], !beaten, "{one:#}");
    }
    let csv = fs::read_to_string(folder.path().join("out/pareto.csv")).unwrap();
    let metrics = candidates[0]["metrics"].as_object().unwrap().len();
    assert_eq!(csv.lines().count(), 1 + candidates.len() * metrics);
    assert!(fs::read_to_string(folder.path().join("out/floor.svg")).unwrap().contains("</svg>"));
}

#[test]
fn a_key_crossed_with_all_multiplies_the_candidates_and_an_unknown_metric_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let base = ["pareto", "floor", "--size", "24x18", "-f", "trilinear", "--plain", "-o", "out"];
    texunit(folder.path(), &[base.as_slice(), &["--vary", "cache.sets=1,4,16", "--vary", "cache.ways=1,2"]].concat());
    let pareto = json(&folder.path().join("out/pareto.json"));
    assert_eq!(pareto["scenes"][0]["candidates"].as_array().unwrap().len(), 6);
    let refused = Command::new(env!("CARGO_BIN_EXE_texunit")).args(base).args(["--error", "beauty"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("rmse"));
}

#[test]
fn reuse_adds_up_over_planes_and_agrees_with_a_fully_associative_run() {
    let folder = tempfile::tempdir().unwrap();
    texunit(folder.path(), &["reuse", "floor", "--size", "64x48", "-f", "trilinear,ripmap", "-o", "out"]);
    let reuse = json(&folder.path().join("out/reuse.json"));
    let sweep = "name = \"s\"\nscenes = [\"floor\"]\nsizes = [[64, 48]]\nfilters = [\"trilinear\"]\n\
                 set.cache.sets = [1]\nset.cache.ways = [1, 2, 3, 4, 6, 8, 12, 16]\n";
    fs::write(folder.path().join("s.toml"), sweep).unwrap();
    texunit(folder.path(), &["sweep", "run", "s.toml", "-o", "sweep"]);
    let point = json(&folder.path().join("sweep/point-000000.json"));
    let trilinear = &reuse["scenes"][0]["filters"][0];
    for cell in point["cells"].as_array().unwrap() {
        let corner = trilinear["curve"].as_array().unwrap().iter().find(|corner| corner[0] == cell["ways"]).unwrap();
        assert_eq!(corner[1].as_f64(), Some(metric(cell, "misses")), "{} ways", cell["ways"]);
    }
    for filter in reuse["scenes"][0]["filters"].as_array().unwrap() {
        let sum = |key: &str| {
            filter["planes"].as_array().unwrap().iter().map(|plane| plane[key].as_u64().unwrap()).sum::<u64>()
        };
        assert_eq!(sum("lookups"), filter["lookups"].as_u64().unwrap());
        assert_eq!(sum("lines"), filter["lines"].as_u64().unwrap());
        let largest = filter["curve"].as_array().unwrap().last().unwrap();
        assert_eq!(largest[1], filter["lines"], "at the end of the curve only first references miss");
        let tiles = filter["tiles"].as_array().unwrap();
        assert_eq!(tiles[3]["tiles"].as_u64(), Some(1));
        assert_eq!(tiles[3]["most"], filter["lines"], "one tile is the whole image");
    }
    assert!(trilinear["across_levels"].as_u64().unwrap() > 0, "the floor reads lines as either level");
}

#[test]
fn frames_of_a_path_that_stands_still_share_every_line_and_do_not_flicker() {
    let folder = tempfile::tempdir().unwrap();
    let still = texunit(folder.path(), &["scenes", "--show", "walk"])
        .replace("translation = [0.0, -1.2, -5.6]", "translation = [0.0, -1.2, -6.0]")
        .replace("-80.0, 0.0, 27.0", "-80.0, 0.0, 25.0")
        .replace("name = \"walk\"", "name = \"still\"")
        .replace("frames = 16", "frames = 3");
    fs::write(folder.path().join("still.toml"), still).unwrap();
    let size = ["--size", "32x24", "-f", "trilinear"];
    texunit(folder.path(), &[["reuse", "still.toml"].as_slice(), &size, &["-o", "r"]].concat());
    let reuse = json(&folder.path().join("r/reuse.json"));
    let frames = reuse["scenes"][0]["filters"][0]["frames"].as_array().unwrap().clone();
    assert_eq!(frames.len(), 3);
    assert_eq!(
        [0, 1, 2].map(|number| frames[number]["lines"] == frames[number]["lines_of_previous"]),
        [false, true, true]
    );
    texunit(folder.path(), &[["frames", "still.toml", "walk"].as_slice(), &size, &["-o", "f"]].concat());
    let frames = json(&folder.path().join("f/frames.json"));
    let [still, walk] = [0, 1].map(|scene| &frames["scenes"][scene]["filters"][0]);
    assert_eq!(metric(still, "flicker_rmse"), 0.0);
    assert!(metric(still, "rmse") > 0.0);
    assert!(metric(walk, "flicker_rmse") > 0.0);
    assert!(metric(walk, "bytes_per_pixel_warm") < metric(walk, "bytes_per_pixel_cold"));
}

#[test]
fn a_path_begins_and_ends_where_it_says() {
    let walk = Scene::builtin("walk").unwrap();
    let pose = |scene: &Scene| match scene.shape {
        Shape::Rectangle(rectangle) => rectangle.pose,
        Shape::Ellipsoid(ellipsoid) => ellipsoid.pose,
    };
    assert_eq!(walk.frame_count(), 16);
    assert_eq!(pose(&walk.frame(0)), pose(&walk));
    assert_eq!(pose(&walk.frame(15)), walk.path.unwrap().end);
    let halfway =
        pose(&Scene { path: walk.path.map(|path| texunit::scene::Path { frames: 3, ..path }), ..walk }.frame(1));
    assert!((halfway.translation[2] + 5.8).abs() < 1e-12, "{halfway:?}");
}

#[test]
fn the_truth_itself_is_perfectly_similar_and_its_mean_is_all_blur() {
    let mut scene = Scene::builtin("rectangle-checkerboard").unwrap();
    scene.size = [64, 48];
    let stage = Stage::new(scene);
    let answers = |texel: &dyn Fn([f32; 4]) -> [u8; 4]| {
        let mut picture = stage.empty_picture();
        for fragment in stage.scene.fragments() {
            let truth = stage.truth.at(fragment.x, fragment.y);
            picture.put_pixel(fragment.x.into(), fragment.y.into(), image::Rgba(texel(truth)));
        }
        picture
    };
    let exact = ImageQuality::of(&stage, &answers(&|truth| truth.map(|channel| (channel + 0.5) as u8)));
    // Rounding to 8 bits adds a variance of 1/12, beside the formula's constant (0.03 * 255)^2 = 58.5.
    assert!(exact.ssim.unwrap() > 1.0 - 1.0 / 12.0 / 58.5, "{exact:?}");
    assert!(exact.alias_energy < 1.0 && exact.blur_energy < 1.0, "{exact:?}");
    let grey = ImageQuality::of(&stage, &answers(&|_| [128; 4]));
    assert_eq!(grey.alias_energy, 0.0);
    // How much there is to blur is the scene's: far more than rounding takes away, and less alike by far.
    assert!(grey.blur_energy > 10.0 * exact.blur_energy, "{grey:?} {exact:?}");
    assert!(1.0 - grey.ssim.unwrap() > 10.0 * (1.0 - exact.ssim.unwrap()), "{grey:?} {exact:?}");
    let harsh = ImageQuality::of(&stage, &answers(&|truth| [if truth[0] > 127.0 { 255 } else { 0 }; 4]));
    assert!(harsh.alias_energy > harsh.blur_energy, "{harsh:?}");
}
