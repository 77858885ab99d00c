//! What a machine's vector unit does, whatever its width: the lanes are written once, in these words.

use super::room::{Table, Texels};
use crate::request::{Request, Response};

/// A vector unit, and the proof that this machine has it.
///
/// Every operation but the gathers is one instruction, lane by lane, modulo the lane's width. `64` and `16` are of lanes of so many bits; the
/// others are of 32. Unpacks and packs work within each 128 bits.
pub(super) trait Machine: Copy + core::fmt::Debug {
    /// A register.
    type Words: Copy;
    /// Words of 32 bits in a register.
    const LANES: usize;

    fn splat(self, value: i32) -> Self::Words;
    fn splat64(self, value: i64) -> Self::Words;
    fn splat16(self, value: i16) -> Self::Words;
    fn add(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn sub(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn mul(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn min(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn max(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn and(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn or(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn xor(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// `b` without the bits of `a`.
    fn and_not(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn shl(self, a: Self::Words, bits: i32) -> Self::Words;
    fn shr(self, a: Self::Words, bits: i32) -> Self::Words;
    /// The same, the sign moving in.
    fn shr_signed(self, a: Self::Words, bits: i32) -> Self::Words;
    /// `x`, less one where `a > b`.
    fn sub_where_greater(self, x: Self::Words, a: Self::Words, b: Self::Words) -> Self::Words;
    /// `x` where `a > 0`, zero elsewhere.
    fn where_positive(self, a: Self::Words, x: Self::Words) -> Self::Words;
    /// The word that all lanes hold, if they do.
    fn common(self, a: Self::Words) -> Option<i32>;

    fn add64(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn sub64(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn shl64(self, a: Self::Words, bits: i32) -> Self::Words;
    fn shr64(self, a: Self::Words, bits: i32) -> Self::Words;
    /// Products of the even lanes, signed.
    fn mul_even(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Products of the even lanes, unsigned.
    fn mul_even_unsigned(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Even lanes of the one, odd lanes of the other.
    fn alternate(self, even: Self::Words, odd: Self::Words) -> Self::Words;

    fn add16(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn sub16(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn mul16(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn shl16(self, a: Self::Words, bits: i32) -> Self::Words;
    fn shr16(self, a: Self::Words, bits: i32) -> Self::Words;
    /// Sums of two neighbouring products of signed lanes of 16 bits.
    fn multiply_add16(self, a: Self::Words, b: Self::Words) -> Self::Words;

    fn unpack_low16(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn unpack_high16(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn unpack_low(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn unpack_high(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn unpack_low64(self, a: Self::Words, b: Self::Words) -> Self::Words;
    fn unpack_high64(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Words of both in turns, lane by lane: those of the first half of the lanes, and of the second.
    fn interleaved(self, a: Self::Words, b: Self::Words) -> [Self::Words; 2];
    /// Fills as many words.
    fn store(self, words: Self::Words, to: &mut [u32]);
    /// Words as 16 bits, saturated.
    fn pack(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Lane by lane through a function.
    fn each(self, a: Self::Words, f: impl Fn(i32) -> i32) -> Self::Words;

    /// The entries at some indices; an index past the end reads the last entry.
    fn gather(self, table: &Table, index: Self::Words) -> Self::Words;
    /// The entries at some indices and the entries that follow them; an index past the end reads the last two.
    fn gather_pairs(self, table: &Table, index: Self::Words) -> [Self::Words; 2];
    /// The texels at some indices, transparent black past the end.
    fn texels(self, texels: Texels<'_>, index: Self::Words) -> Self::Words;
    /// The first four words of requests (u, v and the scales): in 128 bits number n, those of request `first + 4 n`.
    fn heads(self, requests: &[Request], first: usize) -> Self::Words;
    /// Fills responses: the texel, and the two levels as the halves of a word.
    fn respond(self, responses: &mut [Response], texel: Self::Words, lod: Self::Words);
}

/// Rows become columns, in each 128 bits: words 0 of all four, then words 1, 2 and 3.
#[inline(always)]
pub(super) fn transposed<M: Machine>(m: M, [a, b, c, d]: [M::Words; 4]) -> [M::Words; 4] {
    let (ab, cd) = (m.unpack_low(a, b), m.unpack_low(c, d));
    let (ab_high, cd_high) = (m.unpack_high(a, b), m.unpack_high(c, d));
    [
        m.unpack_low64(ab, cd),
        m.unpack_high64(ab, cd),
        m.unpack_low64(ab_high, cd_high),
        m.unpack_high64(ab_high, cd_high),
    ]
}
