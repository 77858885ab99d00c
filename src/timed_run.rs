//! A scene's requests through a machine in time.

use serde_json::{Map, Value, json};
use texunit_hw::{
    Filter, LodSource, Request, Sampler, Unit,
    timing::{Histograms, PlaneTiming, Timing, TimingCounters, TimingObserver},
};

use crate::{
    energy::Energy,
    error::{Error, Result},
    experiment::{Pyramids, cache, report::Metric},
    front_end::FrontEnd,
    machine::Machine,
    names::Named,
    scene::{Fragment, Scene},
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

/// The requests of a scene, bound to what they are asked of.
#[derive(Debug)]
pub struct TimedBench<'s> {
    machine: &'s Machine,
    scene: &'s Scene,
    fragments: Vec<Fragment>,
    pyramids: Pyramids,
    size: [u32; 2],
}

impl<'s> TimedBench<'s> {
    /// Rasterizes the scene and makes the pyramids for some filters.
    ///
    /// # Errors
    /// A pyramid that cannot be made or laid out.
    pub fn new(scene: &'s Scene, machine: &'s Machine, filters: &[Filter]) -> Result<Self> {
        let texture = scene.texture.texture_image();
        let pyramids = Pyramids::for_filters(machine, &texture, filters)?;
        Ok(Self { machine, scene, fragments: scene.fragments().collect(), pyramids, size: scene.texture.size() })
    }

    fn requests(&self, filter: Filter) -> (Sampler, Vec<Request>) {
        let address = self.scene.texture.wrap;
        let front_end = FrontEnd::new(self.machine, filter, address, self.size)
            .of_shape(self.machine, |seen| seen.add(&self.fragments));
        let sampler = self.machine.sampler(filter, address, LodSource::Gradient);
        (sampler, front_end.requests(&self.fragments).0)
    }

    /// Times one filter of those it was made for, an epoch every so many requests, with someone watching.
    ///
    /// # Errors
    /// A machine that cannot run.
    pub fn time<O: TimingObserver>(&self, filter: Filter, epoch: Option<usize>, observer: O) -> Result<(Timed, O)> {
        let (_, memory) = self.pyramids.of(filter);
        let (sampler, requests) = self.requests(filter);
        time_requests(self.machine, &sampler, memory, &requests, epoch, observer)
    }
}

/// Times requests of a texture in memory, an epoch every so many of them, with someone watching.
///
/// # Errors
/// A machine that cannot run.
pub fn time_requests<O: TimingObserver>(
    machine: &Machine,
    sampler: &Sampler,
    memory: &TextureMemory,
    requests: &[Request],
    epoch: Option<usize>,
    observer: O,
) -> Result<(Timed, O)> {
    let filter = sampler.filter;
    let surface = &memory.surface;
    let wrong = |problem: String| Error::setting("machine", &machine.name, problem, "change the machine");
    let mut unit = Unit::new(sampler, surface, &memory.bytes).map_err(|error| wrong(error.to_string()))?;
    let texels = if filter == Filter::Point { 1 } else { 4 };
    let cache = memory.behind(cache(machine, surface.bytes_per_read())?);
    // An entry of a summed-area table or a block is read whole: its banks are as wide as it is (docs/timing.md).
    let mut parameters = machine.timing.parameters();
    parameters.data_bank_bytes = parameters.data_bank_bytes.max(surface.bytes_per_read().next_power_of_two());
    let mut timing =
        Timing::new(&parameters, &machine.memory.parameters(), cache, texels * surface.reads_per_texel(), observer)
            .map_err(|error| wrong(error.to_string()))?;
    let mut epochs = Vec::new();
    for requests in requests.chunks(epoch.unwrap_or(usize::MAX).max(1)) {
        unit.addresses(requests, &mut timing);
        if epoch.is_some() {
            epochs.push(timing.counters());
        }
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
