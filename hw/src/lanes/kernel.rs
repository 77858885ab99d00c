//! Eight requests at a time, from coordinates to texels, in registers all the way.

use core::arch::x86_64::*;

use super::{
    LANES,
    address::{Addresses, Taps},
    filter,
    level::{Logarithm, brilinear_weights},
    room::{Table, Texels, load_head, store_responses},
};
use crate::{
    address::Footprint,
    lod::LevelRange,
    request::{Request, Response},
    sampler::{Filter, LevelRounding, Sampler},
    taps::TapUnit,
};

/// A texture unit in eight lanes.
#[derive(Clone, Debug)]
pub(super) struct Kernel<'m> {
    filter: Filter,
    addresses: Addresses,
    texels: Texels<'m>,
    logarithm: Logarithm,
    chain: LevelRange,
    axes: [LevelRange; 2],
    /// Storage index of plane (0, lv) of a Dipmap is this plus lv, for lv above zero; one less than a Ripmap's planes a row.
    row_planes: i32,
    /// What a filter of one whole level adds before it cuts the fraction.
    level_rounding: i32,
    brilinear: Table,
}

/// What a filter makes of eight requests before there are addresses.
#[derive(Clone, Copy)]
struct Levels {
    /// A plane a tap.
    planes: [__m256i; 4],
    /// Weights of the blurrier of two taps, of 256: of the first pair, and of the second pair or between both.
    t: [__m256i; 2],
    /// Levels of a response.
    lod: __m256i,
}

impl<'m> Kernel<'m> {
    pub(super) fn new(sampler: &Sampler, unit: &TapUnit, bytes: &'m [u8]) -> Option<Self> {
        Some(Self {
            filter: sampler.filter,
            addresses: Addresses::new(unit.address(), bytes.len() as u64)?,
            texels: Texels::new(bytes)?,
            logarithm: Logarithm::new(sampler)?,
            chain: unit.chain,
            axes: unit.axes,
            row_planes: unit.row_planes as i32,
            level_rounding: match sampler.level_rounding {
                LevelRounding::Floor => 0,
                LevelRounding::Nearest => 128,
                LevelRounding::Gl => 127,
            },
            brilinear: Table::new(brilinear_weights(sampler.brilinear_threshold.into()))?,
        })
    }

    /// Answers requests if `ANSWER`, writes their taps if `WRITE`; what is not asked for may be empty.
    ///
    /// # Panics
    /// If there is not room for the taps.
    #[target_feature(enable = "avx2")]
    pub(super) fn eights<const ANSWER: bool, const WRITE: bool>(
        &self,
        requests: &[[Request; LANES]],
        responses: &mut [[Response; LANES]],
        footprints: &mut [Footprint],
    ) {
        let mut responses = responses.iter_mut();
        let mut footprints = footprints.chunks_exact_mut(LANES * self.taps());
        for requests in requests {
            let responses = if ANSWER { responses.next() } else { None };
            let footprints = if WRITE { footprints.next().expect("room for the taps") } else { Default::default() };
            self.eight::<WRITE>(requests, responses, footprints);
        }
    }

