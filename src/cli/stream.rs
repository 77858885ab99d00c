//! `texunit stream`: the unit driven by requests from elsewhere.

use std::{path::PathBuf, process::ExitCode};

use comfy_table::Table;
use image::RgbaImage;
use serde_json::{Value, json};
use texunit_hw::{AddressMode, Filter};

use crate::{
    error::{Error, Result},
    experiment::report,
    machine::parser,
    names::Named,
    output::{create_folder, print, write_whole},
    report::table::framed,
    scene::{Camera, Rotation},
    stream::{Stream, StreamOutcome, StreamRun, mesh::Mesh, raster::rasterize, requests_file},
};

/// Drive the unit with requests from elsewhere: another renderer's, a simulator's, or a mesh
///
/// Textures and filters may change from request to request; one cache sees them all. Every answer is compared with the reference, and
/// with the mean of the unfiltered texture over the request's own parallelogram. Exit status: 0 good, 1 an answer differs from the
/// reference, 2 bad use.
#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("source").required(true).args(["requests", "mesh"])))]
pub struct Args {
    /// Requests as CSV (or Parquet, in a build with that feature): columns u, v, dudx, dvdx, dudy, dvdy, and if wanted x, y, texture, filter
    #[arg(long, value_name = "FILE")]
    requests: Option<PathBuf>,
    /// A Wavefront OBJ mesh with the textures its MTL file names (or glTF, in a build with that feature), turned to fill the picture
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
    /// Image file of a texture of the requests, and its name there; more than once for more
    #[arg(long, value_name = "NAME=FILE", value_parser = named_file)]
    texture: Vec<(String, PathBuf)>,
    /// Filters, each a run of its own; requests that name a filter keep theirs
    #[arg(long, short, value_delimiter = ',', value_parser = parser::<Filter>(), default_value = "trilinear")]
    filters: Vec<Filter>,
    /// Address mode of both axes: wrap, clamp, clip, mirror
    #[arg(long, value_parser = parser::<AddressMode>(), default_value = "wrap")]
    wrap: AddressMode,
    /// Picture of a mesh
    #[arg(long, value_name = "WxH", value_parser = super::scene_args::image_size, default_value = "640x480")]
    size: [u32; 2],
    /// Turn a mesh about its x, then its y, then its z axis, degrees
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true,
        default_value = "0,0,0"
    )]
    turn: Vec<f64>,
    /// Vertical angle of view of a mesh, degrees, 1 to 170
    #[arg(long, default_value_t = 45.0)]
    field_of_view: f64,
    /// Folder for stream.json, stream.csv, and per filter the answers as CSV and the picture, if requests have pixels
    #[arg(long, short)]
    output: Option<PathBuf>,
    /// Print stream.json on standard output instead of the tables
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    machine: super::MachineArgs,
}

/// `NAME=FILE`, or a file that goes by its own name.
fn named_file(text: &str) -> Result<(String, PathBuf), String> {
    let (name, file) = text.split_once('=').unwrap_or((text, text));
    if name.is_empty() || file.is_empty() {
        return Err("write NAME=FILE".into());
    }
    Ok((name.to_owned(), file.into()))
}

/// Runs the command.
///
/// # Errors
/// Bad files, machines or settings.
pub fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    let stream = stream(args)?;
    let wrap = [args.wrap; 2];
    let mut rows = Vec::new();
    let mut told = Vec::new();
    let mut mismatches = 0;
    let progress = super::progress_bar(args.filters.len() as u64);
    for &filter in &args.filters {
        progress.set_message(filter.name());
        let outcome = StreamRun::new(&stream, &machine, filter, wrap)?.measure()?;
        progress.inc(1);
        mismatches += outcome.mismatches;
        if !args.json {
            print(|out| writeln!(out, "\n{}\n{}", table(&stream, filter, &outcome), summary(&stream, &outcome)))?;
        }
        if let Some(folder) = &args.output {
            create_folder(folder)?;
            answers(&outcome, &folder.join(format!("answers-{}.csv", filter.name())))?;
            if let Some(picture) = picture(&stream, &outcome) {
                super::run::write_png(&folder.join(format!("{}.png", filter.name())), &picture)?;
            }
        }
        let metrics = metrics(&stream, &outcome);
        told.push(json!({
            "filter": filter.name(),
            "metrics": report::metrics_json(&metrics),
            "parts": parts(&stream, &outcome),
        }));
        rows.push(("stream".to_owned(), filter.name(), metrics));
    }
    progress.finish_and_clear();
    let command: Vec<String> = std::env::args().collect();
    let scene = json!({ "name": "stream", "requests": stream.requests.len(), "filters": told });
    let value = report::report_json(&machine, &command, &[scene]);
    if args.json {
        print(|out| writeln!(out, "{value:#}"))?;
    }
    if let Some(folder) = &args.output {
        write_whole(&folder.join("stream.json"), |file| writeln!(file, "{value:#}"))?;
        write_whole(&folder.join("stream.csv"), |file| report::write_csv(file, &machine.name, &rows))?;
    }
    Ok(ExitCode::from(u8::from(mismatches > 0)))
}

