//! `texunit trace replay`.

use std::{path::PathBuf, process::ExitCode};

use crate::{
    error::Result,
    output::write_or_print,
    trace::{Player, Totals, Trace},
};

/// Ask the chip what a trace asked, and write its answers as a trace
///
/// With --set the requests go to another machine. Tells on standard error how many answers differ from those recorded; exit
/// status 0 either way (`texunit trace verify` judges).
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The trace
    trace: PathBuf,
    /// One setting on top of the machine in the trace, for instance cache.ways=8; may be given more than once
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// The trace of the new answers; `-` for standard output
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let recorded = Trace::load(&args.trace)?;
    let mut replayed = recorded.clone();
    replayed.profile.machine = recorded.profile.machine.with_settings(&args.set)?;
    let player = Player::new(&replayed.profile, &args.trace)?;
    let requests: Vec<_> = recorded.records.iter().map(|record| record.request).collect();
    replayed.records = player.chip(&requests)?;
    replayed.model = env!("CARGO_PKG_VERSION").into();
    write_or_print(&args.output, |file| replayed.write(file))?;
    let [before, now] = [&recorded, &replayed].map(|trace| Totals::of(&trace.records));
    eprintln!(
        "texunit: {} requests replayed, {} reads, {} misses (recorded: {} reads, {} misses); {} records differ",
        requests.len(),
        now.reads,
        now.misses,
        before.reads,
        before.misses,
        recorded.differing(&replayed.records)
    );
    Ok(ExitCode::SUCCESS)
}
