//! AVX2: eight lanes.

use core::arch::x86_64::*;

use super::{Table, Texels, load_head};
use crate::{
    lanes::machine::Machine,
    request::{Request, Response},
};

cpufeatures::new!(avx2, "avx2");

/// Proof that this machine has AVX2.
#[derive(Clone, Copy, Debug)]
pub(in crate::lanes) struct Avx2(());

impl Avx2 {
    /// The proof, where it can be had.
    pub(in crate::lanes) fn detect() -> Option<Self> {
        avx2::get().then_some(Self(()))
    }

    /// The 128 bits with this number.
    #[inline(always)]
    pub(in crate::lanes) fn part(self, a: __m256i, number: usize) -> __m128i {
        // SAFETY: `self` proves the instructions.
        unsafe { if number == 0 { _mm256_castsi256_si128(a) } else { _mm256_extracti128_si256::<1>(a) } }
    }
}

impl Machine for Avx2 {
    type Words = __m256i;
    const LANES: usize = 8;

    #[inline(always)]
    fn splat(self, value: i32) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_set1_epi32(value) }
    }
    #[inline(always)]
    fn splat64(self, value: i64) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_set1_epi64x(value) }
    }
    #[inline(always)]
    fn splat16(self, value: i16) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_set1_epi16(value) }
    }
    #[inline(always)]
    fn add(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_add_epi32(a, b) }
    }
    #[inline(always)]
    fn sub(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_sub_epi32(a, b) }
    }
    #[inline(always)]
    fn mul(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_mullo_epi32(a, b) }
    }
    #[inline(always)]
    fn min(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_min_epi32(a, b) }
    }
    #[inline(always)]
    fn max(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_max_epi32(a, b) }
    }
    #[inline(always)]
    fn and(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_and_si256(a, b) }
    }
    #[inline(always)]
    fn or(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_or_si256(a, b) }
    }
    #[inline(always)]
    fn xor(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_xor_si256(a, b) }
    }
    #[inline(always)]
    fn and_not(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_andnot_si256(a, b) }
    }
    #[inline(always)]
    fn add64(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_add_epi64(a, b) }
    }
    #[inline(always)]
    fn sub64(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_sub_epi64(a, b) }
    }
    #[inline(always)]
    fn mul_even(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_mul_epi32(a, b) }
    }
    #[inline(always)]
    fn mul_even_unsigned(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_mul_epu32(a, b) }
    }
    #[inline(always)]
    fn add16(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_add_epi16(a, b) }
    }
    #[inline(always)]
    fn sub16(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_sub_epi16(a, b) }
    }
    #[inline(always)]
    fn mul16(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_mullo_epi16(a, b) }
    }
    #[inline(always)]
    fn multiply_add16(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_madd_epi16(a, b) }
    }
    #[inline(always)]
    fn unpack_low16(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_unpacklo_epi16(a, b) }
    }
    #[inline(always)]
    fn unpack_high16(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_unpackhi_epi16(a, b) }
    }
    #[inline(always)]
    fn unpack_low(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_unpacklo_epi32(a, b) }
    }
    #[inline(always)]
    fn unpack_high(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_unpackhi_epi32(a, b) }
    }
    #[inline(always)]
    fn unpack_low64(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_unpacklo_epi64(a, b) }
    }
    #[inline(always)]
    fn unpack_high64(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_unpackhi_epi64(a, b) }
    }
    #[inline(always)]
    fn pack(self, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_packus_epi32(a, b) }
    }
    #[inline(always)]
    fn shl(self, a: __m256i, bits: i32) -> __m256i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm256_sll_epi32(a, _mm_cvtsi32_si128(bits)) }
    }
    #[inline(always)]
    fn shr(self, a: __m256i, bits: i32) -> __m256i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm256_srl_epi32(a, _mm_cvtsi32_si128(bits)) }
    }
    #[inline(always)]
    fn shr_signed(self, a: __m256i, bits: i32) -> __m256i {
        // SAFETY: `self` proves the instruction. The count is a constant, as above.
        unsafe { _mm256_sra_epi32(a, _mm_cvtsi32_si128(bits)) }
    }

    #[inline(always)]
    fn shl64(self, a: __m256i, bits: i32) -> __m256i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm256_sll_epi64(a, _mm_cvtsi32_si128(bits)) }
    }
    #[inline(always)]
    fn shr64(self, a: __m256i, bits: i32) -> __m256i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm256_srl_epi64(a, _mm_cvtsi32_si128(bits)) }
    }
    #[inline(always)]
    fn shl16(self, a: __m256i, bits: i32) -> __m256i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm256_sll_epi16(a, _mm_cvtsi32_si128(bits)) }
    }
    #[inline(always)]
    fn shr16(self, a: __m256i, bits: i32) -> __m256i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm256_srl_epi16(a, _mm_cvtsi32_si128(bits)) }
    }

    #[inline(always)]
    fn sub_where_greater(self, x: __m256i, a: __m256i, b: __m256i) -> __m256i {
        // SAFETY: `self` proves the instructions.
        unsafe { _mm256_add_epi32(x, _mm256_cmpgt_epi32(a, b)) }
    }

    #[inline(always)]
    fn where_positive(self, a: __m256i, x: __m256i) -> __m256i {
        // SAFETY: `self` proves the instructions.
        unsafe { _mm256_and_si256(_mm256_cmpgt_epi32(a, _mm256_setzero_si256()), x) }
    }

    #[inline(always)]
    fn common(self, a: __m256i) -> Option<i32> {
        // SAFETY: `self` proves the instructions.
        unsafe {
            let first = _mm_cvtsi128_si32(_mm256_castsi256_si128(a));
            let same = _mm256_cmpeq_epi32(a, _mm256_set1_epi32(first));
            (_mm256_movemask_epi8(same) == -1).then_some(first)
        }
    }

    #[inline(always)]
    fn alternate(self, even: __m256i, odd: __m256i) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_blend_epi32::<0b1010_1010>(even, odd) }
    }

    #[inline(always)]
    fn each(self, a: __m256i, f: impl Fn(i32) -> i32) -> __m256i {
        let mut lanes = [0; Self::LANES];
        let to = lanes.as_mut_ptr();
        // SAFETY: `self` proves the instructions; the array is as large as the register, and neither access needs alignment.
        unsafe {
            _mm256_storeu_si256(to.cast(), a);
            lanes = lanes.map(f);
            _mm256_loadu_si256(lanes.as_ptr().cast())
        }
    }

    #[inline(always)]
    fn gather(self, table: &Table, index: __m256i) -> __m256i {
        let (entries, last) = table.entries_and_last();
        // SAFETY: `self` proves the instructions. Each index is at most the last entry's, and below 2^31, so it is not read as a negative
        // number.
        unsafe { _mm256_i32gather_epi32::<4>(entries, _mm256_min_epu32(index, _mm256_set1_epi32(last))) }
    }

    #[inline(always)]
    fn gather_pairs(self, table: &Table, index: __m256i) -> [__m256i; 2] {
        let (entries, last) = table.entries_and_last();
        // SAFETY: `self` proves the instructions. Each index is at most the last entry's but one (there are two), so the 8 bytes from it are in
        // the table, and below 2^31. The loads of a gather need no alignment.
        unsafe {
            let index = _mm256_min_epu32(index, _mm256_set1_epi32(last - 1));
            // Lanes 0 1 4 5 and 2 3 6 7: the order from which one shuffle a half restores 0 to 7.
            let order = _mm256_permute4x64_epi64::<0b11_01_10_00>(index);
            let low = _mm256_i32gather_epi64::<4>(entries.cast(), _mm256_castsi256_si128(order));
            let high = _mm256_i32gather_epi64::<4>(entries.cast(), _mm256_extracti128_si256::<1>(order));
            let (low, high) = (_mm256_castsi256_ps(low), _mm256_castsi256_ps(high));
            [
                _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(low, high)),
                _mm256_castps_si256(_mm256_shuffle_ps::<0b11_01_11_01>(low, high)),
            ]
        }
    }

    #[inline(always)]
    fn texels(self, texels: Texels<'_>, index: __m256i) -> __m256i {
        let (first, last) = texels.first_and_last();
        // SAFETY: `self` proves the instructions. Only lanes inside are loaded; their four bytes are in the memory, and they are below 2^31. The
        // loads of a gather need no alignment.
        unsafe {
            let inside = _mm256_cmpeq_epi32(_mm256_min_epu32(index, _mm256_set1_epi32(last)), index);
            _mm256_mask_i32gather_epi32::<4>(_mm256_setzero_si256(), first, index, inside)
        }
    }

    #[inline(always)]
    fn heads(self, requests: &[Request], first: usize) -> __m256i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm256_set_m128i(load_head(&requests[first + 4]), load_head(&requests[first])) }
    }

    #[inline(always)]
    fn interleaved(self, a: __m256i, b: __m256i) -> [__m256i; 2] {
        // SAFETY: `self` proves the instructions.
        unsafe {
            let (low, high) = (_mm256_unpacklo_epi32(a, b), _mm256_unpackhi_epi32(a, b));
            [_mm256_permute2x128_si256::<0x20>(low, high), _mm256_permute2x128_si256::<0x31>(low, high)]
        }
    }

    #[inline(always)]
    fn store(self, words: __m256i, to: &mut [u32]) {
        let to = &mut to[..Self::LANES];
        // SAFETY: `self` proves the instruction; 32 bytes of a slice of as many; the store needs no alignment.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), words) }
    }

    #[inline(always)]
    fn respond(self, responses: &mut [Response], texel: __m256i, lod: __m256i) {
        let responses = &mut responses[..Self::LANES];
        let to: *mut __m256i = responses.as_mut_ptr().cast();
        // SAFETY: `self` proves the instructions. Eight responses are the 64 bytes of these two stores, which need no alignment, and any bits
        // are a response.
        unsafe {
            let (low, high) = (_mm256_unpacklo_epi32(texel, lod), _mm256_unpackhi_epi32(texel, lod));
            _mm256_storeu_si256(to, _mm256_permute2x128_si256::<0x20>(low, high));
            _mm256_storeu_si256(to.add(1), _mm256_permute2x128_si256::<0x31>(low, high));
        }
    }
}
