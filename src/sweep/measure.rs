//! What is found out at one point of a sweep.

use serde::{Deserialize, Serialize};
use texunit_hw::{Filter, Geometry};

use super::Caches;
use crate::{
    error::{Error, Result},
    experiment::{AddressBench, Bench, Deviation, Pyramids, Stage, report, report::Metric},
    machine::Machine,
    scene::Scene,
};

/// How much is measured at each point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Lookups, misses and bytes of every cache: no texel is touched.
    #[default]
    Traffic,
    /// These, and how far the image is from the ground truth.
    Error,
    /// Everything `texunit run` says, proof against the reference included, of one cache after the other.
    All,
}

/// One cache of a point.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Its shape.
    pub geometry: Geometry,
    /// What was measured of it.
    pub metrics: Vec<Metric>,
}

/// What a point came to.
#[derive(Clone, Debug)]
pub struct Measured {
    /// What does not depend on the cache.
    pub metrics: Vec<Metric>,
    /// What does.
    pub cells: Vec<Cell>,
}

/// Counts the traffic of a scene through caches of many shapes, without its texels.
///
/// # Errors
/// A layout or cache that cannot be built.
pub fn traffic(scene: &Scene, machine: &Machine, filter: Filter, geometries: &[Geometry]) -> Result<Measured> {
    let bench = AddressBench::new(scene, machine, filter)?;
    let mut caches = caches(machine, geometries)?;
    let mut pixels = 0;
    bench.run(scene, &mut caches, |fragments, _| pixels += fragments.len() as u64);
    Ok(Measured { metrics: vec![], cells: cells(caches, pixels, bench.surface.bytes_per_read()) })
}

/// Measures one point; a stage is needed for all but traffic.
///
/// # Errors
/// A machine that cannot be built.
pub fn on_stage(
    stage: &Stage,
    machine: &Machine,
    filter: Filter,
    geometries: &[Geometry],
    measure: Measure,
) -> Result<Measured> {
    let pyramids = Pyramids::for_filters(machine, &stage.texture, &[filter])?;
    let (pyramid, memory) = pyramids.of(filter);
    let bench = Bench::new(stage, machine, filter, pyramid, memory);
    if measure == Measure::All {
        let cells = geometries.iter().map(|&geometry| {
            let mut machine = machine.clone();
            (machine.cache.sets, machine.cache.ways) = (geometry.sets, geometry.ways);
            let outcome = bench.measure(&machine)?;
            Ok(Cell { geometry, metrics: report::metrics(&outcome) })
        });
        return Ok(Measured { metrics: vec![], cells: cells.collect::<Result<_>>()? });
    }
    let mut caches = caches(machine, geometries)?;
    let mut against_truth = Deviation::default();
    let answers = bench.answer(&mut caches, |fragments, _, responses| {
        against_truth = bench.against_truth(against_truth, fragments, responses);
    })?;
    let metrics = report::deviation_metrics(report::AGAINST_TRUTH, &against_truth);
    Ok(Measured { metrics: metrics.into(), cells: cells(caches, answers.pixels, memory.surface.bytes_per_read()) })
}

fn caches(machine: &Machine, geometries: &[Geometry]) -> Result<Caches> {
    if machine.texture.decompresses_before_cache() {
        let problem = "a fill then fetches more from one line than from another, which one pass does not weigh";
        return Err(Error::setting("texture.decompress", "before-cache", problem, "use measure = \"all\""));
    }
    let wrong = |problem: String| {
        Error::setting("cache", &machine.cache.policy, problem, "for instance 64 sets, 4 ways, 64 bytes a line")
    };
    Caches::new(geometries, machine.cache.policy().map_err(wrong)?).map_err(|error| wrong(error.to_string()))
}

fn cells(caches: Caches, pixels: u64, bytes_per_read: u32) -> Vec<Cell> {
    let (lookups, misses) = caches.finish();
    let count = |value: u64| value as f64;
    let per_pixel = |value: u64| count(value) / count(pixels.max(1));
    let metric = |name, value, unit| Metric { name, value: Some(value), unit };
    misses
        .into_iter()
        .map(|(geometry, misses)| {
            let fetched = misses * u64::from(geometry.line);
            let requested = lookups * u64::from(bytes_per_read);
            let metrics = vec![
                metric("pixels", count(pixels), "pixel"),
                metric("cache_bytes", count(geometry.size_bytes()), "B"),
                metric("lookups", count(lookups), "read"),
                metric("misses", count(misses), "read"),
                metric("miss_rate", count(misses) / count(lookups.max(1)), "1"),
                metric("bytes_requested", count(requested), "B"),
                metric("bytes_fetched", count(fetched), "B"),
                metric("bytes_per_pixel_uncached", per_pixel(requested), "B/pixel"),
                metric("bytes_per_pixel_cached", per_pixel(fetched), "B/pixel"),
            ];
            Cell { geometry, metrics }
        })
        .collect()
}
