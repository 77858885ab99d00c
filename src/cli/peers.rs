//! `texunit peers`: the arithmetic of other machines, and how far it is from exact.

use std::process::ExitCode;

use comfy_table::Table;
use texunit_hw::peers::{Arithmetic, Blend, LEVEL_BITS, LevelUnit, Logarithm, Rounding, Shape, Space, Weights};

use crate::{
    error::Result,
    output::print,
    peers::{CONVENTIONS, PUBLISHED_TAPS, Spread, TapError, keeps_flat_fields, level_error, measure},
    report::table::plain,
};

/// Show the arithmetic of other machines, and how far it is from exact
///
/// That is coordinates, weights, roundings and levels. Errors of taps are in units of the last of 8 bits, over 2 million random texels and places; of levels in levels, over 2 million ratios,
/// negative too sharp. Beside them stands what a survey of the machines' sources found with code of its own.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Print JSON instead of the tables
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// Standard output that cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    let measured = measure();
    let levels: Vec<_> = CONVENTIONS.iter().map(|convention| (convention, level_error(&convention.unit))).collect();
    if args.json {
        let machines: Vec<_> = measured
            .iter()
            .map(|(machine, tap, level)| {
                let published = PUBLISHED_TAPS.iter().find(|row| row.machine == machine.name);
                serde_json::json!({
                    "name": machine.name, "source": machine.source, "assumed": machine.assumed, "coordinate": coordinate(machine),
                    "fraction-bits": machine.fraction, "weights": weights(machine), "rounding": rounding(machine.rounding),
                    "level": level_unit(machine.level.as_ref()), "blend": blend(machine.blend), "full-scale": machine.full_scale,
                    "tap": tap, "tap-published": published, "level-error": level, "keeps-flat-fields": keeps_flat_fields(machine),
                })
            })
            .collect();
        let logarithms: Vec<_> = levels
            .iter()
            .map(|(convention, error)| {
                serde_json::json!({ "name": convention.name, "measured": error, "published": convention.published })
            })
            .collect();
        let report = serde_json::json!({ "machines": machines, "logarithms": logarithms });
        return print(|out| writeln!(out, "{report:#}")).map(|()| ExitCode::SUCCESS);
    }
    print(|out| {
        writeln!(out, "{}\n", parameters(&measured))?;
        for (machine, ..) in measured.iter().filter(|(machine, ..)| !machine.assumed.is_empty()) {
            writeln!(out, "{}: {}", machine.name, machine.assumed)?;
        }
        writeln!(out, "\nA bilinear tap: error in units of the last of 8 bits\n{}", taps(&measured))?;
        writeln!(out, "\nLogarithms: error in levels\n{}", logarithms(&levels))
    })?;
    Ok(ExitCode::SUCCESS)
}

type Measured = (&'static Arithmetic, TapError, Option<Spread>);

fn parameters(measured: &[Measured]) -> Table {
    let header =
        ["machine", "coordinate", "fraction", "half texel", "weights", "rounding", "level", "two levels", "source"];
    let mut table = plain(header, 0..0);
    for (machine, ..) in measured {
        table.add_row([
            machine.name.to_owned(),
            coordinate(machine),
            format!("{} bits", machine.fraction),
            if machine.coordinate.half_texel { "yes" } else { "no" }.into(),
            weights(machine),
            rounding(machine.rounding).into(),
            level_unit(machine.level.as_ref()),
            blend(machine.blend),
            machine.source.into(),
        ]);
    }
    table
}

fn coordinate(machine: &Arithmetic) -> String {
    let of = match machine.coordinate.space {
        Space::Normalised => "repeat",
        Space::Texels => "texel",
    };
    let how = if machine.coordinate.nearest { "nearest" } else { "cut" };
    format!("{} bits of a {of}, {how}", machine.coordinate.bits)
}

fn weights_of(weights: Weights) -> &'static str {
    match weights {
        Weights::Binary => "f of 2^b",
        Weights::OfOnes => "f of 2^b - 1",
        Weights::Complement => "f and ~f, all at 0",
        Weights::AlwaysComplement => "f and ~f",
    }
}

fn weights(machine: &Arithmetic) -> String {
    match machine.shape {
        Shape::Square => weights_of(machine.weights).into(),
        Shape::Triangle => format!("{}, three texels", weights_of(machine.weights)),
    }
}

const fn rounding(rounding: Rounding) -> &'static str {
    match rounding {
        Rounding::Once => "once, half up",
        Rounding::OnceTruncate => "once, cut",
        Rounding::Staged => "each lerp, half up",
        Rounding::StagedTruncate => "each lerp, cut",
        Rounding::UpperHalves => "each product, cut",
    }
}

fn level_unit(unit: Option<&LevelUnit>) -> String {
    let Some(unit) = unit else { return "no mipmaps".into() };
    let power = ["ratio", "square", "fourth power"][unit.squarings as usize];
    let logarithm = match unit.logarithm {
        Logarithm::Whole => "leading one".into(),
        Logarithm::Linear => "linear".into(),
        Logarithm::TableFloor { index, .. } | Logarithm::TableNearest { index } => format!("{} entries", 1 << index),
        Logarithm::Exact => "exact".into(),
    };
    format!("{logarithm} of the {power}, {} bits", unit.bits)
}

fn blend(blend: Blend) -> String {
    match blend {
        Blend::None => "no".into(),
        Blend::Lerp { bits, weights, rounding: round } => {
            format!("{} bits, {}, {}", bits, weights_of(weights), rounding(round))
        }
        Blend::Once { bits } => format!("{bits} bits, one rounding in all"),
    }
}

fn taps(measured: &[Measured]) -> Table {
    let header = [
        "machine",
        "least",
        "greatest",
        "mean",
        "own fraction: least",
        "greatest",
        "mean",
        "right",
        "flat kept",
        "published: least",
        "greatest",
        "mean",
        "right",
    ];
    let mut table = plain(header, 1..);
    let share = |right: f64| format!("{:.1} %", 100.0 * right);
    for (machine, tap, _) in measured {
        let digits = |value: f64| format!("{value:+.3}");
        let spread = |spread: Spread| [spread.least, spread.greatest, spread.mean].map(digits);
        let mut row = vec![machine.name.to_owned()];
        row.extend(spread(tap.exact));
        row.extend(spread(tap.own));
        row.push(share(tap.right));
        row.push(if keeps_flat_fields(machine) { "yes" } else { "no" }.into());
        match PUBLISHED_TAPS.iter().find(|row| row.machine == machine.name) {
            Some(published) => {
                row.extend([published.least, published.greatest, published.mean].map(digits));
                row.push(published.right.map_or_else(|| "-".into(), share));
            }
            None => row.extend(std::iter::repeat_n("-".to_owned(), 4)),
        }
        table.add_row(row);
    }
    table
}

fn logarithms(levels: &[(&crate::peers::Convention, Spread)]) -> Table {
    let header = ["convention", "least", "greatest", "mean", "published: least", "greatest", "mean"];
    let mut table = plain(header, 1..);
    for (convention, error) in levels {
        let mut row = vec![convention.name.to_owned()];
        for Spread { least, greatest, mean } in [*error, convention.published] {
            let places = if convention.unit.bits == LEVEL_BITS { 5 } else { 4 };
            row.extend([least, greatest, mean].map(|value| format!("{value:+.places$}")));
        }
        table.add_row(row);
    }
    table
}
