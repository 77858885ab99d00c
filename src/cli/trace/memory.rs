//! `texunit trace memory`.

use std::{path::PathBuf, process::ExitCode};

use crate::{
    error::{Error, Result},
    output::write_or_print,
    trace::{Player, Trace},
};

/// Write the texture memory that a trace reads, with the table of its planes: with it RTL replays the trace
///
/// Text that `$readmemh` reads, 32 bits a line (docs/trace-format.md). `make -C hw golden` replays the traces of this
/// repository through its RTL.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The trace
    trace: PathBuf,
    /// The memory; `-` for standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let profile = Trace::load(&args.trace)?.profile;
    let format = profile.machine.texture.format;
    if format == texunit_hw::Format::Palette8 {
        let problem = "its colours lie outside the texture memory, and the file has no place for them";
        return Err(Error::setting(
            "machine.texture.format",
            crate::names::Named::name(format),
            problem,
            "record a trace of another format",
        ));
    }
    let player = Player::new(&profile, &args.trace)?;
    write_or_print(&args.output, |file| player.write_memory(&profile, file))?;
    eprintln!("texunit: {} bytes of texture memory written", player.memory_bytes());
    Ok(ExitCode::SUCCESS)
}
