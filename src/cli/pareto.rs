//! `texunit pareto`: which filter, at what cost.

use std::{path::PathBuf, process::ExitCode, sync::atomic::Ordering};

use serde_json::json;

use super::{STOP, progress_bar, scene_args::SceneArgs, stop_on_ctrl_c};
use crate::{
    error::{Error, Result},
    experiment::Stage,
    machine::Machine,
    names::Named,
    output::{create_folder, write_whole},
    pareto::{Candidate, MORE_IS_BETTER, Study, mark_front, plot, scene_json, variants},
    report::table::framed,
};

/// Plot error against cost for every filter and the knobs inside it, the Pareto front marked
///
/// Writes pareto.csv, pareto.json and an SVG for every scene. Pixels are not proved against the reference: `texunit run` and
/// `texunit verify` do that.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scenes: SceneArgs,
    /// Folder for results
    #[arg(short, long, value_name = "DIR", default_value = "out/pareto")]
    output: PathBuf,
    /// The error: rmse, psnr, worst, ssim, alias_energy, blur_energy
    #[arg(long, default_value = "rmse")]
    error: String,
    /// The cost: cycles_per_pixel, energy_pj_per_pixel, bytes_per_pixel_cached, bytes_per_pixel_uncached, reads_per_pixel, misses, area_transistors, area_luts (filters with RTL only), host_ns_per_pixel
    #[arg(long, default_value = "cycles_per_pixel")]
    cost: String,
    /// Filters as the machine has them, without turning their own knobs
    #[arg(long)]
    plain: bool,
    /// Cross all with more values of a key, for instance cache.sets=16,64; may be given more than once
    #[arg(long, value_name = "KEY=V,V", value_parser = axis)]
    vary: Vec<(String, Vec<String>)>,
    #[command(flatten)]
    machine: super::MachineArgs,
}

fn axis(text: &str) -> Result<(String, Vec<String>), String> {
    let (key, values) = text.split_once('=').ok_or("write key=value,value, for instance cache.sets=16,64")?;
    Ok((key.into(), values.split(',').map(str::to_owned).collect()))
}

/// Runs the command.
///
/// # Errors
/// Bad scenes, machines, metrics or folders.
pub fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    let scenes = args.scenes.scenes()?;
    let filters = args.scenes.filters();
    create_folder(&args.output)?;
    let variants = variants(&filters, !args.plain, &args.vary);
    stop_on_ctrl_c();
    let progress = progress_bar((scenes.len() * variants.len()) as u64);
    let mut studied = Vec::new();
    for scene in scenes {
        progress.set_message(format!("{}: ground truth", scene.name));
        let stage = Stage::in_light(scene, machine.texture.srgb);
        let mut study = Study::new(&stage);
        let mut candidates = Vec::new();
        for variant in &variants {
            if STOP.load(Ordering::Relaxed) {
                progress.finish_and_clear();
                return Err(Error::Interrupted(args.output.clone()));
            }
            progress.set_message(format!("{}: {}", stage.scene.name, variant.filter.name()));
            candidates.push(study.measure(&machine, variant)?);
            progress.inc(1);
        }
        for name in [&args.error, &args.cost] {
            let known = &candidates[0].metrics;
            if known.iter().all(|metric| metric.name != name) {
                let names: Vec<&str> = known.iter().map(|metric| metric.name).collect();
                return Err(Error::setting(
                    "--error, --cost",
                    name,
                    "no such metric",
                    format!("one of {}", names.join(", ")),
                ));
            }
        }
        mark_front(&mut candidates, &args.error, &args.cost);
        let svg = plot(&stage.scene.name, &candidates, &args.error, &args.cost).svg();
        write_whole(&args.output.join(format!("{}.svg", stage.scene.name)), |file| file.write_all(svg.as_bytes()))?;
        progress.suspend(|| print(&stage.scene.name, &candidates, args))?;
        studied.push((stage.scene.name.clone(), candidates));
    }
    progress.finish_and_clear();
    write(args, &machine, &studied)?;
    Ok(ExitCode::SUCCESS)
}

/// The front, cheapest first, and how many variants it left behind.
fn print(scene: &str, candidates: &[Candidate], args: &Args) -> Result<()> {
    let columns = [
        args.cost.as_str(),
        args.error.as_str(),
        "bytes_per_pixel_cached",
        "energy_pj_per_pixel",
        "psnr",
        "ssim",
        "alias_energy",
        "worst",
        "host_ns_per_pixel",
    ];
    let mut heads = vec!["filter", "settings"];
    heads.extend(columns);
    let mut table = framed(heads, 2..);
    let mut front: Vec<&Candidate> = candidates.iter().filter(|candidate| candidate.front).collect();
    let by = |candidate: &Candidate| candidate.metric(&args.cost).unwrap_or(f64::NAN);
    front.sort_by(|a, b| by(a).total_cmp(&by(b)));
    for candidate in &front {
        let variant = &candidate.variant;
        let mut row = vec![variant.filter.name().to_owned(), variant.settings.join(" ")];
        row.extend(
            columns.iter().map(|name| candidate.metric(name).map_or_else(|| "-".into(), |value| format!("{value:.3}"))),
        );
        table.add_row(row);
    }
    let sense = if MORE_IS_BETTER.contains(&args.error.as_str()) { "more" } else { "less" };
    say!(
        "\n{scene}: {} of {} variants are on the front ({sense} {} is better)",
        front.len(),
        candidates.len(),
        args.error
    );
    say!("{table}");
    Ok(())
}

fn write(args: &Args, machine: &Machine, studied: &[(String, Vec<Candidate>)]) -> Result<()> {
    let value = json!({
        "schema": 1,
        "texunit": env!("CARGO_PKG_VERSION"),
        "command": std::env::args().collect::<Vec<_>>(),
        "machine": machine,
        "error": args.error,
        "cost": args.cost,
        "scenes": studied.iter().map(|(scene, candidates)| scene_json(scene, candidates)).collect::<Vec<_>>(),
    });
    write_whole(&args.output.join("pareto.json"), |file| writeln!(file, "{value:#}"))?;
    write_whole(&args.output.join("pareto.csv"), |file| {
        let mut csv = csv::Writer::from_writer(file);
        csv.write_record(["design", "scene", "filter", "settings", "front", "metric", "value", "unit"])?;
        for (scene, candidates) in studied {
            for Candidate { variant, metrics, front } in candidates {
                let (settings, front) = (variant.settings.join(" "), front.to_string());
                for metric in metrics {
                    let number = metric.value.map_or_else(String::new, |value| value.to_string());
                    let filter = variant.filter.name();
                    csv.write_record([
                        &machine.name,
                        scene,
                        filter,
                        &settings,
                        &front,
                        metric.name,
                        &number,
                        metric.unit,
                    ])?;
                }
            }
        }
        csv.flush()
    })?;
    say!("\nTables and plots: {}", args.output.display());
    Ok(())
}
