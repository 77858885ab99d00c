//! A run on the page: what every filter costs on a scene, what stalls it, what could be left out, and its images side by side.

use maud::{Markup, html};
use serde_json::Value;

use super::{
    provenance::provenance,
    results::{Results, scene_name},
};

/// Columns of the table of filters: metric, heading, unit, decimals, factor, and whether less or more is better, if either.
const COLUMNS: [(&str, &str, &str, usize, f64, i8); 18] = [
    ("cycles_per_pixel", "cycles", "/pixel", 2, 1.0, -1),
    ("energy_pj_per_pixel", "energy", "pJ/pixel", 0, 1.0, -1),
    ("reads_per_pixel", "reads", "/pixel", 1, 1.0, 0),
    ("miss_rate", "misses", "% of reads", 2, 100.0, 0),
    ("bytes_per_pixel_uncached", "uncached", "B/pixel", 1, 1.0, 0),
    ("bytes_per_pixel_cached", "cached", "B/pixel", 2, 1.0, -1),
    ("line_use", "line use", "%", 0, 100.0, 1),
    ("pyramid_multiple", "memory", "x texture", 3, 1.0, 0),
    ("rmse", "RMSE", "LSB", 2, 1.0, -1),
    ("psnr", "PSNR", "dB", 2, 1.0, 1),
    ("ssim", "SSIM", "", 4, 1.0, 1),
    ("alias_energy", "alias", "LSB²", 1, 1.0, -1),
    ("blur_energy", "blur", "LSB²", 1, 1.0, -1),
    ("worst", "worst", "LSB", 0, 1.0, -1),
    ("flicker_rmse", "flicker", "LSB", 2, 1.0, -1),
    ("bytes_per_pixel_warm", "warm cache", "B/pixel", 2, 1.0, -1),
    ("mismatches", "mismatches", "pixels", 0, 1.0, 0),
    ("host_ns_per_pixel", "this host", "ns/pixel", 0, 1.0, 0),
];

pub(super) fn run_section(number: usize, results: &Results, run: &Value, scene: &Value) -> Markup {
    let name = scene_name(scene);
    let filters: Vec<&str> =
        scene["filters"].as_array().into_iter().flatten().filter_map(|filter| filter["filter"].as_str()).collect();
    let id = |image: &str| format!("i{number}-{name}-{image}");
    let images: Vec<(&str, String, &str)> = ["truth"]
        .into_iter()
        .chain(filters.iter().copied())
        .filter_map(|image| Some((image, id(image), results.image(&name, &format!("{image}.png"))?)))
        .collect();
    html! {
        p { (scene["scene"]["description"].as_str().unwrap_or_default()) }
        figure { div.wide { (filter_table(scene)) } figcaption { "Every filter on this scene; the best of a column stands out." } }
        (stall_bars(scene))
        (saved(scene))
        @if images.len() > 1 {
            figure {
                div.choice {
                    @for side in 0..2_usize {
                        select aria-label=(if side == 0 { "image on the left" } else { "image on the right" }) {
                            @for (place, (image, id, _)) in images.iter().enumerate() {
                                option value=(id) selected[place == preferred(side, &images)] { (image) }
                            }
                        }
                    }
                }
                div.compare { img alt=""; img alt=""; }
                input.slide type="range" min="0" max="100" value="50" aria-label="how much of either";
                figcaption { "Two images at the same place: choose both, and move the line between them." }
            }
            div.gallery {
                @for (image, id, data) in &images {
                    div.pair {
                        figure { img id=(id) src=(data) alt={ (name) ", " (image) }; figcaption { (image) } }
                        @if let Some(difference) = results.image(&name, &format!("{image}-difference.png")) {
                            figure {
                                img src=(difference) alt={ (name) ", difference of " (image) " from the truth" };
                                figcaption { (image) " minus truth, around grey" }
                            }
                        }
                    }
                }
            }
        }
        (left_out(scene))
        (provenance(run))
    }
}

/// What a comparison starts with: truth on the left, trilinear, or else the last, on the right.
fn preferred(side: usize, images: &[(&str, String, &str)]) -> usize {
    if side == 0 { 0 } else { images.iter().position(|(name, ..)| *name == "trilinear").unwrap_or(images.len() - 1) }
}

pub(super) fn metric(filter: &Value, name: &str) -> Option<f64> {
    filter["metrics"][name]["value"].as_f64()
}

