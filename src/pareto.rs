//! Error against cost, for every filter and for the knobs inside it.

use serde_json::{Value, json};
use texunit_hw::{Filter, PyramidKind};

use crate::{
    area,
    error::Result,
    experiment::{Bench, Deviation, ImageQuality, Pyramids, Stage, cache, paint, report, report::Metric},
    machine::{Machine, Texture},
    names::Named,
    report::plot::{Axis, Plot, Series, Style},
};

/// A filter with settings on top of the machine's.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// The filter.
    pub filter: Filter,
    /// The settings, as on a command line; none for the machine as it is.
    pub settings: Vec<String>,
}

/// A knob that is turned, and the filters it does something for.
struct Knob {
    key: &'static str,
    values: &'static [&'static str],
    matters: fn(Filter) -> bool,
}

const fn reads_pyramid(filter: Filter) -> bool {
    filter.uses_level()
}

/// Every knob inside a filter, one turned at a time.
const KNOBS: [Knob; 8] = [
    Knob { key: "filter.max-anisotropy", values: &["2", "4", "8"], matters: Filter::is_anisotropic },
    Knob {
        key: "filter.brilinear-threshold",
        values: &["0", "32", "96", "127"],
        matters: |filter| matches!(filter, Filter::Brilinear),
    },
    Knob { key: "filter.bits", values: &["4", "6"], matters: |filter| !matches!(filter, Filter::Point) },
    Knob {
        key: "filter.rounding",
        values: &["staged-round", "staged-truncate"],
        matters: |filter| !matches!(filter, Filter::Point | Filter::Sat),
    },
    Knob { key: "lod.log2", values: &["herf", "ilog2"], matters: Filter::uses_level },
    Knob { key: "lod.bits", values: &["4"], matters: Filter::uses_level },
    Knob { key: "lod.bias", values: &["-0.5", "0.5"], matters: Filter::uses_level },
    Knob { key: "texture.pyramid.kernel", values: &["tent", "lanczos", "kaiser"], matters: reads_pyramid },
];

/// Every filter as it is, then with one knob turned, each crossed with `crossed`: keys with the values they take.
#[must_use]
pub fn variants(filters: &[Filter], knobs: bool, crossed: &[(String, Vec<String>)]) -> Vec<Variant> {
    let mut list = Vec::new();
    for &filter in filters {
        let mut own = vec![vec![]];
        if knobs {
            for knob in KNOBS.iter().filter(|knob| (knob.matters)(filter)) {
                own.extend(knob.values.iter().map(|value| vec![format!("{}={value}", knob.key)]));
            }
        }
        for settings in own {
            let every = crossed.iter().fold(vec![settings], |rows: Vec<Vec<String>>, (key, values)| {
                rows.iter()
                    .flat_map(|row| values.iter().map(|value| [row.as_slice(), &[format!("{key}={value}")]].concat()))
                    .collect()
            });
            list.extend(every.into_iter().map(|settings| Variant { filter, settings }));
        }
    }
    list
}

/// A variant measured on a scene.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What was measured.
    pub variant: Variant,
    /// Everything it came to.
    pub metrics: Vec<Metric>,
    /// Whether no other is better in error or cost without being worse in the other.
    pub front: bool,
}

impl Candidate {
    /// A metric by its name.
    #[must_use]
    pub fn metric(&self, name: &str) -> Option<f64> {
        self.metrics.iter().find(|metric| metric.name == name).and_then(|metric| metric.value)
    }
}

/// Measures variants on one scene, making each pyramid once.
#[derive(Debug)]
pub struct Study<'s> {
    stage: &'s Stage,
    pyramids: Vec<(Texture, PyramidKind, Pyramids)>,
}

impl<'s> Study<'s> {
    /// Nothing measured yet.
    #[must_use]
    pub const fn new(stage: &'s Stage) -> Self {
        Self { stage, pyramids: Vec::new() }
    }

    /// Samples the scene and counts.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn measure(&mut self, base: &Machine, variant: &Variant) -> Result<Candidate> {
        let machine = base.with_settings(&variant.settings)?;
        let (filter, kind) = (variant.filter, variant.filter.pyramid());
        let known = |made: &(Texture, PyramidKind, Pyramids)| made.0 == machine.texture && made.1 == kind;
        let at = match self.pyramids.iter().position(known) {
            Some(at) => at,
            None => {
                let pyramids = Pyramids::for_filters(&machine, &self.stage.texture, &[filter])?;
                self.pyramids.push((machine.texture.clone(), kind, pyramids));
                self.pyramids.len() - 1
            }
        };
        let (pyramid, memory) = self.pyramids[at].2.of(filter);
        let bench = Bench::new(self.stage, &machine, filter, pyramid, memory);
        let mut cache = memory.behind(cache(&machine, memory.surface.bytes_per_read())?);
        let mut timer = bench.timer(&machine)?;
        let (mut picture, mut against_truth) = (self.stage.empty_picture(), Deviation::default());
        let answers = bench.answer(&mut cache, |fragments, requests, responses| {
            paint(&mut picture, fragments, responses.iter().map(|response| response.texel));
            against_truth = bench.against_truth(against_truth, fragments, responses);
            timer.time(requests);
        })?;
        let mut metrics = report::traffic_metrics(&cache.counters(), answers.pixels);
        metrics.push(report::host_metric(answers.host_seconds, answers.pixels));
        metrics.extend(report::deviation_metrics(report::AGAINST_TRUTH, &against_truth));
        metrics.extend(ImageQuality::of(self.stage, &picture).metrics());
        metrics.extend(timer.finish().0.metrics());
        metrics.extend(area::metrics(&machine, filter));
        Ok(Candidate { variant: variant.clone(), metrics, front: false })
    }
}

