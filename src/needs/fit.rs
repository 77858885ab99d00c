//! The smallest machine for a scene: a proposal with its evidence, never done by itself.

use texunit_hw::{Filter, Geometry, LodSource, Request, Response, Sampler, Unit};

use super::{Needs, Plan, requests};
use crate::{
    error::{Error, Result},
    machine::Machine,
    scene::Scene,
    sweep::Caches,
    texture_memory::TextureMemory,
    timed_run::time_requests,
};

/// What a smaller machine may lose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// More clocks, as a share of those of the machine as it is.
    pub time: f64,
    /// Root of the mean square difference from the picture of the machine as it is, in steps of an 8-bit channel.
    pub rmse: f64,
}

/// One setting that was tried, on top of those chosen before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// What was changed.
    pub setting: String,
    /// To what.
    pub value: String,
    /// Bytes of the cache.
    pub cache_bytes: u64,
    /// Lines it missed.
    pub misses: u64,
    /// Clocks of the whole scene.
    pub cycles: u64,
    /// Difference from the picture of the machine as it is, LSB.
    pub rmse: f64,
    /// The largest difference of a channel.
    pub worst: u8,
    /// Whether both losses are within their bounds.
    pub within: bool,
    /// Whether it is part of the proposal.
    pub chosen: bool,
}

/// The smallest machine found, and what was tried on the way to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The filter it is for.
    pub filter: Filter,
    /// What it may lose.
    pub loss: Loss,
    /// Requests of the scene.
    pub requests: u64,
    /// Clocks of the machine as it is, with everything left out that is not needed.
    pub cycles: u64,
    /// The proposal, as `--set` takes it.
    pub settings: Vec<String>,
    /// The machine as it is, then every candidate in the order it was tried.
    pub candidates: Vec<Candidate>,
}

/// Number of ways of the caches tried.
const WAYS: [u32; 5] = [1, 2, 3, 4, 8];

/// Most sets of the caches tried, as a power of two.
const LOG2_SETS: u32 = 10;

struct Bench<'a> {
    scene: &'a Scene,
    memory: TextureMemory,
    requests: Vec<Request>,
    needs: Needs,
    filter: Filter,
    expected: Vec<Response>,
    bound: u64,
    loss: Loss,
}

impl Bench<'_> {
    /// The sampler of a machine, with what is not needed left out.
    fn sampler(&self, machine: &Machine) -> Sampler {
        let sampler = machine.sampler(self.filter, self.scene.texture.wrap, LodSource::Gradient);
        Plan::new(&self.needs, &sampler).sampler
    }

    fn answers(&self, sampler: &Sampler) -> Result<Vec<Response>> {
        let mut unit = Unit::new(sampler, &self.memory.surface, &self.memory.bytes).map_err(|error| {
            Error::setting("machine", "the scene's sampler", error.to_string(), "change the machine")
        })?;
        let mut responses = vec![Response::default(); self.requests.len()];
        unit.run(&self.requests, &mut responses, &mut ());
        Ok(responses)
    }

    /// Runs one machine and holds it against the first.
    fn measure(&self, machine: &Machine, setting: &str, value: String) -> Result<Candidate> {
        let sampler = self.sampler(machine);
        let timed = time_requests(machine, &sampler, &self.memory, &self.requests)?;
        let (mut squares, mut worst) = (0u64, 0);
        for (one, other) in self.answers(&sampler)?.iter().zip(&self.expected) {
            for (one, other) in one.texel.iter().zip(other.texel).take(3) {
                let apart = one.abs_diff(other);
                squares += u64::from(apart) * u64::from(apart);
                worst = worst.max(apart);
            }
        }
        let rmse = (squares as f64 / (3 * self.requests.len()).max(1) as f64).sqrt();
        let cycles = timed.counters.cycles;
        Ok(Candidate {
            setting: setting.to_owned(),
            value,
            cache_bytes: machine.cache.geometry().size_bytes(),
            misses: timed.counters.fills,
            cycles,
            rmse,
            worst,
            within: cycles <= self.bound && rmse <= self.loss.rmse,
            chosen: false,
        })
    }
}

