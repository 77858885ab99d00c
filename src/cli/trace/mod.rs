//! `texunit trace`: golden traces of requests and answers.

mod export;
mod memory;
mod record;
mod replay;
mod verify;

use std::process::ExitCode;

use crate::{error::Result, trace::Selection};

/// Record what the machine answers, replay it, verify it, and export addresses and memory
///
/// A trace is text: a head that says everything an answer depends on, then a request with its answer, reads and misses a line
/// (docs/trace-format.md). `$readmemh` reads it as it is.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    Record(record::Args),
    Replay(replay::Args),
    Verify(verify::Args),
    Export(export::Args),
    Memory(memory::Args),
}

/// Which of a scene's fragments become requests.
#[derive(Debug, clap::Args)]
struct SelectionArgs {
    /// This many requests, spread over the whole scene
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 28))]
    count: Option<u64>,
    /// Every K-th request of the scene
    #[arg(long, value_name = "K", conflicts_with = "count", value_parser = clap::value_parser!(u64).range(1..))]
    every: Option<u64>,
    /// Seed of the choice that --count makes
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl SelectionArgs {
    fn selection(&self, default: Selection) -> Selection {
        self.count.map(Selection::Count).or(self.every.map(Selection::Every)).unwrap_or(default)
    }
}

/// Runs the command.
///
/// # Errors
/// Bad scenes, machines, traces or files.
pub fn run(args: &Args) -> Result<ExitCode> {
    match &args.action {
        Action::Record(args) => record::run(args),
        Action::Replay(args) => replay::run(args),
        Action::Verify(args) => verify::run(args),
        Action::Export(args) => export::run(args),
        Action::Memory(args) => memory::run(args),
    }
}
