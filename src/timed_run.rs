//! A scene's requests through a machine in time.

use serde_json::{Map, Value, json};
use texunit_hw::{
    Filter, LodSource, Request, Sampler, Unit,
    cache::Detail,
    timing::{Histograms, PlaneTiming, Timing, TimingCounters, TimingObserver},
};

use crate::{
    energy::Energy,
    error::{Error, Result},
    experiment::{Pyramids, cache_that_keeps, report::Metric},
    front_end::FrontEnd,
    machine::Machine,
    names::Named,
    scene::Scene,
    texture_memory::TextureMemory,
};

/// What one filter took.
#[derive(Clone, Debug)]
pub struct Timed {
    /// The filter.
    pub filter: Filter,
    /// Everything counted.
    pub counters: TimingCounters,
    /// The same per plane: how often each axis was halved, and its share.
    pub planes: Vec<((u8, u8), PlaneTiming)>,
    /// Requests by what they asked for.
    pub histograms: Histograms,
    /// Counters at the end of every epoch, running totals.
    pub epochs: Vec<TimingCounters>,
    /// Bytes asked of the cache, and misses.
    pub bytes_requested: u64,
    /// An estimate.
    pub energy: Energy,
}

impl Timed {
    /// Clocks a request.
    #[must_use]
    pub fn cycles_per_request(&self) -> f64 {
        self.counters.cycles as f64 / self.counters.requests.max(1) as f64
    }

    /// Clocks, the clocks each stall took, and energy, for each request.
    #[must_use]
    pub fn metrics(&self) -> Vec<Metric> {
        let requests = self.counters.requests.max(1) as f64;
        let metric = |name, value: f64, unit| Metric { name, value: Some(value / requests), unit };
        let stalls = TimingCounters::FIELDS.iter().zip(self.counters.values());
        let stalls = stalls.filter(|((name, _), _)| name.starts_with("stall_"));
        let mut metrics = vec![
            metric("cycles_per_pixel", self.counters.cycles as f64, "clock/pixel"),
            metric("energy_pj_per_pixel", self.energy.total(), "pJ/pixel"),
        ];
        metrics.extend(stalls.map(|((name, _), clocks)| metric(name, clocks as f64, "clock/pixel")));
        metrics
    }

    /// Every counter by name, with its definition; planes, histograms and energy below.
    #[must_use]
    pub fn json(&self) -> Value {
        let named = |fields: &[(&str, &str)], values: Vec<u64>| -> Map<String, Value> {
            fields.iter().zip(values).map(|((name, _), value)| ((*name).to_owned(), value.into())).collect()
        };
        let planes: Vec<Value> = self
            .planes
            .iter()
            .map(|((lu, lv), row)| {
                let mut plane = named(PlaneTiming::FIELDS, row.values());
                plane.insert("lu".into(), (*lu).into());
                plane.insert("lv".into(), (*lv).into());
                plane.into()
            })
            .collect();
        let bars = |bars: &[u64]| -> Map<String, Value> {
            bars.iter().enumerate().filter(|(_, n)| **n > 0).map(|(at, n)| (at.to_string(), (*n).into())).collect()
        };
        json!({
            "filter": self.filter.name(),
            "cycles_per_request": self.cycles_per_request(),
            "counters": named(TimingCounters::FIELDS, self.counters.values()),
            "planes": planes,
            "requests_by_taps": bars(&self.histograms.taps),
            "requests_by_planes": bars(&self.histograms.planes),
            "requests_by_anisotropy": bars(&self.histograms.anisotropy),
            "energy_estimate_pj": self.energy,
        })
    }
}

/// A scene, bound to what its requests are asked of.
#[derive(Debug)]
pub struct TimedBench<'s> {
    machine: &'s Machine,
    scene: &'s Scene,
    pyramids: Pyramids,
}

impl<'s> TimedBench<'s> {
    /// Makes the pyramids for some filters.
    ///
    /// # Errors
    /// A pyramid that cannot be made or laid out.
    pub fn new(scene: &'s Scene, machine: &'s Machine, filters: &[Filter]) -> Result<Self> {
        let pyramids = Pyramids::for_filters(machine, &scene.texture.texture_image(), filters)?;
        Ok(Self { machine, scene, pyramids })
    }