    /// Taps of a request.
    pub(super) const fn taps(&self) -> usize {
        match self.filter {
            Filter::Point | Filter::Bilinear | Filter::NearestMip => 1,
            Filter::DipmapTrilinear | Filter::Ripmap => 4,
            _ => 2,
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn eight<const WRITE: bool>(
        &self,
        requests: &[Request; LANES],
        responses: Option<&mut [Response; LANES]>,
        footprints: &mut [Footprint],
    ) {
        let (at, scale) = transposed(requests);
        let levels = self.levels(scale);
        let distance = self.taps();
        let tap = |number: usize| self.addresses.bilinear(levels.planes[number], at);
        let s = |number: usize| _mm256_sub_epi32(_mm256_set1_epi32(256), levels.t[number]);
        let sums = |taps: &Taps| filter::bilinear(self.texels, taps);
        let mut write = |number: usize, taps: &Taps, weight: __m256i| {
            if WRITE {
                self.addresses.write(taps, weight, levels.planes[number], &mut footprints[number..], distance);
            }
        };
        let one = _mm256_set1_epi32(1);
        match self.filter {
            Filter::Point => {
                let nothing = _mm256_setzero_si256();
                let index = self.addresses.point(nothing, at);
                write(0, &Taps { corners: [index, nothing, nothing, nothing], fractions: [nothing; 2] }, one);
                if let Some(responses) = responses {
                    store_responses(responses, self.texels.gather(index), levels.lod);
                }
            }
            Filter::Bilinear | Filter::NearestMip => {
                let tap = tap(0);
                write(0, &tap, one);
                if let Some(responses) = responses {
                    store_responses(responses, filter::one(sums(&tap)), levels.lod);
                }
            }
            Filter::DipmapTrilinear | Filter::Ripmap => {
                let taps = [tap(0), tap(1), tap(2), tap(3)];
                let ripmap = self.filter == Filter::Ripmap;
                if WRITE {
                    let weights = if ripmap {
                        let product = |v, u| _mm256_mullo_epi32(v, u);
                        let (su, tu, sv, tv) = (s(0), levels.t[0], s(1), levels.t[1]);
                        [product(sv, su), product(sv, tu), product(tv, su), product(tv, tu)]
                    } else {
                        [s(0), levels.t[0], s(1), levels.t[1]]
                    };
                    for (number, weight) in weights.into_iter().enumerate() {
                        write(number, &taps[number], weight);
                    }
                }
                if let Some(responses) = responses {
                    let [a, b, c, d] = [sums(&taps[0]), sums(&taps[1]), sums(&taps[2]), sums(&taps[3])];
                    let texel = if ripmap {
                        filter::four([a, b, c, d], levels.t)
                    } else {
                        filter::mean_of_two([(a, b, levels.t[0]), (c, d, levels.t[1])])
                    };
                    store_responses(responses, texel, levels.lod);
                }
            }
            _ => {
                let taps = [tap(0), tap(1)];
                if WRITE {
                    let halves = matches!(self.filter, Filter::MipDouble | Filter::Dipmap);
                    let weights = if halves { [one; 2] } else { [s(0), levels.t[0]] };
                    write(0, &taps[0], weights[0]);
                    write(1, &taps[1], weights[1]);
                }
                if let Some(responses) = responses {
                    let texel = filter::two(sums(&taps[0]), sums(&taps[1]), levels.t[0]);
                    store_responses(responses, texel, levels.lod);
                }
            }
        }
    }

    /// The filter's program (see `taps`), as far as the planes and weights.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn levels(&self, [scale_u, scale_v]: [__m256i; 2]) -> Levels {
        let nothing = _mm256_setzero_si256();
        let mut levels = Levels { planes: [nothing; 4], t: [nothing; 2], lod: nothing };
        let half = _mm256_set1_epi32(128);
        match self.filter {
            Filter::NearestMip => {
                let level = self.chain.whole_lanes(self.logarithm.raw(scale_u), self.level_rounding);
                levels.planes[0] = level;
                levels.lod = both(_mm256_slli_epi32::<8>(level));
            }
            Filter::Trilinear => {
                let split = self.chain.split_lanes(self.logarithm.raw(scale_u));
                levels.planes = [split.level, split.coarser, nothing, nothing];
                levels.t[0] = split.t;
                levels.lod = both(split.lod);
            }
            Filter::Brilinear => {
                let split = self.chain.split_lanes(self.logarithm.raw(scale_u));
                levels.planes = [split.level, split.coarser, nothing, nothing];
                levels.t[0] = self.brilinear.gather(split.t);
                levels.lod = both(_mm256_add_epi32(_mm256_slli_epi32::<8>(split.level), levels.t[0]));
            }
            Filter::MipDouble => {
                let u = self.chain.whole_lanes(self.logarithm.raw(scale_u), 0);
                let v = self.chain.whole_lanes(self.logarithm.raw(scale_v), 0);
                levels.planes = [u, v, nothing, nothing];
                levels.t[0] = half;
                levels.lod = pair(_mm256_slli_epi32::<8>(u), _mm256_slli_epi32::<8>(v));
            }
            Filter::Dipmap => {
                let u = self.axes[0].whole_lanes(self.logarithm.raw(scale_u), 0);
                let v = self.axes[1].whole_lanes(self.logarithm.raw(scale_v), 0);
                levels.planes = [u, self.row_plane(v), nothing, nothing];
                levels.t[0] = half;
                levels.lod = pair(_mm256_slli_epi32::<8>(u), _mm256_slli_epi32::<8>(v));
            }
            Filter::DipmapTrilinear => {
                let u = self.axes[0].split_lanes(self.logarithm.raw(scale_u));
                let v = self.axes[1].split_lanes(self.logarithm.raw(scale_v));
                levels.planes = [u.level, u.coarser, self.row_plane(v.level), self.row_plane(v.coarser)];
                levels.t = [u.t, v.t];
                levels.lod = pair(u.lod, v.lod);
            }
            Filter::Ripmap => {
                let u = self.axes[0].split_lanes(self.logarithm.raw(scale_u));
                let v = self.axes[1].split_lanes(self.logarithm.raw(scale_v));
                let planes_of_row = _mm256_set1_epi32(self.row_planes + 1);
                let rows = [_mm256_mullo_epi32(v.level, planes_of_row), _mm256_mullo_epi32(v.coarser, planes_of_row)];
                levels.planes = [
                    _mm256_add_epi32(rows[0], u.level),
                    _mm256_add_epi32(rows[0], u.coarser),
                    _mm256_add_epi32(rows[1], u.level),
                    _mm256_add_epi32(rows[1], u.coarser),
                ];
                levels.t = [u.t, v.t];
                levels.lod = pair(u.lod, v.lod);
            }
            _ => {}
        }
        levels
    }

    /// Storage indices of planes (0, lv) of a Dipmap.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn row_plane(&self, lv: __m256i) -> __m256i {
        let beyond = _mm256_cmpgt_epi32(lv, _mm256_setzero_si256());
        _mm256_add_epi32(lv, _mm256_and_si256(beyond, _mm256_set1_epi32(self.row_planes)))
    }
}

/// Two levels as the halves of a word.
#[inline]
#[target_feature(enable = "avx2")]
fn pair(u: __m256i, v: __m256i) -> __m256i {
    _mm256_or_si256(u, _mm256_slli_epi32::<16>(v))
}

/// One level as both halves of a word.
#[inline]
#[target_feature(enable = "avx2")]
fn both(lod: __m256i) -> __m256i {
    pair(lod, lod)
}

/// Coordinates and scales of eight requests.
#[inline]
#[target_feature(enable = "avx2")]
fn transposed(requests: &[Request; LANES]) -> ([__m256i; 2], [__m256i; 2]) {
    let [r0, r1, r2, r3, r4, r5, r6, r7] = requests;
    let row = |low, high| _mm256_set_m128i(load_head(high), load_head(low));
    let [u, v, scale_u, scale_v] = super::address::transposed(row(r0, r4), row(r1, r5), row(r2, r6), row(r3, r7));
    ([u, v], [scale_u, scale_v])
}
