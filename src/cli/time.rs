//! `texunit time`: how long, and why.

use std::{path::PathBuf, process::ExitCode, sync::atomic::Ordering};

use comfy_table::Table;
use rayon::prelude::*;
use serde_json::json;
use texunit_hw::timing::TimingCounters;

use super::{
    STOP, progress_bar,
    scene_args::{FilterArgs, image_size},
    stop_on_ctrl_c,
};
use crate::{
    error::{Error, Result},
    machine::Machine,
    names::Named,
    output::write_whole,
    report::table::framed,
    scene::Scene,
    timed_run::{Timed, TimedBench},
    timing_output::{Recording, epochs, kanata, memory_trace, perfetto, vcd},
};

/// Time a scene's requests: cycles, stalls by cause, memory traffic, energy (an estimate)
///
/// The clock is that of docs/timing.md. Files of single events (Kanata, Perfetto, VCD) hold the first requests only, see --first, and need a single filter.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene: a name that ships or a TOML file
    scene: String,
    #[command(flatten)]
    filters: FilterArgs,
    /// Image size instead of the scene's own, for instance 640x480
    #[arg(long, value_name = "WxH", value_parser = image_size)]
    size: Option<[u32; 2]>,
    /// Write all counters every N requests as CSV
    #[arg(long, num_args = 2, value_names = ["N", "FILE"])]
    epochs: Option<Vec<String>>,
    /// Write a pipeline log for Konata
    #[arg(long, value_name = "FILE")]
    kanata: Option<PathBuf>,
    /// Write a trace for Perfetto or chrome://tracing
    #[arg(long, value_name = "FILE")]
    perfetto: Option<PathBuf>,
    /// Write a value change dump for GTKWave or Surfer
    #[arg(long, value_name = "FILE")]
    vcd: Option<PathBuf>,
    /// Write every request to memory, for DRAMSim3 or Ramulator 2
    #[arg(long, value_name = "FILE")]
    memory_trace: Option<PathBuf>,
    /// Format of the memory trace
    #[arg(long, value_enum, default_value = "dramsim3")]
    memory_trace_format: memory_trace::Format,
    /// Bytes one line of the memory trace moves in the program that reads it, a power of two, for instance 64: longer blocks become several lines [default: a line a block]
    #[arg(long, value_name = "BYTES")]
    memory_trace_bytes: Option<u32>,
    /// Requests whose events are written
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    first: u64,
    /// Print every counter as JSON instead of the table
    #[arg(long)]
    json: bool,
    /// Print the definition of every counter and exit
    #[arg(long)]
    definitions: bool,
    #[command(flatten)]
    machine: super::MachineArgs,
}

/// Runs the command.
///
/// # Errors
/// Bad scenes, machines or files.
pub fn run(args: &Args) -> Result<ExitCode> {
    if args.definitions {
        for (name, definition) in TimingCounters::FIELDS {
            say!("{name}:{definition}");
        }
        return Ok(ExitCode::SUCCESS);
    }
    let machine = args.machine.load()?;
    let mut scene = Scene::find(&args.scene)?;
    if let Some(size) = args.size {
        scene.size = size;
    }
    let filters = args.filters.filters();
    let files = [&args.kanata, &args.perfetto, &args.vcd, &args.memory_trace];
    let events = files.iter().any(|file| file.is_some());
    if filters.len() > 1 && (events || args.epochs.is_some()) {
        return Err(Error::setting(
            "--filter",
            filters.len(),
            "files of events hold one filter",
            "name one, for instance --filter trilinear",
        ));
    }
    if let Some(bytes) = args.memory_trace_bytes.filter(|bytes| !bytes.is_power_of_two()) {
        return Err(Error::setting("--memory-trace-bytes", bytes, "not a power of two", "64 for most memories"));
    }
    let epoch = epoch_length(args)?;
    let bench = TimedBench::new(&scene, &machine, &filters)?;
    stop_on_ctrl_c();
    let progress = progress_bar(filters.len() as u64 * scene.coverage().covered);
    progress.set_message("requests");
    let go_on = |requests| {
        progress.inc(requests);
        !STOP.load(Ordering::Relaxed)
    };
    let time = |filter| {
        let timed = if events {
            let recording = Recording::new(args.first, args.memory_trace.is_some());
            let (timed, recording) = bench.time_while(filter, epoch, recording, &go_on)?;
            write_events(args, &machine, &recording)?;
            timed
        } else {
            bench.time_while(filter, epoch, (), &go_on)?.0
        };
        if let Some([_, file]) = args.epochs.as_deref() {
            write_whole(file.as_ref(), |writer| epochs::write(writer, &timed.epochs))?;
        }
        Ok((!STOP.load(Ordering::Relaxed)).then_some(timed))
    };
    let timed: Vec<Option<Timed>> = filters.par_iter().map(|&filter| time(filter)).collect::<Result<_>>()?;
    progress.finish_and_clear();
    // Files of events and epochs hold what a filter came to; the table only filters that were finished.
    let all: Vec<Timed> = timed.into_iter().flatten().collect();
    if args.json {
        let filters: Vec<_> = all.iter().map(Timed::json).collect();
        say!("{:#}", json!({ "scene": scene.name, "machine": machine, "filters": filters }));
    } else {
        say!("{} on {}: {}", scene.name, machine.name, machine.description);
        say!("{}", table(&all));
        say!("energy is an estimate: {}", machine.energy.source);
    }
    if all.len() < filters.len() {
        eprintln!("texunit: interrupted; filters that were not finished are left out");
        return Ok(ExitCode::from(2));
    }
    Ok(ExitCode::SUCCESS)
}

