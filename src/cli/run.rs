//! `texunit run`: the main job.

use std::{
    fs::{File, TryLockError},
    io::Write,
    path::{Path, PathBuf},
    process::ExitCode,
    sync::atomic::Ordering,
};

use image::RgbaImage;
use rayon::prelude::*;
use texunit_hw::Filter;

use super::{
    STOP, progress_bar,
    scene_args::{image_size, scenes},
    stop_on_ctrl_c,
};
use crate::{
    error::{Error, Result},
    experiment::{Bench, FloatOutcome, Outcome, Pyramids, Stage, ewa, report},
    machine::Machine,
    names::{AnyFilter, Named},
    needs,
    output::{create_folder, print, write_whole},
};

/// Render scenes, prove their pixels against the reference, and count the traffic
///
/// Writes report.json, report.csv, and for every scene and filter the image and its difference from the ground truth.
/// Exit status: 0 good, 1 a pixel differs from the reference, 2 bad use.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scenes: names of those that ship (`texunit scenes` lists them) or TOML files; all that ship if none is given
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Filters, all if none is given
    #[arg(long, short, value_delimiter = ',', value_parser = AnyFilter::from_name)]
    filters: Vec<AnyFilter>,
    /// Folder for reports and images
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    output: PathBuf,
    /// Image size for every scene, instead of its own, for instance 1920x1080
    #[arg(long, value_name = "WxH", value_parser = image_size)]
    size: Option<[u32; 2]>,
    /// Print report.json on standard output instead of the tables
    #[arg(long)]
    json: bool,
    /// Run everything again without what the scene does not need, compare every pixel, and report what that saves
    #[arg(long)]
    leave_out: bool,
    #[command(flatten)]
    machine: super::MachineArgs,
}

