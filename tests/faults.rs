//! What goes wrong outside: disks that are full, folders that are none, processes that are killed, files that are cut or come from the
//! future. A clear error, nothing half-written, nothing lost that was finished.
#![cfg(target_os = "linux")]

use std::{
    collections::BTreeMap,
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

use texunit::trace::Trace;

fn texunit(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_texunit"));
    command.args(arguments).current_dir(folder);
    command
}

fn refused(output: &Output, parts: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    for part in parts {
        assert!(message.contains(part), "no `{part}` in: {message}");
    }
}

/// A folder with coordinates, a texture, a sweep of some points.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("c.csv"), "u,v,lod\n".to_owned() + &"0.5,0.25,1\n".repeat(20_000)).unwrap();
    image::RgbaImage::from_fn(64, 64, |x, y| image::Rgba([x as u8, y as u8, 0, 255]))
        .save(folder.path().join("t.png"))
        .unwrap();
    fs::write(folder.path().join("s.toml"), SWEEP).unwrap();
    folder
}

/// 12 points of some tens of milliseconds.
const SWEEP: &str = r#"
name = "s"
scenes = ["floor"]
sizes = [[120, 90]]
filters = ["trilinear", "feline"]
measure = "error"

[set]
lod.bits = [2, 5, 8]
filter.bits = [4, 8]
"#;

const SAMPLE: [&str; 7] = ["sample", "--texture", "t.png", "--filter", "trilinear", "--input", "c.csv"];

/// Every file below a folder, hidden ones left out: temporary files of the killed, and the lock.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.file_name().unwrap().to_string_lossy().starts_with('.') {
            continue;
        }
        if path.is_dir() {
            found.extend(files(&path))
        } else {
            drop(found.insert(path.clone(), fs::read(&path).unwrap()))
        }
    }
    found
}

/// Holds each file to what its kind must look like from end to end.
fn all_whole(files: &BTreeMap<PathBuf, Vec<u8>>) {
    for (path, bytes) in files {
        let name = path.display();
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("json") => {
                drop(serde_json::from_slice::<serde_json::Value>(bytes).unwrap_or_else(|e| panic!("{name}: {e}")))
            }
            Some("png") => drop(image::load_from_memory(bytes).unwrap_or_else(|error| panic!("{name}: {error}"))),
            Some("csv") => assert!(bytes.ends_with(b"\n"), "{name} is cut"),
            _ => {}
        }
    }
}

#[test]
fn a_full_disk_behind_standard_output_is_an_error_of_every_command_that_prints() {
    let folder = folder();
    let full = || Stdio::from(File::options().write(true).open("/dev/full").unwrap());
    let small = ["floor", "--size", "16x12", "-f", "bilinear"];
    let commands: Vec<Vec<&str>> = vec![
        [&["run"][..], &small, &["--json"]].concat(),
        [&["conform"][..], &small].concat(),
        [&SAMPLE[..], &["--output", "-"]].concat(),
        vec!["explain"],
        vec!["scenes"],
        vec!["scenes", "--show", "floor"],
        vec!["trace", "record", "floor", "-f", "bilinear", "--count", "3"],
        vec!["kernels"],
        vec!["drift", "--levels", "1"],
        vec!["sweep", "plan", "s.toml"],
        vec!["sweep", "slurm", "s.toml"],
        vec!["time", "floor", "--definitions"],
    ];
    for arguments in commands {
        let output = texunit(folder.path(), &arguments).stdout(full()).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains("standard output") && message.contains("No space left"), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{arguments:?}: {message}");
    }
}

#[test]
fn a_device_named_as_output_is_written_to_and_stays_a_device() {
    use std::os::unix::fs::FileTypeExt;
    let folder = folder();
    let output = texunit(folder.path(), &[&SAMPLE[..], &["--output", "/dev/full"]].concat()).output().unwrap();
    refused(&output, &["/dev/full", "No space left", "make room"]);
    let output = texunit(folder.path(), &[&SAMPLE[..], &["--output", "/dev/null"]].concat()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for device in ["/dev/full", "/dev/null"] {
        assert!(fs::metadata(device).unwrap().file_type().is_char_device(), "{device} was replaced");
    }
}

#[test]
fn a_link_named_as_output_stays_a_link() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("real.csv"), "old").unwrap();
    std::os::unix::fs::symlink("real.csv", at.join("link.csv")).unwrap();
    let output = texunit(at, &[&SAMPLE[..], &["--output", "link.csv"]].concat()).output().unwrap();
    assert!(output.status.success());
    assert!(fs::symlink_metadata(at.join("link.csv")).unwrap().is_symlink());
    assert!(fs::read_to_string(at.join("real.csv")).unwrap().starts_with("r,g,b,a,lod\n"));
}

/// A mounted file system, unmounted in the end; none where this process may not mount.
struct Mount(PathBuf);

