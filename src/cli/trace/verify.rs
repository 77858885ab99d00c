//! `texunit trace verify`.

use std::{path::PathBuf, process::ExitCode};

use crate::{
    error::Result,
    output::print,
    texture_file::TextureImage,
    trace::{Player, Trace, TracedTexture},
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
    // Traces come in families: the computed texture of the one before is often that of the next.
    let mut texture: Option<(TracedTexture, TextureImage)> = None;
    for path in &args.traces {
        let trace = Trace::load(path)?;
        let named = &trace.profile.texture;
        let held = match texture.take().filter(|(known, _)| known == named && named.file.is_none()) {
            Some((_, held)) => held,
            None => named.load(path)?,
        };
        let difference = trace.verify(&Player::with_texture(&trace.profile, &held)?)?;
        texture = Some((named.clone(), held));
        differ |= difference.is_some();
        let name = path.display();
        print(|out| match difference {
            Some(difference) => writeln!(out, "{name}: {difference}"),
            None => writeln!(out, "{name}: {} requests agree", trace.records.len()),
        })?;
    }
    Ok(ExitCode::from(u8::from(differ)))
}