impl Fit {
    /// Looks for the smallest cache, then FIFO, then widths of filter and level, each with what was chosen before it. Caches of all
    /// shapes are counted in one pass over the addresses; of each size the one with the fewest misses is timed, the smallest first.
    ///
    /// # Errors
    /// A machine that cannot be built or timed.
    pub fn find(scene: &Scene, machine: &Machine, filter: Filter, loss: Loss) -> Result<Self> {
        let texture = scene.texture.texture_image();
        let requests = requests(scene, machine, filter);
        let sampler = machine.sampler(filter, scene.texture.wrap, LodSource::Gradient);
        let needs = Needs::of(&requests, &sampler, scene.texture.size())?;
        let plan = Plan::new(&needs, &sampler);
        let memory = plan.hold(&machine.texture, &texture)?;
        let mut bench = Bench { scene, memory, requests, needs, filter, expected: Vec::new(), bound: u64::MAX, loss };
        bench.expected = bench.answers(&plan.sampler)?;
        let mut first = bench.measure(machine, "as it is", machine.name.clone())?;
        first.chosen = true;
        bench.bound = (first.cycles as f64 * (1.0 + loss.time)) as u64;
        let mut fit = Self {
            filter,
            loss,
            requests: bench.requests.len() as u64,
            cycles: first.cycles,
            settings: Vec::new(),
            candidates: vec![first],
        };
        let mut best = machine.clone();
        let caches = fit.caches(&bench, machine)?;
        best = fit.first_within(&bench, &best, "cache", &caches)?;
        let fifo = |depth: u32| {
            let value = format!("{depth} taps");
            (value, vec![format!("timing.fragment-fifo={depth}")])
        };
        let deepest = best.timing.fragment_fifo;
        let depths: Vec<_> = (2..).map(|log2| 1 << log2).take_while(|depth| *depth < deepest).map(fifo).collect();
        best = fit.first_within(&bench, &best, "fragment FIFO", &depths)?;
        for (name, key, lowest, bits) in
            [("filter bits", "filter.bits", 1, best.filter.bits), ("LOD bits", "lod.bits", 0, best.lod.bits)]
        {
            let widths: Vec<_> =
                (lowest..bits).map(|width| (width.to_string(), vec![format!("{key}={width}")])).collect();
            best = fit.first_within(&bench, &best, name, &widths)?;
        }
        Ok(fit)
    }

    /// The best cache of each size below that of the machine, smallest first, with its settings.
    fn caches(&self, bench: &Bench<'_>, machine: &Machine) -> Result<Vec<(String, Vec<String>)>> {
        let whole = machine.cache.geometry();
        let geometries: Vec<Geometry> = (0..=LOG2_SETS)
            .flat_map(|log2| WAYS.map(|ways| Geometry { sets: 1 << log2, ways, line: whole.line }))
            .filter(|geometry| geometry.size_bytes() < whole.size_bytes())
            .collect();
        let wrong = |problem: String| Error::setting("cache", &machine.cache.policy, problem, "use lru or fifo");
        let policy = machine.cache.policy().map_err(wrong)?;
        let mut caches = Caches::new(&geometries, policy).map_err(|error| wrong(error.to_string()))?;
        let sampler = bench.sampler(machine);
        let mut unit =
            Unit::without_memory(&sampler, &bench.memory.surface).map_err(|error| wrong(error.to_string()))?;
        unit.addresses(&bench.requests, &mut caches);
        let (_, mut counted) = caches.finish();
        counted.sort_by_key(|(geometry, misses)| (geometry.size_bytes(), *misses, geometry.ways));
        counted.dedup_by_key(|(geometry, _)| geometry.size_bytes());
        Ok(counted
            .into_iter()
            .map(|(Geometry { sets, ways, line }, _)| {
                let settings = vec![format!("cache.sets={sets}"), format!("cache.ways={ways}")];
                (format!("{sets} sets x {ways} ways x {line} B"), settings)
            })
            .collect())
    }

    /// Tries settings in order until one loses no more than it may; the machine with it, or as it was.
    fn first_within(
        &mut self,
        bench: &Bench<'_>,
        machine: &Machine,
        setting: &str,
        candidates: &[(String, Vec<String>)],
    ) -> Result<Machine> {
        for (value, settings) in candidates {
            // A machine that cannot be built, as one whose FIFO would hang, is no candidate.
            let Ok(smaller) = machine.with_settings(settings) else { continue };
            let mut candidate = bench.measure(&smaller, setting, value.clone())?;
            candidate.chosen = candidate.within;
            let chosen = candidate.chosen;
            self.candidates.push(candidate);
            if chosen {
                self.settings.extend_from_slice(settings);
                return Ok(smaller);
            }
        }
        Ok(machine.clone())
    }
}