fn epoch_length(args: &Args) -> Result<Option<usize>> {
    let Some([length, _]) = args.epochs.as_deref() else { return Ok(None) };
    match length.parse() {
        Ok(requests) if requests > 0 => Ok(Some(requests)),
        _ => {
            Err(Error::setting("--epochs", length, "not a number of requests", "for instance --epochs 4096 epochs.csv"))
        }
    }
}

fn write_events(args: &Args, machine: &Machine, recording: &Recording) -> Result<()> {
    if let Some(path) = &args.kanata {
        write_whole(path, |writer| kanata::write(writer, recording))?;
    }
    if let Some(path) = &args.perfetto {
        write_whole(path, |writer| perfetto::write(writer, recording))?;
    }
    if let Some(path) = &args.vcd {
        write_whole(path, |writer| vcd::write(writer, recording))?;
    }
    if let Some(path) = &args.memory_trace {
        let second = &machine.memory.second_level;
        let block = if second.enabled { second.line } else { machine.cache.line };
        let bytes = args.memory_trace_bytes.unwrap_or(block);
        let format = args.memory_trace_format;
        write_whole(path, |writer| memory_trace::write(writer, recording, block, bytes, format))?;
    }
    Ok(())
}

/// One row a filter.
fn table(all: &[Timed]) -> Table {
    let header = [
        "filter",
        "cycles/px",
        "taps/px",
        "miss %",
        "bytes/px",
        "address %",
        "fetch %",
        "wait-read %",
        "ready-read %",
        "row hit %",
        "latency",
        "pJ/px",
    ];
    let mut table = framed(header, 1..);
    for timed in all {
        let c = &timed.counters;
        let per = |value: u64, whole: u64| value as f64 / whole.max(1) as f64;
        let percent = |clocks: u64| format!("{:.1}", 100.0 * per(clocks, c.cycles));
        let rows = c.row_hits + c.row_misses + c.row_conflicts;
        table.add_row([
            timed.filter.name().to_owned(),
            format!("{:.3}", timed.cycles_per_request()),
            format!("{:.2}", per(c.taps, c.requests)),
            format!("{:.2}", 100.0 * per(c.fetches_failed, c.reads)),
            format!("{:.1}", per(c.memory_bytes, c.requests)),
            percent(c.stall_address),
            percent(c.stall_fetch),
            percent(c.stall_wait_read),
            percent(c.stall_ready_read),
            if rows == 0 { "-".into() } else { format!("{:.1}", 100.0 * per(c.row_hits, rows)) },
            format!("{:.0}", per(c.request_latency_sum, c.requests)),
            format!("{:.0}", timed.energy.total() / c.requests.max(1) as f64),
        ]);
    }
    table
}
