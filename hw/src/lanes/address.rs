//! The address unit in eight lanes (see `address`): the same tables, in words of 32 bits that count texels.

use core::arch::x86_64::*;

use alloc::vec::Vec;

use super::{
    LANES,
    room::{Table, store_footprint},
};
use crate::{
    address::{AddressUnit, FIRST_INDEX, Footprint, OUTSIDE},
    coordinate::COORDINATE_BITS,
};

/// Texels of a surface are fewer than this, so that an index, or the sum of an index and `OUTSIDE_INDEX`, or twice the latter is a
/// positive number of 32 bits.
const MOST_TEXELS: u64 = 1 << OUTSIDE_SHIFT;
const OUTSIDE_SHIFT: u32 = 29;
/// Stands for `OUTSIDE`.
const OUTSIDE_INDEX: u32 = 1 << OUTSIDE_SHIFT;

/// Sides are at most this, so that the index of a texel under any coordinate is a number of 32 bits.
const LARGEST_SIDE: u32 = 1 << 19;

/// Words of a row of `AddressUnit::planes`: side, first entry and last lower index of u, the same of v, two to spare.
const ROW: usize = 8;

/// Where texels lie, for eight taps at a time.
#[derive(Clone, Debug)]
pub(super) struct Addresses {
    entries: Table,
    /// A row a plane.
    planes: Table,
    /// The bits of a coordinate that each axis keeps.
    masks: [i32; 2],
    /// Whether an index beyond the border can come up, which a periodic mode with its masked coordinates rules out.
    saturates: [bool; 2],
    /// Whether a texel can be outside.
    clips: bool,
}

/// Eight taps: the texels' indices in memory, and the fractions.
#[derive(Clone, Copy)]
pub(super) struct Taps {
    /// Texels (i0, j0), (i1, j0), (i0, j1), (i1, j1).
    pub(super) corners: [__m256i; 4],
    /// Of u and v, of 256.
    pub(super) fractions: [__m256i; 2],
}

impl Addresses {
    /// The same tables, if words of 32 bits can hold them. Addresses must be those of texels of four bytes.
    pub(super) fn new(unit: &AddressUnit, bytes: u64) -> Option<Self> {
        if bytes / 4 >= MOST_TEXELS || unit.axes.as_flattened().iter().any(|axis| axis.size > LARGEST_SIDE) {
            return None;
        }
        let entries: Vec<u32> = unit
            .tables
            .iter()
            .map(|&entry| if entry == OUTSIDE { OUTSIDE_INDEX } else { (entry / 4) as u32 })
            .collect();
        let clips = unit.tables.contains(&OUTSIDE);
        let mut planes = Vec::with_capacity(ROW * unit.axes.len());
        for axes in &unit.axes {
            for axis in axes {
                planes.extend([axis.size, (axis.start as i64 - FIRST_INDEX) as u32, axis.last as u32]);
            }
            planes.extend([0; 2]);
        }
        let any_plane = &unit.axes[0];
        Some(Self {
            entries: Table::new(entries)?,
            planes: Table::new(planes)?,
            masks: [0, 1].map(|axis| any_plane[axis].mask as i32),
            saturates: [0, 1].map(|axis| any_plane[axis].mask == -1),
            clips,
        })
    }

