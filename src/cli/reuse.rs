//! `texunit reuse`: how soon lines are read again.

use std::{path::PathBuf, process::ExitCode};

use rayon::prelude::*;
use serde_json::{Value, json};
use texunit_hw::Filter;

use super::{progress_bar, scene_args::SceneArgs};
use crate::{
    error::Result,
    names::Named,
    output::{create_folder, write_whole},
    report::plot::{Axis, Plot, Series, Style},
    report::table::framed,
    reuse::Reuse,
    scene::Scene,
};

/// Measure reuse distances, miss curves and working sets per plane, screen tile, level and frame
///
/// The curve of a filter is the misses of a fully associative LRU cache of every size, exactly. The working set is the fewest
/// lines with which no more than 1 % of the reused lookups miss. Writes reuse.json and an SVG for every scene. A scene
/// with a path is followed through all its frames.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scenes: SceneArgs,
    /// Folder for results
    #[arg(short, long, value_name = "DIR", default_value = "out/reuse")]
    output: PathBuf,
    #[command(flatten)]
    machine: super::MachineArgs,
}

/// Runs the command.
///
/// # Errors
/// Bad scenes, machines or folders.
pub fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    let scenes = args.scenes.scenes()?;
    let filters = args.scenes.filters();
    create_folder(&args.output)?;
    let frames: u64 = scenes.iter().map(|scene| u64::from(scene.frame_count())).sum();
    let progress = progress_bar(frames * filters.len() as u64);
    let mut studied: Vec<Value> = Vec::new();
    for scene in &scenes {
        progress.set_message(scene.name.clone());
        let study = |filter: &Filter| Reuse::of(scene, &machine, *filter, || progress.inc(1));
        let all: Vec<Reuse> = filters.par_iter().map(study).collect::<Result<_>>()?;
        let svg = miss_curves(&scene.name, &all).svg();
        write_whole(&args.output.join(format!("{}.svg", scene.name)), |file| file.write_all(svg.as_bytes()))?;
        progress.suspend(|| print(scene, &all))?;
        let filters: Vec<Value> = all.iter().map(Reuse::json).collect();
        studied.push(json!({ "scene": scene.name, "size": scene.size, "filters": filters }));
    }
    progress.finish_and_clear();
    let value = json!({
        "schema": 1,
        "texunit": env!("CARGO_PKG_VERSION"),
        "command": std::env::args().collect::<Vec<_>>(),
        "machine": machine,
        "units": { "lines": "line", "lookups": "read", "curve": "[line, read]", "line": "B", "tile": "pixel", "mean": "line" },
        "scenes": studied,
    });
    write_whole(&args.output.join("reuse.json"), |file| writeln!(file, "{value:#}"))?;
    say!("\nCurves: {}", args.output.display());
    Ok(ExitCode::SUCCESS)
}

/// Miss rate over size, a line a filter.
fn miss_curves(scene: &str, all: &[Reuse]) -> Plot {
    let series = all.iter().map(|reuse| {
        let lookups = reuse.all.lookups().max(1) as f64;
        let points = reuse.all.curve().map(|(lines, misses)| {
            ((lines * u64::from(reuse.line)) as f64, 100.0 * misses as f64 / lookups, String::new())
        });
        Series { name: reuse.filter.name().into(), style: Style::Line, points: points.collect() }
    });
    Plot {
        title: format!("{scene}: misses of a fully associative LRU cache"),
        x: Axis { label: "size, B".into(), logarithmic: true },
        y: Axis { label: "misses, % of lookups".into(), logarithmic: true },
        series: series.collect(),
    }
}

fn print(scene: &Scene, all: &[Reuse]) -> Result<()> {
    let [width, height] = scene.size;
    say!("\n{}: {width} x {height}, {} frames", scene.name, scene.frame_count());
    let header = [
        "filter",
        "lookups",
        "lines",
        "KiB\ntouched",
        "working\nset, lines",
        "across\nlevels %",
        "lines of\nlast frame %",
        "8 x 8 tile\nmean lines",
        "64 x 64\nmean lines",
    ];
    let mut table = framed(header, 1..);
    for reuse in all {
        let share = |part: u64, whole: u64| 100.0 * part as f64 / whole.max(1) as f64;
        let later = reuse.frames.iter().skip(1);
        let (lines, shared) =
            later.fold((0, 0), |(lines, shared), frame| (lines + frame.lines, shared + frame.lines_of_previous));
        table.add_row([
            reuse.filter.name().to_owned(),
            reuse.all.lookups().to_string(),
            reuse.lines.to_string(),
            format!("{:.0}", (reuse.lines * u64::from(reuse.line)) as f64 / 1024.0),
            reuse.all.working_set(10).to_string(),
            format!("{:.2}", share(reuse.across_levels(), reuse.all.lookups())),
            if reuse.frames.len() > 1 { format!("{:.1}", share(shared, lines)) } else { "-".into() },
            format!("{:.1}", reuse.tiles[0].mean),
            format!("{:.1}", reuse.tiles[3].mean),
        ]);
    }
    say!("{table}");
    Ok(())
}