/// Which pairs of error and cost no other pair beats: smaller is better, equal pairs stand together, a pair without a number never.
///
/// ```
/// use texunit::pareto::front;
/// let pairs = [(3.0, 1.0), (2.0, 2.0), (2.5, 2.0), (1.0, 9.0), (f64::NAN, 0.0)];
/// assert_eq!(front(&pairs), [true, true, false, true, false]);
/// ```
#[must_use]
pub fn front(pairs: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    let number = |pair: &(f64, f64)| !pair.0.is_nan() && !pair.1.is_nan();
    pairs.iter().map(|pair| number(pair) && !pairs.iter().any(|other| beats(other, pair))).collect()
}

/// Metrics of which more is better; of all others less is.
pub const MORE_IS_BETTER: [&str; 2] = ["psnr", "ssim"];

/// Marks the front of `error` against `cost`.
pub fn mark_front(candidates: &mut [Candidate], error: &str, cost: &str) {
    let sign = if MORE_IS_BETTER.contains(&error) { -1.0 } else { 1.0 };
    // Equal images have no PSNR: it is infinite.
    let value = |candidate: &Candidate, name: &str| {
        candidate.metric(name).unwrap_or(if name == "psnr" { f64::INFINITY } else { f64::NAN })
    };
    let pairs: Vec<(f64, f64)> =
        candidates.iter().map(|candidate| (sign * value(candidate, error), value(candidate, cost))).collect();
    for (candidate, front) in candidates.iter_mut().zip(front(&pairs)) {
        candidate.front = front;
    }
}

/// One scene of pareto.json.
#[must_use]
pub fn scene_json(scene: &str, candidates: &[Candidate]) -> Value {
    let candidates: Vec<Value> = candidates
        .iter()
        .map(|candidate| {
            json!({
                "filter": candidate.variant.filter.name(),
                "settings": candidate.variant.settings,
                "front": candidate.front,
                "metrics": report::metrics_json(&candidate.metrics),
            })
        })
        .collect();
    json!({ "scene": scene, "candidates": candidates })
}

/// Error over cost: a disc for each variant, named if on the front.
#[must_use]
pub fn plot(scene: &str, candidates: &[Candidate], error: &str, cost: &str) -> Plot {
    let unit = |name: &str| {
        let mut metrics = candidates.iter().flat_map(|candidate| &candidate.metrics);
        metrics.find(|metric| metric.name == name).map_or("", |metric| metric.unit)
    };
    let axis = |name: &str, logarithmic| Axis { label: format!("{name}, {}", unit(name)), logarithmic };
    let point = |candidate: &Candidate| {
        let label = if candidate.front { candidate.variant.filter.name() } else { "" };
        Some((candidate.metric(cost)?, candidate.metric(error)?, label.to_owned()))
    };
    let mut steps: Vec<(f64, f64, String)> = candidates
        .iter()
        .filter(|candidate| candidate.front)
        .filter_map(point)
        .map(|(x, y, _)| (x, y, String::new()))
        .collect();
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut series = vec![Series { name: "front".into(), style: Style::Thread, points: steps }];
    let mut named: Vec<&str> = Vec::new();
    for (_, filter) in Filter::ALL {
        let points: Vec<_> =
            candidates.iter().filter(|candidate| candidate.variant.filter == *filter).filter_map(point).collect();
        if points.is_empty() {
            continue;
        }
        // Variants of a filter lie close together: its name once is enough.
        let points = points
            .into_iter()
            .map(|(x, y, label)| {
                let label = if label.is_empty() || named.contains(&filter.name()) { String::new() } else { label };
                if !label.is_empty() {
                    named.push(filter.name());
                }
                (x, y, label)
            })
            .collect();
        series.push(Series { name: filter.name().into(), style: Style::Points, points });
    }
    let title = format!("{scene}: {error} against {cost}");
    Plot { title, x: axis(cost, true), y: axis(error, !MORE_IS_BETTER.contains(&error)), series }
}
