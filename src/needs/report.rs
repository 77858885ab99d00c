//! Needs and savings as tables and JSON.

use comfy_table::Table;
use serde_json::{Value, json};
use texunit_hw::{AddressMode, Sampler};

use super::{Fit, ImageNeeds, LeftOut, Needs, PixelNeeds, Plan, TILE};
use crate::{names::Named, report::table::framed};

fn percent(part: u64, whole: u64) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

/// What the pixels of a scene ask for, in a few lines.
#[must_use]
pub fn pixels_text(pixels: &PixelNeeds, image: ImageNeeds) -> String {
    let share = |part: u64| format!("{:.1} %", percent(part, pixels.pixels));
    let [neither, u, v, both] = pixels.minified.map(share);
    let levels: Vec<String> = (0..)
        .zip(&pixels.levels)
        .filter(|(_, count)| **count > 0)
        .map(|(level, count): (usize, _)| match level {
            0 => format!("up to 0: {}", share(*count)),
            level => format!("{}-{level}: {}", level - 1, share(*count)),
        })
        .collect();
    let ratios: Vec<String> = (0..)
        .zip(&pixels.anisotropy)
        .filter(|(_, count)| **count > 0)
        .map(|(octave, count): (u32, _)| format!("{}-{}: {}", 1u32 << octave, 2u32 << octave, share(*count)))
        .collect();
    let range = pixels.range.map_or_else(
        || "none".into(),
        |range| {
            let [low, high] = range.map(|level| format!("{:.2}", f64::from(level) / 256.0));
            format!("{low} to {high}")
        },
    );
    let channels = match image.channels() {
        1 => "1 (opaque greys)",
        3 => "3 (opaque)",
        _ => "4",
    };
    format!(
        "magnified {}, a texel a pixel {}; minified along u only {u}, v only {v}, both {both}, neither {neither}\n\
         level of detail {range}: {}\n\
         footprint, longer over shorter axis: {}\n\
         channels {channels}",
        share(pixels.magnified),
        share(pixels.one_to_one),
        levels.join(", "),
        ratios.join(", "),
    )
}

fn address_logic(needs: &Needs, sampler: &Sampler) -> [&'static str; 2] {
    [0, 1].map(|axis| if needs.address_logic[axis] { sampler.address[axis].name() } else { "none" })
}

/// One line for each filter.
#[must_use]
pub fn needs_table(rows: &[(Needs, Sampler)]) -> Table {
    let header = [
        "filter",
        "runs as",
        "taps\nneeded %",
        "planes",
        "levels",
        "tiles\n%",
        "smallest\ntexture",
        "address\nlogic u, v",
        "u bits",
        "v bits",
        "LOD bits",
    ];
    let mut table = framed(header, 1..);
    for (needs, sampler) in rows {
        let plan = Plan::new(needs, sampler);
        let levels = needs.levels.map_or_else(
            || "-".into(),
            |levels| {
                let [low, high] = levels.map(|level| format!("{:.2}", f64::from(level) / 256.0));
                format!("{low}-{high}")
            },
        );
        let [width, height] = needs.smallest_texture();
        let [read, all] = needs.tiles();
        let bits = needs.coordinate_bits.map(|bits| format!("{}.{}", bits.integer, bits.fraction));
        let [u, v] = address_logic(needs, sampler);
        table.add_row([
            needs.filter.name().to_owned(),
            plan.sampler.filter.name().to_owned(),
            format!("{:.1}", percent(needs.needed_taps, needs.taps)),
            format!("{} of {}", needs.planes.iter().filter(|plane| plane.taps > 0).count(), needs.planes.len()),
            levels,
            format!("{:.1}", percent(read, all)),
            format!("{width} x {height}"),
            format!("{u}, {v}"),
            bits[0].clone(),
            bits[1].clone(),
            format!("{}.{}", needs.lod_bits[0], needs.lod_bits[1]),
        ]);
    }
    table
}

/// Everything [`Needs`] knows.
#[must_use]
pub fn needs_json(needs: &Needs, sampler: &Sampler) -> Value {
    let plan = Plan::new(needs, sampler);
    let planes: Vec<Value> = needs
        .planes
        .iter()
        .map(|plane| {
            json!({
                "lu": plane.halvings.0, "lv": plane.halvings.1, "width": plane.size[0], "height": plane.size[1],
                "taps": plane.taps, "tiles": plane.tiles.len(), "of_tiles": plane.tiles.all(),
                "columns": plane.window.map(|window| window[0]), "rows": plane.window.map(|window| window[1]),
            })
        })
        .collect();
    let [read, all] = needs.tiles();
    json!({
        "filter": needs.filter.name(),
        "runs_as": plan.sampler.filter.name(),
        "requests": needs.requests,
        "taps": needs.taps,
        "needed_taps": needs.needed_taps,
        "levels": needs.levels.map(|levels| levels.map(|level| f64::from(level) / 256.0)),
        "address_logic": address_logic(needs, sampler),
        "coordinate_bits": needs.coordinate_bits.map(|bits| json!({ "integer": bits.integer, "fraction": bits.fraction })),
        "lod_bits": json!({ "integer": needs.lod_bits[0], "fraction": needs.lod_bits[1] }),
        "smallest_texture": needs.smallest_texture(),
        "tile": TILE,
        "tiles": read,
        "of_tiles": all,
        "planes": planes,
    })
}