impl Mount {
    fn new(at: PathBuf, options: &str) -> Option<Self> {
        fs::create_dir(&at).unwrap();
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(&at).output();
        if mounted.is_ok_and(|output| output.status.success()) {
            return Some(Self(at));
        }
        eprintln!(
            "SKIPPED: this process may not mount a tmpfs, so a disk of its own that is full or read-only is not tried"
        );
        None
    }
}

impl Drop for Mount {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn a_disk_that_fills_up_leaves_what_was_there_and_nothing_half_written() {
    let folder = folder();
    let Some(Mount(disk)) = &Mount::new(folder.path().join("disk"), "size=128k") else { return };
    let target = disk.join("texels.csv");
    fs::write(&target, "what was there\n").unwrap();
    let output =
        texunit(folder.path(), &[&SAMPLE[..], &["--output", target.to_str().unwrap()]].concat()).output().unwrap();
    refused(&output, &["texels.csv", "No space left", "make room, or name another place"]);
    assert_eq!(fs::read_to_string(&target).unwrap(), "what was there\n");
    assert_eq!(fs::read_dir(disk).unwrap().count(), 1, "something was left behind");

    let output =
        texunit(folder.path(), &["run", "floor", "-f", "bilinear", "-o", disk.to_str().unwrap()]).output().unwrap();
    refused(&output, &["No space left"]);
    all_whole(&files(disk));
}

#[test]
fn a_read_only_disk_is_named_with_the_remedy() {
    let folder = folder();
    let Some(Mount(disk)) = &Mount::new(folder.path().join("disk"), "ro") else { return };
    for command in [
        vec!["run", "floor", "--size", "16x12", "-f", "bilinear", "-o", disk.to_str().unwrap()],
        vec!["sweep", "run", "s.toml", "-o", disk.to_str().unwrap()],
    ] {
        let output = texunit(folder.path(), &command).output().unwrap();
        refused(&output, &["Read-only file system", "name a place that you may read and write"]);
    }
}

#[test]
fn a_file_where_a_folder_should_be_is_named_with_the_remedy_and_left_alone() {
    let folder = folder();
    let at = folder.path();
    for arguments in [
        vec!["run", "floor", "--size", "16x12", "-f", "bilinear", "-o", "c.csv"],
        vec!["run", "floor", "--size", "16x12", "-f", "bilinear", "-o", "c.csv/out"],
        vec!["sweep", "run", "s.toml", "-o", "c.csv"],
        vec!["trace", "record", "floor", "-f", "bilinear", "-o", "c.csv/a.trace"],
    ] {
        let output = texunit(at, &arguments).output().unwrap();
        refused(&output, &["c.csv", "a file stands where a folder is meant"]);
    }
    assert!(fs::read_to_string(at.join("c.csv")).unwrap().starts_with("u,v,lod\n"));
}

/// Runs a command until it has written enough files, and kills it.
fn killed(mut command: Command, folder: &Path, enough: usize) {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let begin = Instant::now();
    while (!folder.exists() || files(folder).len() < enough) && begin.elapsed() < Duration::from_secs(60) {
        if child.try_wait().unwrap().is_some() {
            break;
        }
        sleep(Duration::from_millis(2));
    }
    child.kill().unwrap(); // SIGKILL
    child.wait().unwrap();
}

#[test]
fn a_killed_sweep_leaves_whole_points_and_goes_on_with_the_rest() {
    let folder = folder();
    let at = folder.path();
    let out = at.join("out");
    killed(texunit(at, &["sweep", "run", "s.toml", "-o", "out", "-j", "1"]), &out, 3);
    let finished = files(&out);
    all_whole(&finished);
    assert!((3..12).contains(&finished.len()), "{} of 12 points: killed too early or too late", finished.len());

    let output = texunit(at, &["sweep", "run", "s.toml", "-o", "out"]).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    assert!(message.contains(&format!("{} of 12 points are there already", finished.len())), "{message}");
    let after = files(&out);
    assert_eq!(after.len(), 13);
    for (path, bytes) in &finished {
        assert!(after[path] == *bytes, "{} was computed again", path.display());
    }
    // And it is the sweep that nobody killed.
    let output = texunit(at, &["sweep", "run", "s.toml", "-o", "whole"]).output().unwrap();
    assert!(output.status.success());
    assert_eq!(after[&out.join("sweep.csv")], fs::read(at.join("whole/sweep.csv")).unwrap());
}

#[test]
fn a_killed_run_leaves_whole_files_and_does_not_block_the_next() {
    let folder = folder();
    let at = folder.path();
    let out = at.join("out");
    let arguments =
        ["run", "floor", "rectangle-natural", "magnified", "--size", "100x75", "-f", "bilinear,trilinear", "-o", "out"];
    killed(texunit(at, &arguments), &out, 7);
    let finished = files(&out);
    all_whole(&finished);
    assert!(!finished.contains_key(&out.join("magnified/trilinear.png")), "killed too late");
    // The first scene is whole: its report was there before the second began.
    let report: serde_json::Value = serde_json::from_slice(&finished[&out.join("report.json")]).unwrap();
    assert_eq!(report["scenes"].as_array().unwrap().len(), finished.len() / 7);
    let output = texunit(at, &arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    all_whole(&files(&out));
}

#[test]
fn two_sweeps_into_one_folder_at_once_leave_the_table_of_one() {
    let folder = folder();
    let at = folder.path();
    let start =
        || texunit(at, &["sweep", "run", "s.toml", "-o", "out"]).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let mut both = [start().unwrap(), start().unwrap()];
    for child in &mut both {
        assert!(child.wait().unwrap().success());
    }
    all_whole(&files(&at.join("out")));
    assert!(texunit(at, &["sweep", "run", "s.toml", "-o", "one"]).output().unwrap().status.success());
    assert_eq!(fs::read(at.join("out/sweep.csv")).unwrap(), fs::read(at.join("one/sweep.csv")).unwrap());
}

#[test]
fn every_beginning_of_a_trace_is_refused_with_the_line_it_ends_on() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/floor.trilinear.trace");
    let text = fs::read_to_string(path).unwrap();
    let whole = text.trim_end().len();
    for length in 0..whole {
        let start = &text[..length];
        let error = match Trace::parse("cut.trace", start.as_bytes()) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("taken, cut at byte {length} of {whole}"),
        };
        // A head cut within the profile's lines is TOML cut: its message shows the line with a margin of numbers.
        assert!(
            error.contains("cut.trace") && error.contains("line ") || error.contains("cut.trace:"),
            "{length}: {error}"
        );
        let lines = start.lines().count().max(1);
        let named = (lines.saturating_sub(1)..=lines).any(|line| error.contains(&line.to_string()));
        assert!(named, "cut at byte {length}, in line {lines}: {error}");
    }
    assert!(Trace::parse("cut.trace", &text.as_bytes()[..whole]).is_ok());
}

