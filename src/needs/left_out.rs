//! What leaving out saved: the same requests with and without it.

use std::time::Instant;

use texunit_hw::{PyramidKind, Request, Response, Sampler, Unit};

use super::{Needs, Plan};
use crate::{
    error::{Error, Result},
    experiment::{cache, report::Metric},
    machine::Machine,
    texture_file::TextureImage,
    texture_memory::TextureMemory,
    timed_run::time_requests,
};

/// What a run costs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Planes held.
    pub planes: u64,
    /// Bytes of texture memory.
    pub memory_bytes: u64,
    /// Reads of the cache.
    pub reads: u64,
    /// Bytes asked of the cache.
    pub bytes_requested: u64,
    /// Bytes fetched from memory.
    pub bytes_fetched: u64,
    /// Clocks.
    pub cycles: u64,
    /// Picojoules, an estimate.
    pub energy_pj: f64,
    /// Seconds of this host to compute the planes and lay them out.
    pub prepare_seconds: f64,
    /// Seconds of this host for texels and exact cache, one thread, the best of some runs.
    pub host_seconds: f64,
}

/// A filter's requests with and without leaving out.
#[derive(Clone, Debug)]
pub struct LeftOut {
    /// What the requests need.
    pub needs: Needs,
    /// What was run instead.
    pub plan: Plan,
    /// Channels filtered, of 4.
    pub channels: u8,
    /// Seconds of this host for finding out what is needed.
    pub needs_seconds: f64,
    /// Everything as the machine says.
    pub without: Cost,
    /// Only what is needed.
    pub with: Cost,
    /// Answers that differ between the two: none, or this is a bug.
    pub differing: u64,
}

/// Runs of which the fastest counts.
const RUNS: usize = 3;

impl LeftOut {
    /// Runs requests of a texture both ways and compares every answer.
    ///
    /// # Errors
    /// A machine or texture that cannot be built.
    pub fn measure(machine: &Machine, texture: &TextureImage, sampler: &Sampler, requests: &[Request]) -> Result<Self> {
        let begin = Instant::now();
        let whole = Self::hold_whole(machine, texture, sampler)?;
        let (mut without, expected) = run(machine, sampler, &whole, requests)?;
        without.prepare_seconds = begin.elapsed().as_secs_f64() - without.prepare_seconds;
        drop(whole);

        let begin = Instant::now();
        let needs = Needs::of(requests, sampler, [texture.top.width, texture.top.height])?;
        let needs_seconds = begin.elapsed().as_secs_f64();
        let plan = Plan::new(&needs, sampler);
        let begin = Instant::now();
        let memory = plan.hold(&machine.texture, texture)?;
        let (mut with, answers) = run(machine, &plan.sampler, &memory, requests)?;
        with.prepare_seconds = begin.elapsed().as_secs_f64() - with.prepare_seconds;
        let differing = expected.iter().zip(&answers).filter(|(one, other)| one != other).count() as u64;
        let channels = memory.channels;
        Ok(Self { needs, plan, channels, needs_seconds, without, with, differing })
    }

    fn hold_whole(machine: &Machine, texture: &TextureImage, sampler: &Sampler) -> Result<TextureMemory> {
        let kind = sampler.filter.pyramid();
        if kind == PyramidKind::Sat {
            return Ok(machine.texture.hold(kind, texture)?.memory);
        }
        machine.texture.hold_planes(&machine.texture.planes(kind, texture)?, texture)
    }

    /// Memory, bytes, clocks and host time of both, by name, for each request where that makes sense.
    #[must_use]
    pub fn metrics(&self) -> Vec<Metric> {
        let per_request = 1.0 / self.needs.requests.max(1) as f64;
        let mut metrics = Vec::new();
        for (names, cost) in [(&NAMES[0], &self.without), (&NAMES[1], &self.with)] {
            let values = [
                cost.planes as f64,
                cost.memory_bytes as f64,
                cost.reads as f64 * per_request,
                cost.bytes_requested as f64 * per_request,
                cost.bytes_fetched as f64 * per_request,
                cost.cycles as f64 * per_request,
                cost.energy_pj * per_request,
                cost.prepare_seconds * 1e3,
                cost.host_seconds * 1e9 * per_request,
            ];
            let named = names.iter().zip(UNITS).zip(values);
            metrics.extend(named.map(|((&name, unit), value)| Metric { name, value: Some(value), unit }));
        }
        metrics
    }
}

/// Names of the numbers of a [`Cost`], as a machine has them and with everything left out that can be.
const NAMES: [[&str; 9]; 2] = [
    [
        "planes_whole",
        "memory_bytes_whole",
        "reads_per_pixel_whole",
        "bytes_per_pixel_uncached_whole",
        "bytes_per_pixel_cached_whole",
        "cycles_per_pixel_whole",
        "energy_pj_per_pixel_whole",
        "prepare_ms_whole",
        "host_ns_per_pixel_whole",
    ],
    [
        "planes_needed",
        "memory_bytes_needed",
        "reads_per_pixel_needed",
        "bytes_per_pixel_uncached_needed",
        "bytes_per_pixel_cached_needed",
        "cycles_per_pixel_needed",
        "energy_pj_per_pixel_needed",
        "prepare_ms_needed",
        "host_ns_per_pixel_needed",
    ],
];

const UNITS: [&str; 9] =
    ["plane", "B", "read/pixel", "B/pixel", "B/pixel", "clock/pixel", "pJ/pixel", "ms", "ns/pixel"];

/// Costs and answers; `prepare_seconds` is what everything here took, for whoever timed the whole.
fn run(
    machine: &Machine,
    sampler: &Sampler,
    memory: &TextureMemory,
    requests: &[Request],
) -> Result<(Cost, Vec<Response>)> {
    let begin = Instant::now();
    let surface = &memory.surface;
    let mut unit = Unit::new(sampler, surface, &memory.bytes)
        .map_err(|error| Error::setting("machine", &machine.name, error.to_string(), "change the machine"))?;
    let mut responses = vec![Response::default(); requests.len()];
    let (mut host_seconds, mut counters) = (f64::INFINITY, None);
    for _ in 0..RUNS {
        let mut cache = memory.behind(cache(machine, surface.bytes_per_read())?);
        let begin = Instant::now();
        unit.run(requests, &mut responses, &mut cache);
        host_seconds = host_seconds.min(begin.elapsed().as_secs_f64());
        counters = Some(cache.counters());
    }
    let counters = counters.unwrap_or_default();
    let timed = time_requests(machine, sampler, memory, requests)?;
    let cost = Cost {
        planes: surface.planes.iter().filter(|plane| plane.held).count() as u64,
        memory_bytes: memory.stored_bytes(),
        reads: counters.lookups,
        bytes_requested: counters.bytes_requested,
        bytes_fetched: counters.bytes_fetched,
        cycles: timed.counters.cycles,
        energy_pj: timed.energy.total(),
        prepare_seconds: begin.elapsed().as_secs_f64(),
        host_seconds,
    };
    Ok((cost, responses))
}
