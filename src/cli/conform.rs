//! `texunit conform`: is every answer one that the promised bits allow?

use std::process::ExitCode;

use clap::ArgAction;
use comfy_table::Table;
use texunit_hw::{
    Filter,
    peers::{Arithmetic, MACHINES},
};

use super::{
    progress_bar,
    scene_args::{image_size, scenes},
};
use crate::{
    conform::{
        FILTERS, Precision,
        largest::{self, Largest},
        scenes::{Finding, LevelRule, judge_peer, judge_scene, peer_filter},
        unknown,
    },
    error::Result,
    machine::{Machine, PROFILES, parser},
    names::Named,
    output::print,
    report::table::framed,
};

/// Judge every sample of a scene as a conformance suite judges a driver
///
/// An answer is held against all that so many bits of precision allow. The rule is that of dEQP's lookup verifier: a coordinate may be off by 2^-subtexel texels and a level by 2^-mipmap, and every texel
/// and weight these can select is a candidate. It knows point, bilinear, nearest-mip and trilinear; no API promises bits for the
/// other filters. Exit status: 0 all allowed, 1 an answer is refused (said in words: which pixel, which interval, how far off), 2 bad use.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scenes: names of those that ship (`texunit scenes` lists them) or TOML files; all that ship if none is given
    #[arg(value_name = "SCENE", conflicts_with = "largest")]
    scenes: Vec<String>,
    /// Filters: point, bilinear, nearest-mip, trilinear; all four if none is given
    #[arg(long, short, value_delimiter = ',', value_parser = parser::<Filter>())]
    filters: Vec<Filter>,
    /// Bits of the sub-texel fraction (Direct3D 11: 8; Vulkan: 4, Roadmap 2022: 8)
    #[arg(long, value_name = "BITS", default_value_t = 8, value_parser = clap::value_parser!(u8).range(0..=24))]
    subtexel: u8,
    /// Bits of the level fraction (Direct3D 11: 8; Vulkan: 4, Roadmap 2022: 6)
    #[arg(long, value_name = "BITS", default_value_t = 8, value_parser = clap::value_parser!(u8).range(0..=24))]
    mipmap: u8,
    /// Bits of a float coordinate that count; the suite takes 20 of 24
    #[arg(long, value_name = "BITS", default_value_t = 20, value_parser = clap::value_parser!(u8).range(1..=53))]
    coordinate: u8,
    /// How far a channel may lie from an allowed colour, in units of its last bit
    #[arg(long, value_name = "LSB", default_value_t = 0.5, value_parser = tolerance)]
    tolerance: f64,
    /// Allow every level an API allows for a gradient, not only that of the machine's norm
    #[arg(long)]
    any_norm: bool,
    /// Image size for every scene, instead of its own
    #[arg(long, value_name = "WxH", value_parser = image_size, conflicts_with = "largest")]
    size: Option<[u32; 2]>,
    /// Instead of scenes: the largest texture at which all samples are allowed, for every machine that ships, or the one named
    #[arg(long, action = ArgAction::SetTrue)]
    largest: bool,
    /// Print JSON instead of the table
    #[arg(long)]
    json: bool,
    /// Machine: a name that ships (`texunit explain` lists them) or a TOML file [default: herf-12.20; with --largest: all]
    #[arg(long, short, value_name = "NAME|FILE")]
    machine: Option<String>,
    /// Instead of a machine, the arithmetic of another (texunit peers lists them), behind this one's front end; bilinear and trilinear
    #[arg(long, value_name = "NAME", conflicts_with_all = ["machine", "set", "largest"], value_parser = arithmetic)]
    arithmetic: Option<&'static Arithmetic>,
    /// One setting on top of the machine, for instance filter.bits=6; may be given more than once
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

fn arithmetic(name: &str) -> Result<&'static Arithmetic, String> {
    Arithmetic::named(name).ok_or_else(|| {
        let names: Vec<&str> = MACHINES.iter().map(|machine| machine.name).collect();
        format!("no arithmetic is named `{name}`: use {}", names.join(", "))
    })
}

fn tolerance(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (0.0..=255.0).contains(value));
    value.ok_or_else(|| "a number of 0 to 255, for instance 0.5".into())
}

/// Runs the command.
///
/// # Errors
/// Bad machines, scenes and filters.
pub fn run(args: &Args) -> Result<ExitCode> {
    if let Some(filter) = args.filters.iter().find(|filter| !FILTERS.contains(filter)) {
        return Err(unknown(*filter));
    }
    let has = |filter: &Filter| args.arithmetic.is_none_or(|peer| peer_filter(peer, *filter).is_ok());
    let filters =
        if args.filters.is_empty() { FILTERS.into_iter().filter(has).collect() } else { args.filters.clone() };
    let precision = Precision {
        subtexel: args.subtexel,
        mipmap: args.mipmap,
        coordinate: args.coordinate,
        tolerance: args.tolerance,
    };
    if args.largest { run_largest(args, &filters, precision) } else { run_scenes(args, &filters, precision) }
}

