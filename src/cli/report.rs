//! `texunit report`: one page from the results of other commands.

use std::{path::PathBuf, process::ExitCode};

use crate::{
    error::Result,
    output::write_whole,
    report::page::{Images, Results, page},
};

/// Make one HTML page, needing nothing else, of folders that run, pareto, reuse, frames, stress and sweep wrote
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folders of results
    #[arg(value_name = "DIR", required = true)]
    folders: Vec<PathBuf>,
    /// The page
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    output: PathBuf,
    /// Its title
    #[arg(long, default_value = "Texture unit report")]
    title: String,
    /// Embed images exactly, as PNG, instead of as JPEG of a fifth of the size
    #[arg(long)]
    exact_images: bool,
}

/// Runs the command.
///
/// # Errors
/// Folders without results, damaged results, a page that cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    let format = if args.exact_images { Images::Png } else { Images::Jpeg };
    let results = args.folders.iter().map(|folder| Results::read(folder, format)).collect::<Result<Vec<_>>>()?;
    let text = page(&args.title, &results);
    write_whole(&args.output, |file| file.write_all(text.as_bytes()))?;
    say!("{}", args.output.display());
    Ok(ExitCode::SUCCESS)
}
