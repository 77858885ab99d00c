//! Temporal error: what an image does from one frame to the next that the truth does not.

use texunit_hw::{Filter, cache::TexelCache};

use crate::{
    error::Result,
    experiment::{Bench, Deviation, Pyramids, Stage, cache, report, report::Metric},
    machine::Machine,
};

/// One filter on its way through the frames of a scene, with a cache that stays warm.
#[derive(Debug)]
pub struct Flicker {
    filter: Filter,
    cache: Option<TexelCache>,
    cold_bytes: u64,
    pixels: u64,
    spatial: Deviation,
    temporal: Deviation,
    /// Error of every pixel in the frame before; not a number where there was none.
    before: Vec<[f64; 4]>,
}

impl Flicker {
    /// Before the first frame.
    #[must_use]
    pub fn new(filter: Filter) -> Self {
        Self {
            filter,
            cache: None,
            cold_bytes: 0,
            pixels: 0,
            spatial: Deviation::default(),
            temporal: Deviation::default(),
            before: Vec::new(),
        }
    }

    /// Which filter.
    #[must_use]
    pub const fn filter(&self) -> Filter {
        self.filter
    }

    /// The next frame.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn frame(&mut self, stage: &Stage, machine: &Machine, pyramids: &Pyramids) -> Result<()> {
        let (pyramid, memory) = pyramids.of(self.filter);
        let bench = Bench::new(stage, machine, self.filter, pyramid, memory);
        let bytes = memory.surface.bytes_per_read();
        let mut warm = match self.cache.take() {
            Some(cache) => cache,
            None => memory.behind(cache(machine, bytes)?),
        };
        let (mut cold, mut other_unit) = (memory.behind(cache(machine, bytes)?), bench.unit()?);
        let width = stage.scene.size[0] as usize;
        let mut errors = vec![[f64::NAN; 4]; width * stage.scene.size[1] as usize];
        self.before.resize(errors.len(), [f64::NAN; 4]);
        let answers = bench.answer(&mut warm, |fragments, requests, responses| {
            other_unit.addresses(requests, &mut cold);
            for (fragment, response) in fragments.iter().zip(responses) {
                let truth = stage.truth.at(fragment.x, fragment.y).map(f64::from);
                let answer = response.texel.map(f64::from);
                self.spatial.add(answer, truth);
                let at = usize::from(fragment.y) * width + usize::from(fragment.x);
                errors[at] = [0, 1, 2, 3].map(|channel| answer[channel] - truth[channel]);
                if !self.before[at][0].is_nan() {
                    self.temporal.add(errors[at], self.before[at]);
                }
            }
        })?;
        self.cache = Some(warm);
        self.cold_bytes += cold.counters().bytes_fetched;
        self.pixels += answers.pixels;
        self.before = errors;
        Ok(())
    }

    /// What all frames came to.
    #[must_use]
    pub fn metrics(&self) -> Vec<Metric> {
        let metric = |name, value: f64, unit| Metric { name, value: Some(value), unit };
        let per_pixel = |bytes: u64| bytes as f64 / self.pixels.max(1) as f64;
        let warm = self.cache.as_ref().map_or(0, |cache| cache.counters().bytes_fetched);
        let mut metrics = vec![metric("pixels", self.pixels as f64, "pixel")];
        metrics.extend(report::deviation_metrics(report::AGAINST_TRUTH, &self.spatial));
        metrics.extend([
            metric("flicker_rmse", self.temporal.rmse(), "LSB"),
            metric("flicker_worst", self.temporal.worst(), "LSB"),
            metric("bytes_per_pixel_cold", per_pixel(self.cold_bytes), "B/pixel"),
            metric("bytes_per_pixel_warm", per_pixel(warm), "B/pixel"),
        ]);
        metrics
    }
}