#[test]
fn files_from_the_future_are_refused_and_not_written_over() {
    let folder = folder();
    let at = folder.path();
    let future = |name: &str, text: String| fs::write(at.join(name), text).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| fs::read_to_string(root.join(path)).unwrap();

    future("m.toml", "schema = 2\nname = \"later\"\n".into());
    refused(
        &texunit(at, &["explain", "m.toml"]).output().unwrap(),
        &["m.toml", "schema 2", "up to 1", "update texunit"],
    );
    future("m.toml", "schema = 1\nname = \"now\"\n".into());
    assert!(texunit(at, &["explain", "m.toml"]).output().unwrap().status.success());

    future("f.toml", format!("schema = 2\n{}", read("scenes/floor.toml")));
    let output = texunit(at, &["run", "f.toml", "-f", "bilinear", "--size", "16x12"]).output().unwrap();
    refused(&output, &["f.toml", "schema 2", "update texunit"]);

    future("later.toml", format!("schema = 2\n{SWEEP}"));
    refused(
        &texunit(at, &["sweep", "plan", "later.toml"]).output().unwrap(),
        &["later.toml", "schema 2", "update texunit"],
    );

    future("t.trace", read("traces/floor.point.trace").replacen("// texunit trace 1", "// texunit trace 2", 1));
    refused(
        &texunit(at, &["trace", "verify", "t.trace"]).output().unwrap(),
        &["t.trace", "line 1", "version 2", "update texunit"],
    );

    // Reports and the results of sweeps.
    let run = ["run", "floor", "-f", "bilinear", "--size", "16x12", "-o", "out"];
    assert!(texunit(at, &run).output().unwrap().status.success());
    let report = fs::read_to_string(at.join("out/report.json")).unwrap().replacen("\"schema\": 1", "\"schema\": 2", 1);
    future("out/report.json", report);
    let output = texunit(at, &["report", "out", "-o", "page.html"]).output().unwrap();
    refused(&output, &["report.json", "schema 2", "update texunit"]);
    assert!(!at.join("page.html").exists());

    assert!(texunit(at, &["sweep", "point", "s.toml", "0", "-o", "points"]).output().unwrap().status.success());
    let point = at.join("points/point-000000.json");
    let newer = fs::read_to_string(&point).unwrap().replacen("\"schema\": 1", "\"schema\": 2", 1);
    fs::write(&point, &newer).unwrap();
    for arguments in [["sweep", "run", "s.toml", "-o", "points"], ["sweep", "merge", "s.toml", "-o", "points"]] {
        refused(&texunit(at, &arguments).output().unwrap(), &["point-000000.json", "schema 2", "update texunit"]);
    }
    assert_eq!(fs::read_to_string(&point).unwrap(), newer, "a finished result was written over");
}
