//! A scene through a filter that no unit has: floats, texel reads and error, but neither bits nor cache.

use std::time::Instant;

use image::RgbaImage;
use rayon::prelude::*;
use texunit_hw::{Filter, LodSource};

use super::{
    Deviation, Stage,
    stage::{SLICE, paint},
};
use crate::{
    error::Result,
    machine::Machine,
    names::AnyFilter,
    pyramid::Pyramid,
    reference::{ewa::Ewa, ideal::IdealSampler},
};

/// What a filter in floats did with one scene.
#[derive(Clone, Debug)]
pub struct FloatOutcome {
    /// What it is called.
    pub filter: AnyFilter,
    /// How many pixels it answered.
    pub pixels: u64,
    /// The answers, rounded to 8 bits.
    pub picture: RgbaImage,
    /// Texels read in all.
    pub texels_read: u64,
    /// Deviation of the unrounded answers from the ground truth, in the eight bits of a channel.
    pub against_truth: Deviation,
    /// Wall time for the whole scene, all threads.
    pub host_seconds: f64,
}

/// The elliptical weighted average, on a mipmap.
///
/// # Errors
/// A pyramid that is no mipmap.
pub fn ewa(stage: &Stage, machine: &Machine, pyramid: &Pyramid) -> Result<FloatOutcome> {
    let sampler = machine.sampler(Filter::Trilinear, stage.scene.texture.wrap, LodSource::Gradient);
    let ewa = Ewa::new(pyramid, &IdealSampler::from(&sampler))?;
    let mut outcome = FloatOutcome {
        filter: AnyFilter::Ewa,
        pixels: 0,
        picture: stage.empty_picture(),
        texels_read: 0,
        against_truth: Deviation::default(),
        host_seconds: 0.0,
    };
    stage.for_each_batch(|fragments| {
        let begin = Instant::now();
        let slices: Vec<(Vec<[u8; 4]>, u64, Deviation)> = fragments
            .par_chunks(SLICE)
            .with_max_len(1)
            .map(|fragments| {
                let (mut texels, mut reads, mut deviation) = (Vec::with_capacity(SLICE), 0, Deviation::default());
                for fragment in fragments {
                    let answer = ewa.sample([fragment.u, fragment.v], fragment.gradient);
                    texels.push(answer.texel.map(|value| (value + 0.5) as u8));
                    reads += answer.texels_read;
                    deviation.add(answer.texel, stage.truth.at(fragment.x, fragment.y).map(f64::from));
                }
                (texels, reads, deviation)
            })
            .collect();
        outcome.host_seconds += begin.elapsed().as_secs_f64();
        outcome.pixels += fragments.len() as u64;
        for ((texels, reads, deviation), fragments) in slices.into_iter().zip(fragments.chunks(SLICE)) {
            paint(&mut outcome.picture, fragments, texels.into_iter());
            outcome.texels_read += reads;
            outcome.against_truth = outcome.against_truth.merge(deviation);
        }
    });
    Ok(outcome)
}