/// Runs the command.
///
/// # Errors
/// Bad scenes, machines or folders.
pub fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    let scenes = scenes(&args.scenes, args.size)?;
    let filters: Vec<AnyFilter> =
        if args.filters.is_empty() { AnyFilter::all().collect() } else { args.filters.clone() };
    let on_pyramids: Vec<Filter> = filters.iter().map(|filter| filter.on_pyramid_of()).collect();
    create_folder(&args.output)?;
    let _lock = lock(&args.output)?;
    stop_on_ctrl_c();
    let progress = progress_bar((scenes.len() * filters.len()) as u64);
    let mut written = Written { folder: &args.output, machine: &machine, scenes: Vec::new(), rows: Vec::new() };
    let mut mismatches = 0;
    let count = scenes.len();
    for scene in scenes {
        if STOP.load(Ordering::Relaxed) {
            break;
        }
        progress.set_message(format!("{}: ground truth", scene.name));
        let stage = Stage::in_light(scene, machine.texture.srgb);
        let pyramids = Pyramids::for_filters(&machine, &stage.texture, &on_pyramids)?;
        written.truth(&stage)?;
        let measured: Vec<Option<Measured>> = filters
            .par_iter()
            .with_max_len(1)
            .map(|filter| {
                if STOP.load(Ordering::Relaxed) {
                    return Ok(None);
                }
                progress.set_message(format!("{}: {}", stage.scene.name, filter.name()));
                let mut measured = Measured::new(*filter, &stage, &machine, &pyramids, args.leave_out)?;
                written.images(&stage, filter.name(), measured.take_picture())?;
                progress.inc(1);
                Ok(Some(measured))
            })
            .collect::<Result<_>>()?;
        let (mut outcomes, mut floats) = (Vec::new(), Vec::new());
        for measured in measured.into_iter().flatten() {
            match measured {
                Measured::Unit(outcome) => outcomes.push(*outcome),
                Measured::Float(outcome) => floats.push(outcome),
            }
        }
        written.report(&stage, &outcomes, &floats)?;
        mismatches += outcomes.iter().map(|outcome| outcome.mismatches).sum::<u64>();
        mismatches +=
            outcomes.iter().flat_map(|outcome| &outcome.left_out).map(|left_out| left_out.differing).sum::<u64>();
        if !args.json {
            progress.suspend(|| print(|out| print_scene(out, &stage, &outcomes, &floats)))?;
        }
    }
    progress.finish_and_clear();
    if args.json {
        print(|out| writeln!(out, "{:#}", written.json()))?;
    }
    if written.scenes.len() < count || STOP.load(Ordering::Relaxed) {
        return Err(Error::Interrupted(args.output.clone()));
    }
    if !args.json {
        print(|out| writeln!(out, "\nReports and images: {}", args.output.display()))?;
    }
    Ok(if mismatches == 0 { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// What a filter made of a scene.
enum Measured {
    Unit(Box<Outcome>),
    Float(FloatOutcome),
}

impl Measured {
    fn new(filter: AnyFilter, stage: &Stage, machine: &Machine, pyramids: &Pyramids, leave_out: bool) -> Result<Self> {
        let (pyramid, memory) = pyramids.of(filter.on_pyramid_of());
        let AnyFilter::Unit(filter) = filter else { return Ok(Self::Float(ewa(stage, machine, pyramid)?)) };
        let bench = Bench::new(stage, machine, filter, pyramid, memory);
        let mut outcome = bench.measure(machine)?;
        if leave_out {
            outcome.left_out = Some(bench.leave_out(machine)?);
        }
        Ok(Self::Unit(Box::new(outcome)))
    }

    /// The answers, which are not needed for reports.
    fn take_picture(&mut self) -> RgbaImage {
        std::mem::take(match self {
            Self::Unit(outcome) => &mut outcome.picture,
            Self::Float(outcome) => &mut outcome.picture,
        })
    }
}

/// Keeps a second run out of the folder until the file returned is dropped: their reports and images would mix.
fn lock(folder: &Path) -> Result<File> {
    let path = folder.join(".texunit-lock");
    let file = File::options().create(true).truncate(false).write(true).open(&path).map_err(Error::io(&path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => {
            let problem = "another texunit run is writing there";
            Err(Error::setting("--output", folder.display(), problem, "wait for it, or give another folder"))
        }
        // A file system without locks: better unguarded than not at all.
        Err(TryLockError::Error(_)) => Ok(file),
    }
}

fn print_scene(
    out: &mut dyn Write,
    stage: &Stage,
    outcomes: &[Outcome],
    floats: &[FloatOutcome],
) -> std::io::Result<()> {
    let coverage = &stage.coverage;
    let behind =
        if coverage.behind > 0 { format!(", {} behind the eye and left out", coverage.behind) } else { String::new() };
    writeln!(
        out,
        "\n{}: {}\n{} x {}, {} pixels covered{behind}; errors against {} samples a pixel of the unfiltered texture",
        stage.scene.name,
        stage.scene.description,
        stage.scene.size[0],
        stage.scene.size[1],
        coverage.covered,
        stage.scene.ground_truth.samples * stage.scene.ground_truth.samples,
    )?;
    writeln!(out, "{}", report::table(outcomes, floats))?;
    let left_out: Vec<_> = outcomes.iter().filter_map(|outcome| outcome.left_out.as_ref()).collect();
    if !left_out.is_empty() {
        writeln!(out, "What is needed, after what the machine does without looking:")?;
        writeln!(out, "{}", needs::report::left_out_table(&left_out))?;
    }
    for outcome in outcomes {
        if outcome.undefined > 0 {
            writeln!(out, "{}: {} coordinates without a place", outcome.filter.name(), outcome.undefined)?;
        }
        if let Some(left_out) = outcome.left_out.as_ref().filter(|left_out| left_out.differing > 0) {
            writeln!(out, "{}: {} PIXELS DIFFER when leaving out", outcome.filter.name(), left_out.differing)?;
        }
        if let Some(first) = outcome.first_mismatch {
            writeln!(out, "{}: {} MISMATCHES; the first: {first:?}", outcome.filter.name(), outcome.mismatches)?;
        }
    }
    Ok(())
}

/// What has been written so far.
struct Written<'a> {
    folder: &'a Path,
    machine: &'a Machine,
    scenes: Vec<serde_json::Value>,
    rows: Vec<(String, &'static str, Vec<report::Metric>)>,
}

impl Written<'_> {
    /// The ground truth of a scene.
    fn truth(&self, stage: &Stage) -> Result<()> {
        let folder = self.folder.join(&stage.scene.name);
        create_folder(&folder)?;
        write_png(&folder.join("truth.png"), &stage.truth.image())
    }

    /// Image and difference of one filter.
    fn images(&self, stage: &Stage, name: &str, mut picture: RgbaImage) -> Result<()> {
        let folder = self.folder.join(&stage.scene.name);
        write_png(&folder.join(format!("{name}.png")), &picture)?;
        show_difference(stage, &mut picture);
        write_png(&folder.join(format!("{name}-difference.png")), &picture)
    }

    /// The reports anew, with one scene more: an interrupted run leaves those of the finished scenes.
    fn report(&mut self, stage: &Stage, outcomes: &[Outcome], floats: &[FloatOutcome]) -> Result<()> {
        self.scenes.push(report::scene_json(stage, outcomes, floats));
        for outcome in outcomes {
            self.rows.push((stage.scene.name.clone(), outcome.filter.name(), report::metrics(outcome)));
        }
        for outcome in floats {
            self.rows.push((stage.scene.name.clone(), outcome.filter.name(), report::float_metrics(outcome)));
        }
        let json = format!("{:#}\n", self.json());
        write_whole(&self.folder.join("report.json"), |file| file.write_all(json.as_bytes()))?;
        write_whole(&self.folder.join("report.csv"), |file| report::write_csv(file, &self.machine.name, &self.rows))
    }

    fn json(&self) -> serde_json::Value {
        report::report_json(self.machine, &std::env::args().collect::<Vec<_>>(), &self.scenes)
    }
}

/// Instead of an answer its difference from the truth: middle grey where they agree, the signed difference of each channel around it.
fn show_difference(stage: &Stage, picture: &mut RgbaImage) {
    let pixels = picture.pixels_mut().zip(&stage.truth.texels).zip(&stage.covered).filter(|(_, covered)| **covered);
    for ((pixel, truth), _) in pixels {
        let channel = |c: usize| (128.0 + f32::from(pixel.0[c]) - truth[c]).round().clamp(0.0, 255.0) as u8;
        pixel.0 = [channel(0), channel(1), channel(2), 255];
    }
}

/// Writes a PNG whole or not at all.
pub(super) fn write_png(path: &Path, image: &RgbaImage) -> Result<()> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).map_err(|error| {
        Error::file(path, "the image", error.to_string(), "report this: it should always be possible")
    })?;
    write_whole(path, |file| file.write_all(bytes.get_ref()))
}
