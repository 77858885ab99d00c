//! `texunit trace record`.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use texunit_hw::{AddressMode, Filter};

use crate::{
    cli::MachineArgs,
    error::Result,
    machine::parser,
    output::write_or_print,
    scene::Scene,
    trace::{self, Profile, Selection, Totals},
};

/// Record requests of a scene with the answers of the chip
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene: the name of one that ships (`texunit scenes` lists them) or a TOML file
    scene: String,
    /// Filter: point, bilinear, nearest-mip, trilinear, dipmap, ...
    #[arg(long, short, value_parser = parser::<Filter>())]
    filter: Filter,
    /// Address mode of both axes instead of the scene's: wrap, clamp, clip, mirror
    #[arg(long, value_parser = parser::<AddressMode>())]
    wrap: Option<AddressMode>,
    /// Address mode of the v axis, where it differs
    #[arg(long, value_parser = parser::<AddressMode>())]
    wrap_v: Option<AddressMode>,
    #[command(flatten)]
    selection: super::SelectionArgs,
    /// The trace; `-` for standard output
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    #[command(flatten)]
    machine: MachineArgs,
}

/// Requests of a trace that nobody gave a number for: 30 kB of text.
const DEFAULT_COUNT: u64 = 256;

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    let scene = Scene::find(&args.scene)?;
    let [wrap_u, wrap_v] = scene.texture.wrap;
    let wrap_u = args.wrap.unwrap_or(wrap_u);
    let wrap = [wrap_u, args.wrap_v.or(args.wrap).unwrap_or(wrap_v)];
    let folder = args.output.parent().unwrap_or(Path::new(""));
    let texture = scene.texture.texture_image();
    let profile = Profile::of_scene(&scene, &texture, &machine, args.filter, wrap, folder)?;
    let selection = args.selection.selection(Selection::Count(DEFAULT_COUNT));
    let trace = trace::record(&scene, &texture, profile, selection, args.selection.seed)?;
    write_or_print(&args.output, |file| trace.write(file))?;
    let Totals { reads, misses } = Totals::of(&trace.records);
    eprintln!("texunit: {} requests recorded, {reads} reads, {misses} misses", trace.records.len());
    Ok(ExitCode::SUCCESS)
}
