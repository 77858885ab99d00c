//! `ewa` on the command line: floats answer, the models of bits say why they do not.

use std::{fs, path::PathBuf, process::Command};

fn texunit() -> Command {
    Command::new(env!("CARGO_BIN_EXE_texunit"))
}

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn samples_come_from_the_ideal_and_only_from_it() {
    let folder = folder("ewa-sample");
    let (texture, rows) = (folder.join("grey.png"), folder.join("rows.csv"));
    image::RgbaImage::from_pixel(8, 8, image::Rgba([10, 20, 30, 255])).save(&texture).unwrap();
    fs::write(&rows, "u,v,dudx,dvdx,dudy,dvdy\n0.3,0.4,0.5,0,0,0.125\n").unwrap();
    let sample = |model: &str| {
        let mut command = texunit();
        command.arg("sample").arg("--texture").arg(&texture).args(["--filter", "ewa", "--model", model]);
        command.arg("--input").arg(&rows).args(["--output", "-"]).output().unwrap()
    };
    let answer = sample("ideal");
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    let text = String::from_utf8(answer.stdout).unwrap();
    let values: Vec<f64> = text.lines().nth(1).unwrap().split(',').map(|value| value.parse().unwrap()).collect();
    for (value, expected) in values.iter().zip([10.0, 20.0, 30.0, 255.0]) {
        assert!((value - expected).abs() < 1e-6, "{text}");
    }
    for model in ["hw", "reference"] {
        let refused = sample(model);
        assert_eq!(refused.status.code(), Some(2));
        let message = String::from_utf8(refused.stderr).unwrap();
        assert!(message.contains("no unit has it") && message.contains("--model ideal"), "{message}");
    }
}

#[test]
fn a_run_has_a_row_for_it_with_reads_and_errors_but_no_bits() {
    let folder = folder("ewa-run");
    let mut command = texunit();
    command.args(["run", "rectangle-pane", "--size", "48x36", "--filters", "feline,ewa", "--json", "-o"]);
    let answer = command.arg(&folder).output().unwrap();
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    let report: serde_json::Value = serde_json::from_slice(&answer.stdout).unwrap();
    let filters = report["scenes"][0]["filters"].as_array().unwrap();
    let [feline, ewa] = filters.as_slice() else { panic!("{filters:?}") };
    assert_eq!((&feline["filter"], &ewa["filter"]), (&"feline".into(), &"ewa".into()));
    assert_eq!(ewa["float_only"], true);
    assert!(ewa["metrics"]["reads_per_pixel"]["value"].as_f64().unwrap() > 1.0);
    assert!(ewa["metrics"]["rmse"]["value"].as_f64().unwrap() > 0.0);
    assert!(ewa["metrics"].get("mismatches").is_none() && ewa["metrics"].get("hits").is_none());
    assert!(folder.join("rectangle-pane/ewa.png").exists());
}
