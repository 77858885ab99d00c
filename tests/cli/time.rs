//! `texunit time`, as a user runs it.

use std::path::Path;

use super::{command, good, texunit};

#[test]
fn every_filter_asked_for_has_a_row() {
    let table = good(&texunit(Path::new("."), &["time", "floor", "--size", "64x48", "-f", "point,trilinear"]));
    for name in ["point", "trilinear"] {
        assert!(table.lines().any(|line| line.contains(name)), "{name} in\n{table}");
    }
}

/// Linux says which signals a process has a handler for, so the test need not guess when the command is ready for it.
#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_ends_a_long_frame_and_prints_what_was_finished() {
    use std::{fs, process::Stdio, time::Instant};

    let arguments = ["time", "floor", "--size", "16384x16384", "-f", "point"];
    let mut command = command(Path::new("."), &arguments);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begin = Instant::now();
    let catches_interrupt = || {
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        // Bit 1 is signal 2.
        u64::from_str_radix(caught.trim(), 16).unwrap() & 2 != 0
    };
    while !catches_interrupt() {
        assert!(begin.elapsed().as_secs() < 120, "no handler");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let kill = format!("kill -INT {}", child.id());
    assert!(std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("interrupted; filters that were not finished are left out"), "{message}");
    let table = String::from_utf8_lossy(&output.stdout);
    assert!(table.contains("floor on"), "{table}");
    assert!(!table.lines().any(|line| line.contains("point")), "{table}");
}
