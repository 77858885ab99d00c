//! `texunit explain`: the machine, resolved, and what follows from it.

use std::{io::Write, process::ExitCode};

use texunit_hw::{PyramidKind, Surface};

use crate::{
    cli::MachineArgs,
    error::{Error, Result},
    machine::{Machine, PROFILES},
    names::{Named, layout_name},
    output::print,
};

/// Print a machine with every key, and what follows from it
///
/// The answer is itself a machine file: what follows from the keys stands in comments. To make a machine of your own, write it to
/// a file, change it, and give the file to --machine.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Machine: a name that ships or a TOML file
    #[arg(default_value = MachineArgs::DEFAULT)]
    machine: String,
    /// One setting on top of the machine, for instance cache.ways=8; may be given more than once
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Only the names of the machines that ship, one a line
    #[arg(long, conflicts_with_all = ["machine", "set"])]
    list: bool,
}

/// Bits of a coordinate below the point.
const COORDINATE_BITS: u32 = 20;

/// Runs the command.
///
/// # Errors
/// A machine that cannot be built.
pub fn run(args: &Args) -> Result<ExitCode> {
    if args.list {
        print(|out| PROFILES.iter().try_for_each(|(name, _)| writeln!(out, "{name}")))?;
        return Ok(ExitCode::SUCCESS);
    }
    let machine = Machine::load(&args.machine, &args.set)?;
    let keys = toml::to_string(&machine)
        .map_err(|error| Error::setting("machine", &args.machine, error.to_string(), "no TOML can say it"))?;
    print(|out| {
        write!(out, "{keys}")?;
        cache(out, &machine)?;
        precision(out, &machine)?;
        memory(out, &machine)?;
        let names: Vec<_> = PROFILES.iter().map(|(name, _)| *name).collect();
        writeln!(out, "\n# Machines that ship: {}", names.join(", "))
    })?;
    Ok(ExitCode::SUCCESS)
}

fn cache(out: &mut dyn Write, machine: &Machine) -> std::io::Result<()> {
    let geometry = machine.cache.geometry();
    let (bytes, lines) = (geometry.size_bytes(), geometry.lines());
    writeln!(out, "\n# Cache: {lines} lines, {bytes} bytes, {} replacement", machine.cache.policy)?;
    let texture = &machine.texture;
    // Large enough for every tile of a usual layout.
    let Ok(surface) = Surface::new(PyramidKind::Mipmap, texture.layout, texture.format, 1024, 1024) else {
        return Ok(());
    };
    let plane = &surface.planes[0];
    // Layouts are separable: what shares a line with texel (0, 0) is a rectangle.
    let [width, height] = [0, 1].map(|axis| {
        let start = plane.base % u64::from(geometry.line);
        (0..1024).take_while(|&index| start + plane.offset(axis, index) < u64::from(geometry.line)).count()
    });
    let layout = layout_name(texture.layout);
    match surface.reads_per_texel() {
        1 => {
            writeln!(out, "# Layout {layout}: a line holds {width} x {height} texels of one plane, a texel is one read")
        }
        reads => writeln!(
            out,
            "# Layout {layout}: a line holds one channel of {width} x {height} texels, a texel is {reads} reads"
        ),
    }
}

fn precision(out: &mut dyn Write, machine: &Machine) -> std::io::Result<()> {
    let wanted = u32::from(machine.filter.bits);
    writeln!(out, "\n# Coordinates: 12.20, one repeat of the texture is 1.0; {wanted} bits select between two texels")?;
    writeln!(out, "#   texels on a side   bits below the texel   of {wanted} filter bits there are")?;
    for log2 in 8..=16 {
        let below = COORDINATE_BITS - log2;
        writeln!(out, "#   {:16}   {below:20}   {}", 1u32 << log2, below.min(wanted))?;
    }
    let lod = &machine.lod;
    writeln!(
        out,
        "# Levels: {} log2 unit, steps of 1/{}, biased by {}, kept within {} to {}",
        lod.log2.name(),
        1u32 << lod.bits,
        lod.bias,
        lod.min,
        lod.max
    )
}

fn memory(out: &mut dyn Write, machine: &Machine) -> std::io::Result<()> {
    let texture = &machine.texture;
    writeln!(out, "\n# Memory of a 1024 x 1024 texture, padding included:")?;
    for (name, kind) in PyramidKind::ALL {
        match Surface::new(*kind, texture.layout, texture.format, 1024, 1024) {
            Ok(surface) => {
                let (planes, bytes) = (surface.planes.len(), surface.bytes);
                let top = 1024.0 * 1024.0 * f64::from(texture.format.element_bytes());
                writeln!(
                    out,
                    "#   {name:8} {planes:4} planes {bytes:10} bytes, {:.4} x the texture",
                    bytes as f64 / top
                )?;
            }
            Err(error) => writeln!(out, "#   {name:8} none: {error}")?,
        }
    }
    Ok(())
}
