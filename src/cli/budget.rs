//! `texunit budget`: where the error of a sample comes from.

use std::{path::PathBuf, process::ExitCode};

use comfy_table::Table;
use serde_json::{Value, json};
use texunit_hw::Filter;

use super::{
    progress_bar,
    scene_args::{image_size, scenes},
};
use crate::{
    budget::{self, Budget, Ledger, PARTS},
    error::Result,
    machine::parser,
    names::Named,
    output::{print, write_whole},
    report::stack::Stack,
    report::table::framed,
};

/// Split the error of samples into what coordinate, fraction, LOD, texel and rounding add
///
/// One quantisation is turned on after the other. Errors are in LSB, of the chip against the same filter without widths on planes that
/// were not rounded. `share` of the five parts adds up to the RMS of the total; `alone` is each part without the others, and
/// `interaction` what these leave unexplained.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene: the name of one that ships or a TOML file
    #[arg(value_name = "SCENE", default_value = "rectangle-natural")]
    scene: String,
    /// Filters; all but sat if none is given
    #[arg(long, short, value_delimiter = ',', value_parser = parser::<Filter>())]
    filters: Vec<Filter>,
    /// Pixels of the scene that are sampled, evenly
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Image size, instead of the scene's own, for instance 1920x1080
    #[arg(long, value_name = "WxH", value_parser = image_size)]
    size: Option<[u32; 2]>,
    /// Print JSON instead of the table
    #[arg(long)]
    json: bool,
    /// Draw the shares as bars into this file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[command(flatten)]
    machine: super::MachineArgs,
}

/// Runs the command.
///
/// # Errors
/// Bad scenes, machines or filters, a file that cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    let scenes = scenes(std::slice::from_ref(&args.scene), args.size)?;
    let scene = &scenes[0];
    let filters = if args.filters.is_empty() { budget::filters().collect() } else { args.filters.clone() };
    let progress = progress_bar(filters.len() as u64 + 1);
    progress.set_message("pyramids");
    let ledger = Ledger::new(&machine, scene, &filters, args.samples as usize)?;
    progress.inc(1);
    let mut budgets = Vec::new();
    for filter in filters {
        progress.set_message(filter.name());
        budgets.push(ledger.budget(filter)?);
        progress.inc(1);
    }
    progress.finish_and_clear();
    if let Some(path) = &args.svg {
        let svg = bars(&scene.name, &budgets).svg();
        write_whole(path, |file| file.write_all(svg.as_bytes()))?;
    }
    if args.json {
        let report: Value = json!({
            "schema": 1, "texunit": env!("CARGO_PKG_VERSION"), "command": std::env::args().collect::<Vec<_>>(),
            "machine": machine, "scene": scene.name, "unit": "LSB", "filters": budgets,
        });
        print(|out| writeln!(out, "{report:#}"))?;
    } else {
        print(|out| {
            writeln!(
                out,
                "{}: {} samples; LSB, the chip against an ideal filter",
                scene.name,
                budgets.first().map_or(0, |b| b.samples)
            )?;
            writeln!(out, "{}", table(&budgets))
        })?;
    }
    Ok(ExitCode::SUCCESS)
}

fn bars(scene: &str, budgets: &[Budget]) -> Stack {
    let bar = |budget: &Budget| (budget.filter.to_owned(), budget.parts.iter().map(|part| part.share).collect());
    Stack {
        title: format!("{scene}: where the error comes from"),
        label: "share of the RMS error, LSB".into(),
        parts: PARTS.iter().map(|part| (*part).to_owned()).collect(),
        bars: budgets.iter().map(bar).collect(),
    }
}

fn table(budgets: &[Budget]) -> Table {
    let header = ["filter", "part", "share\nof RMS", "RMS\nin order", "worst", "mean", "RMS\nalone", "worst"];
    let mut table = framed(header, 2..);
    let number = |value: f64| format!("{value:.4}");
    for budget in budgets {
        for (place, part) in budget.parts.iter().enumerate() {
            let filter = if place == 0 { budget.filter } else { "" };
            let numbers = [
                part.share,
                part.in_order.rms,
                part.in_order.worst,
                part.in_order.mean,
                part.alone.rms,
                part.alone.worst,
            ];
            table.add_row([filter.to_owned(), part.name.to_owned()].into_iter().chain(numbers.map(number)));
        }
        let (total, rest) = (budget.total, budget.interaction);
        let sum: f64 = budget.parts.iter().map(|part| part.share).sum();
        let numbers = [sum, total.rms, total.worst, total.mean].map(number);
        table.add_row(["".to_owned(), "total".to_owned()].into_iter().chain(numbers).chain(["".into(), "".into()]));
        let alone = [number(rest.rms), number(rest.worst)];
        let blank = std::iter::repeat_n(String::new(), 4);
        table.add_row(["".to_owned(), "interaction".to_owned()].into_iter().chain(blank).chain(alone));
    }
    table
}
