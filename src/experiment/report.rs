//! What a run says: one structure, printed as a table, as JSON and as long-form CSV.

use comfy_table::Table;
use serde::Serialize;
use serde_json::{Value, json};

use texunit_hw::cache::Counters;

use super::{Deviation, FloatOutcome, Outcome, Stage};
use crate::{
    machine::Machine,
    names::Named,
    needs::{self, LeftOut},
    report::table::framed,
};

/// Version of the shape of report.json; it grows when a field changes its meaning or goes away.
pub const SCHEMA: u32 = 1;

/// One number with what it is called and its unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metric {
    /// Name, the same in JSON and CSV.
    pub name: &'static str,
    /// Value; none where there is no such number (the PSNR of equal images).
    pub value: Option<f64>,
    /// Unit.
    pub unit: &'static str,
}

/// Names of the numbers of a deviation from the ground truth, for [`deviation_metrics`].
pub const AGAINST_TRUTH: [&str; 4] = ["rmse", "psnr", "worst", "mean_difference"];

/// The numbers of a deviation: root mean square, peak signal to noise, worst and mean difference, by these names.
#[must_use]
pub fn deviation_metrics(names: [&'static str; 4], deviation: &Deviation) -> [Metric; 4] {
    let metric = |name, value, unit| Metric { name, value, unit };
    [
        metric(names[0], Some(deviation.rmse()), "LSB"),
        metric(names[1], deviation.psnr(), "dB"),
        metric(names[2], Some(deviation.worst()), "LSB"),
        metric(names[3], Some(deviation.mean()), "LSB"),
    ]
}

/// What a cache did, and what that is for each pixel.
#[must_use]
pub fn traffic_metrics(counters: &Counters, pixels: u64) -> Vec<Metric> {
    let per_pixel = |count: u64| count as f64 / pixels.max(1) as f64;
    let share = |part: u64, whole: u64| if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
    vec![
        metric("pixels", pixels as f64, "pixel"),
        metric("reads_per_pixel", per_pixel(counters.lookups), "read/pixel"),
        metric("lookups", counters.lookups as f64, "read"),
        metric("hits", counters.hits as f64, "read"),
        metric("misses", counters.misses as f64, "read"),
        metric("miss_rate", share(counters.misses, counters.lookups), "1"),
        metric("compulsory_misses", counters.compulsory as f64, "read"),
        metric("capacity_misses", counters.capacity as f64, "read"),
        metric("conflict_misses", counters.conflict as f64, "read"),
        metric("bytes_requested", counters.bytes_requested as f64, "B"),
        metric("bytes_fetched", counters.bytes_fetched as f64, "B"),
        metric("bytes_filled", counters.bytes_filled as f64, "B"),
        metric("bytes_used", counters.bytes_used as f64, "B"),
        metric("line_use", share(counters.bytes_used, counters.bytes_filled), "1"),
        metric("bytes_per_pixel_uncached", per_pixel(counters.bytes_requested), "B/pixel"),
        metric("bytes_per_pixel_cached", per_pixel(counters.bytes_fetched), "B/pixel"),
    ]
}

fn metric(name: &'static str, value: f64, unit: &'static str) -> Metric {
    Metric { name, value: Some(value), unit }
}

/// Nanoseconds of this computer a pixel.
#[must_use]
pub fn host_metric(seconds: f64, pixels: u64) -> Metric {
    metric("host_ns_per_pixel", seconds * 1e9 / pixels.max(1) as f64, "ns/pixel")
}

/// Everything countable about an outcome, in the order of the report.
#[must_use]
pub fn metrics(outcome: &Outcome) -> Vec<Metric> {
    let pixels = outcome.pixels;
    let mut metrics = traffic_metrics(&outcome.counters, pixels);
    metrics.extend([
        metric("pyramid_texels", outcome.memory.texels as f64, "texel"),
        metric("pyramid_multiple", outcome.memory.multiple(), "texture"),
        metric("pyramid_bytes", outcome.memory.bytes as f64, "B"),
        metric("undefined_coordinates", outcome.undefined as f64, "coordinate"),
        metric("mismatches", outcome.mismatches as f64, "pixel"),
        host_metric(outcome.host_seconds, pixels),
    ]);
    metrics.extend(deviation_metrics(AGAINST_TRUTH, &outcome.against_truth));
    metrics
        .extend(deviation_metrics(["rmse_ideal", "psnr_ideal", "worst_ideal", "mean_ideal"], &outcome.against_ideal));
    metrics.extend(outcome.quality.metrics());
    metrics.extend(outcome.timed.metrics());
    metrics.extend(outcome.left_out.iter().flat_map(LeftOut::metrics));
    metrics
}

/// Metrics as JSON: name to value and unit.
#[must_use]
pub fn metrics_json(metrics: &[Metric]) -> Value {
    metrics
        .iter()
        .map(|metric| (metric.name.to_owned(), json!({ "value": metric.value, "unit": metric.unit })))
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// The same of a filter in floats: no cache, no bits, no memory of its own.
#[must_use]
pub fn float_metrics(outcome: &FloatOutcome) -> Vec<Metric> {
    let pixels = outcome.pixels;
    let per_pixel = outcome.texels_read as f64 / pixels.max(1) as f64;
    let mut metrics = vec![
        metric("pixels", pixels as f64, "pixel"),
        metric("reads_per_pixel", per_pixel, "read/pixel"),
        metric("lookups", outcome.texels_read as f64, "read"),
        host_metric(outcome.host_seconds, pixels),
    ];
    metrics.extend(deviation_metrics(AGAINST_TRUTH, &outcome.against_truth));
    metrics
}

/// The table of one scene; filters in floats come last, with their counts and errors only.
#[must_use]
pub fn table(outcomes: &[Outcome], floats: &[FloatOutcome]) -> Table {
    let header = [
        "filter",
        "cycles\n/pixel",
        "reads\n/pixel",
        "misses",
        "miss\nrate %",
        "B/pixel\nuncached",
        "B/pixel\ncached",
        "line\nuse %",
        "memory\nx texture",
        "RMSE\nLSB",
        "PSNR\ndB",
        "worst\nLSB",
        "mis-\nmatches",
        "host\nns/pixel",
    ];
    let mut table = framed(header, 1..);
    let rows = outcomes.iter().map(|outcome| (outcome.filter.name().to_owned(), metrics(outcome)));
    let in_floats = floats.iter().map(|outcome| (format!("{} (float)", outcome.filter.name()), float_metrics(outcome)));
    for (name, metrics) in rows.chain(in_floats) {
        let number = |name: &str, digits: usize, scale: f64| {
            let value = metrics.iter().find(|metric| metric.name == name).and_then(|metric| metric.value);
            value.map_or_else(|| "-".into(), |value| format!("{:.digits$}", value * scale))
        };
        table.add_row([
            name,
            number("cycles_per_pixel", 2, 1.0),
            number("reads_per_pixel", 1, 1.0),
            number("misses", 0, 1.0),
            number("miss_rate", 2, 100.0),
            number("bytes_per_pixel_uncached", 1, 1.0),
            number("bytes_per_pixel_cached", 1, 1.0),
            number("line_use", 0, 100.0),
            number("pyramid_multiple", 3, 1.0),
            number("rmse", 2, 1.0),
            number("psnr", 2, 1.0),
            number("worst", 0, 1.0),
            number("mismatches", 0, 1.0),
            number("host_ns_per_pixel", 0, 1.0),
        ]);
    }
    table
}

/// One scene of report.json.
#[must_use]
pub fn scene_json(stage: &Stage, outcomes: &[Outcome], floats: &[FloatOutcome]) -> Value {
    let in_floats = floats.iter().map(|outcome| {
        let metrics = metrics_json(&float_metrics(outcome));
        json!({ "filter": outcome.filter.name(), "float_only": true, "metrics": metrics })
    });
    let filters: Vec<Value> = outcomes
        .iter()
        .map(|outcome| {
            let metrics = metrics_json(&metrics(outcome));
            let planes: Vec<Value> = outcome
                .planes
                .iter()
                .map(|row| {
                    json!({
                        "lu": row.halvings.0, "lv": row.halvings.1, "width": row.size[0], "height": row.size[1],
                        "lookups": row.counters.lookups, "hits": row.counters.hits, "misses": row.counters.misses,
                        "compulsory": row.counters.classes.compulsory, "capacity": row.counters.classes.capacity,
                        "conflict": row.counters.classes.conflict,
                    })
                })
                .collect();
            let mut filter = json!({ "filter": outcome.filter.name(), "metrics": metrics, "planes": planes });
            if let Some(left_out) = &outcome.left_out {
                filter["left_out"] = needs::report::left_out_json(left_out);
            }
            filter
        })
        .chain(in_floats)
        .collect();
    json!({
        "scene": stage.scene,
        "coverage": stage.coverage,
        "filters": filters,
    })
}

/// The whole of report.json.
#[must_use]
pub fn report_json(machine: &Machine, command: &[String], scenes: &[Value]) -> Value {
    json!({
        "schema": SCHEMA,
        "texunit": env!("CARGO_PKG_VERSION"),
        "command": command,
        "machine": machine,
        "scenes": scenes,
    })
}

/// One line of report.csv a metric: design, scene, filter, metric, value, unit.
///
/// # Errors
/// Those of the writer.
pub fn write_csv(
    writer: &mut dyn std::io::Write,
    design: &str,
    rows: &[(String, &'static str, Vec<Metric>)],
) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    csv.write_record(["design", "scene", "filter", "metric", "value", "unit"])?;
    for (scene, filter, metrics) in rows {
        for metric in metrics {
            let value = metric.value.map_or_else(String::new, |value| value.to_string());
            csv.write_record([design, scene, filter, metric.name, &value, metric.unit])?;
        }
    }
    csv.flush()
}
