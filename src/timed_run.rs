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
        let mut timer = Timer::new(machine, &sampler, memory, epoch, observer)?;
        let (mut blocks, mut requests) = (scene.blocks(), Vec::new());
        while let Some(block) = blocks.next_block() {
            requests.clear();
            requests.extend(block.iter().map(|fragment| front_end.request(fragment).0));
            timer.time(&requests);
            if !go_on(requests.len() as u64) {
                break;
            }
        }
        Ok(timer.finish())
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
    let mut timer = Timer::new(machine, sampler, memory, None, ())?;
    timer.time(requests);
    Ok(timer.finish().0)
}

/// Requests through a machine in time, as they come.
#[derive(Debug)]
pub struct Timer<'m, O> {
    machine: &'m Machine,
    memory: &'m TextureMemory,
    filter: Filter,
    /// Reads of a tap.
    texels: u32,
    unit: Unit<'m>,
    timing: Timing<O>,
    /// Requests of an epoch, and of the one at hand those to come.
    epoch: Option<usize>,
    left: usize,
    epochs: Vec<TimingCounters>,
}

impl<'m, O: TimingObserver> Timer<'m, O> {
    /// A machine at rest, an epoch every so many requests, with someone watching.
    ///
    /// # Errors
    /// A machine that cannot run.
    pub fn new(
        machine: &'m Machine,
        sampler: &Sampler,
        memory: &'m TextureMemory,
        epoch: Option<usize>,
        observer: O,
    ) -> Result<Self> {
        let surface = &memory.surface;
        let wrong = |problem: String| Error::setting("machine", &machine.name, problem, "change the machine");
        let unit = Unit::new(sampler, surface, &memory.bytes).map_err(|error| wrong(error.to_string()))?;
        let texels = if sampler.filter == Filter::Point { 1 } else { 4 };
        // Time does not ask why a line is missed, nor what of it is used.
        let detail = Detail { classes: false, line_use: false };
        let cache = memory.behind(cache_that_keeps(detail, machine, surface.bytes_per_read())?);
        // An entry of a summed-area table or a block is read whole: its banks are as wide as it is (docs/timing.md).
        let mut parameters = machine.timing.parameters();
        parameters.data_bank_bytes = parameters.data_bank_bytes.max(surface.bytes_per_read().next_power_of_two());
        let timing =
            Timing::new(&parameters, &machine.memory.parameters(), cache, texels * surface.reads_per_texel(), observer)
                .map_err(|error| wrong(error.to_string()))?;
        let left = epoch.unwrap_or(usize::MAX).max(1);
        Ok(Self { machine, memory, filter: sampler.filter, texels, unit, timing, epoch, left, epochs: Vec::new() })
    }

    /// Times the next requests.
    pub fn time(&mut self, mut requests: &[Request]) {
        while !requests.is_empty() {
            let (of_epoch, after) = requests.split_at(self.left.min(requests.len()));
            self.unit.addresses(of_epoch, &mut self.timing);
            self.left -= of_epoch.len();
            requests = after;
            if self.left == 0 {
                self.epochs.push(self.timing.counters());
                self.left = self.length();
            }
        }
    }

    /// What they took, and whoever watched.
    #[must_use]
    pub fn finish(mut self) -> (Timed, O) {
        if self.epoch.is_some() && self.left < self.length() {
            self.epochs.push(self.timing.counters());
        }
        let Self { machine, memory, filter, texels, timing, epochs, .. } = self;
        let counters = timing.counters();
        let word = machine.timing.data_bank_bytes;
        let timed = Timed {
            filter,
            counters,
            planes: memory.surface.planes.iter().map(|plane| (plane.lu, plane.lv)).zip(timing.planes()).collect(),
            histograms: *timing.histograms(),
            epochs,
            bytes_requested: timing.cache().counters().bytes_requested,
            energy: machine.energy.of(&counters, word, texels, memory.channels),
        };
        (timed, timing.into_observer())
    }

    fn length(&self) -> usize {
        self.epoch.unwrap_or(usize::MAX).max(1)
    }
}
