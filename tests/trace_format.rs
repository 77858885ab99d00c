//! Reading and writing traces: what is written is read, and what is wrong is refused with its line.

use std::{path::Path, sync::OnceLock};

use proptest::prelude::*;
use texunit::{
    machine::Machine,
    scene::Scene,
    trace::{FIELDS, Profile, Record, Selection, Trace, record},
};
use texunit_hw::Filter;

/// A short trace, as text.
fn text() -> String {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(recorded).clone()
}

fn recorded() -> String {
    let scene = Scene::builtin("magnified").unwrap();
    let machine = Machine::load("herf-12.20", &[]).unwrap();
    let texture = scene.texture.texture_image();
    let profile =
        Profile::of_scene(&scene, &texture, &machine, Filter::Trilinear, scene.texture.wrap, Path::new("")).unwrap();
    let mut text = Vec::new();
    record(&scene, &texture, profile, Selection::Count(4), 1).unwrap().write(&mut text).unwrap();
    String::from_utf8(text).unwrap()
}

fn parse(text: &str) -> Result<Trace, String> {
    Trace::parse("t.trace", text.as_bytes()).map_err(|error| error.to_string())
}

/// The number of the line that begins with some words, from 1.
fn line_of(text: &str, start: &str) -> usize {
    text.lines().position(|line| line.starts_with(start)).unwrap() + 1
}

#[track_caller]
fn refused(text: &str, parts: &[&str]) {
    let message = parse(text).unwrap_err();
    for part in ["t.trace"].iter().chain(parts) {
        assert!(message.contains(part), "no `{part}` in: {message}");
    }
}

#[test]
fn a_written_trace_reads_back_the_same() {
    let text = text();
    let trace = parse(&text).unwrap();
    let mut again = Vec::new();
    trace.write(&mut again).unwrap();
    assert_eq!(String::from_utf8(again).unwrap(), text);
    assert_eq!(trace.line(0), text.lines().count() as u64 - 3);
}

#[test]
fn readmemh_can_read_the_records_as_they_are() {
    // What $readmemh takes: comments, and words of hexadecimal digits and underscores, all of one width.
    let width: u32 = FIELDS.iter().map(|(_, bits)| bits).sum();
    for line in text().lines().filter(|line| !line.starts_with("//")) {
        assert!(line.bytes().all(|byte| byte == b'_' || byte.is_ascii_hexdigit()), "{line}");
        assert_eq!(line.bytes().filter(|byte| *byte != b'_').count() as u32 * 4, width);
    }
}

#[test]
fn windows_line_ends_blank_lines_and_comments_among_records_change_nothing() {
    let text = text();
    let trace = parse(&text).unwrap();
    assert!(parse(&text.replace('\n', "\r\n")).unwrap() == trace);
    let (head, records) = text.split_once("// count 4\n").unwrap();
    let spaced = format!("{head}// count 4\n\n{}\n", records.replace('\n', "\n// a remark\n\n"));
    assert!(parse(&spaced).unwrap() == trace);
}

#[test]
fn a_machine_key_that_is_not_said_has_its_default() {
    let text = text();
    let without: String =
        text.lines().filter(|line| !line.contains("machine.lod.bits")).map(|l| format!("{l}\n")).collect();
    assert!(text.len() > without.len());
    assert!(parse(&without).unwrap() == parse(&text).unwrap());
}

#[test]
fn traces_of_other_versions_and_other_files_are_refused() {
    let text = text();
    refused(&text.replacen("trace 1", "trace 2", 1), &["line 1", "version 2", "update texunit"]);
    refused(&text.replacen("trace 1", "trace 0", 1), &["line 1", "where a trace begins"]);
    refused("", &["line 1", "no texunit trace"]);
    refused("0 1f40\n", &["line 1", "`0 1f40`", "texunit trace record"]);
}

#[test]
fn a_short_and_a_long_trace_are_refused_with_the_line() {
    let text = text();
    let lines = text.lines().count();
    let short: String = text.lines().take(lines - 1).map(|line| format!("{line}\n")).collect();
    refused(&short, &[&format!("line {}", lines - 1), "ends after 3 of 4 records", "cut short"]);
    let head: String = text.lines().take(lines - 4).map(|line| format!("{line}\n")).collect();
    refused(&head, &["ends after 0 of 4 records"]);
    let long = format!("{text}{}\n", text.lines().last().unwrap());
    refused(&long, &[&format!("line {}", lines + 1), "a record after the 4"]);
    // A count is no reason to take memory.
    refused(&text.replace("// count 4", "// count 18446744073709551615"), &["ends after 4 of 18446744073709551615"]);
}

