//! `texunit cache`: the cache alone on anyone's address trace.

use std::{
    fs,
    io::{ErrorKind, Write, stdout},
    path::{Path, PathBuf},
    process::ExitCode,
    time::{Duration, Instant},
};

use comfy_table::{CellAlignment, Table, presets};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use texunit_hw::cache::{Cache, Geometry, GeometryError, MissClassifier, Policy};

use crate::{
    address_trace::{AddressFormat, AddressTrace},
    error::{Error, Result},
    machine::policy_from_name,
};

/// Count the hits and misses of one cache on an address trace.
///
/// Every address is one access to the line that holds its byte. Misses are compulsory (the first reference to the line),
/// capacity (a fully associative LRU cache with as many lines misses too) or conflict (the rest).
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The trace; `-` is standard input
    trace: PathBuf,
    /// Number of sets, a power of two or not
    #[arg(long)]
    sets: u32,
    /// Lines per set, a power of two or not
    #[arg(long)]
    ways: u32,
    /// Bytes per line, a power of two up to 4096
    #[arg(long)]
    line: u32,
    /// Which line a full set gives up
    #[arg(long, default_value = "lru", value_parser = ["lru", "fifo", "plru", "random"])]
    policy: String,
    /// Seed of the random policy
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// How addresses are written [default: by the file's extension: .din, .u32, or else u64]
    #[arg(long, value_enum)]
    format: Option<AddressFormat>,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// A cache that cannot be built; a trace that cannot be read or is damaged.
pub fn run(args: Args) -> Result<ExitCode> {
    let geometry = Geometry { sets: args.sets, ways: args.ways, line: args.line };
    let policy = policy_from_name(&args.policy, args.seed)
        .map_err(|problem| Error::setting("--policy", &args.policy, problem, "see texunit cache --help"))?;
    let mut cache = Cache::new(geometry, policy).map_err(refused)?;
    let mut classifier = MissClassifier::new(geometry).map_err(refused)?;

    let mut trace = AddressTrace::open(&args.trace, args.format)?;
    let mut progress = Progress::new(&args.trace);
    let mut addresses = Vec::new();
    while trace.next_block(&mut addresses)? {
        cache.access_all(&addresses, &mut classifier);
        progress.at(trace.position());
    }
    progress.finish();

    let answer = if args.json { as_json(&cache, &classifier) } else { as_table(&cache, &classifier) };
    match writeln!(stdout(), "{answer}").and_then(|()| stdout().flush()) {
        // Whoever read our output had enough of it.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(ExitCode::SUCCESS),
        Err(error) => Err(Error::io("standard output")(error)),
        Ok(()) => Ok(ExitCode::SUCCESS),
    }
}

fn refused(error: GeometryError) -> Error {
    Error::setting(format!("--{}", error.key), error.value, error.problem, error.remedy)
}

fn miss_rate(cache: &Cache) -> f64 {
    if cache.lookups() == 0 { 0.0 } else { cache.misses() as f64 / cache.lookups() as f64 }
}

fn as_json(cache: &Cache, classifier: &MissClassifier) -> String {
    let (geometry, classes) = (cache.geometry(), classifier.classes());
    let mut answer = json!({
        "accesses": cache.lookups(),
        "hits": cache.lookups() - cache.misses(),
        "misses": cache.misses(),
        "compulsory": classes.compulsory,
        "capacity": classes.capacity,
        "conflict": classes.conflict,
        "miss_rate": miss_rate(cache),
        "evictions": cache.evictions(),
        "bytes_fetched": cache.misses() * u64::from(geometry.line),
        "sets": geometry.sets,
        "ways": geometry.ways,
        "line": geometry.line,
        "size_bytes": geometry.size_bytes(),
        "policy": cache.policy().name(),
    });
    if let Policy::Random { seed } = cache.policy() {
        answer["seed"] = seed.into();
    }
    format!("{answer:#}")
}

fn as_table(cache: &Cache, classifier: &MissClassifier) -> String {
    let (geometry, classes) = (cache.geometry(), classifier.classes());
    let Geometry { sets, ways, line } = geometry;
    let share = |part: u64| match cache.lookups() {
        0 => String::new(),
        lookups => format!("{:.4} %", 100.0 * part as f64 / lookups as f64),
    };
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY).set_header(["", "count", "of accesses"]);
    let rows = [
        ("accesses", cache.lookups()),
        ("hits", cache.lookups() - cache.misses()),
        ("misses", cache.misses()),
        ("  compulsory", classes.compulsory),
        ("  capacity", classes.capacity),
        ("  conflict", classes.conflict),
    ];
    for (name, count) in rows {
        table.add_row([name.into(), count.to_string(), share(count)]);
    }
    table.add_row(["evictions".into(), cache.evictions().to_string(), String::new()]);
    table.add_row(["bytes fetched".into(), (cache.misses() * u64::from(line)).to_string(), String::new()]);
    table.column_iter_mut().skip(1).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    let bytes = geometry.size_bytes();
    format!("{sets} sets x {ways} ways x {line} bytes = {bytes} bytes, {}\n{table}", cache.policy().name())
}

/// A bar on standard error for what takes longer than two seconds.
struct Progress {
    start: Instant,
    total: u64,
    bar: Option<ProgressBar>,
}

impl Progress {
    fn new(trace: &Path) -> Self {
        let total = fs::metadata(trace).map_or(0, |metadata| metadata.len());
        Self { start: Instant::now(), total, bar: None }
    }

    fn at(&mut self, position: u64) {
        if self.bar.is_none() && self.start.elapsed() > Duration::from_secs(2) {
            let (bar, template) = match self.total {
                0 => (ProgressBar::new_spinner(), "{spinner} {bytes} read, {bytes_per_sec}"),
                total => (ProgressBar::new(total), "{wide_bar} {bytes} of {total_bytes}, {eta} left"),
            };
            self.bar =
                Some(bar.with_style(ProgressStyle::with_template(template).unwrap_or(ProgressStyle::default_bar())));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(position);
        }
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
