//! One scene through one filter of one machine: bits, hits, bytes, errors and host time.

use std::{sync::Arc, time::Instant};

use image::RgbaImage;
use rayon::prelude::*;
use texunit_hw::{
    Filter, LodSource, PyramidKind, Request, Response, Sampler, Unit,
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
    timed_run::{Timed, time_requests},
};

/// A scene with everything that does not depend on the filter.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The scene.
    pub scene: Scene,
    /// Its fragments in pixel order.
    pub fragments: Vec<Fragment>,
    /// Which pixels they cover.
    pub coverage: Coverage,
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
        let mut fragments = Vec::new();
        let coverage = scene.for_each_block(|block| fragments.extend_from_slice(block));
        Self { texture, scene, fragments, coverage, truth }
    }

    /// The image of answers, fragment by fragment; what no fragment covers is transparent black, as in the paper.
    #[must_use]
    pub fn picture(&self, texels: impl Iterator<Item = [u8; 4]>) -> RgbaImage {
        let mut picture = RgbaImage::new(self.scene.size[0], self.scene.size[1]);
        for (fragment, texel) in self.fragments.iter().zip(texels) {
            picture.put_pixel(fragment.x.into(), fragment.y.into(), image::Rgba(texel));
        }
        picture
    }
}

/// What one filter did with one scene.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The filter.
    pub filter: Filter,
    /// The sampler it ran with.
    pub sampler: Sampler,
    /// The answers, in pixel order.
    pub responses: Vec<Response>,
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

/// Requests compared at a time by one thread: few, and each slice a job of its own, for those of the rows at a horizon take the longest.
const SLICE: usize = 1 << 10;

/// A filter bound to a stage: the parts that several measurements share.
#[derive(Debug)]
pub struct Bench<'s> {
    stage: &'s Stage,
    sampler: Sampler,
    pyramid: &'s Pyramid,
    memory: &'s TextureMemory,
    /// The requests, in pixel order.
    pub requests: Vec<Request>,
    undefined: u64,
    front_end: FrontEnd,
}

impl<'s> Bench<'s> {
    /// Makes the requests.
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
            .of_shape(machine, |seen| seen.add(&stage.fragments));
        let (requests, undefined) = front_end.requests(&stage.fragments);
        let sampler = machine.sampler(filter, address, LodSource::Gradient);
        Self { stage, sampler, pyramid, memory, requests, undefined, front_end }
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

    /// Runs chip, cache, reference and ideal.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn measure(&self, machine: &Machine) -> Result<Outcome> {
        let surface = &self.memory.surface;
        let mut unit = self.unit()?;
        let mut responses = vec![Response::default(); self.requests.len()];
        let mut cache = self.memory.behind(cache(machine, surface.bytes_per_read())?);
        let begin = Instant::now();
        unit.run(&self.requests, &mut responses, &mut cache);
        let host_seconds = begin.elapsed().as_secs_f64();

        let (mismatches, first_mismatch) = self.against_reference(&responses)?;
        let planes = surface
            .planes
            .iter()
            .zip(cache.planes().into_iter().chain(std::iter::repeat(PlaneCounters::default())))
            .map(|(plane, counters)| PlaneRow { halvings: (plane.lu, plane.lv), size: plane.size(), counters })
            .collect();
        Ok(Outcome {
            filter: self.sampler.filter,
            sampler: self.sampler,
            counters: cache.counters(),
            planes,
            memory: PyramidMemory {
                texels: self.pyramid.texels() * if self.pyramid.kind == PyramidKind::Sat { 4 } else { 1 },
                texture_texels: u64::from(self.pyramid.width) * u64::from(self.pyramid.height),
                bytes: self.memory.stored_bytes(),
            },
            undefined: self.undefined,
            mismatches,
            first_mismatch,
            against_truth: self.against_truth(&responses),
            against_ideal: self.against_ideal(&responses)?,
            timed: self.time(machine)?,
            left_out: None,
            quality: ImageQuality::of(self.stage, &responses),
            host_seconds,
            responses,
        })
    }

    /// Times the requests through the machine.
    ///
    /// # Errors
    /// A machine that cannot run.
    pub fn time(&self, machine: &Machine) -> Result<Timed> {
        time_requests(machine, &self.sampler, self.memory, &self.requests)
    }

    /// Runs the requests again without what they do not need, and compares every answer.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn leave_out(&self, machine: &Machine) -> Result<LeftOut> {
        LeftOut::measure(machine, &self.stage.texture, &self.sampler, &self.requests)
    }

    /// Seconds of this machine for the texels of the whole scene, without a cache, one thread: the best of some runs.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn texel_seconds(&self, repeats: u8) -> Result<f64> {
        let mut unit = self.unit()?;
        let mut responses = vec![Response::default(); self.requests.len()];
        let mut best = f64::INFINITY;
        for _ in 0..repeats {
            let begin = Instant::now();
            unit.run(&self.requests, &mut responses, &mut ());
            best = best.min(begin.elapsed().as_secs_f64());
        }
        Ok(best)
    }

    /// Counts answers that differ from the float reference in any bit of texel or level.
    ///
    /// # Errors
    /// A reference that cannot be built.
    pub fn against_reference(&self, responses: &[Response]) -> Result<(u64, Option<Mismatch>)> {
        let reference = Reference::new(self.pyramid, &self.sampler)?;
        let slices: Vec<(u64, Option<Mismatch>)> = self
            .requests
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
        Ok((count, slices.into_iter().find_map(|(_, first)| first)))
    }

    /// How far answers are from the ground truth.
    #[must_use]
    pub fn against_truth(&self, responses: &[Response]) -> Deviation {
        let truth = &self.stage.truth;
        let slices: Vec<Deviation> = self
            .stage
            .fragments
            .par_chunks(SLICE)
            .zip(responses.par_chunks(SLICE))
            .with_max_len(1)
            .map(|(fragments, responses)| {
                fragments.iter().zip(responses).fold(Deviation::default(), |mut sum, (fragment, response)| {
                    sum.add(response.texel.map(f64::from), truth.at(fragment.x, fragment.y).map(f64::from));
                    sum
                })
            })
            .collect();
        slices.into_iter().fold(Deviation::default(), Deviation::merge)
    }

    fn against_ideal(&self, responses: &[Response]) -> Result<Deviation> {
        let ideal = Ideal::new(self.pyramid, IdealSampler::from(&self.sampler))?;
        let slices: Vec<Deviation> = self
            .stage
            .fragments
            .par_chunks(SLICE)
            .zip(responses.par_chunks(SLICE))
            .with_max_len(1)
            .map(|(fragments, responses)| {
                let mut sum = Deviation::default();
                for (fragment, response) in fragments.iter().zip(responses) {
                    let answer = ideal.sample([fragment.u, fragment.v], self.front_end.ideal_detail(fragment));
                    sum.add(response.texel.map(f64::from), answer.texel);
                }
                sum
            })
            .collect();
        Ok(slices.into_iter().fold(Deviation::default(), Deviation::merge))
    }
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