fn run_scenes(args: &Args, filters: &[Filter], precision: Precision) -> Result<ExitCode> {
    let machine = Machine::load(args.machine.as_deref().unwrap_or(super::MachineArgs::DEFAULT), &args.set)?;
    let name = args.arithmetic.map_or(machine.name.as_str(), |peer| peer.name);
    let rule = if args.any_norm { LevelRule::Suite } else { LevelRule::Norm };
    let scenes = scenes(&args.scenes, args.size)?;
    let progress = progress_bar((scenes.len() * filters.len()) as u64);
    let mut findings: Vec<Finding> = Vec::new();
    for scene in &scenes {
        progress.set_message(scene.name.clone());
        let done = |_: &Finding| progress.inc(1);
        findings.extend(match args.arithmetic {
            Some(peer) => judge_peer(peer, scene, filters, precision, rule, done)?,
            None => judge_scene(&machine, scene, filters, precision, rule, done)?,
        });
    }
    progress.finish_and_clear();
    let refused: u64 = findings.iter().map(|finding| finding.refused).sum();
    if args.json {
        let report = serde_json::json!({
            "machine": name, "subtexel": precision.subtexel, "mipmap": precision.mipmap, "coordinate": precision.coordinate,
            "tolerance": precision.tolerance, "any-norm": args.any_norm, "refused": refused, "findings": findings,
        });
        print(|out| writeln!(out, "{report:#}"))?;
    } else {
        let samples: u64 = findings.iter().map(|finding| finding.samples).sum();
        print(|out| {
            writeln!(out, "{}", table(&findings))?;
            writeln!(
                out,
                "{}: {samples} samples at {} sub-texel and {} level bits, {refused} refused",
                name, precision.subtexel, precision.mipmap
            )
        })?;
    }
    for explained in findings.iter().flat_map(|finding| &finding.explained).take(SHOWN) {
        eprintln!("texunit: {explained}");
    }
    Ok(if refused == 0 { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// Refusals explained on a terminal; JSON has two of each scene and filter.
const SHOWN: usize = 4;

fn table(findings: &[Finding]) -> Table {
    let header = ["scene", "filter", "samples", "undecided", "refused", "worst off"];
    let mut table = framed(header, 2..);
    for finding in findings {
        let worst = if finding.refused == 0 { "-".into() } else { format!("{:.2}", finding.worst) };
        let counts = [finding.samples, finding.undecided, finding.refused].map(|count| count.to_string());
        table.add_row([finding.scene.clone(), finding.filter.into()].into_iter().chain(counts).chain([worst]));
    }
    table
}

fn run_largest(args: &Args, filters: &[Filter], precision: Precision) -> Result<ExitCode> {
    let names: Vec<&str> =
        args.machine.as_deref().map_or_else(|| PROFILES.iter().map(|(name, _)| *name).collect(), |name| vec![name]);
    let machines = names.iter().map(|name| Machine::load(name, &args.set)).collect::<Result<Vec<_>>>()?;
    let peers = if args.machine.is_some() { &[] } else { MACHINES };
    let progress = progress_bar(((machines.len() + peers.len()) * filters.len()) as u64);
    let mut rows: Vec<Row> = Vec::new();
    for &filter in filters {
        for machine in &machines {
            progress.set_message(machine.name.clone());
            let largest = largest::of_machine(machine, filter, precision)?;
            rows.push(Row { kind: "machine", name: machine.name.clone(), filter: filter.name(), largest });
            progress.inc(1);
        }
        for peer in peers {
            progress.set_message(peer.name);
            if let Some(largest) = largest::of_peer(peer, filter, precision)? {
                rows.push(Row { kind: "arithmetic", name: peer.name.into(), filter: filter.name(), largest });
            }
            progress.inc(1);
        }
    }
    progress.finish_and_clear();
    if args.json {
        let report = serde_json::json!({ "subtexel": precision.subtexel, "mipmap": precision.mipmap, "rows": rows });
        print(|out| writeln!(out, "{report:#}"))?;
    } else {
        print(|out| {
            writeln!(out, "{}", largest_table(&rows))?;
            writeln!(
                out,
                "Sides of textures, from {} to {} texels, up to which all samples are allowed at {} sub-texel and {} level bits.\n\
                 arithmetic: the sums of another machine alone (texunit peers); machine: this unit, set as the profile says",
                1 << largest::SIZES.start(),
                1 << largest::SIZES.end(),
                precision.subtexel,
                precision.mipmap
            )
        })?;
        if let (Some(_), Some(row)) = (&args.machine, rows.first()) {
            row.largest.why.iter().for_each(|why| eprintln!("texunit: {}, {}: {why}", row.name, row.filter));
        }
    }
    // A question of how far, not of whether; but who is asked for by name and passes nowhere fails.
    let nowhere = rows.iter().any(|row| row.largest.power_of_two.is_none());
    Ok(if nowhere && args.machine.is_some() { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

#[derive(serde::Serialize)]
struct Row {
    kind: &'static str,
    name: String,
    filter: &'static str,
    largest: Largest,
}

fn largest_table(rows: &[Row]) -> Table {
    let header = ["", "machine", "filter", "largest 2^k", "largest 2^k - 1"];
    let mut table = framed(header, 3..);
    for Row { kind, name, filter, largest } in rows {
        let size = |size: Option<u32>| size.map_or_else(|| "none".into(), |size| size.to_string());
        table.add_row([(*kind).into(), name.clone(), (*filter).into(), size(largest.power_of_two), size(largest.odd)]);
    }
    table
}
