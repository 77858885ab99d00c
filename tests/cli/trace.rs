//! `texunit trace` as a user meets it.

use std::fs;

use super::{good, refused, texunit};

/// Small enough that every test takes a moment.
const SCENE: &str = r#"
name = "small"
description = "A small furred rectangle"
width = 96
height = 72
[rectangle]
size = [3.2, 3.2]
rotation = { euler = [-60.0, 0.0, 30.0] }
translation = [0.0, 0.0, -4.6]
repeats = [2.0, 2.0]
[texture]
pattern = "natural"
size = [128, 64]
wrap = ["wrap", "clip"]
"#;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("small.toml"), SCENE).unwrap();
    folder
}

#[test]
fn a_recorded_trace_verifies_and_replays_to_itself() {
    let folder = folder();
    let at = folder.path();
    good(&texunit(at, &["trace", "record", "small.toml", "-f", "trilinear", "--count", "50", "-o", "a.trace"]));
    assert!(good(&texunit(at, &["trace", "verify", "a.trace"])).contains("a.trace: 50 requests agree"));
    let recorded = fs::read_to_string(at.join("a.trace")).unwrap();
    assert_eq!(good(&texunit(at, &["trace", "replay", "a.trace"])), recorded);
    assert_eq!(good(&texunit(at, &["trace", "record", "small.toml", "-f", "trilinear", "--count", "50"])), recorded);
}

#[test]
fn a_replay_on_another_machine_tells_what_changed() {
    let folder = folder();
    let at = folder.path();
    good(&texunit(at, &["trace", "record", "small.toml", "-f", "bilinear", "--every", "10", "-o", "a.trace"]));
    let output =
        texunit(at, &["trace", "replay", "a.trace", "--set", "cache.sets=1", "--set", "cache.ways=1", "-o", "b.trace"]);
    good(&output);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("recorded:") && !told.contains(" 0 records differ"), "{told}");
    good(&texunit(at, &["trace", "verify", "a.trace", "b.trace"]));
}

#[test]
fn a_changed_answer_is_found_with_line_field_and_both_values() {
    let folder = folder();
    let at = folder.path();
    good(&texunit(at, &["trace", "record", "small.toml", "-f", "dipmap", "--count", "20", "-o", "a.trace"]));
    let text = fs::read_to_string(at.join("a.trace")).unwrap();
    let number = text.lines().count() - 7;
    let line = text.lines().nth(number - 1).unwrap();
    // The field at a place, changed in its last digit.
    for (place, name) in [(10, "texel"), (11, "lod0"), (13, "reads"), (14, "misses")] {
        let mut fields: Vec<String> = line.split('_').map(str::to_owned).collect();
        let before = u32::from_str_radix(&fields[place], 16).unwrap();
        fields[place] = format!("{:0width$x}", before ^ 1, width = fields[place].len());
        fs::write(at.join("b.trace"), text.replace(line, &fields.join("_"))).unwrap();
        let output = texunit(at, &["trace", "verify", "a.trace", "b.trace"]);
        assert_eq!(output.status.code(), Some(1));
        let told = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(told.contains("a.trace: 20 requests agree"), "{told}");
        let expected = format!("b.trace: line {number}: {name}: expected {}, the chip gives", fields[place]);
        assert!(told.contains(&expected), "no `{expected}` in {told}");
    }
}

#[test]
fn exported_addresses_give_the_cache_the_hits_and_misses_of_a_run() {
    let folder = folder();
    let at = folder.path();
    for filter in ["trilinear", "dipmap", "feline"] {
        let report = good(&texunit(at, &["run", "small.toml", "-f", filter, "--json", "-o", "out"]));
        let report: serde_json::Value = serde_json::from_str(&report).unwrap();
        let metric = |name: &str| report["scenes"][0]["filters"][0]["metrics"][name]["value"].as_f64().unwrap();
        for file in ["a.u64", "a.u32", "a.din"] {
            good(&texunit(at, &["trace", "export", "small.toml", "-f", filter, "-o", file]));
            let cache = ["cache", file, "--sets", "64", "--ways", "4", "--line", "64", "--json"];
            let cache: serde_json::Value = serde_json::from_str(&good(&texunit(at, &cache))).unwrap();
            for (ours, theirs) in [
                ("lookups", "accesses"),
                ("hits", "hits"),
                ("misses", "misses"),
                ("compulsory_misses", "compulsory"),
                ("capacity_misses", "capacity"),
                ("conflict_misses", "conflict"),
            ] {
                assert_eq!(cache[theirs].as_f64(), Some(metric(ours)), "{theirs}, {filter}, {file}");
            }
            assert!(metric("misses") > 0.0 && metric("hits") > 0.0);
        }
    }
}

#[test]
fn a_trace_exports_the_reads_it_counts() {
    let folder = folder();
    let at = folder.path();
    good(&texunit(at, &["trace", "record", "small.toml", "-f", "trilinear", "--every", "7", "-o", "a.trace"]));
    let din = good(&texunit(at, &["trace", "export", "a.trace", "--format", "din", "-o", "-"]));
    let text = fs::read_to_string(at.join("a.trace")).unwrap();
    let reads = |line: &str| usize::from_str_radix(line.split('_').nth(13).unwrap(), 16).unwrap();
    let counted: usize = text.lines().filter(|line| !line.starts_with("//")).map(reads).sum();
    assert_eq!(din.lines().count(), counted);
    // The same requests from the scene.
    good(&texunit(at, &["trace", "export", "small.toml", "-f", "trilinear", "--every", "7", "-o", "b.din"]));
    assert_eq!(fs::read_to_string(at.join("b.din")).unwrap(), din);
    refused(&texunit(at, &["trace", "export", "a.trace", "-f", "point", "-o", "x"]), &["--filter = point", "its own"]);
    refused(&texunit(at, &["trace", "export", "a.trace", "--set", "cache.ways=2", "-o", "x"]), &["--set"]);
    refused(&texunit(at, &["trace", "export", "a.trace", "--count", "2", "-o", "x"]), &["--count"]);
    refused(&texunit(at, &["trace", "export", "small.toml", "-o", "x"]), &["--filter", "trilinear"]);
}

