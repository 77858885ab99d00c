//! The datapath in eight lanes (see `datapath`): 8 fraction bits, one rounding.
//!
//! Every sum is exact. The horizontal step works in words of 16 bits, where 255 * 256 fits. The vertical one is a multiply-add of signed
//! words, so 2^15 is taken from every horizontal sum, which takes 2^23 from the vertical one; the last step gives it back. The step
//! between levels is taken modulo 2^32, and its result is below that.

use core::arch::x86_64::*;

use super::{
    LANES,
    address::Taps,
    room::{Texels, load_addresses},
};
use crate::{address::Footprint, datapath::Texel};

/// What the vertical step lacks of the weighted sum of a tap.
const LACK: i32 = 1 << 23;

/// Weighted sums of eight bilinear taps, less [`LACK`]: of red and blue in turns, then of green and alpha; in each, taps 0 1 4 5, then 2 3 6 7.
#[derive(Clone, Copy)]
pub(super) struct Sums([__m256i; 4]);

/// A weight a tap, in the order of [`Sums`].
#[inline]
#[target_feature(enable = "avx2")]
fn spread(weight: __m256i) -> [__m256i; 2] {
    [_mm256_unpacklo_epi32(weight, weight), _mm256_unpackhi_epi32(weight, weight)]
}

/// Two columns of red and blue, or of green and alpha, made one, less 2^15; `start` is the left column times 256.
#[inline]
#[target_feature(enable = "avx2")]
fn horizontal(start: __m256i, left: __m256i, right: __m256i, fraction: __m256i) -> __m256i {
    let way = _mm256_mullo_epi16(_mm256_sub_epi16(right, left), fraction);
    _mm256_xor_si256(_mm256_add_epi16(start, way), _mm256_set1_epi16(i16::MIN))
}

/// A row of two texels: red and blue, green and alpha.
#[inline]
#[target_feature(enable = "avx2")]
fn row(left: __m256i, right: __m256i, fraction: __m256i) -> [__m256i; 2] {
    let low = _mm256_set1_epi16(0xFF);
    let high = _mm256_andnot_si256(low, left);
    [
        horizontal(
            _mm256_slli_epi16::<8>(left),
            _mm256_and_si256(left, low),
            _mm256_and_si256(right, low),
            fraction,
        ),
        horizontal(high, _mm256_srli_epi16::<8>(left), _mm256_srli_epi16::<8>(right), fraction),
    ]
}

/// Weighted sums of eight taps.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn bilinear(texels: Texels<'_>, taps: &Taps) -> Sums {
    let [c00, c10, c01, c11] = taps.corners;
    let [f, g] = taps.fractions;
    let fraction = _mm256_or_si256(f, _mm256_slli_epi32::<16>(f));
    let top = row(texels.gather(c00), texels.gather(c10), fraction);
    let bottom = row(texels.gather(c01), texels.gather(c11), fraction);
    // 256 - g for the top, g for the bottom.
    let weights = _mm256_sub_epi32(_mm256_add_epi32(_mm256_slli_epi32::<16>(g), _mm256_set1_epi32(256)), g);
    let [low, high] = spread(weights);
    Sums([
        _mm256_madd_epi16(_mm256_unpacklo_epi16(top[0], bottom[0]), low),
        _mm256_madd_epi16(_mm256_unpackhi_epi16(top[0], bottom[0]), high),
        _mm256_madd_epi16(_mm256_unpacklo_epi16(top[1], bottom[1]), low),
        _mm256_madd_epi16(_mm256_unpackhi_epi16(top[1], bottom[1]), high),
    ])
}

/// Eight texels from their channels, words of 32 bits.
#[inline]
#[target_feature(enable = "avx2")]
fn packed([rb_low, rb_high, ga_low, ga_high]: [__m256i; 4]) -> __m256i {
    let red_blue = _mm256_packus_epi32(rb_low, rb_high);
    let green_alpha = _mm256_packus_epi32(ga_low, ga_high);
    _mm256_or_si256(red_blue, _mm256_slli_epi16::<8>(green_alpha))
}

/// One word a channel and two taps: which half of a spread weight goes with each.
const HALF: [usize; 4] = [0, 1, 0, 1];

/// Texels of one tap each.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn one(sums: Sums) -> __m256i {
    let mut channels = sums.0;
    for channel in &mut channels {
        *channel = _mm256_srli_epi32::<16>(_mm256_add_epi32(*channel, _mm256_set1_epi32(LACK + (1 << 15))));
    }
    packed(channels)
}

/// 256 times the way from one tap to the other, `t` of 256, less 256 times [`LACK`].
#[inline]
#[target_feature(enable = "avx2")]
fn between(from: Sums, to: Sums, t: __m256i) -> [__m256i; 4] {
    let t = spread(t);
    let mut channels = from.0;
    for (number, channel) in channels.iter_mut().enumerate() {
        let way = _mm256_mullo_epi32(_mm256_sub_epi32(to.0[number], *channel), t[HALF[number]]);
        *channel = _mm256_add_epi32(_mm256_slli_epi32::<8>(*channel), way);
    }
    channels
}

