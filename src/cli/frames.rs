//! `texunit frames`: a scene in motion.

use std::{path::PathBuf, process::ExitCode};

use comfy_table::Table;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::{progress_bar, scene_args::SceneArgs};
use crate::{
    error::{Error, Result},
    experiment::{Pyramids, Stage, report},
    flicker::Flicker,
    names::Named,
    output::{create_folder, write_whole},
    report::table::framed,
};

/// Measure the temporal error beside the spatial one, over the frames of a scene with a path
///
/// A scene moves if it has a `[path]`; of those that ship, walk does. Flicker is the root mean square of what the error of a pixel
/// changes from frame to frame. The cache is kept warm from frame to frame, and counted cold at every frame beside it. Writes
/// frames.json.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scenes: SceneArgs,
    /// Folder for results
    #[arg(short, long, value_name = "DIR", default_value = "out/frames")]
    output: PathBuf,
    #[command(flatten)]
    machine: super::MachineArgs,
}

/// Runs the command.
///
/// # Errors
/// Scenes without a path, bad machines or folders.
pub fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    let scenes = args.scenes.scenes()?;
    let filters = args.scenes.filters();
    if let Some(still) = scenes.iter().find(|scene| scene.path.is_none()) {
        return Err(Error::setting(
            "SCENE",
            &still.name,
            "it does not move",
            "add a [path], as in `texunit scenes --show walk`",
        ));
    }
    create_folder(&args.output)?;
    let progress = progress_bar(scenes.iter().map(|scene| u64::from(scene.frame_count())).sum());
    let mut done: Vec<Value> = Vec::new();
    for scene in &scenes {
        progress.set_message(scene.name.clone());
        let mut flickers: Vec<Flicker> = filters.iter().map(|&filter| Flicker::new(filter)).collect();
        let mut pyramids = None;
        for number in 0..scene.frame_count() {
            let stage = Stage::in_light(scene.frame(number), machine.texture.srgb);
            let pyramids = match &mut pyramids {
                Some(made) => made,
                none => none.insert(Pyramids::for_filters(&machine, &stage.texture, &filters)?),
            };
            flickers.par_iter_mut().try_for_each(|flicker| flicker.frame(&stage, &machine, pyramids))?;
            progress.inc(1);
        }
        progress.suspend(|| -> Result<()> {
            say!("\n{}: {} frames of {} x {}", scene.name, scene.frame_count(), scene.size[0], scene.size[1]);
            say!("{}", table(&flickers));
            Ok(())
        })?;
        let filters: Vec<Value> = flickers
            .iter()
            .map(|flicker| json!({ "filter": flicker.filter().name(), "metrics": report::metrics_json(&flicker.metrics()) }))
            .collect();
        done.push(json!({ "scene": scene, "filters": filters }));
    }
    progress.finish_and_clear();
    let value = report::report_json(&machine, &std::env::args().collect::<Vec<_>>(), &done);
    write_whole(&args.output.join("frames.json"), |file| writeln!(file, "{value:#}"))?;
    Ok(ExitCode::SUCCESS)
}

fn table(flickers: &[Flicker]) -> Table {
    let header = ["filter", "RMSE\nLSB", "flicker\nLSB", "flicker\nworst", "B/pixel\ncold", "B/pixel\nwarm"];
    let mut table = framed(header, 1..);
    for flicker in flickers {
        let metrics = flicker.metrics();
        let number = |name: &str| {
            let value = metrics.iter().find(|metric| metric.name == name).and_then(|metric| metric.value);
            value.map_or_else(|| "-".into(), |value| format!("{value:.2}"))
        };
        let names = ["rmse", "flicker_rmse", "flicker_worst", "bytes_per_pixel_cold", "bytes_per_pixel_warm"];
        table.add_row([vec![flicker.filter().name().to_owned()], names.map(number).to_vec()].concat());
    }
    table
}
