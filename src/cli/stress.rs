//! `texunit stress`: the extremes, answered carelessly, by this unit, and ideally.

use std::{path::PathBuf, process::ExitCode};

use serde_json::{Value, json};

use super::progress_bar;
use crate::{
    error::{Error, Result},
    output::{print, write_whole},
    report::table::plain,
    stress::{CASES, Case, Finding, Options, Q, Summary, shown},
};

/// Try every extreme input (X1 to X23) on a careless unit, on this one, and on an ideal one
///
/// Each row is an input with the answer of a careless unit (computed by code one might write), ours (through the chip), the
/// ideal, both errors, and what is allowed, in the unit named. Exit status: 0 all cases pass, 1 one fails, 2 bad use.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Only these cases, for instance X1,X10
    #[arg(long, value_name = "CASE", value_delimiter = ',')]
    only: Vec<String>,
    /// Wider internal formats of coordinates for X10
    #[arg(long, value_name = "I.F", value_delimiter = ',', default_value = "9.23,12.32")]
    formats: Vec<Q>,
    /// Print JSON instead of the table
    #[arg(long)]
    json: bool,
    /// Write the JSON to this file too; as stress.json in a folder it becomes a section of `texunit report`
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// A case that does not exist, a file that cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    let chosen = chosen(&args.only)?;
    let options = Options { formats: args.formats.clone() };
    let progress = progress_bar(chosen.len() as u64);
    let mut findings = Vec::new();
    for case in chosen {
        progress.set_message(case.name);
        let finding = case.run(&options)?;
        progress.inc(1);
        if !args.json {
            progress.suspend(|| print(|out| show(out, &finding)))?;
        }
        findings.push(finding);
    }
    progress.finish_and_clear();
    let summary = Summary::of(&findings);
    let cases: Vec<Value> = findings.iter().map(Finding::json).collect();
    let report = json!({
        "schema": 1, "texunit": env!("CARGO_PKG_VERSION"), "command": std::env::args().collect::<Vec<_>>(),
        "summary": summary, "cases": cases,
    });
    if let Some(path) = &args.output {
        write_whole(path, |file| writeln!(file, "{report:#}"))?;
    }
    if args.json {
        print(|out| writeln!(out, "{report:#}"))?;
    } else {
        print(|out| writeln!(out, "\n{} cases, {} failed", summary.cases, summary.failed))?;
    }
    Ok(if summary.failed == 0 { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

fn chosen(only: &[String]) -> Result<Vec<&'static Case>> {
    if only.is_empty() {
        return Ok(CASES.iter().collect());
    }
    let named = |name: &String| {
        CASES.iter().find(|case| case.name.eq_ignore_ascii_case(name)).ok_or_else(|| {
            let names: Vec<&str> = CASES.iter().map(|case| case.name).collect();
            Error::setting("--only", name, "no such case", format!("use {}", names.join(", ")))
        })
    };
    only.iter().map(named).collect()
}

fn show(out: &mut dyn std::io::Write, finding: &Finding) -> std::io::Result<()> {
    let verdict = if finding.passes() { "pass" } else { "FAIL" };
    writeln!(out, "\n{} {}: {verdict}\nCareless: {}", finding.name, finding.title, finding.wrong)?;
    let header = ["input", "unit", "careless", "ours", "ideal", "careless\nerror", "our error", "allowed", ""];
    let mut table = plain(header, 2..);
    for row in &finding.rows {
        let numbers = [row.careless, row.ours, row.ideal, row.careless_error(), row.error(), row.allowed];
        let verdict = if row.passes() { "" } else { "FAIL" };
        let cells = [row.input.clone(), row.unit.into()].into_iter().chain(numbers.map(shown));
        table.add_row(cells.chain([verdict.into()]));
    }
    writeln!(out, "{table}")
}