/// Texels of two taps each.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn two(from: Sums, to: Sums, t: __m256i) -> __m256i {
    let mut channels = between(from, to, t);
    for channel in &mut channels {
        let whole = _mm256_add_epi32(*channel, _mm256_set1_epi32(((LACK as u32) << 8).wrapping_add(1 << 23).cast_signed()));
        *channel = _mm256_srli_epi32::<24>(whole);
    }
    packed(channels)
}

/// Texels of two pairs of taps each, both pairs weighing the same.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn mean_of_two([(a, b, t), (c, d, u)]: [(Sums, Sums, __m256i); 2]) -> __m256i {
    let (mut channels, others) = (whole(between(a, b, t)), whole(between(c, d, u)));
    for (number, channel) in channels.iter_mut().enumerate() {
        // Half of the sum, without its carry.
        let (both, either) = (
            _mm256_and_si256(*channel, others[number]),
            _mm256_xor_si256(*channel, others[number]),
        );
        let half = _mm256_add_epi32(both, _mm256_srli_epi32::<1>(either));
        *channel = _mm256_srli_epi32::<24>(_mm256_add_epi32(half, _mm256_set1_epi32(1 << 23)));
    }
    packed(channels)
}

/// Texels of two pairs of taps each: the first weight within the pairs, the second from one pair to the other.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn four([a, b, c, d]: [Sums; 4], [t, between_pairs]: [__m256i; 2]) -> __m256i {
    let (mut channels, others) = (whole(between(a, b, t)), whole(between(c, d, t)));
    let t = spread(between_pairs);
    let s = spread(_mm256_sub_epi32(_mm256_set1_epi32(256), between_pairs));
    let half = _mm256_set1_epi64x(1 << 31);
    for (number, channel) in channels.iter_mut().enumerate() {
        let (s, t) = (s[HALF[number]], t[HALF[number]]);
        // Both lanes of 32 bits in a lane of 64 are channels of one tap: their weights are the same.
        let even = _mm256_add_epi64(_mm256_mul_epu32(*channel, s), _mm256_mul_epu32(others[number], t));
        let odd = _mm256_add_epi64(
            _mm256_mul_epu32(_mm256_srli_epi64::<32>(*channel), s),
            _mm256_mul_epu32(_mm256_srli_epi64::<32>(others[number]), t),
        );
        let even = _mm256_srli_epi64::<32>(_mm256_add_epi64(even, half));
        *channel = _mm256_blend_epi32::<0b1010_1010>(even, _mm256_add_epi64(odd, half));
    }
    packed(channels)
}

/// Gives back what the sums lack.
#[inline]
#[target_feature(enable = "avx2")]
fn whole(mut channels: [__m256i; 4]) -> [__m256i; 4] {
    for channel in &mut channels {
        *channel = _mm256_add_epi32(*channel, _mm256_set1_epi32(((LACK as u32) << 8).cast_signed()));
    }
    channels
}

/// The corners of eight footprints as indices of texels; what is outside becomes an index past the end of any memory.
#[inline]
#[target_feature(enable = "avx2")]
fn corners(taps: &[Footprint; LANES]) -> [__m256i; 4] {
    // Footprints two by two: the low words of their addresses, and the high ones, which are 0 but for the marks of texels outside.
    let pair = |first: usize| {
        let a = _mm256_castsi256_ps(load_addresses(&taps[first]));
        let b = _mm256_castsi256_ps(load_addresses(&taps[first + 1]));
        let low = _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(a, b));
        let high = _mm256_castps_si256(_mm256_shuffle_ps::<0b11_01_11_01>(a, b));
        _mm256_castsi256_ps(_mm256_or_si256(_mm256_srli_epi32::<2>(low), high))
    };
    let pairs = [pair(0), pair(2), pair(4), pair(6)];
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
fn sums_of(texels: Texels<'_>, taps: &[Footprint; LANES]) -> [__m256i; 4] {
    let [a, b, c, d, e, f, g, h] = taps;
    let both = |tap: &Footprint| i32::from(tap.fraction[0]) | i32::from(tap.fraction[1]) << 16;
    let both = _mm256_setr_epi32(both(a), both(b), both(c), both(d), both(e), both(f), both(g), both(h));
    let fractions = [_mm256_and_si256(both, _mm256_set1_epi32(0xFFFF)), _mm256_srli_epi32::<16>(both)];
    let Sums([rb_low, rb_high, ga_low, ga_high]) =
        bilinear(texels, &Taps { corners: corners(taps), fractions });
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
pub(super) fn of_footprints(
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
        let sums = sums_of(texels, eight);
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
