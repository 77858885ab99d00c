//! `texunit sample`.

use std::{
    fs,
    io::Write,
    path::Path,
    process::{Output, Stdio},
};

use texunit::names::Named;
use texunit_hw::Filter;

use crate::{command, good, refused, texunit};

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