    /// Bilinear taps at 12.20 coordinates.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn bilinear(&self, plane: __m256i, [u, v]: [__m256i; 2]) -> Taps {
        let [along, down] = self.axes_of(plane);
        let ([left, right], fraction_u) = self.pair(0, &along, u);
        let ([top, bottom], fraction_v) = self.pair(1, &down, v);
        let corners = [
            _mm256_add_epi32(left, top),
            _mm256_add_epi32(right, top),
            _mm256_add_epi32(left, bottom),
            _mm256_add_epi32(right, bottom),
        ];
        Taps { corners, fractions: [fraction_u, fraction_v] }
    }

    /// Point taps: their only texels, in the place of the first.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn point(&self, plane: __m256i, [u, v]: [__m256i; 2]) -> __m256i {
        let [along, down] = self.axes_of(plane);
        let entry = |axis: usize, of_plane: &Axis, coordinate| {
            let (index, _) = self.lower(axis, of_plane, coordinate, 0);
            self.entries.gather(_mm256_add_epi32(index, of_plane.first))
        };
        _mm256_add_epi32(entry(0, &along, u), entry(1, &down, v))
    }

    /// What the planes of eight taps have by way of axes.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn axes_of(&self, plane: __m256i) -> [Axis; 2] {
        // Neighbours mostly take the same plane: then its row is read once for all.
        let any = _mm_cvtsi128_si32(_mm256_castsi256_si128(plane));
        let same = _mm256_movemask_epi8(_mm256_cmpeq_epi32(plane, _mm256_set1_epi32(any))) == -1;
        match self.planes.entries().as_chunks::<ROW>().0.get(any as usize) {
            Some(row) if same => {
                let word = |number: usize| _mm256_set1_epi32(row[number].cast_signed());
                [
                    Axis { size: word(0), first: word(1), last: word(2) },
                    Axis { size: word(3), first: word(4), last: word(5) },
                ]
            }
            _ => {
                let row = _mm256_slli_epi32::<{ ROW.trailing_zeros() as i32 }>(plane);
                let word = |number| self.planes.gather(_mm256_add_epi32(row, _mm256_set1_epi32(number)));
                [
                    Axis { size: word(0), first: word(1), last: word(2) },
                    Axis { size: word(3), first: word(4), last: word(5) },
                ]
            }
        }
    }

    /// The table's words for two neighbouring texels, and the fraction.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn pair(&self, axis: usize, of_plane: &Axis, coordinate: __m256i) -> ([__m256i; 2], __m256i) {
        let (lower, fraction) = self.lower(axis, of_plane, coordinate, 1 << (COORDINATE_BITS - 1));
        (self.entries.gather_pairs(_mm256_add_epi32(lower, of_plane.first)), fraction)
    }

    /// The index that a coordinate less `offset` has, saturated, and 8 bits of fraction.
    ///
    /// The product is of 64 bits: those of the even lanes and those of the odd lanes apart.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn lower(&self, axis: usize, of_plane: &Axis, coordinate: __m256i, offset: i64) -> (__m256i, __m256i) {
        let kept = _mm256_and_si256(coordinate, _mm256_set1_epi32(self.masks[axis]));
        let offset = _mm256_set1_epi64x(offset);
        let even = _mm256_sub_epi64(_mm256_mul_epi32(kept, of_plane.size), offset);
        let odd = _mm256_mul_epi32(_mm256_srli_epi64::<32>(kept), _mm256_srli_epi64::<32>(of_plane.size));
        let odd = _mm256_sub_epi64(odd, offset);
        // Bits 20 to 51 of each product, then bits 12 to 19.
        let mut index = _mm256_blend_epi32::<0b1010_1010>(_mm256_srli_epi64::<20>(even), _mm256_slli_epi64::<12>(odd));
        let fraction = _mm256_blend_epi32::<0b1010_1010>(_mm256_srli_epi64::<12>(even), _mm256_slli_epi64::<20>(odd));
        if self.saturates[axis] {
            let first = _mm256_set1_epi32(FIRST_INDEX as i32);
            index = _mm256_min_epi32(_mm256_max_epi32(index, first), of_plane.last);
        }
        (index, _mm256_and_si256(fraction, _mm256_set1_epi32(255)))
    }

    /// Writes the tap of each of eight requests as the one of its footprints with this number.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn write<const TAPS: usize>(
        &self,
        taps: &Taps,
        weight: __m256i,
        plane: __m256i,
        number: usize,
        to: &mut [[Footprint; TAPS]; LANES],
    ) {
        let [c00, c10, c01, c11] = taps.corners;
        let corners = transposed(c00, c10, c01, c11);
        let fractions = _mm256_or_si256(taps.fractions[0], _mm256_slli_epi32::<16>(taps.fractions[1]));
        let rests = transposed(fractions, weight, plane, _mm256_setzero_si256());
        for lane in 0..LANES / 2 {
            let (corners, rest) = (corners[lane], rests[lane]);
            let low = self.bytes(_mm256_castsi256_si128(corners));
            store_footprint(&mut to[lane][number], low, _mm256_castsi256_si128(rest));
            let high = self.bytes(_mm256_extracti128_si256::<1>(corners));
            store_footprint(&mut to[lane + 4][number], high, _mm256_extracti128_si256::<1>(rest));
        }
    }

    /// Byte addresses of four texels, with the marks of those outside as a [`Footprint`] has them.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn bytes(&self, index: __m128i) -> __m256i {
        let index = _mm256_cvtepu32_epi64(index);
        if !self.clips {
            return _mm256_slli_epi64::<2>(index);
        }
        // How often an index holds `OUTSIDE_INDEX` moves up to be how often the address holds `OUTSIDE`.
        let marks = _mm256_slli_epi64::<{ OUTSIDE.trailing_zeros() as i32 }>(_mm256_srli_epi64::<{ OUTSIDE_SHIFT as i32 }>(index));
        let within = _mm256_and_si256(index, _mm256_set1_epi64x(OUTSIDE_INDEX as i64 - 1));
        _mm256_or_si256(_mm256_slli_epi64::<2>(within), marks)
    }
}

/// One axis of the planes of eight taps.
#[derive(Clone, Copy)]
struct Axis {
    size: __m256i,
    /// Where the table has index 0.
    first: __m256i,
    /// Largest lower index a coordinate can saturate to.
    last: __m256i,
}

/// Rows become columns: lanes 0 and 4 of all four, then 1 and 5, 2 and 6, 3 and 7.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn transposed(a: __m256i, b: __m256i, c: __m256i, d: __m256i) -> [__m256i; 4] {
    let (ab, cd) = (_mm256_unpacklo_epi32(a, b), _mm256_unpacklo_epi32(c, d));
    let (ab_high, cd_high) = (_mm256_unpackhi_epi32(a, b), _mm256_unpackhi_epi32(c, d));
    [
        _mm256_unpacklo_epi64(ab, cd),
        _mm256_unpackhi_epi64(ab, cd),
        _mm256_unpacklo_epi64(ab_high, cd_high),
        _mm256_unpackhi_epi64(ab_high, cd_high),
    ]
}
