//! A filter bound to a scene: chip, cache, reference, ideal and time, batch by batch.

use std::time::Instant;

use rayon::prelude::*;
use texunit_hw::{Filter, LodSource, PyramidKind, Request, Response, Sampler, Sink, Unit, cache::PlaneCounters};

use super::{
    Deviation, ImageQuality, Mismatch, Outcome, PlaneRow, PyramidMemory, Stage, cache,
    stage::{SLICE, paint},
};
use crate::{
    error::{Error, Result},
    front_end::FrontEnd,
    machine::Machine,
    needs::LeftOut,
    pyramid::Pyramid,
    reference::{
        Reference,
        ideal::{Ideal, IdealSampler},
    },
    scene::Fragment,
    texture_memory::TextureMemory,
    timed_run::Timer,
};

/// How many answers the chip gave, and in how long.
#[derive(Clone, Copy, Debug, Default)]
pub struct Answers {
    /// How many.
    pub pixels: u64,
    /// Coordinates that had no defined place.
    pub undefined: u64,
    /// Wall time of this machine for the whole scene, one thread.
    pub host_seconds: f64,
}

/// A filter bound to a stage: the parts that several measurements share.
#[derive(Debug)]
pub struct Bench<'s> {
    stage: &'s Stage,
    sampler: Sampler,
    pyramid: &'s Pyramid,
    memory: &'s TextureMemory,
    front_end: FrontEnd,
}

impl<'s> Bench<'s> {
    /// Binds a filter.
    #[must_use]
    pub fn new(
        stage: &'s Stage,
        machine: &Machine,
        filter: Filter,
        pyramid: &'s Pyramid,
        memory: &'s TextureMemory,
    ) -> Self {
        let address = stage.scene.texture.wrap;
        let front_end = FrontEnd::new(machine, filter, address, [pyramid.width, pyramid.height])
            .of_shape(machine, |seen| stage.for_each_batch(|fragments| seen.add(fragments)));
        let sampler = machine.sampler(filter, address, LodSource::Gradient);
        Self { stage, sampler, pyramid, memory, front_end }
    }

