//! The command line: one file per subcommand, each with its `Args` and its `run`.

/// `println!` for functions that can fail: a full disk behind standard output is an error, not a panic, and a reader gone away is none.
macro_rules! say {
    ($($part:tt)*) => {{
        let line = format!($($part)*);
        $crate::output::print(|out| writeln!(out, "{line}"))?
    }};
}

mod budget;
mod cache;
mod conform;
mod drift;
mod explain;
mod frames;
mod kernels;
mod lod;
mod mips;
mod needs;
mod paper;
mod pareto;
mod peers;
mod prove;
mod report;
mod reuse;
mod run;
mod sample;
mod scene_args;
mod scenes;
mod stream;
mod stress;
mod sweep;
mod time;
mod trace;
mod verify;

use std::{
    process::ExitCode,
    sync::atomic::{AtomicBool, Ordering},
};

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};

use crate::{error::Result, machine::Machine};

/// The golden model of a GPU texture unit: exact texels, hits and misses, and bytes.
#[derive(Debug, Parser)]
#[command(name = "texunit", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Budget(budget::Args),
    Cache(cache::Args),
    Conform(conform::Args),
    Drift(drift::Args),
    Explain(explain::Args),
    Frames(frames::Args),
    Kernels(kernels::Args),
    Lod(lod::Args),
    Mips(mips::Args),
    Needs(Box<needs::Args>),
    Paper(paper::Args),
    Pareto(pareto::Args),
    Peers(peers::Args),
    Prove(prove::Args),
    Report(report::Args),
    Reuse(reuse::Args),
    Run(run::Args),
    Sample(sample::Args),
    Scenes(scenes::Args),
    Stream(stream::Args),
    Stress(stress::Args),
    Sweep(sweep::Args),
    Time(Box<time::Args>),
    Trace(trace::Args),
    Verify(verify::Args),
}

/// Which machine, for every command that runs one.
#[derive(Debug, clap::Args)]
struct MachineArgs {
    /// Machine: a name that ships (`texunit explain` lists them) or a TOML file
    #[arg(long, short, value_name = "NAME|FILE", default_value = Self::DEFAULT)]
    machine: String,
    /// One setting on top of the machine, for instance cache.ways=8; may be given more than once
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl MachineArgs {
    /// The machine of those who do not care.
    const DEFAULT: &str = "herf-12.20";

    fn load(&self) -> Result<Machine> {
        Machine::load(&self.machine, &self.set)
    }
}

/// Set by Ctrl-C: what is finished is kept, what is not begun stays so.
static STOP: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C sets [`STOP`].
fn stop_on_ctrl_c() {
    let _ = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed));
}

/// A bar on standard error, if that is a terminal, with an estimate of the time left.
fn progress_bar(length: u64) -> ProgressBar {
    ProgressBar::new(length).with_style(
        ProgressStyle::with_template("{bar:24} {pos}/{len} {msg} (about {eta} left)")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    )
}

/// Exit status: 0 good, 1 a mismatch was found, 2 bad use or bad input.
#[must_use]
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let outcome: Result<ExitCode> = match cli.command {
        Command::Budget(args) => budget::run(&args),
        Command::Cache(args) => cache::run(args),
        Command::Conform(args) => conform::run(&args),
        Command::Drift(args) => drift::run(args),
        Command::Explain(args) => explain::run(&args),
        Command::Frames(args) => frames::run(&args),
        Command::Kernels(args) => kernels::run(args),
        Command::Lod(args) => lod::run(&args),
        Command::Mips(args) => mips::run(args),
        Command::Needs(args) => needs::run(&args),
        Command::Paper(args) => paper::run(&args),
        Command::Pareto(args) => pareto::run(&args),
        Command::Peers(args) => peers::run(&args),
        Command::Prove(args) => prove::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Reuse(args) => reuse::run(&args),
        Command::Run(args) => run::run(&args),
        Command::Sample(args) => sample::run(&args),
        Command::Scenes(args) => scenes::run(args),
        Command::Stream(args) => stream::run(&args),
        Command::Stress(args) => stress::run(&args),
        Command::Sweep(args) => sweep::run(&args),
        Command::Time(args) => time::run(&args),
        Command::Trace(args) => trace::run(&args),
        Command::Verify(args) => verify::run(&args),
    };
    outcome.unwrap_or_else(|error| {
        eprintln!("texunit: error: {error}");
        ExitCode::from(2)
    })
}
