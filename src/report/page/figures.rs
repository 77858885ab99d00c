//! The figures of the page, each with the command and the machine it is from.

use maud::{Markup, html};
use serde_json::Value;

use super::{
    provenance::{pretty, provenance},
    results::{Results, scene_name},
    run::{filter_table, run_section},
    studies::{pareto_section, reuse_section, stress_section, sweep_plots, themed},
};

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
