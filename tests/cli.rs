//! The commands run, sample, verify and explain as a user meets them: files, columns, exit status, and what is said when
//! something is wrong.

use std::{
    fs,
    io::Write,
    path::Path,
    process::{Command, Output, Stdio},
};

use texunit::{machine::Machine, names::Named};
use texunit_hw::Filter;

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_texunit"));
    command.current_dir(folder).args(arguments);
    command
}

fn texunit(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

#[track_caller]
fn good(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Bad use: exit status 2, nothing on standard output, and a message with all that helps.
#[track_caller]
fn refused(output: &Output, parts: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "", "{message}");
    for part in parts {
        assert!(message.contains(part), "no `{part}` in: {message}");
    }
}

mod run {
    use super::*;

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
}

mod machine {
    use super::*;

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
}

mod sample {
    use super::*;

    /// A folder with a texture of 4 x 2 texels.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        image::RgbaImage::from_fn(4, 2, |x, y| image::Rgba([x as u8 * 40, y as u8 * 100, 200, 255 - x as u8]))
            .save(folder.path().join("t.png"))
            .unwrap();
        folder
    }

    /// What a filter and more options answer to rows on standard input.
    fn asked(folder: &Path, filter: &str, more: &[&str], input: &str) -> Output {
        let fixed = ["sample", "--texture", "t.png", "--filter", filter, "--input", "-", "--output", "-"];
        let mut command = command(folder, &fixed);
        command.args(more).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        // A command that refuses its options does not read.
        let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
        child.wait_with_output().unwrap()
    }

    #[test]
    fn all_three_models_answer_the_texel_at_its_centre() {
        let folder = folder();
        let input = "u,v,lod\n0.125,0.25,0\n0.875,0.75,0\n-0.125,1.25,0\n";
        for model in ["hw", "reference", "ideal"] {
            for filter in ["point", "bilinear", "nearest-mip", "trilinear"] {
                let answer = good(&asked(folder.path(), filter, &["--model", model], input));
                let expected = "r,g,b,a,lod\n0,0,200,255,0\n120,100,200,252,0\n120,0,200,252,0\n";
                assert_eq!(answer, expected, "{model} {filter}");
            }
        }
    }

    #[test]
    fn chip_and_reference_answer_alike_and_ideal_close_to_them_for_every_filter_and_wrap() {
        let folder = folder();
        let mut input = "u,v,dudx,dvdx,dudy,dvdy\n".to_owned();
        for i in 0..40 {
            let x = f64::from(i);
            input += &format!("{},{},{},{},{},{}\n", x * 0.17 - 3.0, 2.0 - x * 0.11, x * 0.01, 0.01, -0.02, x * 0.02);
        }
        for (filter, kind) in Filter::ALL {
            for wrap in ["wrap", "clamp", "clip", "mirror"] {
                let of = |model: &str| good(&asked(folder.path(), filter, &["--wrap", wrap, "--model", model], &input));
                let hw = of("hw");
                assert_eq!(hw, of("reference"), "{filter} {wrap}");
                let columns = if kind.level_per_axis() { "r,g,b,a,lod,lod_v" } else { "r,g,b,a,lod" };
                assert_eq!(hw.lines().next(), Some(columns));
                assert_eq!(hw.lines().count(), 41);
                assert_eq!(of("ideal").lines().count(), 41);
            }
        }
    }

    #[test]
    fn the_ideal_is_not_rounded() {
        let folder = folder();
        let answer = good(&asked(folder.path(), "bilinear", &["--model", "ideal"], "u,v,lod\n0.1875,0.25,0\n"));
        assert_eq!(answer, "r,g,b,a,lod\n10,0,200,254.75,0\n");
    }

    #[test]
    fn columns_may_stand_in_any_order() {
        let folder = folder();
        let level = good(&asked(folder.path(), "trilinear", &[], "u,v,lod\n0.3,0.6,1.5\n"));
        assert_eq!(good(&asked(folder.path(), "trilinear", &[], "lod, v, u\n1.5,0.6,0.3\n")), level);
        let gradient = good(&asked(folder.path(), "dipmap", &[], "u,v,dudx,dvdx,dudy,dvdy\n0.3,0.6,0.5,0,0,1\n"));
        let turned = good(&asked(folder.path(), "dipmap", &[], "dvdy,dudy,dvdx,dudx,v,u\n1,0,0,0.5,0.6,0.3\n"));
        assert_eq!(gradient, turned);
        // Half the texture a pixel along u is two texels, a whole one along v two as well: level 1 on both axes.
        assert!(gradient.lines().nth(1).unwrap().ends_with(",1,1"), "{gradient}");
    }

    #[test]
    fn what_a_spreadsheet_writes_is_read() {
        let folder = folder();
        let plain = good(&asked(folder.path(), "bilinear", &[], "u,v,lod\n0.3,0.6,0\n0.9,0.1,0\n"));
        let spreadsheet = "\u{FEFF}\"u\",\"v\",\"lod\"\r\n\"0.3\", 0.6,0\r\n\r\n0.9,1e-1,0";
        assert_eq!(good(&asked(folder.path(), "bilinear", &[], spreadsheet)), plain);
    }

    #[test]
    fn axes_can_have_address_modes_of_their_own() {
        let folder = folder();
        let input = "u,v,lod\n1.125,1.25,0\n";
        let both = good(&asked(folder.path(), "point", &["--wrap", "wrap"], input));
        assert!(both.ends_with("0,0,200,255,0\n"), "{both}");
        let split = good(&asked(folder.path(), "point", &["--wrap", "wrap", "--wrap-v", "clip"], input));
        assert!(split.ends_with("0,0,0,0,0\n"), "{split}");
    }

    #[test]
    fn coordinates_without_a_place_are_read_as_zero_and_said() {
        let folder = folder();
        let input = "u,v,lod\nNaN,0.25,0\ninf,-inf,0\n0,0.25,NaN\n0,0.25,-inf\n";
        let output = asked(folder.path(), "nearest-mip", &["--wrap", "wrap"], input);
        let answer = good(&output);
        assert_eq!(answer.lines().count(), 5);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(told.contains("3 coordinates were NaN or infinite"), "{told}");
        // A level that is no number is the coarsest, minus infinity the finest.
        let lods: Vec<&str> = answer.lines().skip(1).map(|line| line.rsplit(',').next().unwrap()).collect();
        assert_eq!(lods, ["0", "0", "2", "0"]);
        assert_eq!(answer, good(&asked(folder.path(), "nearest-mip", &["--model", "reference"], input)));
        let gradients = "u,v,dudx,dvdx,dudy,dvdy\n0,0,NaN,0,0,0\n0,0,inf,0,0,0\n0,0,0,0,0,0\n";
        let answer = good(&asked(folder.path(), "nearest-mip", &[], gradients));
        let lods: Vec<&str> = answer.lines().skip(1).map(|line| line.rsplit(',').next().unwrap()).collect();
        assert_eq!(lods, ["2", "2", "0"]);
    }

    #[test]
    fn no_rows_give_no_rows() {
        let folder = folder();
        for model in ["hw", "reference", "ideal"] {
            assert_eq!(good(&asked(folder.path(), "trilinear", &["--model", model], "u,v,lod\n")), "r,g,b,a,lod\n");
        }
        refused(&asked(folder.path(), "trilinear", &[], ""), &["standard input", "line 1", "u,v,lod"]);
    }

    #[test]
    fn more_rows_than_a_block_keep_their_order() {
        let folder = folder();
        let at = folder.path();
        let mut input = "u,v,lod\n".to_owned();
        for i in 0..40_000 {
            input += &format!("{},0.25,0\n", f64::from(i % 4) / 4.0 + 0.125);
        }
        fs::write(at.join("in.csv"), input).unwrap();
        let files = ["--texture", "t.png", "--filter", "point", "--input", "in.csv", "--output", "out.csv"];
        good(&command(at, &["sample"]).args(files).output().unwrap());
        let answer = fs::read_to_string(at.join("out.csv")).unwrap();
        for (number, line) in answer.lines().skip(1).enumerate() {
            assert_eq!(line.split(',').next().unwrap(), (number % 4 * 40).to_string());
        }
        assert_eq!(answer.lines().count(), 40_001);
    }

    #[test]
    fn a_malformed_row_is_refused_with_its_line_and_leaves_no_output() {
        let folder = folder();
        let at = folder.path();
        let row = |text: &str, parts: &[&str]| {
            fs::write(at.join("in.csv"), text).unwrap();
            let files = ["--texture", "t.png", "--filter", "point", "--input", "in.csv", "--output", "out.csv"];
            let output = command(at, &["sample"]).args(files).output().unwrap();
            refused(&output, &[["in.csv"].as_slice(), parts].concat());
            assert!(!at.join("out.csv").exists(), "{text}");
        };
        row("u,v,lod\n0,0,0\n0,half,0\n", &["line 3", "v = `half` is not a number"]);
        row("u,v,lod\n0,0,0\n\n0,0\n", &["line 4", "2 values where 3 columns"]);
        row("u,v,lod\n0,0,0,0\n", &["line 2", "4 values where 3 columns"]);
        row("u,v,lod\n0,,0\n", &["line 2", "v = ``"]);
        row("u,v\n0,0\n", &["line 1", "`u,v`", "u,v,lod or u,v,dudx,dvdx,dudy,dvdy"]);
        row("u,v,lod,u\n0,0,0,0\n", &["line 1", "u,v,lod,u"]);
        row("u,v,lod,dudx\n0,0,0,0\n", &["line 1", "u,v,lod,dudx"]);
        fs::write(at.join("out.csv"), "mine").unwrap();
        fs::write(at.join("in.csv"), b"u,v,lod\n0,0,0\n\xFF,0,0\n").unwrap();
        let files = ["--texture", "t.png", "--filter", "point", "--input", "in.csv", "--output", "out.csv"];
        refused(&command(at, &["sample"]).args(files).output().unwrap(), &["in.csv", "line 3", "UTF-8"]);
        assert_eq!(fs::read_to_string(at.join("out.csv")).unwrap(), "mine");
    }

    #[test]
    fn files_that_cannot_be_used_are_refused() {
        let folder = folder();
        let at = folder.path();
        fs::write(at.join("in.csv"), "u,v,lod\n0,0,0\n").unwrap();
        let files = |texture: &str, input: &str, output: &str| {
            let files = ["sample", "--texture", texture, "--filter", "point", "--input", input, "--output", output];
            texunit(at, &files)
        };
        refused(&files("lost.png", "in.csv", "o.csv"), &["lost.png", "No such file", "check the path"]);
        refused(&files("t.png", "lost.csv", "o.csv"), &["lost.csv", "No such file"]);
        refused(&files("t.png", "in.csv", "no/o.csv"), &["no/o.csv", "folder"]);
        refused(&files("in.csv", "in.csv", "o.csv"), &["in.csv", "cannot be read as an image", "PNG"]);
        // A PNG cut short, and one of width zero.
        let png = fs::read(at.join("t.png")).unwrap();
        fs::write(at.join("short.png"), &png[..png.len() / 2]).unwrap();
        refused(&files("short.png", "in.csv", "o.csv"), &["short.png", "cannot be read as an image"]);
        fs::write(at.join("zero.pgm"), "P5 0 4 255\n").unwrap();
        refused(&files("zero.pgm", "in.csv", "o.csv"), &["zero.pgm"]);
        refused(&files(".", "in.csv", "o.csv"), &[".", "folder"]);
        refused(&asked(at, "cubic", &[], ""), &["cubic", "nearest-mip"]);
        refused(&asked(at, "point", &["--wrap", "around"], ""), &["around", "mirror"]);
        refused(&asked(at, "point", &["--model", "gpu"], ""), &["gpu", "reference"]);
    }
}

