//! One scene through one filter of one machine: bits, hits, bytes, errors and host time.

use std::{sync::Arc, time::Instant};

use image::RgbaImage;
use rayon::prelude::*;
use texunit_hw::{
    Filter, LodSource, PyramidKind, Request, Response, Sampler, Sink, Unit,
    cache::{Counters, Detail as CacheDetail, PlaneCounters, TexelCache},
};

mod addresses;
pub mod alias;
mod deviation;
mod float_only;
mod image_quality;
mod pyramids;
pub mod report;
pub mod verify;

pub use addresses::AddressBench;
pub use deviation::Deviation;
pub use float_only::{FloatOutcome, ewa};
pub use image_quality::ImageQuality;
pub use pyramids::Pyramids;

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
    scene::{Coverage, Fragment, GroundTruth, Scene},
    texel_format::srgb,
    texture_file::TextureImage,
    texture_memory::TextureMemory,
    timed_run::{Timed, Timer},
};

/// A scene with everything that does not depend on the filter. Its fragments are not kept: they would take far more memory than all images, and are
/// drawn anew faster than a filter answers them.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The scene.
    pub scene: Scene,
    /// How many pixels its fragments cover.
    pub coverage: Coverage,
    /// Which, by rows.
    pub covered: Vec<bool>,
    /// Its texture.
    pub texture: TextureImage,
    /// What an unlimited filter would show.
    pub truth: GroundTruth,
}

impl Stage {
    /// Rasterizes a scene and renders its ground truth.
    #[must_use]
    pub fn new(scene: Scene) -> Self {
        Self::in_light(scene, false)
    }

    /// The same; with `srgb` the ground truth is that of a texture of sRGB codes: linear light, as the filters answer then.
    #[must_use]
    pub fn in_light(scene: Scene, srgb: bool) -> Self {
        let mut image = scene.texture.image();
        let texture = scene.texture.texture_image();
        if srgb {
            for pixel in Arc::make_mut(&mut image).pixels_mut() {
                pixel.0 = srgb::linear_texel(pixel.0);
            }
        }
        let truth = GroundTruth::render(&scene, &image);
        let [width, height] = scene.size.map(|side| side as usize);
        let mut covered = vec![false; width * height];
        let coverage = scene.for_each_block(|block| {
            block.iter().for_each(|fragment| covered[usize::from(fragment.y) * width + usize::from(fragment.x)] = true);
        });
        Self { texture, scene, coverage, covered, truth }
    }

    /// Shows `visit` the fragments in pixel order, [`BATCH`] at a time.
    pub fn for_each_batch(&self, mut visit: impl FnMut(&[Fragment])) {
        let mut batch = Vec::with_capacity(BATCH);
        self.scene.for_each_block(|mut block| {
            while !block.is_empty() {
                let (now, after) = block.split_at(block.len().min(BATCH - batch.len()));
                batch.extend_from_slice(now);
                block = after;
                if batch.len() == BATCH {
                    visit(&batch);
                    batch.clear();
                }
            }
        });
        if !batch.is_empty() {
            visit(&batch);
        }
    }

    /// A picture without an answer: what no fragment covers stays transparent black, as in the paper.
    #[must_use]
    pub fn empty_picture(&self) -> RgbaImage {
        RgbaImage::new(self.scene.size[0], self.scene.size[1])
    }
}

/// Puts the answers of fragments where they belong.
fn paint(picture: &mut RgbaImage, fragments: &[Fragment], texels: impl Iterator<Item = [u8; 4]>) {
    for (fragment, texel) in fragments.iter().zip(texels) {
        picture.put_pixel(fragment.x.into(), fragment.y.into(), image::Rgba(texel));
    }
}

/// What one filter did with one scene.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The filter.
    pub filter: Filter,
    /// The sampler it ran with.
    pub sampler: Sampler,
    /// How many pixels it answered.
    pub pixels: u64,
    /// The answers.
    pub picture: RgbaImage,
    /// Cache counters in all.
    pub counters: Counters,
    /// The same per plane, in storage order.
    pub planes: Vec<PlaneRow>,
    /// Bytes of the pyramid, padding included, and texels of all planes.
    pub memory: PyramidMemory,
    /// Coordinates that had no defined place.
    pub undefined: u64,
    /// Answers that differ from the reference, and the first of them.
    pub mismatches: u64,
    /// Where the first of them is, and both answers.
    pub first_mismatch: Option<Mismatch>,
    /// Deviation from the ground truth, in the eight bits of a channel.
    pub against_truth: Deviation,
    /// Deviation from the unquantised filter.
    pub against_ideal: Deviation,
    /// What it took in time.
    pub timed: Timed,
    /// The same without what is not needed, where that was asked for.
    pub left_out: Option<LeftOut>,
    /// What the eye sees of the difference from the ground truth.
    pub quality: ImageQuality,
    /// Wall time of this machine for the whole scene: texels and exact cache, one thread.
    pub host_seconds: f64,
}

