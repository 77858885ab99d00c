//! The figures of the page, each with the command and the machine it is from.

use std::collections::BTreeMap;

use maud::{Markup, PreEscaped, html};
use serde_json::Value;

use super::results::{Results, scene_name};
use crate::{
    report::plot::{Axis, Plot, Series, Style},
    stress::shown,
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

/// All sections of a folder with their headings.
pub(super) fn sections(number: usize, results: &Results) -> Vec<(String, Markup)> {
    let mut sections = Vec::new();
    let scenes = |part: &Value| part["scenes"].as_array().cloned().unwrap_or_default();
    if let Some(run) = &results.run {
        for scene in scenes(run) {
            sections.push((scene_name(&scene), run_section(number, results, run, &scene)));
        }
    }
    if let Some(pareto) = &results.pareto {
        for scene in scenes(pareto) {
            sections.push((format!("{}: Pareto", scene_name(&scene)), pareto_section(results, pareto, &scene)));
        }
    }
    if let Some(reuse) = &results.reuse {
        for scene in scenes(reuse) {
            sections.push((format!("{}: reuse", scene_name(&scene)), reuse_section(results, reuse, &scene)));
        }
    }
    if let Some(frames) = &results.frames {
        for scene in scenes(frames) {
            let section = html! {
                figure { div.wide { (filter_table(&scene)) } figcaption { "All frames together: error, and its change from frame to frame." } }
                (provenance(frames))
            };
            sections.push((format!("{}: in motion", scene_name(&scene)), section));
        }
    }
    if let Some(stress) = &results.stress {
        sections.push(("Extreme inputs".to_owned(), stress_section(stress)));
    }
    if let Some((columns, rows)) = &results.sweep {
        for (heading, plot) in sweep_plots(columns, rows) {
            let section = html! {
                figure { (themed(&plot.svg())) figcaption { "The best number of ways at each size of the cache." } }
                @if let Some(point) = &results.sweep_point {
                    details { summary { "Sweep and machine" } pre { (results.folder) "\n" (pretty(&point["config"]["machine"])) } }
                }
            };
            sections.push((heading, section));
        }
    }
    sections
}

fn run_section(number: usize, results: &Results, run: &Value, scene: &Value) -> Markup {
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

fn metric(filter: &Value, name: &str) -> Option<f64> {
    filter["metrics"][name]["value"].as_f64()
}

fn filter_table(scene: &Value) -> Markup {
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

fn pareto_section(results: &Results, pareto: &Value, scene: &Value) -> Markup {
    let name = scene_name(scene);
    let [error, cost] = ["error", "cost"].map(|key| pareto[key].as_str().unwrap_or_default());
    let mut front: Vec<&Value> =
        scene["candidates"].as_array().into_iter().flatten().filter(|candidate| candidate["front"] == true).collect();
    front.sort_by(|a, b| metric(a, cost).unwrap_or(f64::MAX).total_cmp(&metric(b, cost).unwrap_or(f64::MAX)));
    let all = scene["candidates"].as_array().map_or(0, Vec::len);
    html! {
        @if let Some((_, svg)) = results.plots.iter().find(|(plot, _)| *plot == name) {
            figure { (themed(svg)) figcaption { "Every disc is a filter with one setting; the line joins the front: nothing is better in both." } }
        }
        figure {
            div.wide { table {
                thead { tr { th { "filter" } th.text { "settings" } th { (cost) } th { (error) } } }
                tbody { @for candidate in &front { tr {
                    td { (candidate["filter"].as_str().unwrap_or_default()) }
                    td.text { (candidate["settings"].as_array().into_iter().flatten().filter_map(Value::as_str).collect::<Vec<_>>().join(" ")) }
                    @for name in [cost, error] { td { (metric(candidate, name).map_or("–".into(), |value| format!("{value:.3}"))) } }
                } } }
            } }
            figcaption { (front.len()) " of " (all) " variants are on the front." }
        }
        (provenance(pareto))
    }
}

fn reuse_section(results: &Results, reuse: &Value, scene: &Value) -> Markup {
    let name = scene_name(scene);
    let plots: Vec<_> = results.plots.iter().filter(|(plot, _)| *plot == name).collect();
    let filters: Vec<&Value> = scene["filters"].as_array().into_iter().flatten().collect();
    let kib = |filter: &Value, key: &str| {
        format!("{:.1}", (filter[key].as_u64().unwrap_or(0) * filter["line"].as_u64().unwrap_or(0)) as f64 / 1024.0)
    };
    html! {
        @if let Some((_, svg)) = plots.last() {
            figure { (themed(svg)) figcaption { "Misses of a fully associative LRU cache of every size, from one pass." } }
        }
        figure {
            div.wide { table {
                thead { tr { th { "filter" } th { "touched" small { "KiB" } } th { "working set" small { "KiB" } } th { "64 x 64 tile" small { "lines, mean" } } } }
                tbody { @for filter in &filters { tr {
                    td { (filter["filter"].as_str().unwrap_or_default()) }
                    td { (kib(filter, "lines")) }
                    td { (kib(filter, "working_set_lines")) }
                    td { (format!("{:.1}", filter["tiles"][3]["mean"].as_f64().unwrap_or(0.0))) }
                } } }
            } }
            figcaption { "The working set is the fewest lines with which no more than 1 % of the reused lookups miss." }
        }
        (provenance(reuse))
    }
}

/// Every extreme input with a careless answer beside ours, a case at a time.
fn stress_section(stress: &Value) -> Markup {
    let cases: Vec<&Value> = stress["cases"].as_array().into_iter().flatten().collect();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let number = |value: &Value| value.as_f64().map_or_else(|| text(value), shown);
    let failed = cases.iter().filter(|case| case["passes"] != true).count();
    html! {
        p { (cases.len()) " cases, " (failed) " failed. Every careless answer is computed by code one might write; ours come from the chip." }
        @for case in &cases {
            details open[case["passes"] != true] {
                summary { (text(&case["case"])) ", " (text(&case["title"])) ": " @if case["passes"] == true { "pass" } @else { strong { "FAIL" } } }
                p.quiet { (text(&case["wrong"])) }
                div.wide { table {
                    thead { tr {
                        th { "input" } th.text { "unit" } th { "careless" } th { "ours" } th { "ideal" }
                        th { "careless" small { "error" } } th { "ours" small { "error" } } th { "allowed" }
                    } }
                    tbody { @for row in case["rows"].as_array().into_iter().flatten() { tr {
                        td { (text(&row["input"])) }
                        td.text { (text(&row["unit"])) }
                        @for key in ["careless", "ours", "ideal", "careless_error", "error", "allowed"] {
                            td.best[key == "error" && row["passes"] != true] { (number(&row[key])) }
                        }
                    } } }
                } }
            }
        }
        details { summary { "Command" } pre { (command(stress)) } }
    }
}

/// Bytes per pixel over the size of the cache, a line for each filter and setting.
fn sweep_plots(columns: &[String], rows: &[Vec<String>]) -> Vec<(String, Plot)> {
    let at = |name: &str| columns.iter().position(|known| known == name);
    let (Some(metric), Some(value), Some(scene), Some(sets)) =
        (at("metric"), at("value"), at("scene"), at("cache.sets"))
    else {
        return Vec::new();
    };
    let (Some(width), Some(height), Some(point)) = (at("width"), at("height"), at("point")) else { return Vec::new() };
    let mut sizes: BTreeMap<(&str, &str, &str), f64> = BTreeMap::new();
    for row in rows.iter().filter(|row| row[metric] == "cache_bytes") {
        sizes.insert((&row[point], &row[sets], &row[sets + 1]), row[value].parse().unwrap_or(0.0));
    }
    // Scene and size, then filter and settings, then bytes of cache: the least traffic.
    let mut scenes: BTreeMap<String, BTreeMap<String, BTreeMap<u64, f64>>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row[metric] == "bytes_per_pixel_cached") {
        let Some(size) = sizes.get(&(row[point].as_str(), row[sets].as_str(), row[sets + 1].as_str())) else {
            continue;
        };
        let Ok(traffic) = row[value].parse::<f64>() else { continue };
        let heading = format!("{} {} x {}: cache sizes", row[scene], row[width], row[height]);
        let best = scenes.entry(heading).or_default().entry(row[height + 1..sets].join(" ")).or_default();
        let least = best.entry(*size as u64).or_insert(traffic);
        *least = least.min(traffic);
    }
    let plot = |(heading, lines): (String, BTreeMap<String, BTreeMap<u64, f64>>)| {
        let series = lines.into_iter().map(|(name, points)| {
            let points = points.into_iter().map(|(size, traffic)| (size as f64, traffic, String::new())).collect();
            Series { name, style: Style::Line, points }
        });
        let plot = Plot {
            title: heading.clone(),
            x: Axis { label: "cache, B".into(), logarithmic: true },
            y: Axis { label: "fetched, B/pixel".into(), logarithmic: true },
            series: series.collect(),
        };
        (heading, plot)
    };
    scenes.into_iter().map(plot).collect()
}

/// A plot in the colours of the page.
fn themed(svg: &str) -> Markup {
    let svg = svg.find("<svg").map_or(svg, |start| &svg[start..]);
    let svg = svg
        .replace("fill=\"#FFFFFF\"", "class=\"paper\"")
        .replace("fill=\"#000000\"", "fill=\"currentColor\"")
        .replace("stroke=\"#000000\"", "stroke=\"currentColor\"");
    html! { (PreEscaped(svg)) }
}

fn pretty(value: &Value) -> String {
    toml::to_string(value).unwrap_or_else(|_| format!("{value:#}"))
}

/// The command that made a figure, and its machine with every default filled in.
fn provenance(results: &Value) -> Markup {
    html! {
        details { summary { "Command and machine" } pre { (command(results)) "\n\n" (pretty(&results["machine"])) } }
    }
}

/// The command that made a figure, as one would type it.
fn command(results: &Value) -> String {
    let words = results["command"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let command: Vec<String> = words
        .enumerate()
        .map(|(place, word)| match word.rsplit('/').next() {
            Some(program) if place == 0 => program.to_owned(),
            _ if word.chars().any(|letter| !letter.is_ascii_alphanumeric() && !"-_./=,:".contains(letter)) => {
                format!("'{}'", word.replace('\'', r"'\''"))
            }
            _ => word.to_owned(),
        })
        .collect();
    command.join(" ")
}
