//! AVX-512: sixteen lanes.

use core::arch::x86_64::*;

use super::{Table, Texels, load_head};
use crate::{
    lanes::machine::Machine,
    request::{Request, Response},
};

cpufeatures::new!(avx512, "avx2", "avx512f", "avx512bw");

/// Proof that this machine has the foundation of AVX-512 and its instructions for words of 16 bits.
#[derive(Clone, Copy, Debug)]
pub(in crate::lanes) struct Avx512(());

impl Avx512 {
    /// The proof, where it can be had.
    pub(in crate::lanes) fn detect() -> Option<Self> {
        avx512::get().then_some(Self(()))
    }
}

impl Machine for Avx512 {
    type Words = __m512i;
    const LANES: usize = 16;

    #[inline(always)]
    fn splat(self, value: i32) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_set1_epi32(value) }
    }
    #[inline(always)]
    fn splat64(self, value: i64) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_set1_epi64(value) }
    }
    #[inline(always)]
    fn splat16(self, value: i16) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_set1_epi16(value) }
    }
    #[inline(always)]
    fn add(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_add_epi32(a, b) }
    }
    #[inline(always)]
    fn sub(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_sub_epi32(a, b) }
    }
    #[inline(always)]
    fn mul(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_mullo_epi32(a, b) }
    }
    #[inline(always)]
    fn min(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_min_epi32(a, b) }
    }
    #[inline(always)]
    fn max(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_max_epi32(a, b) }
    }
    #[inline(always)]
    fn and(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_and_si512(a, b) }
    }
    #[inline(always)]
    fn or(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_or_si512(a, b) }
    }
    #[inline(always)]
    fn xor(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_xor_si512(a, b) }
    }
    #[inline(always)]
    fn and_not(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_andnot_si512(a, b) }
    }
    #[inline(always)]
    fn add64(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_add_epi64(a, b) }
    }
    #[inline(always)]
    fn sub64(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_sub_epi64(a, b) }
    }
    #[inline(always)]
    fn mul_even(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_mul_epi32(a, b) }
    }
    #[inline(always)]
    fn mul_even_unsigned(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_mul_epu32(a, b) }
    }
    #[inline(always)]
    fn add16(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_add_epi16(a, b) }
    }
    #[inline(always)]
    fn sub16(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_sub_epi16(a, b) }
    }
    #[inline(always)]
    fn mul16(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_mullo_epi16(a, b) }
    }
    #[inline(always)]
    fn multiply_add16(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_madd_epi16(a, b) }
    }
    #[inline(always)]
    fn unpack_low16(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_unpacklo_epi16(a, b) }
    }
    #[inline(always)]
    fn unpack_high16(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_unpackhi_epi16(a, b) }
    }
    #[inline(always)]
    fn unpack_low(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_unpacklo_epi32(a, b) }
    }
    #[inline(always)]
    fn unpack_high(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_unpackhi_epi32(a, b) }
    }
    #[inline(always)]
    fn unpack_low64(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_unpacklo_epi64(a, b) }
    }
    #[inline(always)]
    fn unpack_high64(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_unpackhi_epi64(a, b) }
    }
    #[inline(always)]
    fn pack(self, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_packus_epi32(a, b) }
    }
    #[inline(always)]
    fn shl(self, a: __m512i, bits: i32) -> __m512i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm512_sll_epi32(a, _mm_cvtsi32_si128(bits)) }
    }
    #[inline(always)]
    fn shr(self, a: __m512i, bits: i32) -> __m512i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm512_srl_epi32(a, _mm_cvtsi32_si128(bits)) }
    }
    #[inline(always)]
    fn shr_signed(self, a: __m512i, bits: i32) -> __m512i {
        // SAFETY: `self` proves the instruction. The count is a constant, as above.
        unsafe { _mm512_sra_epi32(a, _mm_cvtsi32_si128(bits)) }
    }

    #[inline(always)]
    fn shl64(self, a: __m512i, bits: i32) -> __m512i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm512_sll_epi64(a, _mm_cvtsi32_si128(bits)) }
    }
    #[inline(always)]
    fn shr64(self, a: __m512i, bits: i32) -> __m512i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm512_srl_epi64(a, _mm_cvtsi32_si128(bits)) }
    }
    #[inline(always)]
    fn shl16(self, a: __m512i, bits: i32) -> __m512i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm512_sll_epi16(a, _mm_cvtsi32_si128(bits)) }
    }
    #[inline(always)]
    fn shr16(self, a: __m512i, bits: i32) -> __m512i {
        // SAFETY: `self` proves the instruction. The count is a constant wherever this is called, so it ends up inside it.
        unsafe { _mm512_srl_epi16(a, _mm_cvtsi32_si128(bits)) }
    }

    #[inline(always)]
    fn sub_where_greater(self, x: __m512i, a: __m512i, b: __m512i) -> __m512i {
        // SAFETY: `self` proves the instructions.
        unsafe { _mm512_mask_sub_epi32(x, _mm512_cmpgt_epi32_mask(a, b), x, _mm512_set1_epi32(1)) }
    }

    #[inline(always)]
    fn where_positive(self, a: __m512i, x: __m512i) -> __m512i {
        // SAFETY: `self` proves the instructions.
        unsafe { _mm512_maskz_mov_epi32(_mm512_cmpgt_epi32_mask(a, _mm512_setzero_si512()), x) }
    }

    #[inline(always)]
    fn common(self, a: __m512i) -> Option<i32> {
        // SAFETY: `self` proves the instructions.
        unsafe {
            let first = _mm512_cvtsi512_si32(a);
            (_mm512_cmpeq_epi32_mask(a, _mm512_set1_epi32(first)) == 0xFFFF).then_some(first)
        }
    }

    #[inline(always)]
    fn alternate(self, even: __m512i, odd: __m512i) -> __m512i {
        // SAFETY: `self` proves the instruction.
        unsafe { _mm512_mask_blend_epi32(0b1010_1010_1010_1010, even, odd) }
    }

    #[inline(always)]
    fn each(self, a: __m512i, f: impl Fn(i32) -> i32) -> __m512i {
        let mut lanes = [0i32; Self::LANES];
        // SAFETY: `self` proves the instructions; the array is as large as the register, and neither access needs alignment.
        unsafe {
            _mm512_storeu_si512(lanes.as_mut_ptr().cast(), a);
            lanes = lanes.map(f);
            _mm512_loadu_si512(lanes.as_ptr().cast())
        }
    }

    #[inline(always)]
    fn gather(self, table: &Table, index: __m512i) -> __m512i {
        let (entries, last) = table.entries_and_last();
        // SAFETY: `self` proves the instructions. Each index is at most the last entry's, and below 2^31, so it is not read as a negative
        // number.
        unsafe { _mm512_i32gather_epi32::<4>(_mm512_min_epu32(index, _mm512_set1_epi32(last)), entries) }
    }

    #[inline(always)]
    fn gather_pairs(self, table: &Table, index: __m512i) -> [__m512i; 2] {
        let (entries, last) = table.entries_and_last();
        // SAFETY: `self` proves the instructions. Each index is at most the last entry's but one (there are two), so the 8 bytes from it are in
        // the table, and below 2^31. The loads of a gather need no alignment.
        unsafe {
            let index = _mm512_min_epu32(index, _mm512_set1_epi32(last - 1));
            // Every other pair of lanes to each half: the order from which one shuffle a half restores 0 to 15.
            let order = _mm512_permutexvar_epi64(_mm512_setr_epi64(0, 2, 4, 6, 1, 3, 5, 7), index);
            let low = _mm512_i32gather_epi64::<4>(_mm512_castsi512_si256(order), entries.cast());
            let high = _mm512_i32gather_epi64::<4>(_mm512_extracti64x4_epi64::<1>(order), entries.cast());
            let (low, high) = (_mm512_castsi512_ps(low), _mm512_castsi512_ps(high));
            [
                _mm512_castps_si512(_mm512_shuffle_ps::<0b10_00_10_00>(low, high)),
                _mm512_castps_si512(_mm512_shuffle_ps::<0b11_01_11_01>(low, high)),
            ]
        }
    }

    #[inline(always)]
    fn texels(self, texels: Texels<'_>, index: __m512i) -> __m512i {
        let (first, last) = texels.first_and_last();
        // SAFETY: `self` proves the instructions. Only lanes inside are loaded; their four bytes are in the memory, and they are below 2^31. The
        // loads of a gather need no alignment.
        unsafe {
            let inside = _mm512_cmple_epu32_mask(index, _mm512_set1_epi32(last));
            _mm512_mask_i32gather_epi32::<4>(_mm512_setzero_si512(), inside, index, first)
        }
    }

    #[inline(always)]
    fn heads(self, requests: &[Request], first: usize) -> __m512i {
        // SAFETY: `self` proves the instructions.
        unsafe {
            let heads = _mm512_castsi128_si512(load_head(&requests[first]));
            let heads = _mm512_inserti32x4::<1>(heads, load_head(&requests[first + 4]));
            let heads = _mm512_inserti32x4::<2>(heads, load_head(&requests[first + 8]));
            _mm512_inserti32x4::<3>(heads, load_head(&requests[first + 12]))
        }
    }

    #[inline(always)]
    fn interleaved(self, a: __m512i, b: __m512i) -> [__m512i; 2] {
        // SAFETY: `self` proves the instructions.
        unsafe {
            let first = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
            let second = _mm512_add_epi32(first, _mm512_set1_epi32(8));
            [_mm512_permutex2var_epi32(a, first, b), _mm512_permutex2var_epi32(a, second, b)]
        }
    }

    #[inline(always)]
    fn store(self, words: __m512i, to: &mut [u32]) {
        let to = &mut to[..Self::LANES];
        // SAFETY: `self` proves the instruction; 64 bytes of a slice of as many; the store needs no alignment.
        unsafe { _mm512_storeu_si512(to.as_mut_ptr().cast(), words) }
    }

    #[inline(always)]
    fn respond(self, responses: &mut [Response], texel: __m512i, lod: __m512i) {
        let responses = &mut responses[..Self::LANES];
        let to: *mut __m512i = responses.as_mut_ptr().cast();
        // SAFETY: `self` proves the instructions. Sixteen responses are the 128 bytes of these two stores, which need no alignment, and any bits
        // are a response.
        unsafe {
            let (low, high) = (_mm512_unpacklo_epi32(texel, lod), _mm512_unpackhi_epi32(texel, lod));
            let first = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
            let second = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
            _mm512_storeu_si512(to, _mm512_permutex2var_epi64(low, first, high));
            _mm512_storeu_si512(to.add(1), _mm512_permutex2var_epi64(low, second, high));
        }
    }
}
