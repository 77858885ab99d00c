//! `texunit trace export`.

use std::{
    io,
    path::{Path, PathBuf},
    process::ExitCode,
};

use texunit_hw::{Filter, Request};

use crate::{
    address_trace::AddressFormat,
    cli::MachineArgs,
    error::{Error, Result},
    machine::parser,
    output::write_or_print,
    scene::Scene,
    trace::{Player, Profile, Selection, Trace, is_trace},
};

/// Write the byte address of each read of memory, in order of issue: input for `texunit cache` and other simulators
///
/// A scene gives all its requests, a trace those it holds. What lies outside the texture under clip is not read.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene (a name that ships or a TOML file) or trace
    #[arg(value_name = "SCENE|TRACE")]
    source: String,
    /// Filter, for a scene; a trace says its own
    #[arg(long, short, value_parser = parser::<Filter>())]
    filter: Option<Filter>,
    /// How addresses are written [default: by the file's extension: .din, .u32, or else u64]
    #[arg(long, value_enum)]
    format: Option<AddressFormat>,
    #[command(flatten)]
    selection: super::SelectionArgs,
    /// The addresses; `-` for standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    machine: MachineArgs,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let path = Path::new(&args.source);
    if path.is_file() && is_trace(path)? { of_trace(args, path) } else { of_scene(args) }
}

fn of_trace(args: &Args, path: &Path) -> Result<ExitCode> {
    let trace = Trace::load(path)?;
    let fixed = |option: &str, value: &str| {
        Err(Error::setting(option, value, "a trace says its own", format!("leave {option} out")))
    };
    if let Some(setting) = args.machine.set.first() {
        return fixed("--set", setting);
    }
    if args.machine.machine != MachineArgs::DEFAULT {
        return fixed("--machine", &args.machine.machine);
    }
    if args.filter.is_some_and(|filter| filter != trace.profile.filter) {
        let problem = "the requests of a trace were made for its own filter";
        return Err(Error::setting(
            "--filter",
            crate::names::Named::name(args.filter.unwrap_or_default()),
            problem,
            "leave it out",
        ));
    }
    if let Some(count) = args.selection.count.or(args.selection.every) {
        return fixed("--count, --every", &count.to_string());
    }
    let requests: Vec<_> = trace.records.iter().map(|record| record.request).collect();
    let player = Player::new(&trace.profile, path)?;
    write(args, &player, |visit| visit(&requests))
}

fn of_scene(args: &Args) -> Result<ExitCode> {
    let Some(filter) = args.filter else {
        return Err(Error::setting(
            "--filter",
            "",
            "which one a scene is to be filtered with is not said",
            "--filter trilinear",
        ));
    };
    let machine = args.machine.load()?;
    let scene = Scene::find(&args.source)?;
    let texture = scene.texture.texture_image();
    let profile = Profile::of_scene(&scene, &texture, &machine, filter, scene.texture.wrap, Path::new(""))?;
    let player = Player::with_texture(&profile, &texture)?;
    let selection = args.selection.selection(Selection::All);
    write(args, &player, |visit| selection.requests(&scene, &profile, args.selection.seed, visit))
}

/// Writes the addresses of all requests that `each_block` shows its visitor.
fn write(
    args: &Args,
    player: &Player,
    each_block: impl FnOnce(&mut dyn FnMut(&[Request]) -> Result<()>) -> Result<()>,
) -> Result<ExitCode> {
    let format = args.format.unwrap_or_else(|| AddressFormat::of(&args.output));
    if format == AddressFormat::U32 && player.memory_bytes() > 1 << 32 {
        let problem = format!("the texture takes {} bytes, more than 32 bits can address", player.memory_bytes());
        return Err(Error::setting("--format", "u32", problem, "use u64 or din"));
    }
    let mut count = 0u64;
    let mut failed = None;
    write_or_print(&args.output, |out| {
        let mut written = Ok(());
        let blocks = each_block(&mut |requests| {
            player.addresses(requests, |address| {
                count += 1;
                if written.is_ok() {
                    written = format.write(address, out);
                }
            })
        });
        failed = blocks.err();
        if failed.is_some() { Err(io::Error::other("requests")) } else { written }
    })
    .map_err(|error| failed.take().unwrap_or(error))?;
    eprintln!("texunit: {count} addresses written");
    Ok(ExitCode::SUCCESS)
}
