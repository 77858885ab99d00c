//! Studies on the page: the Pareto front, reuse, extreme inputs, sweeps.

use std::collections::BTreeMap;

use maud::{Markup, PreEscaped, html};
use serde_json::Value;

use super::{
    provenance::{command, provenance},
    results::{Results, scene_name},
    run::metric,
};
use crate::{
    report::plot::{Axis, Plot, Series, Style},
    stress::shown,
};

pub(super) fn pareto_section(results: &Results, pareto: &Value, scene: &Value) -> Markup {
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

pub(super) fn reuse_section(results: &Results, reuse: &Value, scene: &Value) -> Markup {
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
pub(super) fn stress_section(stress: &Value) -> Markup {
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
pub(super) fn sweep_plots(columns: &[String], rows: &[Vec<String>]) -> Vec<(String, Plot)> {
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
pub(super) fn themed(svg: &str) -> Markup {
    let svg = svg.find("<svg").map_or(svg, |start| &svg[start..]);
    let svg = svg
        .replace("fill=\"#FFFFFF\"", "class=\"paper\"")
        .replace("fill=\"#000000\"", "fill=\"currentColor\"")
        .replace("stroke=\"#000000\"", "stroke=\"currentColor\"");
    html! { (PreEscaped(svg)) }
}