/// Cache counters of one plane.
#[derive(Clone, Copy, Debug)]
pub struct PlaneRow {
    /// How often each axis was halved.
    pub halvings: (u8, u8),
    /// Width and height in texels.
    pub size: [u32; 2],
    /// What was read from it.
    pub counters: PlaneCounters,
}

/// What a pyramid takes.
#[derive(Clone, Copy, Debug)]
pub struct PyramidMemory {
    /// Texels of all planes; an entry of a summed-area table takes as much memory as four.
    pub texels: u64,
    /// Texels of the texture itself.
    pub texture_texels: u64,
    /// Bytes laid out, padding included.
    pub bytes: u64,
}

impl PyramidMemory {
    /// Texels of all planes as a multiple of the texture's.
    #[must_use]
    pub fn multiple(&self) -> f64 {
        self.texels as f64 / self.texture_texels as f64
    }
}

/// Two answers that should be one.
#[derive(Clone, Copy, Debug)]
pub struct Mismatch {
    /// The request.
    pub request: Request,
    /// What the chip said.
    pub hw: Response,
    /// What the reference said.
    pub reference: Response,
}

/// What the chip answers, and how far from the ground truth that is.
#[derive(Clone, Debug)]
pub struct Answers {
    /// How many.
    pub pixels: u64,
    /// Coordinates that had no defined place.
    pub undefined: u64,
    /// All of them.
    pub picture: RgbaImage,
    /// Deviation from the ground truth, in the eight bits of a channel.
    pub against_truth: Deviation,
    /// Wall time of this machine for the whole scene, one thread.
    pub host_seconds: f64,
}

/// Requests compared at a time by one thread: few, and each slice a job of its own, for those of the rows at a horizon take the longest.
const SLICE: usize = 1 << 10;

/// Fragments kept at a time: slices for many threads.
pub const BATCH: usize = SLICE << 6;

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

    /// Lets the chip answer, batch by batch, while `sink` looks at its addresses; `visit` is shown every batch.
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
        let (picture, against_truth) = (self.stage.empty_picture(), Deviation::default());
        let mut answers = Answers { pixels: 0, undefined: 0, picture, against_truth, host_seconds: 0.0 };
        self.stage.for_each_batch(|fragments| {
            let (requests, undefined) = self.front_end.requests(fragments);
            responses.resize(requests.len(), Response::default());
            let begin = Instant::now();
            unit.run(&requests, &mut responses, sink);
            answers.host_seconds += begin.elapsed().as_secs_f64();
            answers.pixels += responses.len() as u64;
            answers.undefined += undefined;
            paint(&mut answers.picture, fragments, responses.iter().map(|response| response.texel));
            answers.against_truth = self.against_truth(answers.against_truth, fragments, &responses);
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
        let (mut mismatches, mut first_mismatch, mut against_ideal) = (0, None, Deviation::default());
        let answers = self.answer(&mut cache, |fragments, requests, responses| {
            let (count, first) = against_reference(&reference, requests, responses);
            mismatches += count;
            first_mismatch = first_mismatch.or(first);
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
            against_truth: answers.against_truth,
            against_ideal,
            timed: timer.finish().0,
            left_out: None,
            quality: ImageQuality::of(self.stage, &answers.picture),
            host_seconds: answers.host_seconds,
            picture: answers.picture,
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

    /// How far answers are from the ground truth, added to what others are.
    fn against_truth(&self, so_far: Deviation, fragments: &[Fragment], responses: &[Response]) -> Deviation {
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

/// The machine's cache, empty, for reads of `bytes`, with every counter.
///
/// # Errors
/// A geometry that cannot be built.
pub fn cache(machine: &Machine, bytes: u32) -> Result<TexelCache> {
    cache_that_keeps(CacheDetail::default(), machine, bytes)
}

/// The same with some of the counters.
///
/// # Errors
/// A geometry that cannot be built.
pub fn cache_that_keeps(detail: CacheDetail, machine: &Machine, bytes: u32) -> Result<TexelCache> {
    let shape = &machine.cache;
    let wrong = |problem: String| {
        let value = format!("{} sets x {} ways x {} bytes", shape.sets, shape.ways, shape.line);
        Error::setting("cache", value, problem, "for instance 64 sets, 4 ways, 64 bytes a line")
    };
    let policy = shape.policy().map_err(wrong)?;
    TexelCache::new(shape.geometry(), policy, bytes, detail).map_err(|error| wrong(error.to_string()))
}
