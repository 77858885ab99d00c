//! `texunit needs` and `texunit run --leave-out`.

fn texunit(arguments: &[&str]) -> (i32, String) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_texunit")).args(arguments).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stdout).unwrap())
}

fn json(arguments: &[&str]) -> serde_json::Value {
    let (status, text) = texunit(arguments);
    assert_eq!(status, 0, "{arguments:?}");
    serde_json::from_str(&text).unwrap()
}

#[test]
fn the_command_line_says_what_is_needed_and_what_leaving_out_saves() {
    let needs = json(&["needs", "one-to-one", "-f", "trilinear,sat", "--json"]);
    let filter = &needs["scenes"][0]["filters"][0];
    assert_eq!((filter["runs_as"].as_str(), filter["taps"].as_u64()), (Some("bilinear"), Some(2 * 256 * 256)));
    assert_eq!(needs["scenes"][0]["filters"][1]["runs_as"], "point");
    assert_eq!(needs["scenes"][0]["channels"]["count"], 3);

    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let run = json(&[
        "run",
        "one-to-one",
        "mixed",
        "-f",
        "trilinear,dipmap",
        "--size",
        "80x60",
        "--leave-out",
        "--json",
        "-o",
        out,
    ]);
    for scene in run["scenes"].as_array().unwrap() {
        for filter in scene["filters"].as_array().unwrap() {
            assert_eq!(filter["left_out"]["differing_pixels"], 0);
            let number = |name: &str| filter["metrics"][name]["value"].as_f64().unwrap();
            assert_eq!(number("cycles_per_pixel"), number("cycles_per_pixel_whole"));
            assert!(number("cycles_per_pixel_needed") <= number("cycles_per_pixel_whole"));
            assert!(number("memory_bytes_needed") <= number("pyramid_bytes"));
        }
    }
    let page = folder.path().join("page.html");
    assert_eq!(texunit(&["report", out, "-o", page.to_str().unwrap()]).0, 0);
    let page = std::fs::read_to_string(page).unwrap();
    assert!(
        page.contains("what it costs without what this scene does not need")
            && page.contains("differ between the two: 0")
    );

    let picture = folder.path().join("tiles.png");
    let arguments =
        ["needs", "one-to-one", "-f", "bilinear", "--texture-size", "32768x32768", "--size", "64x64", "--tiles"];
    let (status, text) = texunit(&[&arguments[..], &[picture.to_str().unwrap()]].concat());
    assert!(status == 0 && text.contains("all planes would take 5461.3 MiB"), "{text}");
    assert_eq!(image::open(picture).unwrap().to_rgba8().dimensions(), (64, 64));
}