/// What was left out, for report.json; the numbers are among the filter's metrics.
#[must_use]
pub fn left_out_json(left_out: &LeftOut) -> Value {
    let LeftOut { needs, plan, channels, needs_seconds, differing, .. } = left_out;
    let planes: Vec<[u8; 2]> = plan.planes.iter().map(|&(lu, lv)| [lu, lv]).collect();
    json!({
        "runs_as": plan.sampler.filter.name(),
        "planes": planes,
        "of_planes": needs.planes.len(),
        "taps": needs.taps,
        "needed_taps": needs.needed_taps,
        "address": plan.sampler.address.map(AddressMode::name),
        "address_logic": needs.address_logic,
        "channels": channels,
        "needs_ms": needs_seconds * 1e3,
        "differing_pixels": differing,
    })
}

/// With and without, a line for each filter.
#[must_use]
pub fn left_out_table(rows: &[&LeftOut]) -> Table {
    let header = [
        "filter",
        "runs as",
        "planes",
        "chan-\nnels",
        "memory\nKiB",
        "B/pixel\nuncached",
        "B/pixel\ncached",
        "cycles\n/pixel",
        "prepared\nms",
        "host\nns/pixel",
        "needs\nns/pixel",
        "pixels\ndiffer",
    ];
    let mut table = framed(header, 1..);
    for left_out in rows {
        let LeftOut { needs, plan, channels, needs_seconds, without, with, differing } = left_out;
        let per_pixel = |value: f64| value / needs.requests.max(1) as f64;
        let change = |digits: usize, of: &dyn Fn(&super::Cost) -> f64| {
            let [whole, needed] = [without, with].map(|cost| format!("{:.digits$}", of(cost)));
            if whole == needed { whole } else { format!("{needed} of {whole}") }
        };
        table.add_row([
            needs.filter.name().to_owned(),
            plan.sampler.filter.name().to_owned(),
            change(0, &|cost| cost.planes as f64),
            channels.to_string(),
            change(0, &|cost| cost.memory_bytes as f64 / 1024.0),
            change(1, &|cost| per_pixel(cost.bytes_requested as f64)),
            change(2, &|cost| per_pixel(cost.bytes_fetched as f64)),
            change(2, &|cost| per_pixel(cost.cycles as f64)),
            change(1, &|cost| cost.prepare_seconds * 1e3),
            change(0, &|cost| per_pixel(cost.host_seconds * 1e9)),
            format!("{:.0}", per_pixel(needs_seconds * 1e9)),
            differing.to_string(),
        ]);
    }
    table
}

/// Candidates in the order they were tried.
#[must_use]
pub fn fit_table(fit: &Fit) -> Table {
    let header = [
        "setting",
        "value",
        "cache\nbytes",
        "misses",
        "cycles\n/pixel",
        "time\n%",
        "error\nRMSE LSB",
        "worst\nLSB",
        "",
    ];
    let mut table = framed(header, 1..);
    for candidate in &fit.candidates {
        let time = candidate.cycles as f64 / fit.cycles.max(1) as f64 * 100.0;
        table.add_row([
            candidate.setting.clone(),
            candidate.value.clone(),
            candidate.cache_bytes.to_string(),
            candidate.misses.to_string(),
            format!("{:.3}", candidate.cycles as f64 / fit.requests.max(1) as f64),
            format!("{time:.1}"),
            format!("{:.3}", candidate.rmse),
            candidate.worst.to_string(),
            if candidate.chosen {
                "chosen"
            } else if candidate.within {
                ""
            } else {
                "too much"
            }
            .to_owned(),
        ]);
    }
    table
}

/// The proposal with its evidence.
#[must_use]
pub fn fit_json(fit: &Fit) -> Value {
    let candidates: Vec<Value> = fit
        .candidates
        .iter()
        .map(|candidate| {
            json!({
                "setting": candidate.setting, "value": candidate.value, "cache_bytes": candidate.cache_bytes,
                "misses": candidate.misses, "cycles": candidate.cycles, "rmse": candidate.rmse, "worst": candidate.worst,
                "within": candidate.within, "chosen": candidate.chosen,
            })
        })
        .collect();
    json!({
        "filter": fit.filter.name(),
        "loss": { "time": fit.loss.time, "rmse": fit.loss.rmse },
        "cycles": fit.cycles,
        "settings": fit.settings,
        "candidates": candidates,
    })
}