mod verify {
    use super::*;

    #[test]
    fn chip_and_reference_agree_on_random_requests_of_every_filter() {
        let folder = tempfile::tempdir().unwrap();
        let json = good(&texunit(folder.path(), &["verify", "--no-scenes", "--random", "100", "--json"]));
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(json["mismatches"], 0);
        let filters = json["filters"].as_array().unwrap();
        assert_eq!(filters.len(), Filter::ALL.len());
        // Nine textures, four address modes, three roundings.
        assert!(filters.iter().all(|filter| filter["compared"] == 9 * 12 * 100), "{json}");
        let table = good(&texunit(folder.path(), &["verify", "--no-scenes", "--random", "10", "-f", "dipmap"]));
        assert!(table.contains("1080 samples compared") && table.contains("0 mismatches"), "{table}");
    }
}

#[test]
fn every_command_explains_itself() {
    let folder = tempfile::tempdir().unwrap();
    let list = good(&texunit(folder.path(), &["--help"]));
    let commands: Vec<&str> = list
        .split_once("Commands:\n")
        .unwrap()
        .1
        .lines()
        .map_while(|line| line.strip_prefix("  ")?.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect();
    for name in ["run", "sample", "mips", "trace", "cache", "verify", "scenes", "explain"] {
        assert!(commands.contains(&name), "{name} in {list}");
    }
    let mut pages: Vec<Vec<&str>> = commands.iter().map(|name| vec![*name]).collect();
    pages.extend(["record", "replay", "verify", "export"].map(|action| vec!["trace", action]));
    for page in pages {
        let line = list.lines().find(|line| line.trim_start().starts_with(page[0])).unwrap();
        assert!(line.split_whitespace().count() > 3, "no word about {line}");
        let help = good(&texunit(folder.path(), &[page.as_slice(), &["--help"]].concat()));
        assert!(help.contains("Usage: texunit"), "{help}");
        // Every argument and option says what it is.
        let lines: Vec<&str> = help.lines().collect();
        for (number, line) in lines.iter().enumerate() {
            let option = line.trim_start();
            if line.starts_with("  ")
                && (option.starts_with("--") || option.starts_with('-') && !option.starts_with("- "))
            {
                let said = option.split("  ").count() > 1
                    || lines.get(number + 1).is_some_and(|next| next.starts_with("     "));
                assert!(said, "{page:?}: `{option}` says nothing");
            }
        }
    }
}

#[test]
fn no_command_or_an_unknown_one_is_bad_use() {
    let folder = tempfile::tempdir().unwrap();
    refused(&texunit(folder.path(), &[]), &["Usage: texunit", "run"]);
    refused(&texunit(folder.path(), &["render"]), &["render"]);
    assert!(good(&texunit(folder.path(), &["--version"])).contains(env!("CARGO_PKG_VERSION")));
}