#[test]
fn the_texture_memory_of_a_trace_holds_at_each_address_the_texel_that_was_answered() {
    let folder = folder();
    let at = folder.path();
    good(&texunit(at, &["trace", "record", "small.toml", "-f", "point", "--every", "3", "-o", "a.trace"]));
    good(&texunit(at, &["trace", "memory", "a.trace", "-o", "a.memory"]));
    let memory = fs::read_to_string(at.join("a.memory")).unwrap();
    let (head, words): (Vec<&str>, Vec<&str>) = memory.lines().partition(|line| line.starts_with("//"));
    assert!(head.contains(&"// plane 1 halved 1 1 size 64 32 at 00008000"), "{head:?}");
    assert!(head.contains(&format!("// count {}", words.len()).as_str()), "{head:?}");
    let trace = fs::read_to_string(at.join("a.trace")).unwrap();
    for line in trace.lines().filter(|line| line.contains(" = ")) {
        assert!(head.contains(&line), "{line} in {head:?}");
    }
    // A point request reads its texel and nothing else; outside under clip it reads nothing.
    let answered: Vec<u32> = trace
        .lines()
        .filter(|line| !line.starts_with("//"))
        .map(|line| line.split('_').collect::<Vec<_>>())
        .filter(|fields| fields[13] == "0001")
        .map(|fields| u32::from_str_radix(fields[10], 16).unwrap())
        .collect();
    let addresses = good(&texunit(at, &["trace", "export", "a.trace", "--format", "din", "-o", "-"]));
    let held: Vec<u32> = addresses
        .lines()
        .map(|line| usize::from_str_radix(line.split(' ').nth(1).unwrap(), 16).unwrap())
        // Red is the highest byte of an answer and the lowest of a word.
        .map(|address| u32::from_str_radix(words[address / 4], 16).unwrap().swap_bytes())
        .collect();
    assert!(held.len() > 100, "{}", held.len());
    assert_eq!(held, answered);

    good(&texunit(at, &["trace", "replay", "a.trace", "--set", "texture.format=palette8", "-o", "b.trace"]));
    refused(&texunit(at, &["trace", "memory", "b.trace", "-o", "b"]), &["texture.format", "palette8", "colours"]);
}

#[test]
fn a_texture_file_is_found_beside_the_trace_and_refused_when_it_changed() {
    let folder = folder();
    let at = folder.path();
    image::RgbaImage::from_fn(8, 8, |x, y| image::Rgba([x as u8 * 30, y as u8 * 30, 7, 255]))
        .save(at.join("t.png"))
        .unwrap();
    let (head, _) = SCENE.split_once("pattern").unwrap();
    fs::write(at.join("file.toml"), format!("{head}file = \"t.png\"\n")).unwrap();
    fs::create_dir(at.join("elsewhere")).unwrap();
    for trace in ["a.trace", "elsewhere/a.trace"] {
        good(&texunit(at, &["trace", "record", "file.toml", "-f", "bilinear", "--count", "9", "-o", trace]));
        good(&texunit(&std::env::temp_dir(), &["trace", "verify", at.join(trace).to_str().unwrap()]));
    }
    let text = fs::read_to_string(at.join("a.trace")).unwrap();
    assert!(text.contains("// texture.file = \"t.png\""), "{text}");
    image::RgbaImage::from_pixel(8, 8, image::Rgba([1, 2, 3, 255])).save(at.join("t.png")).unwrap();
    refused(&texunit(at, &["trace", "verify", "a.trace"]), &["a.trace", "texture.digest", "was recorded", "t.png"]);
    image::RgbaImage::new(8, 9).save(at.join("t.png")).unwrap();
    refused(&texunit(at, &["trace", "verify", "a.trace"]), &["texture.size", "8 x 8 were recorded", "8 x 9"]);
    fs::remove_file(at.join("t.png")).unwrap();
    refused(&texunit(at, &["trace", "verify", "a.trace"]), &["texture.file", "t.png", "No such file"]);
}

#[test]
fn traces_that_cannot_be_read_or_written_are_refused() {
    let folder = folder();
    let at = folder.path();
    refused(&texunit(at, &["trace", "verify", "missing.trace"]), &["missing.trace", "No such file", "check the path"]);
    fs::write(at.join("not.trace"), "0 1f40\n").unwrap();
    refused(&texunit(at, &["trace", "replay", "not.trace"]), &["not.trace", "line 1", "no texunit trace"]);
    let lost = ["trace", "record", "small.toml", "-f", "point", "-o", "no/such/folder/a.trace"];
    refused(&texunit(at, &lost), &["no/such/folder/a.trace", "folder"]);
    refused(&texunit(at, &["trace", "record", "nowhere", "-f", "point"]), &["nowhere", "no built-in scene", "floor"]);
    refused(&texunit(at, &["trace", "record", "small.toml", "-f", "cubic"]), &["cubic", "trilinear"]);
    refused(&texunit(at, &["trace", "verify"]), &["TRACE"]);
}
