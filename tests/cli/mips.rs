//! `texunit mips`, `kernels` and `drift` as a user meets them.

use std::fs;

use serde_json::Value;

use super::{refused, texunit};

/// A folder with a 6 x 3 texture in it, binary PNM: no compression, so a test can write it by hand.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let texels: Vec<u8> = (0..6 * 3 * 3).map(|index| (index * 37 % 256) as u8).collect();
    fs::write(folder.path().join("texture.ppm"), [b"P6\n6 3\n255\n".as_slice(), &texels].concat()).unwrap();
    folder
}

#[test]
fn mips_writes_planes_as_a_format_stores_them() {
    let folder = folder();
    for (format, bytes) in [("rgb565", 2 * 22), ("palette8", 22), ("bc1", 8 * (2 + 1 + 1)), ("bc7", 16 * (2 + 1 + 1))] {
        let output = texunit(folder.path(), &["mips", "texture.ppm", "--format", format, "--out", format]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let out = folder.path().join(format);
        let listing: Value = serde_json::from_slice(&fs::read(out.join("planes.json")).unwrap()).unwrap();
        assert_eq!((&listing["format"], &listing["bytes"]), (&format.into(), &bytes.into()));
        let written: usize = ["0_0", "1_1", "2_1"]
            .map(|plane| fs::read(out.join(format!("plane_{plane}.{format}"))).unwrap().len())
            .iter()
            .sum();
        assert_eq!(written, bytes);
        assert_eq!(out.join("palette.rgba").exists(), format == "palette8");
        assert_eq!(listing["palette"].is_string(), format == "palette8");
    }
    refused(
        &texunit(folder.path(), &["mips", "texture.ppm", "--format", "astc", "--out", "x"]),
        &["astc", "palette8", "bc7"],
    );
}

#[test]
fn mips_writes_every_plane_twice_and_lists_them() {
    let folder = folder();
    for (pyramid, planes, texels) in [
        ("mipmap", vec![(0, 0, 6, 3), (1, 1, 3, 1), (2, 1, 1, 1)], 22),
        ("dipmap", vec![(0, 0, 6, 3), (1, 0, 3, 3), (2, 0, 1, 3), (0, 1, 6, 1)], 36),
        ("ripmap", vec![(0, 0, 6, 3), (1, 0, 3, 3), (2, 0, 1, 3), (0, 1, 6, 1), (1, 1, 3, 1), (2, 1, 1, 1)], 40),
    ] {
        let arguments = ["mips", "texture.ppm", "--pyramid", pyramid, "--out", pyramid];
        let output = texunit(folder.path(), &arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let table = String::from_utf8(output.stdout).unwrap();
        assert!(
            table.contains(&format!("{} bytes in all: {:.4} times", 4 * texels, f64::from(texels) / 18.0)),
            "{table}"
        );

        let out = folder.path().join(pyramid);
        let listing: Value = serde_json::from_slice(&fs::read(out.join("planes.json")).unwrap()).unwrap();
        assert_eq!(listing["pyramid"], pyramid);
        assert_eq!(listing["texels"], texels);
        assert_eq!(listing["build"]["kernel"], "box");
        assert_eq!(listing["build"]["from"], "top");
        let listed = listing["planes"].as_array().unwrap();
        assert_eq!(listed.len(), planes.len());
        for (plane, (lu, lv, width, height)) in listed.iter().zip(planes) {
            assert_eq!([&plane["lu"], &plane["lv"], &plane["width"], &plane["height"]], [lu, lv, width, height]);
            assert_eq!(plane["png"], format!("plane_{lu}_{lv}.png"));
            let raw = fs::read(out.join(format!("plane_{lu}_{lv}.rgba"))).unwrap();
            let png = image::open(out.join(format!("plane_{lu}_{lv}.png"))).unwrap();
            assert_eq!((png.width(), png.height()), (width, height));
            assert_eq!(png.into_rgba8().into_raw(), raw);
        }
        // Planes, their raw twins and the listing: nothing else lies about.
        assert_eq!(fs::read_dir(&out).unwrap().count(), 2 * listed.len() + 1);

        let before = fs::read(out.join("plane_1_0.rgba")).or_else(|_| fs::read(out.join("plane_1_1.rgba"))).unwrap();
        fs::write(out.join("plane_0_0.rgba"), "stale").unwrap();
        assert!(texunit(folder.path(), &arguments).status.success(), "a second run overwrites");
        let after = fs::read(out.join("plane_1_0.rgba")).or_else(|_| fs::read(out.join("plane_1_1.rgba"))).unwrap();
        assert_eq!(before, after);
        assert_eq!(fs::read(out.join("plane_0_0.rgba")).unwrap().len(), 72);
    }
}

#[test]
fn mips_says_how_the_planes_were_made() {
    let folder = folder();
    let options = ["--kernel", "kaiser", "--from-above", "--rounding", "truncate", "--edge", "mirror"];
    let output = texunit(folder.path(), &[["mips", "texture.ppm", "--out", "o"].as_slice(), &options].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let listing: Value = serde_json::from_slice(&fs::read(folder.path().join("o/planes.json")).unwrap()).unwrap();
    let expected = serde_json::json!(
        {"kernel": "kaiser", "width": 14, "from": "above", "rounding": "truncate", "edge": "mirror"}
    );
    assert_eq!(listing["build"], expected);
    assert_eq!(listing["premultiplied"], true);
}

#[test]
fn a_missing_image_is_named() {
    refused(&texunit(folder().path(), &["mips", "nowhere.png", "--out", "o"]), &["nowhere.png", "No such file"]);
}

#[test]
fn files_that_are_no_whole_images_are_refused_before_anything_is_written() {
    let folder = folder();
    let whole = folder.path().join("whole.png");
    image::RgbaImage::new(64, 64).save(&whole).unwrap();
    let png = fs::read(&whole).unwrap();
    for (name, bytes, word) in [
        ("text.png", b"not an image".to_vec(), "cannot be read as an image"),
        ("empty.png", Vec::new(), "cannot be read as an image"),
        ("short.png", png[..png.len() / 2].to_vec(), "cannot be read as an image"),
        ("zero.ppm", b"P6\n0 4\n255\n".to_vec(), "help: "),
        ("huge.ppm", b"P6\n40000 40000\n255\n".to_vec(), "40000 x 40000 texels"),
        ("long.pgm", b"P5\n2000000 1\n255\n".to_vec(), "at most 1048576 texels on a side"),
    ] {
        fs::write(folder.path().join(name), bytes).unwrap();
        refused(&texunit(folder.path(), &["mips", name, "--out", "o"]), &[name, word, "help: "]);
        assert!(!folder.path().join("o").exists());
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    refused(&texunit(folder().path(), &["mips", "texture.ppm", "--out", "texture.ppm/o"]), &["texture.ppm/o"]);
}

#[test]
fn impossible_options_are_refused_with_what_would_do() {
    let folder = folder();
    let mips = |options: &[&str]| {
        texunit(folder.path(), &[["mips", "texture.ppm", "--out", "o"].as_slice(), options].concat())
    };
    refused(&mips(&["--kernel", "kaiser", "--width", "13"]), &["width = 13", "an even number from 2 to 64"]);
    refused(&mips(&["--width", "4"]), &["width = 4", "kernel box has no width"]);
    refused(&mips(&["--kernel", "gauss"]), &["gauss", "point, box, tent, lanczos, kaiser"]);
    refused(&mips(&["--pyramid", "sat"]), &["sat", "mipmap, dipmap, ripmap"]);
    refused(&mips(&["--from-top", "--from-above"]), &["cannot be used with"]);
}

#[test]
fn kernels_prints_the_errata_s_numbers_and_draws_them() {
    let folder = folder();
    let output = texunit(folder.path(), &["kernels", "-o", "drawn"]);
    assert!(output.status.success());
    let table = String::from_utf8(output.stdout).unwrap();
    for number in ["0.0177", "0.1817", "0.0224", "0.0217", "0.0214", "-2.9 to 257.9"] {
        assert!(table.contains(number), "{number} in\n{table}");
    }
    let drawing = fs::read_to_string(folder.path().join("drawn/kernels.svg")).unwrap();
    assert!(drawing.trim_end().ends_with("</svg>") && drawing.contains("kaiser (14)"));
    refused(&texunit(folder.path(), &["kernels", "--width", "65"]), &["width = 65"]);
}

#[test]
fn drift_measures_the_user_s_image_too() {
    let folder = folder();
    let output = texunit(folder.path(), &["drift", "texture.ppm", "--levels", "1"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("image 5 bit") && table.contains("-0.375"), "{table}");
    refused(&texunit(folder.path(), &["drift", "nowhere.png"]), &["nowhere.png"]);
}
