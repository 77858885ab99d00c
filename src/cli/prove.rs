//! `texunit prove`: the chip on everything it can be asked.

use std::{process::ExitCode, sync::atomic::Ordering, time::Instant};

use serde_json::{Value, json};

use super::{STOP, progress_bar, stop_on_ctrl_c};
use crate::{
    error::{Error, Result},
    output::print,
    prove::{Built, Proof, Work, proofs},
};

/// Compare every unit of the chip with independent arithmetic, on all inputs there are
///
/// Each row is one proof: its name, the inputs compared, the mismatches, and what was compared. Some minutes on two cores.
/// Ctrl-C keeps the finished rows. Exit status: 0 no mismatch, 1 a mismatch (the first is shown) or not finished, 2 bad use.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A subset of every proof, in seconds: boundaries, ends, and a stride through the rest
    #[arg(long)]
    quick: bool,
    /// Only proofs whose name begins so, for instance lod or address-morton; may be given more than once
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Print JSON instead of the table
    #[arg(long)]
    json: bool,
    /// Name the proofs and run none
    #[arg(long)]
    list: bool,
}

/// Runs the command.
///
/// # Errors
/// A name that no proof begins with.
pub fn run(args: &Args) -> Result<ExitCode> {
    let chosen = chosen(&args.only)?;
    if args.list {
        print(|out| chosen.iter().try_for_each(|proof| writeln!(out, "{:26} {}", proof.name, proof.what)))?;
        return Ok(ExitCode::SUCCESS);
    }
    stop_on_ctrl_c();
    let begin = Instant::now();
    let mut rows: Vec<Value> = Vec::new();
    let (mut compared, mut mismatches) = (0, 0);
    if !args.json {
        let what = if args.quick { "what (a subset of it)" } else { "what" };
        print(|out| writeln!(out, "{:26} {:>15} {:>10}  {what}", "proof", "compared", "mismatches"))?;
    }
    for proof in &chosen {
        let bar = progress_bar(0).with_message(proof.name.clone());
        let work = Work { quick: args.quick, bar, stop: &STOP };
        let Some(tally) = proof.run(&Built, &work) else { break };
        work.bar.finish_and_clear();
        compared += tally.compared;
        mismatches += tally.mismatches;
        if !args.json {
            print(|out| {
                writeln!(out, "{:26} {:>15} {:>10}  {}", proof.name, tally.compared, tally.mismatches, proof.what)
            })?;
        }
        if let Some(first) = &tally.first {
            eprintln!("texunit: {}: the first mismatch: {first}", proof.name);
        }
        rows.push(json!({
            "proof": proof.name, "what": proof.what, "compared": tally.compared, "mismatches": tally.mismatches, "first": tally.first,
        }));
    }
    let finished = rows.len() == chosen.len();
    if args.json {
        let report = json!({
            "schema": 1, "texunit": env!("CARGO_PKG_VERSION"), "quick": args.quick, "finished": finished,
            "compared": compared, "mismatches": mismatches, "proofs": rows,
        });
        print(|out| writeln!(out, "{report:#}"))?;
    } else {
        print(|out| writeln!(out, "{compared} inputs compared in {} proofs, {mismatches} mismatches", rows.len()))?;
    }
    eprintln!("texunit: {:.1} s on {} threads", begin.elapsed().as_secs_f64(), rayon::current_num_threads());
    if STOP.load(Ordering::Relaxed) && !finished {
        eprintln!("texunit: interrupted after {} of {} proofs", rows.len(), chosen.len());
    }
    Ok(if mismatches == 0 && finished { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// The proofs of these names, all if there are none.
fn chosen(only: &[String]) -> Result<Vec<Proof<Built>>> {
    let all = proofs::<Built>();
    for name in only {
        if !all.iter().any(|proof| proof.name.starts_with(name)) {
            let remedy = "`texunit prove --list` names them";
            return Err(Error::setting("--only", name, "no proof has a name that begins so", remedy));
        }
    }
    let wanted = |proof: &Proof<Built>| only.is_empty() || only.iter().any(|name| proof.name.starts_with(name));
    Ok(all.into_iter().filter(wanted).collect())
}
