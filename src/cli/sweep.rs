//! `texunit sweep`: thousands of machines from one file.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    sync::atomic::Ordering,
};

use clap::Subcommand;
use rayon::prelude::*;

use super::{STOP, progress_bar, stop_on_ctrl_c};
use crate::{
    error::{Error, Result},
    names::Named,
    output::print,
    sweep::{Plan, Point, Store, script},
};

/// Cross parameters of the machine, filters, scenes and sizes
///
/// All caches that differ in sets and ways only (LRU or FIFO) come out of one pass. Results are written point by point, so
/// an interrupted sweep goes on where it stopped.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List the points with their numbers
    Plan(Common),
    /// Compute what is missing on this machine, then merge
    Run(Common),
    /// Compute one point, or a range such as 8-15, on this machine
    Point {
        #[command(flatten)]
        common: Common,
        /// Its number in `plan`, or first-last; numbers beyond the last point are left out of a range
        #[arg(value_parser = range)]
        number: (usize, usize),
    },
    /// Write sweep.csv from all points; an error if one is missing
    Merge(Common),
    /// Print a job-array script for Slurm: `sbatch` it, or run it with `sh` to merge as well
    Slurm {
        #[command(flatten)]
        common: Common,
        /// Longest array
        #[arg(long, default_value_t = 1000)]
        tasks: usize,
        /// Tasks that may run at the same time [default: as many as Slurm likes]
        #[arg(long)]
        at_once: Option<usize>,
    },
}

#[derive(Debug, clap::Args)]
struct Common {
    /// The sweep, a TOML file (docs/sweeps.md)
    file: PathBuf,
    /// Folder for results [default: out/NAME of the sweep]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Points at the same time [default: the number of cores]
    #[arg(short, long)]
    jobs: Option<usize>,
    /// Write sweep.parquet beside sweep.csv
    #[cfg(feature = "parquet")]
    #[arg(long)]
    parquet: bool,
}

fn range(text: &str) -> Result<(usize, usize), String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    match (first.parse(), last.parse()) {
        (Ok(first), Ok(last)) if first <= last => Ok((first, last)),
        _ => Err("write a number, or first-last, for instance 17 or 8-15".into()),
    }
}

impl Common {
    fn plan(&self) -> Result<(Plan, PathBuf)> {
        let plan = Plan::load(&self.file)?;
        let output = self.output.clone().unwrap_or_else(|| Path::new("out").join(&plan.name));
        Ok((plan, output))
    }

    fn merge(&self, plan: &Plan, store: &Store) -> Result<()> {
        store.check(plan)?;
        let rows = store.rows(plan)?;
        say!("{}", store.write_csv(plan, &rows)?.display());
        #[cfg(feature = "parquet")]
        if self.parquet {
            say!("{}", store.write_parquet(plan, &rows)?.display());
        }
        Ok(())
    }

    /// Computes points, by stage.
    fn compute(&self, plan: &Plan, store: &Store, points: &[&Point], output: &Path) -> Result<()> {
        store.check(plan)?;
        stop_on_ctrl_c();
        let progress = progress_bar(points.len() as u64);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.jobs.unwrap_or(0)).build();
        let pool =
            pool.map_err(|error| Error::setting("--jobs", self.jobs.unwrap_or(0), error.to_string(), "fewer"))?;
        let done = pool.install(|| {
            points.chunk_by(|one, next| one.stage_key() == next.stage_key()).try_for_each(|points| {
                progress.set_message(plan.stages[points[0].stage].scene.name.clone());
                let stage = plan.stage(points[0]);
                points.par_iter().try_for_each(|point| -> Result<()> {
                    if !STOP.load(Ordering::Relaxed) {
                        store.write(plan, point, &plan.measure(point, stage.as_ref())?)?;
                        progress.inc(1);
                    }
                    Ok(())
                })
            })
        });
        progress.finish_and_clear();
        done?;
        if STOP.load(Ordering::Relaxed) { Err(Error::Interrupted(output.to_path_buf())) } else { Ok(()) }
    }
}

/// Runs the command.
///
/// # Errors
/// A bad sweep file, results that cannot be written, a missing point in a merge.
pub fn run(args: &Args) -> Result<ExitCode> {
    match &args.action {
        Action::Plan(common) => {
            let (plan, output) = common.plan()?;
            list(&plan, &output)?;
        }
        Action::Run(common) => {
            let (plan, output) = common.plan()?;
            let store = Store::open(&output)?;
            let missing = store.missing(&plan);
            let there = plan.points.len() - missing.len();
            if there > 0 {
                eprintln!("texunit: {there} of {} points are there already", plan.points.len());
            }
            common.compute(&plan, &store, &missing, &output)?;
            common.merge(&plan, &store)?;
        }
        Action::Point { common, number: (first, last) } => {
            let (plan, output) = common.plan()?;
            let points: Vec<&Point> = plan.points.iter().skip(*first).take(last - first + 1).collect();
            if points.is_empty() {
                let count = plan.points.len();
                return Err(Error::setting(
                    "NUMBER",
                    first,
                    format!("there are {count} points, from 0"),
                    "see sweep plan",
                ));
            }
            common.compute(&plan, &Store::open(&output)?, &points, &output)?;
        }
        Action::Merge(common) => {
            let (plan, output) = common.plan()?;
            common.merge(&plan, &Store::open(&output)?)?;
        }
        Action::Slurm { common, tasks, at_once } => {
            let (plan, output) = common.plan()?;
            let absolute = |path: &Path| std::path::absolute(path).map_err(Error::io(path));
            let program = std::env::current_exe().map_err(Error::io("texunit"))?;
            let script = script(&plan, &program, &absolute(&common.file)?, &absolute(&output)?, *tasks, *at_once);
            print(|out| write!(out, "{script}"))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn list(plan: &Plan, output: &Path) -> Result<()> {
    let caches = plan.caches.len();
    let head =
        format!("{}: {} points of {caches} caches each, into {}", plan.name, plan.points.len(), output.display());
    print(|out| {
        writeln!(out, "{head}")?;
        plan.points.iter().try_for_each(|point| {
            let scene = &plan.stages[point.stage].scene;
            let settings: Vec<String> = point.settings.iter().map(|(key, value)| format!("{key}={value}")).collect();
            let [width, height] = scene.size;
            let filter = point.filter.name();
            writeln!(out, "{:6}  {} {width}x{height} {filter} {}", point.number, scene.name, settings.join(" "))
        })
    })
}
