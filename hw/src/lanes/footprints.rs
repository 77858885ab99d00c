//! The datapath for taps that are made: eight at a time, whatever requests they belong to.

use core::arch::x86_64::*;

use super::{
    LANES,
    address::Taps,
    filter::{self, LACK, Sums},
    room::{Avx2, Texels},
};
use crate::{
    address::Footprint,
    address_stream::{BATCH_TAPS, Places, TapRows},
    datapath::Texel,
};

/// The corners of eight footprints as indices of texels; what is outside becomes an index past the end of any memory.
#[inline]
#[target_feature(enable = "avx2")]
fn corners(m: Avx2, taps: &[Footprint; LANES]) -> [__m256i; 4] {
    // Footprints two by two: the low words of their addresses, and the high ones, which are 0 but for the marks of texels outside.
    let pair = |first: usize| {
        let a = _mm256_castsi256_ps(m.load_addresses(&taps[first]));
        let b = _mm256_castsi256_ps(m.load_addresses(&taps[first + 1]));
        let low = _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(a, b));
        let high = _mm256_castps_si256(_mm256_shuffle_ps::<0b11_01_11_01>(a, b));
        _mm256_castsi256_ps(_mm256_or_si256(_mm256_srli_epi32::<2>(low), high))
    };
    columns([pair(0), pair(2), pair(4), pair(6)])
}

/// The addresses of the eight taps of this number, a register a corner; none if one is beyond 32 bits or outside.
///
/// # Panics
/// If there are fewer taps.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn low_words(m: Avx2, taps: Places<'_>, eight: usize) -> Option<[__m256i; 4]> {
    match taps {
        Places::Footprints(taps) => of_footprints(m, &taps.as_chunks().0[eight]),
        Places::Rows(rows, _) => {
            let [a, b, c, d] = &rows.corners;
            let load = |row: &[u32; BATCH_TAPS]| m.load_words(&row.as_chunks().0[eight]);
            let [a, b, c, d] = [load(a), load(b), load(c), load(d)];
            let any = _mm256_or_si256(_mm256_or_si256(a, b), _mm256_or_si256(c, d));
            // The highest bit is set of those that are outside, and of no other.
            const { assert!(TapRows::OUTSIDE == 1 << 31) };
            (_mm256_movemask_ps(_mm256_castsi256_ps(any)) == 0).then_some([a, b, c, d])
        }
    }
}

/// [`low_words`] of footprints.
#[inline]
#[target_feature(enable = "avx2")]
fn of_footprints(m: Avx2, taps: &[Footprint; LANES]) -> Option<[__m256i; 4]> {
    let [a, b, c, d, e, f, g, h] = [0, 1, 2, 3, 4, 5, 6, 7].map(|number| m.load_addresses(&taps[number]));
    let any = |x, y| _mm256_or_si256(x, y);
    let high = any(any(any(a, b), any(c, d)), any(any(e, f), any(g, h)));
    if _mm256_testz_si256(high, _mm256_set1_epi64x(!0xFFFF_FFFF)) == 0 {
        return None;
    }
    let low = |x, y| _mm256_shuffle_ps::<0b10_00_10_00>(_mm256_castsi256_ps(x), _mm256_castsi256_ps(y));
    Some(columns([low(a, b), low(c, d), low(e, f), low(g, h)]))
}

/// Words of four corners of eight taps, from those of taps two by two: a register a corner.
#[inline]
#[target_feature(enable = "avx2")]
fn columns(pairs: [__m256; 4]) -> [__m256i; 4] {
    let [left, right] = [
        [
            _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(pairs[0], pairs[1])),
            _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(pairs[2], pairs[3])),
        ],
        [
            _mm256_castps_si256(_mm256_shuffle_ps::<0b11_01_11_01>(pairs[0], pairs[1])),
            _mm256_castps_si256(_mm256_shuffle_ps::<0b11_01_11_01>(pairs[2], pairs[3])),
        ],
    ];
    [
        _mm256_permute2x128_si256::<0x20>(left[0], left[1]),
        _mm256_permute2x128_si256::<0x20>(right[0], right[1]),
        _mm256_permute2x128_si256::<0x31>(left[0], left[1]),
        _mm256_permute2x128_si256::<0x31>(right[0], right[1]),
    ]
}