pub(super) fn filter_table(scene: &Value) -> Markup {
    let filters: Vec<&Value> = scene["filters"].as_array().into_iter().flatten().collect();
    let there = |name: &str| filters.iter().any(|filter| metric(filter, name).is_some());
    let columns: Vec<_> = COLUMNS.iter().filter(|(name, ..)| there(name)).collect();
    let best = |name: &str, sense: i8| {
        let values = filters.iter().filter_map(|filter| metric(filter, name)).map(|value| value * f64::from(sense));
        if sense == 0 || filters.len() < 2 {
            None
        } else {
            values.reduce(f64::max).map(|value| value * f64::from(sense))
        }
    };
    html! {
        table {
            thead { tr { th { "filter" } @for (_, heading, unit, ..) in &columns { th { (heading) small { (unit) } } } } }
            tbody {
                @for filter in &filters {
                    tr {
                        td { (filter["filter"].as_str().unwrap_or_default()) }
                        @for &&(name, _, _, digits, factor, sense) in &columns {
                            @let value = metric(filter, name);
                            td.best[value.is_some() && value == best(name, sense)] {
                                @match value { Some(value) => (format!("{:.digits$}", value * factor)), None => "–" }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Stacked bars of every metric that begins with `stall_`.
fn stall_bars(scene: &Value) -> Markup {
    let filters: Vec<&Value> = scene["filters"].as_array().into_iter().flatten().collect();
    let stalls = |filter: &Value| -> Vec<(String, f64)> {
        let metrics = filter["metrics"].as_object().into_iter().flatten();
        metrics
            .filter(|(name, _)| name.starts_with("stall_"))
            .filter_map(|(name, metric)| {
                Some((name.trim_start_matches("stall_").replace('_', " "), metric["value"].as_f64()?))
            })
            .collect()
    };
    let rows: Vec<(&str, Vec<(String, f64)>)> =
        filters.iter().map(|filter| (filter["filter"].as_str().unwrap_or_default(), stalls(filter))).collect();
    let most = rows.iter().map(|(_, stalls)| stalls.iter().map(|(_, value)| value).sum::<f64>()).fold(0.0, f64::max);
    if most <= 0.0 {
        return html! {};
    }
    html! {
        figure {
            div.bars {
                @for (filter, stalls) in &rows {
                    span { (filter) }
                    div.bar {
                        @for (place, (name, value)) in stalls.iter().enumerate() {
                            i class={ "c" (place % 7) } style={ "width:" (format!("{:.3}", 100.0 * value / most)) "%" } title={ (name) ": " (value) } {}
                        }
                    }
                }
            }
            p.key { @for (place, (name, _)) in rows[0].1.iter().enumerate() { span { i class={ "c" (place % 7) } {} (name) } } }
            figcaption { "Clocks stalled a pixel, by cause; the longest bar is " (format!("{most:.2}")) "." }
        }
    }
}

/// What the same picture costs without what the scene does not need.
fn saved(scene: &Value) -> Markup {
    let filters = scene["filters"].as_array().into_iter().flatten();
    let filters: Vec<&Value> = filters.filter(|filter| filter["left_out"].is_object()).collect();
    if filters.is_empty() {
        return html! {};
    }
    let columns = [
        ("memory_bytes", "memory", "KiB", 1.0 / 1024.0),
        ("bytes_per_pixel_uncached", "uncached", "B/pixel", 1.0),
        ("bytes_per_pixel_cached", "cached", "B/pixel", 1.0),
        ("cycles_per_pixel", "cycles", "/pixel", 1.0),
        ("energy_pj_per_pixel", "energy", "pJ/pixel", 1.0),
        ("host_ns_per_pixel", "this host", "ns/pixel", 1.0),
    ];
    let differing: u64 = filters.iter().filter_map(|filter| filter["left_out"]["differing_pixels"].as_u64()).sum();
    html! {
        figure {
            div.wide {
                table {
                    thead { tr {
                        th { "filter" } th { "runs as" } th { "planes" } th { "channels" }
                        @for (_, heading, unit, _) in &columns { th { (heading) small { (unit) } } }
                    } }
                    tbody {
                        @for filter in &filters {
                            tr {
                                td { (filter["filter"].as_str().unwrap_or_default()) }
                                td { (filter["left_out"]["runs_as"].as_str().unwrap_or_default()) }
                                td { (filter["left_out"]["planes"].as_array().map_or(0, Vec::len)) }
                                td { (filter["left_out"]["channels"].as_u64().unwrap_or(4)) }
                                @for (name, _, _, factor) in &columns {
                                    td {
                                        @for (suffix, arrow) in [("whole", " \u{2192} "), ("needed", "")] {
                                            @match metric(filter, &format!("{name}_{suffix}")) {
                                                Some(value) => (format!("{:.1}", value * factor)),
                                                None => "-",
                                            }
                                            (arrow)
                                        }
                                    }
                                }
                            }
                        }
                    }
                }
            }
            figcaption {
                "What every filter costs, and what it costs without what this scene does not need. Pixels that differ between the two: "
                (differing) "."
            }
        }
    }
}

/// What a scene says was left out.
fn left_out(scene: &Value) -> Markup {
    let count = |value: &Value| value.as_u64().unwrap_or(0);
    let coverage = &scene["coverage"];
    let undefined: f64 = scene["filters"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|filter| metric(filter, "undefined_coordinates"))
        .sum();
    html! {
        p.quiet {
            "Of " (count(&coverage["pixels"])) " pixels, " (count(&coverage["covered"])) " are covered. Left out: "
            (count(&coverage["behind"])) " behind the eye or at the horizon; differences that gave way to the analytic gradient: "
            (count(&coverage["gradient-fallbacks"])) "; coordinates without a place, all filters: " (format!("{undefined:.0}")) "."
        }
    }
}
