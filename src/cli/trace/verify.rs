//! `texunit trace verify`.

use std::{path::PathBuf, process::ExitCode};

use crate::{
    error::Result,
    output::print,
    trace::{Player, Trace},
};

/// Hold chip, reference and cache to recorded answers, reads and misses
///
/// Exit status: 0 all agree, 1 one differs (the first line, field, and both values of each such trace are printed), 2 bad use.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let mut differ = false;
    for path in &args.traces {
        let trace = Trace::load(path)?;
        let difference = trace.verify(&Player::new(&trace.profile, path)?)?;
        differ |= difference.is_some();
        let name = path.display();
        print(|out| match difference {
            Some(difference) => writeln!(out, "{name}: {difference}"),
            None => writeln!(out, "{name}: {} requests agree", trace.records.len()),
        })?;
    }
    Ok(ExitCode::from(u8::from(differ)))
}
