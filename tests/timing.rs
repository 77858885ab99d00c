//! Time as a user sees it: the machines that ship, their files of events, and refusals.

use std::collections::BTreeMap;

use texunit::{
    experiment::{Bench, Outcome, Pyramids, Stage},
    machine::{Machine, PROFILES},
    scene::Scene,
    timed_run::{Timed, TimedBench},
    timing_output::{Recording, epochs, kanata, memory_trace, perfetto, vcd},
};
use texunit_hw::{Filter, timing::TimingCounters};

fn small_floor() -> Scene {
    let mut scene = Scene::find("floor").unwrap();
    scene.size = [40, 30];
    scene
}

fn record(machine: &Machine, filter: Filter) -> (Timed, Recording) {
    let scene = small_floor();
    let bench = TimedBench::new(&scene, machine, &[filter]).unwrap();
    bench.time(filter, Some(100), Recording::new(u64::MAX, true)).unwrap()
}

fn written(write: impl FnOnce(&mut dyn std::io::Write) -> std::io::Result<()>) -> String {
    let mut bytes = Vec::new();
    write(&mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

#[test]
fn every_machine_that_ships_runs_and_every_clock_of_it_is_accounted_for() {
    for (name, _) in PROFILES {
        let machine = Machine::load(name, &[]).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(machine.name, *name);
        let (timed, recording) = record(&machine, Filter::Trilinear);
        let c = &timed.counters;
        assert_eq!(c.requests, recording.requests.len() as u64);
        assert_eq!(c.taps, 2 * c.requests, "{name}");
        assert_eq!(c.data_busy + c.data_idle + c.data_stall_fill + c.data_stall_result_fifo, c.cycles);
        assert_eq!(recording.requests.last().map(|last| last.result + 1), Some(c.cycles));
        assert!(timed.energy.total() > 0.0);
    }
}

#[test]
fn a_machine_that_would_hang_is_refused_with_the_reason() {
    let message = Machine::load("herf-12.20", &["timing.reorder-buffer=3".into()]).unwrap_err().to_string();
    assert!(message.contains("timing.reorder-buffer = 3: deadlock"), "{message}");
    assert!(message.contains("use at least 4"), "{message}");
    for setting in ["timing.tag-ports=0", "timing.data-bank-bytes=2", "memory.bytes-per-clock=0", "energy.add=-1"] {
        let key = setting.split('=').next().unwrap();
        let message = Machine::load("herf-12.20", &[setting.into()]).unwrap_err().to_string();
        assert!(message.contains(key), "{message}");
    }
    let dram = ["memory.kind=dram".into(), "memory.dram.interleave=32".into()];
    assert!(Machine::load("herf-12.20", &dram).unwrap_err().to_string().contains("memory.dram.interleave = 32"));
}

#[test]
fn epochs_add_up_to_the_run() {
    let (timed, _) = record(&Machine::load("mobile", &[]).unwrap(), Filter::Bilinear);
    let text = written(|writer| epochs::write(writer, &timed.epochs));
    let mut csv = csv::Reader::from_reader(text.as_bytes());
    let names: Vec<String> = csv.headers().unwrap().iter().map(str::to_owned).collect();
    let rows: Vec<Vec<i64>> =
        csv.records().map(|row| row.unwrap().iter().map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), timed.epochs.len());
    assert!(rows.len() > 3);
    for (column, ((name, _), total)) in TimingCounters::FIELDS.iter().zip(timed.counters.values()).enumerate() {
        assert_eq!(names[column + 1], *name);
        if !name.ends_with("_max") && !name.ends_with("_min") {
            assert_eq!(rows.iter().map(|row| row[column + 1]).sum::<i64>(), total as i64, "{name}");
        }
    }
}

#[test]
fn the_kanata_log_starts_ends_and_retires_every_tap_once_and_never_goes_back() {
    let (timed, recording) = record(&Machine::load("igehy-1998", &[]).unwrap(), Filter::Trilinear);
    let log = written(|writer| kanata::write(writer, &recording));
    let mut lines = log.lines();
    assert_eq!(lines.next(), Some("Kanata\t0004"));
    assert!(lines.next().unwrap().starts_with("C=\t"));
    let (mut clock, mut open) = (0u64, BTreeMap::new());
    let (mut begun, mut retired) = (0u64, 0u64);
    for line in lines {
        let fields: Vec<&str> = line.split('\t').collect();
        match fields[0] {
            "C" => {
                let step: u64 = fields[1].parse().unwrap();
                assert!(step > 0);
                clock += step;
            }
            "I" => begun += 1,
            "L" => {}
            "S" => assert!(open.insert((fields[1], fields[2]), fields[3]).is_none(), "{line}"),
            "E" => assert_eq!(open.remove(&(fields[1], fields[2])), Some(fields[3]), "{line}"),
            "R" => retired += 1,
            other => panic!("{other}"),
        }
    }
    assert!(open.is_empty(), "{open:?}");
    assert_eq!((begun, retired), (timed.counters.taps, timed.counters.taps));
    assert_eq!(clock, timed.counters.cycles);
}

#[test]
fn the_perfetto_trace_is_json_in_which_every_span_ends_and_counters_return_to_zero() {
    let (timed, recording) = record(&Machine::load("herf-12.20", &[]).unwrap(), Filter::Trilinear);
    let trace: serde_json::Value =
        serde_json::from_str(&written(|writer| perfetto::write(writer, &recording))).unwrap();
    let (mut depth, mut last) = (BTreeMap::new(), BTreeMap::new());
    for event in trace["traceEvents"].as_array().unwrap() {
        let key = || (event["cat"].to_string(), event["id2"]["local"].as_str().unwrap().to_owned());
        match event["ph"].as_str().unwrap() {
            "b" => *depth.entry(key()).or_insert(0) += 1,
            "e" => *depth.entry(key()).or_insert(0) -= 1,
            "C" => drop(last.insert(event["name"].to_string(), event["args"]["value"].as_i64().unwrap())),
            _ => {}
        }
    }
    assert!(depth.values().all(|depth| *depth == 0));
    assert_eq!(depth.len() as u64, timed.counters.taps + timed.counters.fills);
    assert!(last.len() == 3 && last.values().all(|value| *value == 0), "{last:?}");
}

#[test]
fn the_perfetto_trace_names_spans_alike_so_that_they_share_a_track_and_numbers_them_in_order() {
    let (timed, recording) = record(&Machine::load("herf-12.20", &[]).unwrap(), Filter::Trilinear);
    let trace: serde_json::Value =
        serde_json::from_str(&written(|writer| perfetto::write(writer, &recording))).unwrap();
    let mut spans: BTreeMap<&str, u64> = BTreeMap::new();
    let mut taps = 0;
    for event in trace["traceEvents"].as_array().unwrap().iter().filter(|event| event["ph"] == "b") {
        *spans.entry(event["name"].as_str().unwrap()).or_default() += 1;
        if event["name"] == "tap" {
            assert_eq!(event["args"]["tap"], taps);
            assert_eq!(event["args"]["request"], taps / 2, "a trilinear request is two taps");
            taps += 1;
        }
        if event["name"] == "line" {
            assert!(event["args"]["address"].as_str().unwrap().starts_with("0x"));
        }
    }
    assert_eq!((spans["tap"], spans["line"]), (timed.counters.taps, timed.counters.fills));
    assert!(spans.len() <= 10, "eight stages, taps and lines: {spans:?}");
}

#[test]
fn the_value_change_dump_says_one_thing_of_a_signal_in_a_clock() {
    let (_, recording) = record(&Machine::load("herf-12.20", &[]).unwrap(), Filter::Trilinear);
    let dump = written(|writer| vcd::write(writer, &recording));
    let mut said = std::collections::BTreeSet::new();
    for command in ::vcd::Parser::new(dump.as_bytes()) {
        match command.unwrap() {
            ::vcd::Command::Timestamp(_) => said.clear(),
            ::vcd::Command::ChangeScalar(signal, _) | ::vcd::Command::ChangeVector(signal, _) => {
                assert!(said.insert(signal), "{signal} twice");
            }
            _ => {}
        }
    }
}

#[test]
fn the_value_change_dump_shows_each_unit_busy_as_long_as_it_was() {
    // The second asks memory twice for a line: of 8 x 8 texels, two rows of two blocks.
    let twice = ["texture.layout=tiled-8x8", "texture.format=bc1", "cache.line=256", BEFORE_CACHE];
    for machine in [stored("herf-12.20", &[]), stored("herf-12.20", &twice)] {
        let (timed, recording) = record(&machine, Filter::Trilinear);
        let is_first = machine.cache.line == 64;
        assert_eq!(timed.counters.miss_port_busy == timed.counters.fills, is_first);
        let dump = written(|writer| vcd::write(writer, &recording));
        let mut parser = ::vcd::Parser::new(dump.as_bytes());
        let header = parser.parse_header().unwrap();
        for (unit, busy) in [
            ("entry", timed.counters.entry_busy),
            ("sequencer", timed.counters.sequencer_busy),
            ("miss_port", timed.counters.miss_port_busy),
            ("datapath", timed.counters.datapath_busy),
            ("result", timed.counters.result_busy),
        ] {
            let valid = header.find_var(&["texunit", unit, "valid"]).unwrap().code;
            let (mut clock, mut since, mut clocks) = (0, None, 0);
            for command in ::vcd::Parser::new(dump.as_bytes()) {
                match command.unwrap() {
                    ::vcd::Command::Timestamp(at) => clock = at,
                    ::vcd::Command::ChangeScalar(signal, ::vcd::Value::V1) if signal == valid => {
                        since.get_or_insert(clock);
                    }
                    ::vcd::Command::ChangeScalar(signal, ::vcd::Value::V0) if signal == valid => {
                        clocks += since.take().map_or(0, |since| clock - since);
                    }
                    _ => {}
                }
            }
            assert_eq!((since, clocks), (None, busy), "{unit}");
        }
    }
}

#[test]
fn the_memory_trace_holds_each_request_to_memory_once_in_order() {
    for machine in ["herf-12.20", "desktop"] {
        let machine = Machine::load(machine, &[]).unwrap();
        let (timed, recording) = record(&machine, Filter::Bilinear);
        let trace = written(|writer| memory_trace::write(writer, &recording, 128, 128, memory_trace::Format::Dramsim3));
        let rows: Vec<(u64, u64)> = trace
            .lines()
            .map(|line| {
                let fields: Vec<&str> = line.split(' ').collect();
                assert_eq!(fields[1], "READ");
                (u64::from_str_radix(&fields[0][2..], 16).unwrap(), fields[2].parse().unwrap())
            })
            .collect();
        assert_eq!(rows.len() as u64, timed.counters.memory_requests);
        assert!(rows.windows(2).all(|pair| pair[0].1 < pair[1].1));
        assert!(rows.iter().all(|row| row.0 % 128 == 0));
        let loads =
            written(|writer| memory_trace::write(writer, &recording, 128, 128, memory_trace::Format::Ramulator2));
        assert!(loads.lines().all(|line| line.starts_with("LD 0x")));
        assert_eq!(loads.lines().count(), rows.len());
    }
}

#[test]
fn blocks_longer_than_a_line_of_the_memory_trace_moves_become_several_lines_and_no_byte_is_lost() {
    for (name, block) in [("herf-12.20", 64), ("desktop", 128)] {
        let (timed, recording) = record(&Machine::load(name, &[]).unwrap(), Filter::Bilinear);
        let trace =
            written(|writer| memory_trace::write(writer, &recording, block, 32, memory_trace::Format::Dramsim3));
        let rows: Vec<(u64, &str)> = trace
            .lines()
            .map(|line| {
                let (address, clock) = line.split_once(" READ ").unwrap();
                (u64::from_str_radix(&address[2..], 16).unwrap(), clock)
            })
            .collect();
        assert_eq!(32 * rows.len() as u64, timed.counters.memory_bytes, "{name}");
        for block in rows.chunks(block as usize / 32) {
            assert!(block.windows(2).all(|pair| pair[1] == (pair[0].0 + 32, pair[0].1)), "{name}: {block:?}");
        }
    }
}

/// The machine with textures of blocks in tiles, decompressed before or after the cache.
fn stored(machine: &str, settings: &[&str]) -> Machine {
    let all = ["texture.layout=tiled-4x4"].iter().chain(settings).map(|setting| (*setting).to_owned());
    Machine::load(machine, &all.collect::<Vec<_>>()).unwrap()
}

fn outcome(machine: &Machine, filter: Filter) -> Outcome {
    let stage = Stage::new(Scene { size: [120, 90], ..small_floor() });
    let pyramids = Pyramids::for_filters(machine, &stage.texture, &[filter]).unwrap();
    let (pyramid, memory) = pyramids.of(filter);
    Bench::new(&stage, machine, filter, pyramid, memory).measure(machine).unwrap()
}

const BEFORE_CACHE: &str = "texture.decompress=before-cache";

#[test]
fn a_decompressor_before_the_cache_has_time_move_the_bytes_that_the_cache_counts() {
    let texels = outcome(&stored("herf-12.20", &[]), Filter::Trilinear).timed;
    // A line of 16 texels in a tile of 4 x 4 is one block.
    for (format, bytes_a_line) in [("bc1", 8), ("bc3", 16), ("bc7", 16)] {
        let format = format!("texture.format={format}");
        let before = outcome(&stored("herf-12.20", &[&format, BEFORE_CACHE]), Filter::Trilinear);
        let c = before.timed.counters;
        assert_eq!(c.fills, texels.counters.fills, "{format}: the cache holds the same texels");
        assert!(c.fills > 100 && before.timed.energy.memory < texels.energy.memory / 3.0, "{format}");
        assert_eq!((c.bytes_filled, c.bytes_fetched), (before.counters.bytes_filled, before.counters.bytes_fetched));
        assert_eq!((c.memory_bytes, c.memory_requests), (c.fills * bytes_a_line, c.fills), "{format}");
        assert_eq!(c.decompressor_busy, c.fills, "{format}: a line a clock");
    }
}

#[test]
fn a_line_of_four_blocks_in_a_row_costs_their_bytes_in_one_request_and_a_slow_decompressor_costs_clocks() {
    let bc1 = ["texture.format=bc1", "texture.layout=row-major"];
    let before = outcome(&stored("herf-12.20", &[bc1[0], bc1[1], BEFORE_CACHE]), Filter::Bilinear);
    let c = before.timed.counters;
    assert_eq!(c.bytes_fetched, before.counters.bytes_fetched);
    assert!(c.bytes_fetched > 3 * 8 * c.fills, "{} of {}", c.bytes_fetched, c.fills);
    assert_eq!(c.memory_requests, c.fills, "side by side");
    let slow = ["timing.decompress-texels-per-clock=1", "timing.decompress-latency=9"];
    let slow = outcome(&stored("herf-12.20", &[bc1[0], bc1[1], BEFORE_CACHE, slow[0], slow[1]]), Filter::Bilinear);
    assert_eq!(slow.timed.counters.decompressor_busy, 16 * c.fills);
    assert!(slow.timed.counters.cycles > c.cycles);
    assert_eq!((slow.counters, slow.picture), (before.counters, before.picture));
}

#[test]
fn what_a_decompressor_asks_of_memory_is_in_the_memory_trace() {
    let settings = ["texture.format=bc1", "texture.layout=morton", BEFORE_CACHE];
    // Blocks of 8 bytes from memory; or second-level lines of 128, which take four lines of the file.
    for (name, moves) in [("herf-12.20", 8), ("desktop", 32)] {
        let machine = stored(name, &settings);
        let (timed, recording) = record(&machine, Filter::Trilinear);
        let c = timed.counters;
        let block = machine.memory.second_level.line;
        let trace = written(|writer| {
            memory_trace::write(writer, &recording, block, moves as u32, memory_trace::Format::Dramsim3)
        });
        assert_eq!(trace.lines().count() as u64 * moves, c.memory_bytes, "{name}");
        assert_eq!(recording.stored.len() as u64, c.miss_port_busy, "{name}");
    }
}
