//! The command line: one file per subcommand, each with its `Args` and its `run`.

mod drift;
mod kernels;
mod mips;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::error::Error;

/// The golden model of a GPU texture unit: exact texels, hits and misses, and bytes.
#[derive(Debug, Parser)]
#[command(name = "texunit", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Drift(drift::Args),
    Kernels(kernels::Args),
    Mips(mips::Args),
}

/// Exit status: 0 good, 1 a mismatch was found, 2 bad use or bad input.
#[must_use]
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let outcome: Result<ExitCode, Error> = match cli.command {
        Command::Drift(args) => drift::run(args),
        Command::Kernels(args) => kernels::run(args),
        Command::Mips(args) => mips::run(args),
    };
    outcome.unwrap_or_else(|error| {
        eprintln!("texunit: error: {error}");
        ExitCode::from(2)
    })
}
