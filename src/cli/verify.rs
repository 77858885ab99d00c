//! `texunit verify`: the chip against the float reference.

use std::process::ExitCode;

use comfy_table::Table;
use indicatif::{ProgressBar, ProgressStyle};
use texunit_hw::{Filter, Format};

use super::scene_args::FilterArgs;
use crate::{
    error::Result,
    experiment::verify::{Finding, combinations, compare, random_subjects, scene_subjects},
    names::Named,
    output::print,
    report::table::framed,
    scene::Scene,
};

/// Compare the chip with the float reference, bit for bit, over everything that combines
///
/// That is scenes and random requests, filters, wraps, roundings, layouts, texel formats and widths. A texture.format other than rgba8
/// is the only one compared; rgba8 stands for all. Exit status: 0 all answers equal, 1 a mismatch was found (the first is printed with everything needed to repeat it), 2 bad use.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    filters: FilterArgs,
    /// Random requests for each combination on each of nine textures of awkward shapes
    #[arg(long, value_name = "N", default_value_t = 60_000)]
    random: usize,
    /// Leave out the scenes that ship
    #[arg(long)]
    no_scenes: bool,
    /// Print JSON instead of the table
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    machine: super::MachineArgs,
}

/// Runs the command.
///
/// # Errors
/// Bad machines.
pub fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    let filters = args.filters.filters();
    // The default stands for all of them; whoever names another one means that one.
    let format = Some(machine.texture.format).filter(|format| *format != Format::Rgba8);
    let combinations = combinations(&filters, format);
    let mut subjects = random_subjects(args.random);
    if !args.no_scenes {
        subjects.extend(scene_subjects(&Scene::builtins()?));
    }
    let total: usize = subjects.iter().map(|subject| subject.requests()).sum::<usize>() * combinations.len();
    let progress = ProgressBar::new(total as u64).with_style(
        ProgressStyle::with_template("{bar:24} {human_pos} of {human_len} samples, {msg} (about {eta} left)")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let mut findings = Vec::new();
    for subject in &subjects {
        progress.set_message(subject.name.clone());
        findings.extend(compare(&machine, subject, &combinations, |count| progress.inc(count))?);
    }
    progress.finish_and_clear();

    let rows = rows(&filters, &findings);
    let compared: u64 = rows.iter().map(|row| row.compared).sum();
    let mismatches: u64 = rows.iter().map(|row| row.mismatches).sum();
    if args.json {
        let filters: Vec<_> = rows
            .iter()
            .map(|row| serde_json::json!({ "filter": row.filter, "compared": row.compared, "mismatches": row.mismatches }))
            .collect();
        let report = serde_json::json!({ "compared": compared, "mismatches": mismatches, "filters": filters });
        print(|out| writeln!(out, "{report:#}"))?;
    } else {
        let (runs, textures) = (combinations.len(), subjects.len());
        print(|out| {
            writeln!(out, "{}", table(&rows))?;
            writeln!(
                out,
                "{compared} samples compared in {runs} combinations on {textures} textures, {mismatches} mismatches"
            )
        })?;
    }
    if let Some(finding) = findings.iter().find(|finding| finding.mismatches > 0) {
        let Finding { combination, subject, first, .. } = finding;
        eprintln!("texunit: the first mismatch: {subject}, {combination}: {first:?}");
        return Ok(ExitCode::from(1));
    }
    Ok(ExitCode::SUCCESS)
}

struct Row {
    filter: &'static str,
    combinations: usize,
    compared: u64,
    mismatches: u64,
}

fn rows(filters: &[Filter], findings: &[Finding]) -> Vec<Row> {
    filters
        .iter()
        .map(|filter| {
            let of_filter = findings.iter().filter(|finding| finding.combination.filter == *filter);
            let (combinations, compared, mismatches) =
                of_filter.fold((0, 0, 0), |(count, compared, mismatches), finding| {
                    (count + 1, compared + finding.compared, mismatches + finding.mismatches)
                });
            Row { filter: filter.name(), combinations, compared, mismatches }
        })
        .collect()
}

fn table(rows: &[Row]) -> Table {
    let mut table = framed(["filter", "runs", "samples", "mismatches"], 1..);
    for row in rows {
        table.add_row([
            row.filter.to_string(),
            row.combinations.to_string(),
            row.compared.to_string(),
            row.mismatches.to_string(),
        ]);
    }
    table
}