/// Weighted sums of eight footprints, the channels of one together: lanes 0 and 4, then 1 and 5, 2 and 6, 3 and 7.
#[inline]
#[target_feature(enable = "avx2")]
fn sums_of(m: Avx2, texels: Texels<'_>, taps: &[Footprint; LANES]) -> [__m256i; 4] {
    let [a, b, c, d, e, f, g, h] = taps;
    let both = |tap: &Footprint| i32::from(tap.fraction[0]) | i32::from(tap.fraction[1]) << 16;
    let both = _mm256_setr_epi32(both(a), both(b), both(c), both(d), both(e), both(f), both(g), both(h));
    let fractions = [_mm256_and_si256(both, _mm256_set1_epi32(0xFFFF)), _mm256_srli_epi32::<16>(both)];
    let Sums([rb_low, rb_high, ga_low, ga_high]) =
        filter::bilinear(m, texels, &Taps { corners: corners(m, taps), fractions });
    let lack = _mm256_set1_epi32(LACK);
    [
        _mm256_add_epi32(_mm256_unpacklo_epi32(rb_low, ga_low), lack),
        _mm256_add_epi32(_mm256_unpackhi_epi32(rb_low, ga_low), lack),
        _mm256_add_epi32(_mm256_unpacklo_epi32(rb_high, ga_high), lack),
        _mm256_add_epi32(_mm256_unpackhi_epi32(rb_high, ga_high), lack),
    ]
}

/// Filters requests of any number of taps, lanes being taps: `ends` are where the taps of each request end, its last end that of
/// `taps`; weights sum to two to the power of `weight_bits`.
#[target_feature(enable = "avx2")]
pub(super) fn filter(
    m: Avx2,
    texels: Texels<'_>,
    taps: &[Footprint],
    mut ends: impl Iterator<Item = usize>,
    weight_bits: u32,
    mut answer: impl FnMut(Texel),
) {
    let shift = _mm_cvtsi32_si128((16 + weight_bits) as i32);
    let half = _mm256_set1_epi64x(1 << (15 + weight_bits));
    let mut sum = half;
    let (mut number, mut end) = (0, ends.next());
    let mut padded = [Footprint::default(); LANES];
    let (eights, rest) = taps.as_chunks::<LANES>();
    padded[..rest.len()].copy_from_slice(rest);
    let rest = if rest.is_empty() { None } else { Some(&padded) };
    for eight in eights.iter().chain(rest) {
        let sums = sums_of(m, texels, eight);
        for (lane, tap) in eight.iter().enumerate() {
            let row = sums[lane % 4];
            let channels = if lane < 4 { _mm256_castsi256_si128(row) } else { _mm256_extracti128_si256::<1>(row) };
            let weight = _mm256_set1_epi64x(tap.weight.into());
            sum = _mm256_add_epi64(sum, _mm256_mul_epu32(_mm256_cvtepu32_epi64(channels), weight));
            number += 1;
            while end == Some(number) {
                answer(narrowed(_mm256_srl_epi64(sum, shift)));
                sum = half;
                end = ends.next();
            }
        }
    }
}

/// Four channels in lanes of 64 bits as bytes.
#[inline]
#[target_feature(enable = "avx2")]
fn narrowed(channels: __m256i) -> Texel {
    let words = _mm256_permutevar8x32_epi32(channels, _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6));
    let words = _mm_packus_epi32(_mm256_castsi256_si128(words), _mm256_castsi256_si128(words));
    _mm_cvtsi128_si32(_mm_packus_epi16(words, words)).to_le_bytes()
}
