//! Anisotropic tap programs: several probes along or over the footprint (docs/numerics.md, section 5.2).

use crate::{
    address::Footprint,
    probe_tables::{FAST_CAP, FAST_SAMPLES, FELINE_CAP, FELINE_PROBES, FELINE_WEIGHTS},
    request::Request,
    taps::{Program, Split, TapUnit, coordinates},
};

/// Most probes a level.
const MOST_PROBES: usize = 64;

/// Logarithms of the footprint's axes, in 1/256.
#[derive(Clone, Copy)]
struct Axes {
    major: i32,
    minor: i32,
}

impl Axes {
    #[inline]
    fn of(unit: &TapUnit, request: &Request) -> Self {
        let [major, minor] = request.scale.map(|scale| unit.raw(scale));
        Self { major, minor: minor.max(0) }
    }

    /// Logarithm of their ratio.
    #[inline]
    const fn ratio(self) -> i32 {
        let ratio = self.major.saturating_sub(self.minor);
        if ratio > 0 { ratio } else { 0 }
    }

    /// The minor axis, raised where the cap on the number of probes would leave gaps.
    #[inline]
    fn probe_level(self, unit: &TapUnit, cap: i32) -> Split {
        unit.chain_level(self.minor.max(self.major.saturating_sub(cap)))
    }
}

/// How many probes: one more for each threshold reached, up to the cap.
#[inline]
fn probes(thresholds: &[i32; 63], reached: i32, cap: u8) -> i64 {
    1 + thresholds[..usize::from(cap) - 1].partition_point(|&threshold| reached >= threshold) as i64
}

/// A coordinate moved by `numerator / denominator` of a vector, floor of the exact quotient.
#[inline]
fn moved(at: [i64; 2], request: &Request, axis: usize, numerator: i64, denominator: i64) -> [i64; 2] {
    let vector = request.axes[axis].map(|component| i64::from(component.to_bits()));
    [0, 1].map(|i| at[i] + (vector[i] * numerator).div_euclid(denominator))
}

/// Writes the two taps of each trilinear probe.
#[inline]
fn trilinear_probes(
    unit: &TapUnit,
    split: Split,
    count: i64,
    taps: &mut [Footprint],
    probe: impl Fn(i64) -> ([i64; 2], u32),
) -> (usize, [u16; 2]) {
    for (i, taps) in (0..count).zip(taps.chunks_exact_mut(2)) {
        let (at, weight) = probe(i);
        taps[0] = unit.tap(split.level, at, weight * split.s());
        taps[1] = unit.tap(split.coarser, at, weight * split.t);
    }
    (2 * count as usize, [split.lod; 2])
}

pub(crate) struct Texram;

impl Program for Texram {
    const WEIGHT_BITS: u32 = 16;
    const MOST_TAPS: usize = 2 * MOST_PROBES;
    const ALWAYS: bool = false;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let at = coordinates(request);
        let axes = Axes::of(unit, request);
        let most = unit.sampler().max_anisotropy.ilog2() as i32;
        let log2_count = ((axes.ratio() + 128) >> 8).min(most);
        let count = 1i64 << log2_count;
        let split = axes.probe_level(unit, most << 8);
        trilinear_probes(unit, split, count, taps, |i| {
            (moved(at, request, 0, 2 * i + 1 - count, 2 * count), 256 >> log2_count)
        })
    }
}

pub(crate) struct Feline;

impl Program for Feline {
    const WEIGHT_BITS: u32 = 16;
    const MOST_TAPS: usize = 2 * MOST_PROBES;
    const ALWAYS: bool = false;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let at = coordinates(request);
        let axes = Axes::of(unit, request);
        let cap = unit.sampler().max_anisotropy;
        let count = probes(&FELINE_PROBES, axes.ratio(), cap);
        let split = axes.probe_level(unit, FELINE_CAP[usize::from(cap) - 1]);
        let weights = &FELINE_WEIGHTS[(count * (count - 1) / 2) as usize..];
        trilinear_probes(unit, split, count, taps, |i| {
            (moved(at, request, 0, 2 * i + 1 - count, count + 1), weights[i as usize].into())
        })
    }
}

pub(crate) struct Fast;

impl Program for Fast {
    const WEIGHT_BITS: u32 = 16;
    const MOST_TAPS: usize = 2 * MOST_PROBES;
    const ALWAYS: bool = false;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let at = coordinates(request);
        let axes = Axes::of(unit, request);
        let cap = unit.sampler().max_anisotropy;
        let split = axes.probe_level(unit, FAST_CAP[usize::from(cap) - 1]);
        let area = axes.major.saturating_add(axes.minor);
        let mut written = 0;
        for (level, of_level) in [(split.level, split.s()), (split.coarser, split.t)] {
            let count = probes(&FAST_SAMPLES, area.saturating_sub((level as i32) << 9), cap);
            for i in 0..count {
                let place = if count == 1 {
                    at
                } else {
                    let [along, across] = jitter(request.pixel, i as u32, level as u32);
                    let along = moved(at, request, 0, 256 * i + along - 128 * count, 256 * count);
                    moved(along, request, 1, across - 128, 256)
                };
                let share = 256 * (i + 1) / count - 256 * i / count;
                taps[written] = unit.tap(level, place, share as u32 * of_level);
                written += 1;
            }
        }
        (written, [split.lod; 2])
    }
}

/// FAST jitters its samples; a model that must answer the same twice takes the jitter from a hash of pixel, sample and level
/// (E25). The mixing is the finalizer of MurmurHash3.
#[inline]
fn jitter([x, y]: [u16; 2], sample: u32, level: u32) -> [i64; 2] {
    let seed = sample.wrapping_mul(0x9E37_79B9).wrapping_add(level.wrapping_mul(0x85EB_CA6B));
    let mut hash = (u32::from(x) | u32::from(y) << 16) ^ seed;
    hash ^= hash >> 16;
    hash = hash.wrapping_mul(0x85EB_CA6B);
    hash ^= hash >> 13;
    hash = hash.wrapping_mul(0xC2B2_AE35);
    hash ^= hash >> 16;
    [i64::from(hash & 255), i64::from(hash >> 8 & 255)]
}