fn stream(args: &Args) -> Result<Stream> {
    if let Some(requests) = &args.requests {
        return requests_file::load(requests, &args.texture);
    }
    let file = args.mesh.as_deref().expect("clap asks for one of the two");
    if !(1.0..=170.0).contains(&args.field_of_view) {
        return Err(Error::setting("--field-of-view", args.field_of_view, "out of range", "use 1 to 170 degrees"));
    }
    let turn = <[f64; 3]>::try_from(args.turn.as_slice()).map_err(|_| {
        Error::setting("--turn", args.turn.len(), "three angles are meant", "for instance --turn -20,30,0")
    })?;
    let mut mesh = Mesh::load(file)?;
    mesh.put_in_view(Rotation::Euler(turn).matrix(), args.field_of_view);
    let stream = rasterize(mesh, Camera { field_of_view: args.field_of_view }, args.size);
    if stream.requests.is_empty() {
        return Err(Error::file(file, "its faces", "no pixel is covered", "make the picture larger"));
    }
    Ok(stream)
}

fn metrics(stream: &Stream, outcome: &StreamOutcome) -> Vec<report::Metric> {
    let requests = stream.requests.len() as u64;
    let mut metrics = report::traffic_metrics(&outcome.counters, requests);
    let mut add = |name, value, unit| metrics.push(report::Metric { name, value: Some(value), unit });
    add("pyramid_bytes", outcome.memory as f64, "B");
    add("undefined_coordinates", outcome.undefined as f64, "1");
    add("mismatches", outcome.mismatches as f64, "1");
    add("cycles_per_pixel", outcome.timing.cycles as f64 / requests as f64, "clock/pixel");
    metrics.extend(report::deviation_metrics(report::AGAINST_TRUTH, &outcome.against_truth));
    metrics
}

fn parts(stream: &Stream, outcome: &StreamOutcome) -> Vec<Value> {
    let part = |part: &crate::stream::PartOutcome| {
        json!({
            "texture": stream.textures[part.texture].name,
            "filter": part.filter.name(),
            "requests": part.requests,
            "lookups": part.traffic.lookups,
            "hits": part.traffic.hits,
            "misses": part.traffic.misses,
        })
    };
    outcome.parts.iter().map(part).collect()
}

fn table(stream: &Stream, filter: Filter, outcome: &StreamOutcome) -> Table {
    let mut table = framed(["texture", "filter", "requests", "reads", "misses", "miss rate %"], 2..);
    let row = |name: &str, filter: &str, requests: u64, lookups: u64, misses: u64| {
        let rate = 100.0 * misses as f64 / lookups.max(1) as f64;
        [
            name.into(),
            filter.into(),
            requests.to_string(),
            lookups.to_string(),
            misses.to_string(),
            format!("{rate:.2}"),
        ]
    };
    for part in &outcome.parts {
        let name = &stream.textures[part.texture].name;
        table.add_row(row(name, part.filter.name(), part.requests, part.traffic.lookups, part.traffic.misses));
    }
    let requests = stream.requests.len() as u64;
    let counters = &outcome.counters;
    table.add_row(row("all", filter.name(), requests, counters.lookups, counters.misses));
    table
}

fn summary(stream: &Stream, outcome: &StreamOutcome) -> String {
    let requests = stream.requests.len() as u64;
    let per_request = |count: u64| count as f64 / requests as f64;
    format!(
        "{:.2} clocks and {:.1} bytes a request ({:.1} without a cache); RMSE {:.2} LSB, worst {:.0}; {} mismatches; {} coordinates \
         without a place",
        per_request(outcome.timing.cycles),
        per_request(outcome.counters.bytes_fetched),
        per_request(outcome.counters.bytes_requested),
        outcome.against_truth.rmse(),
        outcome.against_truth.worst(),
        outcome.mismatches,
        outcome.undefined,
    )
}

/// Answers, a row a request, in order.
fn answers(outcome: &StreamOutcome, path: &std::path::Path) -> Result<()> {
    write_whole(path, |file| {
        writeln!(file, "r,g,b,a,lod,lod_v")?;
        for response in &outcome.responses {
            let [r, g, b, a] = response.texel;
            let [lod, lod_v] = response.lod.map(|level| f64::from(level) / 256.0);
            writeln!(file, "{r},{g},{b},{a},{lod},{lod_v}")?;
        }
        Ok(())
    })
}

/// The picture: of a pixel drawn over, the last.
fn picture(stream: &Stream, outcome: &StreamOutcome) -> Option<RgbaImage> {
    let [width, height] = stream.size?;
    let mut picture = RgbaImage::new(width, height);
    for (request, response) in stream.requests.iter().zip(&outcome.responses) {
        picture.put_pixel(request.fragment.x.into(), request.fragment.y.into(), image::Rgba(response.texel));
    }
    Some(picture)
}