    /// The unit, bound to this texture.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn unit(&self) -> Result<Unit<'s>> {
        Unit::new(&self.sampler, &self.memory.surface, &self.memory.bytes).map_err(|error| {
            Error::setting("machine", self.sampler.filter as u8, error.to_string(), "change the machine")
        })
    }

    /// All requests, in pixel order: 36 bytes a pixel.
    #[must_use]
    pub fn requests(&self) -> Vec<Request> {
        let mut requests = Vec::new();
        self.stage.for_each_batch(|fragments| requests.extend(self.front_end.requests(fragments).0));
        requests
    }

    /// Lets the chip answer, batch by batch in pixel order, while `sink` looks at its addresses; `visit` is shown every batch.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn answer(
        &self,
        sink: &mut impl Sink,
        mut visit: impl FnMut(&[Fragment], &[Request], &[Response]),
    ) -> Result<Answers> {
        let mut unit = self.unit()?;
        let mut responses = Vec::new();
        let mut answers = Answers::default();
        self.stage.for_each_batch(|fragments| {
            let (requests, undefined) = self.front_end.requests(fragments);
            responses.resize(requests.len(), Response::default());
            let begin = Instant::now();
            unit.run(&requests, &mut responses, sink);
            answers.host_seconds += begin.elapsed().as_secs_f64();
            answers.pixels += responses.len() as u64;
            answers.undefined += undefined;
            visit(fragments, &requests, &responses);
        });
        Ok(answers)
    }

    /// Runs chip, cache, reference and ideal.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn measure(&self, machine: &Machine) -> Result<Outcome> {
        self.measure_watched(machine, |_| ())
    }

    /// The same; `watch` is shown the answers, batch by batch in pixel order.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn measure_watched(&self, machine: &Machine, mut watch: impl FnMut(&[Response])) -> Result<Outcome> {
        let surface = &self.memory.surface;
        let mut cache = self.memory.behind(cache(machine, surface.bytes_per_read())?);
        let mut timer = self.timer(machine)?;
        let reference = Reference::new(self.pyramid, &self.sampler)?;
        let ideal = Ideal::new(self.pyramid, IdealSampler::from(&self.sampler))?;
        let (mut mismatches, mut first_mismatch) = (0, None);
        let (mut picture, mut against_truth, mut against_ideal) =
            (self.stage.empty_picture(), Deviation::default(), Deviation::default());
        let answers = self.answer(&mut cache, |fragments, requests, responses| {
            let (count, first) = against_reference(&reference, requests, responses);
            mismatches += count;
            first_mismatch = first_mismatch.or(first);
            paint(&mut picture, fragments, responses.iter().map(|response| response.texel));
            against_truth = self.against_truth(against_truth, fragments, responses);
            against_ideal = self.against_ideal(against_ideal, &ideal, fragments, responses);
            timer.time(requests);
            watch(responses);
        })?;
        let planes = surface
            .planes
            .iter()
            .zip(cache.planes().into_iter().chain(std::iter::repeat(PlaneCounters::default())))
            .map(|(plane, counters)| PlaneRow { halvings: (plane.lu, plane.lv), size: plane.size(), counters })
            .collect();
        Ok(Outcome {
            filter: self.sampler.filter,
            sampler: self.sampler,
            pixels: answers.pixels,
            counters: cache.counters(),
            planes,
            memory: PyramidMemory {
                texels: self.pyramid.texels() * if self.pyramid.kind == PyramidKind::Sat { 4 } else { 1 },
                texture_texels: u64::from(self.pyramid.width) * u64::from(self.pyramid.height),
                bytes: self.memory.stored_bytes(),
            },
            undefined: answers.undefined,
            mismatches,
            first_mismatch,
            against_truth,
            against_ideal,
            timed: timer.finish().0,
            left_out: None,
            quality: ImageQuality::of(self.stage, &picture),
            host_seconds: answers.host_seconds,
            picture,
        })
    }

    /// Times requests through the machine.
    ///
    /// # Errors
    /// A machine that cannot run.
    pub fn timer<'m>(&self, machine: &'m Machine) -> Result<Timer<'m, ()>>
    where
        's: 'm,
    {
        Timer::new(machine, &self.sampler, self.memory, None, ())
    }

    /// Runs the requests again without what they do not need, and compares every answer. All requests are kept for it.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn leave_out(&self, machine: &Machine) -> Result<LeftOut> {
        LeftOut::measure(machine, &self.stage.texture, &self.sampler, &self.requests())
    }

    /// Seconds of this machine for the texels of the whole scene, without a cache, one thread: the best of some runs.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn texel_seconds(&self, repeats: u8) -> Result<f64> {
        let mut unit = self.unit()?;
        let requests = self.requests();
        let mut responses = vec![Response::default(); requests.len()];
        let mut best = f64::INFINITY;
        for _ in 0..repeats {
            let begin = Instant::now();
            unit.run(&requests, &mut responses, &mut ());
            best = best.min(begin.elapsed().as_secs_f64());
        }
        Ok(best)
    }

    /// How far answers are from the ground truth, in the eight bits of a channel, added to what others are.
    #[must_use]
    pub fn against_truth(&self, so_far: Deviation, fragments: &[Fragment], responses: &[Response]) -> Deviation {
        deviation(so_far, fragments, responses, |fragment| self.stage.truth.at(fragment.x, fragment.y).map(f64::from))
    }

    /// The same from the unquantised filter.
    fn against_ideal(
        &self,
        so_far: Deviation,
        ideal: &Ideal<'_>,
        fragments: &[Fragment],
        responses: &[Response],
    ) -> Deviation {
        deviation(so_far, fragments, responses, |fragment| {
            ideal.sample([fragment.u, fragment.v], self.front_end.ideal_detail(fragment)).texel
        })
    }
}

/// How far the answers of fragments are from what `truth` says, added to what others are. Sums are by slice, whatever the threads.
fn deviation(
    so_far: Deviation,
    fragments: &[Fragment],
    responses: &[Response],
    truth: impl Fn(&Fragment) -> [f64; 4] + Sync,
) -> Deviation {
    let slices: Vec<Deviation> = fragments
        .par_chunks(SLICE)
        .zip(responses.par_chunks(SLICE))
        .with_max_len(1)
        .map(|(fragments, responses)| {
            let mut sum = Deviation::default();
            for (fragment, response) in fragments.iter().zip(responses) {
                sum.add(response.texel.map(f64::from), truth(fragment));
            }
            sum
        })
        .collect();
    slices.into_iter().fold(so_far, Deviation::merge)
}

/// Counts answers that differ from the float reference in any bit of texel or level, and the first of them.
fn against_reference(
    reference: &Reference<'_>,
    requests: &[Request],
    responses: &[Response],
) -> (u64, Option<Mismatch>) {
    let slices: Vec<(u64, Option<Mismatch>)> = requests
        .par_chunks(SLICE)
        .zip(responses.par_chunks(SLICE))
        .with_max_len(1)
        .map(|(requests, responses)| {
            let mut differing = requests.iter().zip(responses).filter_map(|(request, hw)| {
                let reference = reference.sample(request);
                (reference != *hw).then_some(Mismatch { request: *request, hw: *hw, reference })
            });
            let first = differing.next();
            (u64::from(first.is_some()) + differing.count() as u64, first)
        })
        .collect();
    let count = slices.iter().map(|(count, _)| count).sum();
    (count, slices.into_iter().find_map(|(_, first)| first))
}
