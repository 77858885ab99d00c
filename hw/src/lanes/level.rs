//! The LOD unit in lanes (see `lod`).

use alloc::vec::Vec;

use super::{machine::Machine, room::Table};
use crate::{
    lod::{LOD_BITS, LevelRange, raw_level},
    log2_table::CELLS,
    request::LodSource,
    sampler::{Log2, Sampler},
};

/// From the scale of a request to a level before bias and clamp.
#[derive(Clone, Debug)]
pub(super) struct Logarithm {
    source: LodSource,
    log2: Log2,
    cells: Table,
}

impl Logarithm {
    pub(super) fn new(sampler: &Sampler) -> Option<Self> {
        Some(Self { source: sampler.lod_source, log2: sampler.log2, cells: Table::new(CELLS.to_vec())? })
    }

    /// The level, exact wherever the clamp that follows leaves anything of it.
    ///
    /// The clamp ends at 32.0 and the bias at +-16.0. So the exponents of zero, infinity and NaN need no words of their own here: the
    /// levels their bits come to, below -126 and from 64, clamp to the same ends as the levels of the scalar unit. And an
    /// explicit level may saturate at +-2^20 before the bias is added.
    #[inline(always)]
    pub(super) fn raw<M: Machine>(&self, m: M, scale: M::Words) -> M::Words {
        match (self.source, self.log2) {
            (LodSource::Explicit, _) => {
                let far = m.splat(1 << 20);
                m.max(m.min(scale, far), m.sub(m.splat(0), far))
            }
            (LodSource::Gradient, Log2::Exact) => self.exact(m, scale),
            (LodSource::Gradient, log2) => by_the_scalar_unit(m, scale, log2),
        }
    }

    #[inline(always)]
    fn exact<M: Machine>(&self, m: M, scale: M::Words) -> M::Words {
        let magnitude = m.and(scale, m.splat(0x7FFF_FFFF));
        let mantissa = m.and(scale, m.splat(0x7F_FFFF));
        let cell = m.gather(&self.cells, m.shr(mantissa, 15));
        let threshold = m.and(cell, m.splat(0xFF_FFFF));
        let octaves = m.shl(m.shr(magnitude, 23), 7);
        // One more from the threshold on: one more for all, and one less below it.
        let start = m.add(octaves, m.splat(1 - (127 << 7)));
        m.sub_where_greater(m.add(start, m.shr(cell, 24)), threshold, mantissa)
    }
}

/// The units that only studies choose: lane by lane.
#[inline(always)]
fn by_the_scalar_unit<M: Machine>(m: M, scale: M::Words, log2: Log2) -> M::Words {
    m.each(scale, |scale| raw_level(scale.cast_unsigned(), log2))
}

/// Levels split into the two each lies between.
#[derive(Clone, Copy)]
pub(super) struct Splits<M: Machine> {
    /// The sharper levels.
    pub(super) level: M::Words,
    /// The blurrier ones, or the same at the end of the chain.
    pub(super) coarser: M::Words,
    /// Weights of the blurrier ones, of 256.
    pub(super) t: M::Words,
    /// Both together, 8.8.
    pub(super) lod: M::Words,
}

/// Bias and clamp of one axis or of the chain; see [`LevelRange`].
impl LevelRange {
    #[inline(always)]
    fn clamp_lanes<M: Machine>(&self, m: M, raw: M::Words) -> M::Words {
        let level = m.add(raw, m.splat(self.bias));
        m.min(m.max(level, m.splat(self.low)), m.splat(self.high))
    }

    /// `fractional`, split.
    #[inline(always)]
    pub(super) fn split_lanes<M: Machine>(&self, m: M, raw: M::Words) -> Splits<M> {
        let rounded = m.and(m.add(self.clamp_lanes(m, raw), m.splat(self.half)), m.splat(self.mask));
        let last = m.splat(self.last.into());
        let lod = m.min(rounded, m.shl(last, LOD_BITS as i32));
        let level = m.shr(lod, LOD_BITS as i32);
        let coarser = m.min(m.add(level, m.splat(1)), last);
        Splits { level, coarser, t: m.and(lod, m.splat(255)), lod }
    }

    /// `whole`, where `added` is what the rounding adds before the fraction is cut.
    #[inline(always)]
    pub(super) fn whole_lanes<M: Machine>(&self, m: M, raw: M::Words, added: i32) -> M::Words {
        let level = m.add(self.clamp_lanes(m, raw), m.splat(added));
        m.min(m.shr(level, LOD_BITS as i32), m.splat(self.last.into()))
    }
}

/// What brilinear makes of a fraction, for each of the 256: the weight of the blurrier level, 256 for that level alone.
pub(super) fn brilinear_weights(threshold: u32) -> Vec<u32> {
    (0..256)
        .map(|t| match t {
            _ if t <= threshold => 0,
            _ if t >= 256 - threshold => 256,
            _ => ((t - threshold) << 8) / (256 - 2 * threshold),
        })
        .collect()
}
