//! `texunit cache` as a user meets it.

use std::{
    fs,
    io::Write,
    path::PathBuf,
    process::{Command, Output, Stdio},
};

fn texunit(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_texunit"));
    command.arg("cache").args(arguments);
    command
}

/// A file of the test's own.
fn file(folder: &tempfile::TempDir, name: &str, bytes: &[u8]) -> String {
    let path: PathBuf = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_string()
}

fn json(output: &Output) -> serde_json::Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refused(mut command: Command, parts: &[&str]) {
    let output = command.output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty());
    for part in parts {
        assert!(message.contains(part), "no `{part}` in: {message}");
    }
}

const SMALL: [&str; 6] = ["--sets", "2", "--ways", "1", "--line", "64"];

#[test]
fn the_three_formats_and_standard_input_give_the_same_counts() {
    let folder = tempfile::tempdir().unwrap();
    let addresses = [0u32, 128, 0, 64, 256, 0, 1];
    let wide: Vec<u8> = addresses.iter().flat_map(|&address| u64::from(address).to_le_bytes()).collect();
    let narrow: Vec<u8> = addresses.iter().flat_map(|&address| address.to_le_bytes()).collect();
    let text = "0 0\n1 80 4 extra\n\n2 0x0\r\n0 40\n0 0X100\n 0\t0 \n0 1";
    let wide_file = file(&folder, "trace", &wide);
    let sources = [wide_file.clone(), file(&folder, "trace.u32", &narrow), file(&folder, "trace.din", text.as_bytes())];
    for source in &sources {
        let answer = json(&texunit(&[source, "--json"]).args(SMALL).output().unwrap());
        for (key, value) in [
            ("accesses", 7),
            ("hits", 1),
            ("misses", 6),
            ("compulsory", 4),
            ("conflict", 1),
            ("capacity", 1),
            ("evictions", 4),
            ("bytes_fetched", 384),
            ("sets", 2),
            ("ways", 1),
            ("line", 64),
            ("size_bytes", 128),
        ] {
            assert_eq!(answer[key], value, "{key} of {source}");
        }
        assert_eq!(answer["policy"], "lru");
    }
    let mut child = texunit(&["-", "--json", "--format", "din"])
        .args(SMALL)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    let piped = json(&child.wait_with_output().unwrap());
    assert_eq!(piped, json(&texunit(&[&wide_file, "--json"]).args(SMALL).output().unwrap()));
}

#[test]
fn any_shape_and_policy_runs_and_the_table_agrees_with_the_json() {
    let folder = tempfile::tempdir().unwrap();
    let trace: Vec<u8> = (0..40_000u64).flat_map(|i| (i * i % 65_537).to_le_bytes()).collect();
    let trace = file(&folder, "trace.u64", &trace);
    for policy in ["lru", "fifo", "plru", "random"] {
        for (sets, ways) in [("1", "256"), ("4", "24"), ("3", "5")] {
            let arguments = [&trace, "--sets", sets, "--ways", ways, "--line", "32", "--policy", policy];
            let answer = json(&texunit(&arguments).arg("--json").output().unwrap());
            assert_eq!(answer["accesses"], 40_000);
            let count = |key: &str| answer[key].as_u64().unwrap();
            assert_eq!(count("compulsory") + count("capacity") + count("conflict"), count("misses"));
            let table = texunit(&arguments).output().unwrap();
            let table = String::from_utf8(table.stdout).unwrap();
            for key in ["hits", "misses", "compulsory", "capacity", "conflict"] {
                let row = table.lines().find(|line| line.trim().starts_with(key)).unwrap();
                assert_eq!(row.split_whitespace().nth(1), Some(answer[key].to_string().as_str()), "{table}");
            }
        }
    }
}

#[test]
fn the_seed_of_random_replacement_decides_and_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let trace: Vec<u8> = (0..40_000u64).flat_map(|i| (i * i % 65_537).to_le_bytes()).collect();
    let trace = file(&folder, "trace.u64", &trace);
    let with = |seed: &str| {
        let shape = ["--sets", "4", "--ways", "24", "--line", "32", "--policy", "random", "--seed", seed, "--json"];
        json(&texunit(&[&trace]).args(shape).output().unwrap())
    };
    assert_eq!(with("7"), with("7"));
    assert_eq!(with("7")["seed"], 7);
    assert_ne!(with("7")["misses"], with("8")["misses"]);
}

#[test]
fn an_empty_trace_is_no_accesses() {
    let folder = tempfile::tempdir().unwrap();
    let trace = file(&folder, "empty", b"");
    let answer = json(&texunit(&[&trace, "--json"]).args(SMALL).output().unwrap());
    assert_eq!((&answer["accesses"], &answer["miss_rate"]), (&0.into(), &0.0.into()));
}

#[test]
fn caches_that_cannot_be_built_are_refused_with_the_remedy() {
    let shape =
        |sets: &str, ways: &str, line: &str| texunit(&["missing", "--sets", sets, "--ways", ways, "--line", line]);
    refused(shape("0", "1", "64"), &["--sets = 0", "at least one set", "give 1 or more"]);
    refused(shape("1", "0", "64"), &["--ways = 0", "at least one way"]);
    refused(shape("1", "1", "48"), &["--line = 48", "power of two from 1 to 4096"]);
    refused(shape("1", "1", "8192"), &["--line = 8192"]);
    refused(shape("4000000000", "4000000000", "64"), &["too many lines", "2^28"]);
}

#[test]
fn traces_that_cannot_be_read_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let on = |path: &str| {
        let mut command = texunit(&[path]);
        command.args(SMALL);
        command
    };
    refused(on("no/such/trace"), &["no/such/trace", "No such file"]);
    let short = file(&folder, "short.u64", &[0; 13]);
    refused(on(&short), &[&short, "byte 8", "5 of its 8 bytes", "--format"]);
    let label = file(&folder, "label.din", b"0 10\n\n7 20\n");
    refused(on(&label), &[&label, "line 3", "label is `7`"]);
    for bad in ["0", "0 xyz", "0 0x", "0 +1", "0 11112222333344445"] {
        let address = file(&folder, "address.din", format!("0 10\n{bad}\n").as_bytes());
        refused(on(&address), &[&address, "line 2", "the address is", "hexadecimal digits"]);
    }
    refused(texunit(&["x", "--sets", "1", "--ways", "1", "--line", "64", "--policy", "mru"]), &["mru", "plru"]);
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let mut child = texunit(&["-", "--json"])
        .args(SMALL)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    child.stdin.take().unwrap().write_all(&[0; 64]).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}
