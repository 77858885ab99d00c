//! A scene through a filter that no unit has: floats, texel reads and error, but neither bits nor cache.

use std::time::Instant;

use rayon::prelude::*;
use texunit_hw::{Filter, LodSource};

use super::{Deviation, Stage};
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
    /// The answers, in pixel order, rounded to 8 bits for a picture.
    pub texels: Vec<[u8; 4]>,
    /// Texels read in all.
    pub texels_read: u64,
    /// Deviation of the unrounded answers from the ground truth, in the eight bits of a channel.
    pub against_truth: Deviation,
    /// Wall time for the whole scene, all threads.
    pub host_seconds: f64,
}

/// Pixels a task takes.
const SLICE: usize = 1 << 10;

/// The elliptical weighted average, on a mipmap.
///
/// # Errors
/// A pyramid that is no mipmap.
pub fn ewa(stage: &Stage, machine: &Machine, pyramid: &Pyramid) -> Result<FloatOutcome> {
    let sampler = machine.sampler(Filter::Trilinear, stage.scene.texture.wrap, LodSource::Gradient);
    let ewa = Ewa::new(pyramid, &IdealSampler::from(&sampler))?;
    let begin = Instant::now();
    let slices: Vec<(Vec<[u8; 4]>, u64, Deviation)> = stage
        .fragments
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
    let host_seconds = begin.elapsed().as_secs_f64();
    let mut outcome = FloatOutcome {
        filter: AnyFilter::Ewa,
        texels: Vec::with_capacity(stage.fragments.len()),
        texels_read: 0,
        against_truth: Deviation::default(),
        host_seconds,
    };
    for (texels, reads, deviation) in slices {
        outcome.texels.extend(texels);
        outcome.texels_read += reads;
        outcome.against_truth = outcome.against_truth.merge(deviation);
    }
    Ok(outcome)
}
