//! The LOD unit in eight lanes (see `lod`).

use core::arch::x86_64::*;

use alloc::vec::Vec;

use super::room::Table;
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
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn raw(&self, scale: __m256i) -> __m256i {
        match (self.source, self.log2) {
            (LodSource::Explicit, _) => {
                let far = _mm256_set1_epi32(1 << 20);
                _mm256_max_epi32(_mm256_min_epi32(scale, far), _mm256_sub_epi32(_mm256_setzero_si256(), far))
            }
            (LodSource::Gradient, Log2::Exact) => self.exact(scale),
            (LodSource::Gradient, log2) => by_the_scalar_unit(scale, log2),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn exact(&self, scale: __m256i) -> __m256i {
        let magnitude = _mm256_and_si256(scale, _mm256_set1_epi32(0x7FFF_FFFF));
        let mantissa = _mm256_and_si256(scale, _mm256_set1_epi32(0x7F_FFFF));
        let cell = self.cells.gather(_mm256_srli_epi32::<15>(mantissa));
        let threshold = _mm256_and_si256(cell, _mm256_set1_epi32(0xFF_FFFF));
        // Minus one below the threshold; the constant adds one to all.
        let below = _mm256_cmpgt_epi32(threshold, mantissa);
        let octaves = _mm256_slli_epi32::<7>(_mm256_srli_epi32::<23>(magnitude));
        let start = _mm256_add_epi32(octaves, _mm256_set1_epi32(1 - (127 << 7)));
        _mm256_add_epi32(_mm256_add_epi32(start, _mm256_srli_epi32::<24>(cell)), below)
    }
}

/// The units that only studies choose: lane by lane.
#[target_feature(enable = "avx2")]
fn by_the_scalar_unit(scale: __m256i, log2: Log2) -> __m256i {
    let lane = |scale: i32| raw_level(scale.cast_unsigned(), log2);
    _mm256_setr_epi32(
        lane(_mm256_extract_epi32::<0>(scale)),
        lane(_mm256_extract_epi32::<1>(scale)),
        lane(_mm256_extract_epi32::<2>(scale)),
        lane(_mm256_extract_epi32::<3>(scale)),
        lane(_mm256_extract_epi32::<4>(scale)),
        lane(_mm256_extract_epi32::<5>(scale)),
        lane(_mm256_extract_epi32::<6>(scale)),
        lane(_mm256_extract_epi32::<7>(scale)),
    )
}

/// Levels split into the two each lies between.
#[derive(Clone, Copy)]
pub(super) struct Splits {
    /// The sharper levels.
    pub(super) level: __m256i,
    /// The blurrier ones, or the same at the end of the chain.
    pub(super) coarser: __m256i,
    /// Weights of the blurrier ones, of 256.
    pub(super) t: __m256i,
    /// Both together, 8.8.
    pub(super) lod: __m256i,
}

/// Bias and clamp of one axis or of the chain; see [`LevelRange`].
impl LevelRange {
    #[inline]
    #[target_feature(enable = "avx2")]
    fn clamp_lanes(&self, raw: __m256i) -> __m256i {
        let level = _mm256_add_epi32(raw, _mm256_set1_epi32(self.bias));
        _mm256_min_epi32(_mm256_max_epi32(level, _mm256_set1_epi32(self.low)), _mm256_set1_epi32(self.high))
    }

    /// `fractional`, split.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn split_lanes(&self, raw: __m256i) -> Splits {
        let rounded = _mm256_and_si256(
            _mm256_add_epi32(self.clamp_lanes(raw), _mm256_set1_epi32(self.half)),
            _mm256_set1_epi32(self.mask),
        );
        let last = _mm256_set1_epi32(self.last.into());
        let lod = _mm256_min_epi32(rounded, _mm256_slli_epi32::<{ LOD_BITS as i32 }>(last));
        let level = _mm256_srli_epi32::<{ LOD_BITS as i32 }>(lod);
        let coarser = _mm256_min_epi32(_mm256_add_epi32(level, _mm256_set1_epi32(1)), last);
        Splits { level, coarser, t: _mm256_and_si256(lod, _mm256_set1_epi32(255)), lod }
    }

    /// `whole`, where `added` is what the rounding adds before the fraction is cut.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn whole_lanes(&self, raw: __m256i, added: i32) -> __m256i {
        let level = _mm256_add_epi32(self.clamp_lanes(raw), _mm256_set1_epi32(added));
        _mm256_min_epi32(_mm256_srli_epi32::<{ LOD_BITS as i32 }>(level), _mm256_set1_epi32(self.last.into()))
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
