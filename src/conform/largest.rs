//! The largest texture whose samples are all allowed.
//!
//! A normalised coordinate of 20 fraction bits leaves `20 - log2(size)` for the sub-texel fraction (numerics-input X13, peers.md (c) 8), so
//! every machine has a size beyond which its samples are no longer what it promised. The textures are strips of noise, black or white in
//! each channel: eight rows, so that the columns may be many.

use rayon::prelude::*;
use serde::Serialize;
use texunit_hw::{AddressMode, Filter, PyramidKind, peers::Arithmetic};

use super::{
    Judge, Precision, Sample, Verdict,
    scenes::{LevelRule, answers, front_end, peer_filter, peer_sample, sampling},
};
use crate::{
    error::Result,
    experiment::verify::SplitMix,
    machine::Machine,
    pyramid::{Build, PlaneImage},
    scene::{Fragment, Gradient},
};

/// Rows of a strip.
const ROWS: u32 = 8;
/// log2 of the smallest and largest sizes tried.
pub const SIZES: std::ops::RangeInclusive<u32> = 3..=15;
/// Samples of each size.
const SAMPLES: u32 = 20_000;

/// The largest sizes that pass, none if not even the smallest does.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Largest {
    /// Among powers of two, that one and all below it pass.
    pub power_of_two: Option<u32>,
    /// Among sizes one less than a power of two, as far from a shift as can be.
    pub odd: Option<u32>,
    /// Why the next power of two fails, and the next odd size.
    pub why: Vec<String>,
}

/// A strip of noise, black or white in each channel.
#[must_use]
pub fn strip(size: u32) -> PlaneImage {
    let mut random = SplitMix(u64::from(size));
    let texels = (0..size * ROWS)
        .map(|_| {
            let bits = random.draw();
            [0, 1, 2, 3].map(|channel| if bits >> channel & 1 == 1 { 255 } else { 0 })
        })
        .collect();
    PlaneImage::top(size, ROWS, texels)
}

/// Fragments anywhere in the first repeat of a strip, of any level it has.
#[must_use]
pub fn fragments(size: u32, count: u32) -> Vec<Fragment> {
    let mut random = SplitMix(0x1A26_E572 ^ u64::from(size) << 32);
    let mut unit = || (random.draw() >> 11) as f64 / (1_u64 << 53) as f64;
    (0..count)
        .map(|number| {
            let ratio = libm::exp2(unit() * f64::from(size.ilog2()));
            let gradient = Gradient { ux: ratio / f64::from(size), vy: ratio / f64::from(ROWS), ..Gradient::default() };
            // Half of them near the origin, where a float coordinate is finest and a fixed one is not.
            let near = if number % 2 == 0 { 1.0 } else { 1.0 / 16.0 };
            Fragment { x: (number % 256) as u16, y: (number / 256) as u16, u: unit() * near, v: unit(), gradient }
        })
        .collect()
}

/// Finds the largest sizes `answers` to fragments pass at; it is given the size.
///
/// # Errors
/// What `passes` returns.
pub fn largest(mut refused: impl FnMut(u32) -> Result<Option<String>>) -> Result<Largest> {
    let mut found = Largest { power_of_two: None, odd: None, why: Vec::new() };
    for less in [0, 1] {
        for log2 in SIZES {
            let size = (1 << log2) - less;
            if let Some(why) = refused(size)? {
                found.why.push(why);
                break;
            }
            *(if less == 0 { &mut found.power_of_two } else { &mut found.odd }) = Some(size);
        }
    }
    Ok(found)
}

/// The largest textures a machine passes at with a filter.
///
/// # Errors
/// A filter without a rule; a machine that cannot be built.
pub fn of_machine(machine: &Machine, filter: Filter, precision: Precision) -> Result<Largest> {
    largest(|size| {
        let held = machine.texture.hold(PyramidKind::Mipmap, &strip(size).into())?;
        let address = [AddressMode::Wrap; 2];
        let judge = Judge::new(&held.pyramid, sampling(machine, filter, address), precision)?;
        let front_end = front_end(machine, filter, address, &held.pyramid)?;
        let samples = answers(machine, &held, &front_end, &fragments(size, SAMPLES), LevelRule::Norm)?;
        Ok(first_refused(&judge, &samples, size))
    })
}

/// The same of the arithmetic of another machine: bilinear on level 0, and trilinear where it blends levels.
///
/// # Errors
/// A filter without a rule; a strip without a mipmap.
pub fn of_peer(peer: &Arithmetic, filter: Filter, precision: Precision) -> Result<Option<Largest>> {
    if peer_filter(peer, filter).is_err() {
        return Ok(None);
    }
    let found = largest(|size| {
        let pyramid = Build::default().pyramid(PyramidKind::Mipmap, &strip(size))?;
        let address = [AddressMode::Wrap; 2];
        let judge = Judge::new(&pyramid, sampling(&Machine::default(), filter, address), precision)?;
        let samples: Vec<Sample> = fragments(size, SAMPLES)
            .par_iter()
            .map(|fragment| {
                let ratio = (fragment.gradient.ux * f64::from(size)) as f32;
                let lod = (ratio, [libm::log2(f64::from(ratio)); 2]);
                peer_sample(peer, &pyramid, filter, [fragment.u, fragment.v], lod, address)
            })
            .collect();
        Ok(first_refused(&judge, &samples, size))
    })?;
    Ok(Some(found))
}

/// The first answer refused, in words.
#[must_use]
pub fn first_refused(judge: &Judge<'_>, samples: &[Sample], size: u32) -> Option<String> {
    let number =
        samples.par_iter().position_first(|sample| matches!(judge.verdict(sample), Verdict::Refused { .. }))?;
    Some(format!("{size} x {ROWS}, sample {number}: {}", judge.explain(&samples[number])?))
}
