//! One scene through one filter of one machine: bits, hits, bytes, errors and host time.

use image::RgbaImage;
use texunit_hw::{
    Filter, Request, Response, Sampler,
    cache::{Counters, Detail as CacheDetail, PlaneCounters, TexelCache},
};

mod addresses;
pub mod alias;
mod bench;
mod deviation;
mod float_only;
mod image_quality;
mod pyramids;
pub mod report;
mod stage;
pub mod verify;

pub use addresses::AddressBench;
pub use bench::{Answers, Bench};
pub use deviation::Deviation;
pub use float_only::{FloatOutcome, ewa};
pub use image_quality::ImageQuality;
pub use pyramids::Pyramids;
pub use stage::{BATCH, Stage, paint};

use crate::{
    error::{Error, Result},
    machine::Machine,
    needs::LeftOut,
    timed_run::Timed,
};

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