    /// Times one filter of those it was made for, an epoch every so many requests, with someone watching. The frame is drawn as it
    /// is timed, a block of pixels at a time, and so may have any size.
    ///
    /// # Errors
    /// A machine that cannot run.
    pub fn time<O: TimingObserver>(&self, filter: Filter, epoch: Option<usize>, observer: O) -> Result<(Timed, O)> {
        self.time_while(filter, epoch, observer, &|_| true)
    }

    /// The same for as long as `go_on`, told of every block's requests, says so: what was timed until then.
    ///
    /// # Errors
    /// A machine that cannot run.
    pub fn time_while<O: TimingObserver>(
        &self,
        filter: Filter,
        epoch: Option<usize>,
        observer: O,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<(Timed, O)> {
        let (machine, scene) = (self.machine, self.scene);
        let (_, memory) = self.pyramids.of(filter);
        let address = scene.texture.wrap;
        let front_end = FrontEnd::new(machine, filter, address, scene.texture.size()).of_shape(machine, |seen| {
            scene.for_each_block(|block| seen.add(block));
        });
        let sampler = machine.sampler(filter, address, LodSource::Gradient);
        let draw = |time: &mut dyn FnMut(&[Request])| {
            let (mut blocks, mut requests) = (scene.blocks(), Vec::new());
            while let Some(block) = blocks.next_block() {
                requests.clear();
                requests.extend(block.iter().map(|fragment| front_end.request(fragment).0));
                time(&requests);
                if !go_on(requests.len() as u64) {
                    break;
                }
            }
        };
        time_blocks(machine, &sampler, memory, draw, epoch, observer)
    }
}

/// Times requests of a texture in memory.
///
/// # Errors
/// A machine that cannot run.
pub fn time_requests(
    machine: &Machine,
    sampler: &Sampler,
    memory: &TextureMemory,
    requests: &[Request],
) -> Result<Timed> {
    Ok(time_blocks(machine, sampler, memory, |time| time(requests), None, ())?.0)
}

/// Times the requests that `draw` hands on, an epoch every so many of them, with someone watching.
fn time_blocks<O: TimingObserver>(
    machine: &Machine,
    sampler: &Sampler,
    memory: &TextureMemory,
    draw: impl FnOnce(&mut dyn FnMut(&[Request])),
    epoch: Option<usize>,
    observer: O,
) -> Result<(Timed, O)> {
    let filter = sampler.filter;
    let surface = &memory.surface;
    let wrong = |problem: String| Error::setting("machine", &machine.name, problem, "change the machine");
    let mut unit = Unit::new(sampler, surface, &memory.bytes).map_err(|error| wrong(error.to_string()))?;
    let texels = if filter == Filter::Point { 1 } else { 4 };
    // Time does not ask why a line is missed, nor what of it is used.
    let detail = Detail { classes: false, line_use: false };
    let cache = memory.behind(cache_that_keeps(detail, machine, surface.bytes_per_read())?);
    // An entry of a summed-area table or a block is read whole: its banks are as wide as it is (docs/timing.md).
    let mut parameters = machine.timing.parameters();
    parameters.data_bank_bytes = parameters.data_bank_bytes.max(surface.bytes_per_read().next_power_of_two());
    let mut timing =
        Timing::new(&parameters, &machine.memory.parameters(), cache, texels * surface.reads_per_texel(), observer)
            .map_err(|error| wrong(error.to_string()))?;
    let length = epoch.unwrap_or(usize::MAX).max(1);
    let (mut epochs, mut left) = (Vec::new(), length);
    draw(&mut |mut requests| {
        while !requests.is_empty() {
            let (of_epoch, after) = requests.split_at(left.min(requests.len()));
            unit.addresses(of_epoch, &mut timing);
            left -= of_epoch.len();
            requests = after;
            if left == 0 {
                epochs.push(timing.counters());
                left = length;
            }
        }
    });
    if epoch.is_some() && left < length {
        epochs.push(timing.counters());
    }
    let counters = timing.counters();
    let planes = surface.planes.iter().map(|plane| (plane.lu, plane.lv)).zip(timing.planes()).collect();
    let word = machine.timing.data_bank_bytes;
    let timed = Timed {
        filter,
        counters,
        planes,
        histograms: *timing.histograms(),
        epochs,
        bytes_requested: timing.cache().counters().bytes_requested,
        energy: machine.energy.of(&counters, word, texels, memory.channels),
    };
    Ok((timed, timing.into_observer()))
}
