//! The extremes: every case passes, none passes for want of carelessness, and the results become a section of the page.

use std::process::Command;

use texunit::stress::{CASES, Finding, Options, Q, Row};

#[test]
fn every_extreme_input_is_answered_within_what_it_allows_and_every_case_has_a_careless_answer_that_is_not() {
    let options = Options::default();
    let mut names = Vec::new();
    for case in &CASES {
        let finding = case.run(&options).unwrap();
        let failed: Vec<&Row> = finding.rows.iter().filter(|row| !row.passes()).collect();
        assert!(failed.is_empty(), "{}: {failed:#?}", case.name);
        assert!(finding.rows.iter().any(Row::shows_carelessness), "{} shows nothing: {:#?}", case.name, finding.rows);
        assert!(finding.passes());
        names.push(case.name.to_owned());
    }
    assert_eq!(names, (1..=23).map(|number| format!("X{number}")).collect::<Vec<_>>());
}

#[test]
fn a_case_fails_when_ours_is_wrong_and_when_nobody_is() {
    let row = Row { input: String::new(), unit: "LSB", careless: 9.0, ours: 1.0, ideal: 1.0, allowed: 0.5 };
    let finding = |rows: Vec<Row>| Finding { name: "X0", title: "", wrong: "", rows };
    assert!(finding(vec![row.clone()]).passes());
    assert!(!finding(vec![row.clone(), Row { ours: 2.0, ..row.clone() }]).passes());
    assert!(!finding(vec![Row { ours: f64::NAN, ..row.clone() }]).passes());
    assert!(!finding(vec![Row { careless: 1.2, ..row }]).passes());
}

#[test]
fn published_numbers_of_the_extremes_come_out() {
    let rows = |name: &str| {
        let case = CASES.iter().find(|case| case.name == name).unwrap();
        case.run(&Options::default()).unwrap().rows
    };
    let of = |name: &str, input: &str| {
        let rows = rows(name);
        rows.iter().find(|row| row.input.contains(input)).unwrap_or_else(|| panic!("{name}: {rows:#?}")).clone()
    };
    // Herf's order of multiplication: infinity at w' = 2e-10, where the ratio is 1.5 (X1).
    assert_eq!(of("X1", "2e-10").careless, 8.0);
    // A forward difference one pixel below the horizon is a whole level off (X3).
    assert!((of("X3", "d = 1: against a forward").careless_error() - 1.0).abs() < 0.01);
    // N/2 units of 2^-20 (X5): 8 texels of 4096.
    assert!((of("X5", "4096 pixels on 4096 texels, 12.20").careless_error() - 8.0).abs() < 0.01);
    // Straight alpha (X17): 191.25 instead of 255.
    assert!((of("X17", "on the edge").careless - 191.25).abs() < 0.5);
    // 8 LSB at 32768 texels, 16 at 65536 (X10), and what 9.23 and 12.32 give back.
    assert!((7.5..9.0).contains(&of("X10", "32768 texels: 16 fraction bits").ours));
    assert!((15.5..17.0).contains(&of("X10", "65536 texels: 16 fraction bits").ours));
    assert!(of("X10", "32768 texels: the chip's 12.20 against 9.23").ours < 2.6);
    assert!(of("X10", "65536 texels: the chip's 12.20 against 12.32").ours < 1.6);
    // A third of the pixels or more at the wrong level (X15).
    assert!((25.0..50.0).contains(&of("X15", "(j j) invw4").careless));
}

#[test]
fn the_wider_formats_are_a_users_choice() {
    let case = CASES.iter().find(|case| case.name == "X10").unwrap();
    let rows = case.run(&Options { formats: vec!["16.16".parse::<Q>().unwrap()] }).unwrap().rows;
    assert!(rows.iter().any(|row| row.input.contains("65536 texels: the chip's 12.20 against 16.16, 0 bits left")));
    for wrong in ["9", "9.x", "0.20", "9.41", ""] {
        assert!(wrong.parse::<Q>().unwrap_err().contains("9.23"), "{wrong}");
    }
}

#[test]
fn the_command_writes_a_file_that_the_page_shows() {
    let folder = tempfile::tempdir().unwrap();
    let texunit = |arguments: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_texunit")).args(arguments).current_dir(folder.path()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, table, _) = texunit(&["stress", "--only", "X9,x16", "-o", "stress.json"]);
    assert_eq!(code, Some(0));
    assert!(table.contains("X9 ") && table.contains("2 cases, 0 failed"), "{table}");
    let (code, json, _) = texunit(&["stress", "--only", "X9", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (code, &report["cases"][0]["case"], &report["cases"][0]["passes"]),
        (Some(0), &"X9".into(), &true.into())
    );
    assert_eq!(texunit(&["report", ".", "-o", "page.html"]).0, Some(0));
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    for part in ["Extreme inputs", "2 cases, 0 failed", "squared ratio NaN", "texunit stress --only X9,x16"] {
        assert!(page.contains(part), "{part}");
    }
    let (code, _, message) = texunit(&["stress", "--only", "X24"]);
    assert!(code == Some(2) && message.contains("X23"), "{message}");
}
