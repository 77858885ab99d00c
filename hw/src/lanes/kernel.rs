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

/// Eight requests between the address unit and the datapath.
#[derive(Clone, Copy)]
struct Made {
    taps: [Taps; 4],
    levels: Levels,
}

/// Requests made before the first is filtered, in eights. Addresses and filters are loops of their own: each is short enough for the host
/// to work on two turns at a time, and needs no more registers than it has.
const STAGE: usize = 8;

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
    pub(super) fn run<const ANSWER: bool, const WRITE: bool>(
        &self,
        requests: &[[Request; LANES]],
        responses: &mut [[Response; LANES]],
        footprints: &mut [Footprint],
    ) {
        // A loop a filter: its taps and weights stay in registers.
        macro_rules! eights {
            ($($filter:ident)*) => {
                match self.filter {
                    $(Filter::$filter => {
                        self.eights::<{ Filter::$filter as u8 }, ANSWER, WRITE>(requests, responses, footprints);
                    })*
                    _ => unreachable!("no kernel is made for filters of many taps"),
                }
            };
        }
        eights!(Point Bilinear NearestMip Trilinear Brilinear MipDouble Dipmap DipmapTrilinear Ripmap);
    }

    #[target_feature(enable = "avx2")]
    fn eights<const FILTER: u8, const ANSWER: bool, const WRITE: bool>(
        &self,
        requests: &[[Request; LANES]],
        responses: &mut [[Response; LANES]],
        footprints: &mut [Footprint],
    ) {
        let nothing = _mm256_setzero_si256();
        let levels = Levels { planes: [nothing; 4], t: [nothing; 2], lod: nothing };
        let mut stage = [Made { taps: [Taps { corners: [nothing; 4], fractions: [nothing; 2] }; 4], levels }; STAGE];
        let mut responses = responses.iter_mut();
        let mut footprints = footprints.chunks_exact_mut(LANES * taps_of(FILTER));
        for requests in requests.chunks(STAGE) {
            let stage = &mut stage[..requests.len()];
            for (requests, made) in requests.iter().zip(&mut *stage) {
                self.make::<FILTER>(requests, made);
            }
            if WRITE {
                for (made, footprints) in stage.iter().zip(&mut footprints) {
                    self.write::<FILTER>(made, footprints);
                }
            }
            if ANSWER {
                for (made, responses) in stage.iter().zip(&mut responses) {
                    store_responses(responses, self.filter::<FILTER>(made), made.levels.lod);
                }
            }
        }
    }

    /// The address unit.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn make<const FILTER: u8>(&self, requests: &[Request; LANES], made: &mut Made) {
        let (at, scale) = transposed(requests);
        made.levels = self.levels::<FILTER>(scale);
        if FILTER == Filter::Point as u8 {
            made.taps[0].corners[0] = self.addresses.point(made.levels.planes[0], at);
            return;
        }
        for (tap, plane) in made.taps.iter_mut().zip(made.levels.planes).take(taps_of(FILTER)) {
            *tap = self.addresses.bilinear(plane, at);
        }
    }

    /// Writes taps as the scalar unit does.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn write<const FILTER: u8>(&self, made: &Made, footprints: &mut [Footprint]) {
        let Levels { planes, t, .. } = made.levels;
        let one = _mm256_set1_epi32(1);
        let whole = _mm256_set1_epi32(256);
        let (s, s_between) = (_mm256_sub_epi32(whole, t[0]), _mm256_sub_epi32(whole, t[1]));
        let weights = match FILTER {
            _ if FILTER == Filter::Trilinear as u8 || FILTER == Filter::Brilinear as u8 => [s, t[0], one, one],
            _ if FILTER == Filter::DipmapTrilinear as u8 => [s, t[0], s_between, t[1]],
            _ if FILTER == Filter::Ripmap as u8 => [
                _mm256_mullo_epi32(s_between, s),
                _mm256_mullo_epi32(s_between, t[0]),
                _mm256_mullo_epi32(t[1], s),
                _mm256_mullo_epi32(t[1], t[0]),
            ],
            _ => [one; 4],
        };
        match taps_of(FILTER) {
            1 => self.write_taps::<1>(made, &weights, footprints),
            2 => self.write_taps::<2>(made, &weights, footprints),
            _ => self.write_taps::<4>(made, &weights, footprints),
        }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn write_taps<const TAPS: usize>(&self, made: &Made, weights: &[__m256i; 4], footprints: &mut [Footprint]) {
        let Some(footprints) = footprints.as_chunks_mut::<TAPS>().0.first_chunk_mut::<LANES>() else { return };
        for number in 0..TAPS {
            let (taps, weight, plane) = (&made.taps[number], weights[number], made.levels.planes[number]);
            self.addresses.write(taps, weight, plane, number, footprints);
        }
    }

    /// The datapath.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn filter<const FILTER: u8>(&self, made: &Made) -> __m256i {
        let Made { taps: [a, b, c, d], levels: Levels { t, .. } } = made;
        if FILTER == Filter::Point as u8 {
            return self.texels.gather(a.corners[0]);
        }
        match taps_of(FILTER) {
            1 => filter::one(filter::bilinear(self.texels, a)),
            2 => filter::two(filter::bilinear(self.texels, a), filter::bilinear(self.texels, b), t[0]),
            _ => {
                let a = (filter::bilinear(self.texels, a), filter::bilinear(self.texels, b));
                let b = (filter::bilinear(self.texels, c), filter::bilinear(self.texels, d));
                if FILTER == Filter::Ripmap as u8 {
                    filter::four([a.0, a.1, b.0, b.1], *t)
                } else {
                    filter::mean_of_two([(a.0, a.1, t[0]), (b.0, b.1, t[1])])
                }
            }
        }
    }

    /// The filter's program (see `taps`), as far as the planes and weights.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn levels<const FILTER: u8>(&self, [scale_u, scale_v]: [__m256i; 2]) -> Levels {
        let nothing = _mm256_setzero_si256();
        let mut levels = Levels { planes: [nothing; 4], t: [nothing; 2], lod: nothing };
        let half = _mm256_set1_epi32(128);
        match FILTER {
            _ if FILTER == Filter::NearestMip as u8 => {
                let level = self.chain.whole_lanes(self.logarithm.raw(scale_u), self.level_rounding);
                levels.planes[0] = level;
                levels.lod = both(_mm256_slli_epi32::<8>(level));
            }
            _ if FILTER == Filter::Trilinear as u8 => {
                let split = self.chain.split_lanes(self.logarithm.raw(scale_u));
                levels.planes = [split.level, split.coarser, nothing, nothing];
                levels.t[0] = split.t;
                levels.lod = both(split.lod);
            }
            _ if FILTER == Filter::Brilinear as u8 => {
                let split = self.chain.split_lanes(self.logarithm.raw(scale_u));
                levels.planes = [split.level, split.coarser, nothing, nothing];
                levels.t[0] = self.brilinear.gather(split.t);
                levels.lod = both(_mm256_add_epi32(_mm256_slli_epi32::<8>(split.level), levels.t[0]));
            }
            _ if FILTER == Filter::MipDouble as u8 => {
                let u = self.chain.whole_lanes(self.logarithm.raw(scale_u), 0);
                let v = self.chain.whole_lanes(self.logarithm.raw(scale_v), 0);
                levels.planes = [u, v, nothing, nothing];
                levels.t[0] = half;
                levels.lod = pair(_mm256_slli_epi32::<8>(u), _mm256_slli_epi32::<8>(v));
            }
            _ if FILTER == Filter::Dipmap as u8 => {
                let u = self.axes[0].whole_lanes(self.logarithm.raw(scale_u), 0);
                let v = self.axes[1].whole_lanes(self.logarithm.raw(scale_v), 0);
                levels.planes = [u, self.row_plane(v), nothing, nothing];
                levels.t[0] = half;
                levels.lod = pair(_mm256_slli_epi32::<8>(u), _mm256_slli_epi32::<8>(v));
            }
            _ if FILTER == Filter::DipmapTrilinear as u8 => {
                let u = self.axes[0].split_lanes(self.logarithm.raw(scale_u));
                let v = self.axes[1].split_lanes(self.logarithm.raw(scale_v));
                levels.planes = [u.level, u.coarser, self.row_plane(v.level), self.row_plane(v.coarser)];
                levels.t = [u.t, v.t];
                levels.lod = pair(u.lod, v.lod);
            }
            _ if FILTER == Filter::Ripmap as u8 => {
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

/// Taps of a request of a filter.
const fn taps_of(filter: u8) -> usize {
    const ONE: [u8; 3] = [Filter::Point as u8, Filter::Bilinear as u8, Filter::NearestMip as u8];
    const FOUR: [u8; 2] = [Filter::DipmapTrilinear as u8, Filter::Ripmap as u8];
    if filter == ONE[0] || filter == ONE[1] || filter == ONE[2] {
        1
    } else if filter == FOUR[0] || filter == FOUR[1] {
        4
    } else {
        2
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