#[test]
fn a_damaged_record_is_refused_with_line_and_field() {
    let text = text();
    let last = text.lines().last().unwrap();
    let place = format!("line {}", text.lines().count());
    let with = |line: &str| text.replace(last, line);
    refused(&with(&last[..last.len() - 1]), &[&place, "misses", "4 hexadecimal digits"]);
    refused(&with(&last.replacen('_', "_g", 1)), &[&place, "v = `g"]);
    refused(&with(&last.replacen('_', "_+", 1)), &[&place, "v = `+"]);
    refused(&with(&last[..last.len() - 5]), &[&place, "14 fields where there should be 15"]);
    refused(&with(&format!("{last}_0000")), &[&place, "16 fields"]);
    refused(&with("what?"), &[&place, "1 fields"]);
}

#[test]
fn a_damaged_head_is_refused_with_the_line() {
    let text = text();
    for key in ["unit", "model", "seed", "fields", "count"] {
        let start = format!("// {key} ");
        let line = text.lines().find(|line| line.starts_with(&start)).unwrap();
        refused(&text.replace(&format!("{line}\n"), ""), &["line ", &format!("did not say `// {key} ...`")]);
        refused(&text.replace(line, &format!("{line}\n{line}")), &[&format!("`{key}` was said on line")]);
    }
    let count = format!("line {}", line_of(&text, "// count"));
    refused(&text.replace("// count 4", "// count four"), &[&count, "count = `four`"]);
    let fields = format!("line {}", line_of(&text, "// fields"));
    refused(&text.replace("u:32 v:32", "u:32 v:64"), &[&fields, "v:64"]);
    refused(&text.replace("// unit texture-unit", "// unit lod"), &["line 2", "`lod`"]);
    refused(&text.replace("// seed", "// sead"), &["sead", "no meaning", "update texunit"]);
    let bits = line_of(&text, "// machine.filter.bits").to_string();
    refused(&text.replace("machine.filter.bits", "machine.filter.bitz"), &["bitz", &bits, "docs/trace-format.md"]);
    refused(
        &text.replace("machine.filter.bits = 8", "machine.filter.bits = 13"),
        &[&bits, "13 is out of range", "1 to 12"],
    );
    refused(&text.replace("machine.filter.bits = 8", "machine.filter.bits = "), &[&bits]);
    refused(&text.replace("machine.cache.ways = 4", "machine.cache.ways = 0"), &["machine.cache.ways", "0 is"]);
    let filter = line_of(&text, "// filter").to_string();
    refused(&text.replace("\"trilinear\"", "\"trilinea\""), &["no filter is named", "nearest-mip", &filter]);
}

#[test]
fn a_texture_that_cannot_be_made_is_refused_before_it_is() {
    let text = text();
    let size = format!("line {}", line_of(&text, "// texture.size"));
    refused(&text.replace("[128, 128]", "[0, 128]"), &[&size, "has 0 in it", "1 to 8192"]);
    refused(&text.replace("[128, 128]", "[128, 4294967295]"), &[&size, "out of range"]);
    refused(&text.replace("texture.cell = 32", "texture.cell = 0"), &["texture.cell", "out of range"]);
    let without: String =
        text.lines().filter(|line| !line.contains("texture.cell")).map(|l| format!("{l}\n")).collect();
    refused(&without, &["texture.cell", "a pattern needs it"]);
    refused(
        &text.replace("texture.pattern = \"natural\"", "texture.file = \"x.png\""),
        &["texture.cell", "patterns only"],
    );
    refused(&text.replace("texture.digest = \"", "texture.digest = \"x"), &["16 hexadecimal digits"]);
}

#[test]
fn a_texture_with_another_digest_is_refused() {
    let text = text();
    let trace = parse(&text.replace("texture.seed = 1", "texture.seed = 2")).unwrap();
    let message = trace.profile.texture.load(Path::new("t.trace")).unwrap_err().to_string();
    for part in ["t.trace", "texture.digest", "was recorded", "record the trace again"] {
        assert!(message.contains(part), "no `{part}` in: {message}");
    }
}

#[test]
fn a_file_that_is_not_text_is_refused() {
    let mut bytes = text().into_bytes();
    *bytes.last_mut().unwrap() = 0xFF;
    let message = Trace::parse("t.trace", bytes.as_slice()).unwrap_err().to_string();
    assert!(message.contains("not text"), "{message}");
    let endless = vec![b'/'; 1 << 20];
    assert!(Trace::parse("t.trace", endless.as_slice()).is_err());
}

proptest! {
    #[test]
    fn every_record_reads_back_the_same(values in any::<[u32; 15]>()) {
        let record = Record::of_values(values);
        prop_assert_eq!(Record::parse(&record.to_string()), Ok(record));
        for ((value, (_, bits)), given) in record.values().into_iter().zip(FIELDS).zip(values) {
            prop_assert_eq!(value, if bits == 16 { given & 0xFFFF } else { given });
        }
    }

    #[test]
    fn no_bytes_make_the_reader_panic(line in 0usize..60, bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
        let text = text();
        let mut lines: Vec<&[u8]> = text.lines().map(str::as_bytes).collect();
        let line = line % lines.len();
        lines[line] = &bytes;
        let _ = Trace::parse("t.trace", lines.join(&b'\n').as_slice());
    }
}
