//! `texunit paper`: Table I of Du & Wan beside ours, with the bytes they never measured.

use std::process::ExitCode;

use comfy_table::Table;
use texunit_hw::Filter;

use crate::{
    error::Result,
    experiment::{Bench, Pyramids, Stage, alias},
    machine::Machine,
    names::Named,
    report::table::plain,
    scene::{AxisRule, Pattern, Scene, TextureSource},
};

/// Measure what the Dipmap paper claims, on scenes like its own
///
/// Six scenes like its figures 8 to 10, its Table I beside ours, and the alias energy. Texels, taps and lerps are per pixel (a lerp per channel: 3 a bilinear tap, 1 less than taps to join them). Host time is that of this
/// machine for texels without cache, the best of some runs, as a ratio to Mipmap (trilinear); "paper" is the ratio of Table I.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Times each filter is run for its host time
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u8).range(1..=100))]
    repeats: u8,
    #[command(flatten)]
    machine: super::MachineArgs,
}

/// A row of the paper's Table I: microseconds a pixel of Mipmap, Ripmap, Dipmap and FAST.
struct Published {
    figure: u8,
    pattern: Pattern,
    pixels: u32,
    microseconds: [f64; 4],
}

const TABLE_ONE: [Published; 3] = [
    Published { figure: 8, pattern: Pattern::Natural, pixels: 61_674, microseconds: [0.53, 1.12, 0.62, 2.00] },
    Published { figure: 9, pattern: Pattern::Pane, pixels: 81_509, microseconds: [0.47, 1.05, 0.53, 5.57] },
    Published { figure: 10, pattern: Pattern::Checkerboard, pixels: 46_904, microseconds: [0.54, 1.11, 0.60, 2.20] },
];

/// What is measured: a name, the filter, the axis rule where it is not the machine's, and the paper's column.
const COLUMNS: [(&str, Filter, Option<AxisRule>, Option<usize>); 6] = [
    ("mipmap (trilinear)", Filter::Trilinear, None, Some(0)),
    ("mip-double", Filter::MipDouble, None, None),
    ("ripmap", Filter::Ripmap, None, Some(1)),
    ("dipmap, texture axes", Filter::Dipmap, Some(AxisRule::TextureAxes), Some(2)),
    ("dipmap, screen axes", Filter::Dipmap, Some(AxisRule::Paper2a), None),
    ("fast", Filter::Fast, None, Some(3)),
];

/// Runs the command.
///
/// # Errors
/// Bad machines.
pub fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    say!("Table I of Du & Wan: us a pixel, and the ratio to Mipmap\n{}", published());
    for scene in Scene::builtins()? {
        let TextureSource::Procedural(texture) = &scene.texture.source else { continue };
        let Some(row) = TABLE_ONE.iter().find(|row| row.pattern == texture.pattern) else { continue };
        if !scene.name.starts_with("rectangle-") && !scene.name.starts_with("ellipsoid-") {
            continue;
        }
        let stage = Stage::new(scene);
        say!("\n{}, {} pixels, as figure {}", stage.scene.name, stage.coverage.covered, row.figure);
        say!("{}", measured(&stage, &machine, row, args.repeats)?);
    }
    say!(
        "\nAlias energy: variance that white noise keeps, as a multiple of Mipmap's, and the largest deviation (of 127.5) that \
         stripes of period 2 keep, at the same minification along both axes\n{}",
        aliases(&machine)?
    );
    Ok(ExitCode::SUCCESS)
}

fn published() -> Table {
    let mut table = plain(["figure", "texture", "pixels", "Mipmap", "Ripmap", "Dipmap", "FAST"], 1..);
    for row in &TABLE_ONE {
        let cell = |time: f64| format!("{time:.2} ({:.2})", time / row.microseconds[0]);
        let first = [row.figure.to_string(), row.pattern.name().into(), row.pixels.to_string()];
        table.add_row(first.into_iter().chain(row.microseconds.map(cell)));
    }
    table
}

fn measured(stage: &Stage, machine: &Machine, row: &Published, repeats: u8) -> Result<Table> {
    let header =
        ["filter", "texels", "taps", "lerps", "host ns", "ratio", "paper", "B uncached", "B cached", "RMSE", "worst"];
    let mut table = plain(header, 1..);
    let filters: Vec<Filter> = COLUMNS.iter().map(|(_, filter, ..)| *filter).collect();
    let pyramids = Pyramids::for_filters(machine, &stage.texture, &filters)?;
    let mut of_mipmap = None;
    for (name, filter, rule, column) in COLUMNS {
        let mut machine = machine.clone();
        machine.lod.dipmap_rule = rule.unwrap_or(machine.lod.dipmap_rule);
        let (pyramid, memory) = pyramids.of(filter);
        let bench = Bench::new(stage, &machine, filter, pyramid, memory);
        let outcome = bench.measure(&machine)?;
        let pixels = outcome.pixels.max(1) as f64;
        let seconds = bench.texel_seconds(repeats)?;
        let mipmap = *of_mipmap.get_or_insert(seconds);
        let texels = outcome.counters.lookups as f64 / pixels;
        let taps = texels / 4.0;
        let per_pixel = |bytes: u64| format!("{:.1}", bytes as f64 / pixels);
        table.add_row([
            name.to_owned(),
            format!("{texels:.1}"),
            format!("{taps:.1}"),
            format!("{:.1}", 4.0 * taps - 1.0),
            format!("{:.1}", seconds * 1e9 / pixels),
            format!("{:.2}", seconds / mipmap),
            column.map_or_else(String::new, |column| format!("{:.2}", row.microseconds[column] / row.microseconds[0])),
            per_pixel(outcome.counters.bytes_requested),
            per_pixel(outcome.counters.bytes_fetched),
            format!("{:.2}", outcome.against_truth.rmse()),
            format!("{:.0}", outcome.against_truth.worst()),
        ]);
    }
    Ok(table)
}

fn aliases(machine: &Machine) -> Result<Table> {
    const SCALES: [f64; 4] = [2.0, 4.0, 8.0, 16.0];
    let mut table = plain(["filter", "noise 2x", "4x", "8x", "16x", "stripes 2x", "4x", "8x", "16x"], 1..);
    let mipmap = SCALES.map(|scale| alias::residue(machine, Filter::Trilinear, scale));
    for (name, filter) in Filter::ALL.iter().filter(|(_, filter)| filter.uses_level() || *filter == Filter::Sat) {
        let mut noise = Vec::new();
        let mut stripes = Vec::new();
        for (scale, mipmap) in SCALES.into_iter().zip(&mipmap) {
            let residue = alias::residue(machine, *filter, scale)?;
            let of_mipmap = mipmap.as_ref().map_or(f64::NAN, |mipmap| mipmap.noise);
            noise.push(format!("{:.2}", residue.noise / of_mipmap));
            stripes.push(format!("{:.1}", residue.stripes_worst));
        }
        table.add_row([(*name).to_owned()].into_iter().chain(noise).chain(stripes));
    }
    Ok(table)
}
