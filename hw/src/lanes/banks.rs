//! Which taps read four words of as many data banks (see `timing::data_banks`), eight taps at a time.

use core::arch::x86_64::*;

use super::{LANES, footprints::low_words, room::Avx2};
use crate::address::Footprint;

/// Looks at taps, on machines that can.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BankLanes {
    machine: Avx2,
    word_shift: u32,
    /// Banks less one.
    bank_mask: u32,
}

impl BankLanes {
    /// For words of two to the power of `word_shift` bytes in a power of two of banks, at most 32, one after the other.
    pub(crate) fn new(word_shift: u32, banks: u32) -> Option<Self> {
        let suits = banks.is_power_of_two() && banks <= 32 && word_shift < 32;
        Avx2::detect().filter(|_| suits).map(|machine| Self { machine, word_shift, bank_mask: banks - 1 })
    }

    /// A bit a tap, set where its four words are in four banks; none if an address is beyond 32 bits.
    #[inline(always)]
    pub(crate) fn apart(self, taps: &[Footprint; LANES]) -> Option<u8> {
        self.machine.apart(taps, self.word_shift, self.bank_mask)
    }
}

/// [`BankLanes::apart`].
#[target_feature(enable = "avx2")]
pub(super) fn apart(m: Avx2, taps: &[Footprint; LANES], word_shift: u32, bank_mask: u32) -> Option<u8> {
    let corners = low_words(m, taps)?;
    let shift = _mm_cvtsi32_si128(word_shift as i32);
    let mask = _mm256_set1_epi32(bank_mask as i32);
    let bank =
        |corner| _mm256_sllv_epi32(_mm256_set1_epi32(1), _mm256_and_si256(_mm256_srl_epi32(corner, shift), mask));
    let [a, b, c, d] = corners.map(bank);
    // Different powers of two have the same sum as union, and no others do: of two equal ones the sum is larger.
    let sum = _mm256_add_epi32(_mm256_add_epi32(a, b), _mm256_add_epi32(c, d));
    let union = _mm256_or_si256(_mm256_or_si256(a, b), _mm256_or_si256(c, d));
    Some(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(sum, union))) as u8)
}
