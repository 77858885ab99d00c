//! `texunit lod`: the rules that choose a level, with their errors.

use std::process::ExitCode;

use comfy_table::Table;

use crate::{
    error::Result,
    lod_rules::{
        edge::EdgeCompression,
        ladder::{self, published},
        polygon::PolygonRule,
    },
    names::Named,
    report::table::plain,
    scene::{Gradient, Norm, Scene, Surface},
};

/// Show the error of every log2 unit, norm and polygon rule beside the published numbers
///
/// Errors are in levels: 1 is a factor of two, negative is too sharp. "chip" is the unit as it is built, over all mantissas of
/// two octaves; "sweep" the same over 2 million ratios, uniform in their logarithm; "idea" without the widths of the chip.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Runs the command.
///
/// # Errors
/// None.
pub fn run(_args: &Args) -> Result<ExitCode> {
    say!("log2 units: error in levels\n{}", ladder_table());
    say!("\nNorms: level of six footprints (E3); sigma1 is the truth\n{}", norm_table());
    say!("\nA level for the whole polygon: 256 x 256 texture on a square (E4, E15)\n{}", polygon_table());
    say!("\n{}", edge_line()?);
    Ok(ExitCode::SUCCESS)
}

fn signed(value: f64) -> String {
    format!("{value:+.4}")
}

fn ladder_table() -> Table {
    let header = [
        "log2",
        "chip least",
        "greatest",
        "mean",
        "sweep least",
        "greatest",
        "mean",
        "idea worst",
        "mean",
        "published",
        "mean",
        "8 bits",
        "mean",
        "source",
    ];
    let mut table = plain(header, 1..header.len() - 1);
    for rung in ladder::measure() {
        let of = |error: ladder::LodError| [error.least, error.greatest, error.mean].map(signed);
        let mut row = vec![rung.log2.name().to_owned()];
        row.extend(of(rung.exhaustive));
        row.extend(of(rung.sweep));
        row.extend([format!("{:.4}", rung.unrounded.worst()), signed(rung.unrounded.mean)]);
        let known = published(rung.log2);
        let text = |value: Option<f64>, show: fn(f64) -> String| value.map_or_else(|| "-".into(), show);
        let eight = known.and_then(|known| known.eight_bits);
        row.push(text(known.map(|known| known.worst), |worst| format!("{worst:.4}")));
        row.push(text(known.and_then(|known| known.mean), signed));
        row.push(text(eight.map(|[worst, _]| worst), |worst| format!("{worst:.4}")));
        row.push(text(eight.map(|[_, mean]| mean), signed));
        row.push(known.map_or("", |known| known.source).into());
        table.add_row(row);
    }
    table
}

fn norm_table() -> Table {
    const R: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let cases: [(&str, [f64; 4]); 6] = [
        ("8x, rotated 45", [8.0 * R, -8.0 * R, 8.0 * R, 8.0 * R]),
        ("8:1, texture rotated 45", [8.0 * R, -R, 8.0 * R, R]),
        ("8:1, screen rotated 45", [8.0 * R, -8.0 * R, R, R]),
        ("u-shear: ux = uy = 8", [8.0, 8.0, 0.0, 0.0]),
        ("u and v together: ux = vx = 8", [8.0, 0.0, 8.0, 0.0]),
        ("all entries 8", [8.0; 4]),
    ];
    let mut header = vec!["footprint"];
    header.extend(Norm::ALL.map(Norm::name));
    let mut table = plain(header, 1..);
    for (name, [ux, uy, vx, vy]) in cases {
        let level = |norm: Norm| {
            let squared = f64::from(norm.squared_ratio(Gradient { ux, uy, vx, vy }));
            if squared > 1e-9 { format!("{:.2}", libm::log2(squared) / 2.0) } else { "-inf".into() }
        };
        table.add_row([name.to_owned()].into_iter().chain(Norm::ALL.map(level)));
    }
    table
}

fn polygon_table() -> Table {
    let header = ["pixels on a side", "texels : pixels", "exact", "Herf as printed", "Herf halved", "Flavell"];
    let mut table = plain(header, ..);
    for side in [256.0, 147.8, 128.0, 100.0, 96.8, 64.0, 32.0] {
        let ratio = (256.0 / side) * (256.0 / side);
        let levels = PolygonRule::ALL.map(|rule| rule.level(256.0 * 256.0, side * side, 8).to_string());
        let first = [format!("{side}"), format!("{ratio:.2}"), format!("{:.2}", libm::log2(256.0 / side))];
        table.add_row(first.into_iter().chain(levels));
    }
    table
}

/// Flavell's formula on every pixel of the floor.
fn edge_line() -> Result<String> {
    let scene = Scene::builtin("floor")?;
    let Surface::Plane(plane) = scene.surface() else { return Ok(String::new()) };
    let size = scene.texture.size();
    let edges = EdgeCompression::new(plane.matrix, 0..scene.size[0], size);
    let mut worst: f64 = 0.0;
    let mut pixels = 0;
    for fragment in scene.fragments() {
        let squared = f64::from(Norm::Heckbert.squared_ratio(fragment.gradient.in_texels(size)));
        let found = edges.scanline(fragment.y.into()).compression(fragment.x.into());
        worst = worst.max((libm::log2(found) - libm::log2(squared) / 2.0).abs());
        pixels += 1;
    }
    Ok(format!(
        "Flavell's edge compression, one root a row and one a column (E27): {pixels} pixels of the floor, {worst:.1e} of a level from \
         the heckbert norm at worst;\na pixel takes 2 multiplications and 1 comparison, against 6, 2 additions and 1 comparison"
    ))
}
