//! The error budget: its parts explain the error, and each names the width it is about.

use std::process::Command;

use texunit::{
    budget::{self, Budget, Ledger, Steps},
    machine::Machine,
    scene::{Scene, TextureSource},
};
use texunit_hw::Filter;

fn ledger<'m>(machine: &'m Machine, filters: &[Filter]) -> Ledger<'m> {
    let mut scene = Scene::builtin("rectangle-natural").unwrap();
    scene.size = [96, 72];
    if let TextureSource::Procedural(texture) = &mut scene.texture.source {
        texture.size = [128, 128];
    }
    Ledger::new(machine, &scene, filters, 300).unwrap()
}

fn budget(settings: &[&str], filter: Filter) -> Budget {
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    let machine = Machine::default().with_settings(&settings).unwrap();
    ledger(&machine, &[filter]).budget(filter).unwrap()
}

#[test]
fn the_parts_of_every_sample_in_order_add_up_to_its_error_and_end_at_the_chip() {
    let machine = Machine::default();
    let filters: Vec<Filter> = budget::filters().collect();
    let ledger = ledger(&machine, &filters);
    for filter in filters {
        let steps = ledger.steps(filter).unwrap();
        assert!(steps.len() == 900);
        for steps in &steps {
            let sum: f64 = steps.parts().iter().sum();
            // Six numbers below 256 added and subtracted in f64.
            assert!((sum - steps.total()).abs() < 1e-12, "{filter:?}: {steps:?}");
            let chip = steps.values[5];
            assert!(chip == chip.floor() && (0.0..=255.0).contains(&chip));
            // The model that has every width but the last is rounded to the chip's answer.
            assert!((chip - steps.values[4]).abs() <= 0.5, "{filter:?}: {steps:?}");
        }
        let budget = ledger.budget(filter).unwrap();
        let shares: f64 = budget.parts.iter().map(|part| part.share).sum();
        let means: f64 = budget.parts.iter().map(|part| part.in_order.mean).sum();
        assert!((shares - budget.total.rms).abs() < 1e-9 && (means - budget.total.mean).abs() < 1e-9, "{budget:?}");
        assert!(budget.residue < 1e-12 && (budget.total.rms > 0.0 || filter == Filter::Point), "{budget:?}");
    }
}

#[test]
fn a_part_is_zero_where_its_width_does_not_exist_and_grows_with_it() {
    let part = |budget: &Budget, name: &str| budget.parts.iter().find(|part| part.name == name).unwrap().in_order;
    let point = budget(&[], Filter::Point);
    for name in ["fraction", "lod", "texel", "rounding"] {
        assert_eq!(part(&point, name).worst, 0.0, "point has no {name}");
    }
    let bilinear = budget(&[], Filter::Bilinear);
    assert_eq!((part(&bilinear, "lod").worst, part(&bilinear, "texel").worst), (0.0, 0.0));
    assert!((0.2..0.4).contains(&part(&bilinear, "rounding").rms)); // 1/sqrt(12) is 0.289
    let [wide, narrow] = [8, 3].map(|bits| budget(&[&format!("filter.bits={bits}")], Filter::Trilinear));
    assert!(part(&narrow, "fraction").rms > 8.0 * part(&wide, "fraction").rms);
    assert_eq!(part(&narrow, "coordinate"), part(&wide, "coordinate"));
    let [fine, coarse] = [8, 1].map(|bits| budget(&[&format!("lod.bits={bits}")], Filter::Trilinear));
    assert!(part(&coarse, "lod").rms > 8.0 * part(&fine, "lod").rms);
    let five_bits = budget(&["texture.format=rgb565"], Filter::Trilinear);
    assert!(part(&five_bits, "texel").rms > 2.0 * part(&fine, "texel").rms);
    let truncating = budget(&["filter.rounding=staged-truncate"], Filter::Trilinear);
    assert!(part(&truncating, "rounding").mean < -1.0); // three stages, half a step each
}

#[test]
fn steps_say_what_they_add_up_to() {
    let steps = Steps { values: [1.0, 2.0, 4.0, 8.0, 16.0, 32.0], alone: [0.0; 5] };
    assert_eq!((steps.parts(), steps.total()), ([1.0, 2.0, 4.0, 8.0, 16.0], 31.0));
}

#[test]
fn the_command_prints_a_table_json_and_bars() {
    let folder = tempfile::tempdir().unwrap();
    let texunit = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_texunit"))
            .arg("budget")
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let small = ["floor", "--size", "64x48", "--samples", "500", "-f", "bilinear,trilinear"];
    let (code, table, _) = texunit(&[&small[..], &["--svg", "b.svg"]].concat());
    assert!(code == Some(0) && table.contains("interaction") && table.contains("500 samples"), "{table}");
    let svg = std::fs::read_to_string(folder.path().join("b.svg")).unwrap();
    for part in ["coordinate", "rounding", "trilinear", "<rect"] {
        assert!(svg.contains(part), "{part}");
    }
    let (code, json, _) = texunit(&[&small[..], &["--json"]].concat());
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((code, &report["filters"][1]["filter"]), (Some(0), &"trilinear".into()));
    for (arguments, told) in [(&["-f", "sat"][..], "texunit run"), (&["--set", "texture.srgb=true"], "texture.srgb")] {
        let (code, _, message) = texunit(arguments);
        assert!(code == Some(2) && message.contains(told), "{message}");
    }
}
