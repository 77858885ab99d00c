//! Which banks taps of four texels read (see `timing::data_banks` and `timing::passing`), eight taps at a time.

use core::arch::x86_64::*;

use super::{LANES, footprints::low_words, room::Avx2};
use crate::address_stream::Places;

/// Looks at taps, on machines that can.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BankLanes {
    machine: Avx2,
    words: Banks,
    lines: Banks,
}

/// Of a word or line of two to the power of `shift` bytes, its bank: the bits of its number in `mask`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Banks {
    shift: u32,
    mask: u32,
}

impl BankLanes {
    /// For words, and lines, of two to the power of so many bytes in so many banks, one after the other: powers of two, at most 32.
    pub(crate) fn new(words: [u32; 2], lines: [u32; 2]) -> Option<Self> {
        let suits = [words, lines].iter().all(|&[shift, banks]| banks.is_power_of_two() && banks <= 32 && shift < 32);
        let banks = |[shift, banks]: [u32; 2]| Banks { shift, mask: banks - 1 };
        Avx2::detect().filter(|_| suits).map(|machine| Self { machine, words: banks(words), lines: banks(lines) })
    }

    /// Looks at taps, eight by eight from the eight numbered `first`, up to one with an address beyond 32 bits or outside: how many eights, and whether the
    /// four words of each tap are in four banks. Of each tap is written 1 if its first and its last texel are in two lines of one bank.
    ///
    /// # Panics
    /// If there is not a place for each tap.
    #[inline(always)]
    pub(crate) fn look(self, taps: Places<'_>, first: usize, clashes: &mut [u8]) -> (usize, bool) {
        self.machine.look_at_banks(taps, first, [self.words, self.lines], clashes.as_chunks_mut().0)
    }
}

/// [`BankLanes::look`].
#[target_feature(enable = "avx2")]
pub(super) fn look(
    m: Avx2,
    taps: Places<'_>,
    first: usize,
    [words, lines]: [Banks; 2],
    clashes: &mut [[u8; LANES]],
) -> (usize, bool) {
    let splat = |word: u32| _mm256_set1_epi32(word as i32);
    let number = |corner, of: Banks| _mm256_srl_epi32(corner, _mm_cvtsi32_si128(of.shift as i32));
    let bank = |corner| _mm256_sllv_epi32(splat(1), _mm256_and_si256(number(corner, words), splat(words.mask)));
    let none = |x| _mm256_cmpeq_epi32(x, splat(0));
    let mut apart = splat(u32::MAX);
    let eights = taps.len() / LANES - first;
    let mut seen = 0;
    for clashes in &mut clashes[..eights] {
        let Some([a, b, c, d]) = low_words(m, taps, first + seen) else { break };
        let difference = _mm256_xor_si256(number(a, lines), number(d, lines));
        let clash = _mm256_andnot_si256(none(difference), none(_mm256_and_si256(difference, splat(lines.mask))));
        *clashes = bytes(_mm256_movemask_ps(_mm256_castsi256_ps(clash)) as u32).to_le_bytes();
        // Different powers of two have the same sum as union, and no others do: of two equal ones the sum is larger.
        let [a, b, c, d] = [bank(a), bank(b), bank(c), bank(d)];
        let sum = _mm256_add_epi32(_mm256_add_epi32(a, b), _mm256_add_epi32(c, d));
        let union = _mm256_or_si256(_mm256_or_si256(a, b), _mm256_or_si256(c, d));
        apart = _mm256_and_si256(apart, _mm256_cmpeq_epi32(sum, union));
        seen += 1;
    }
    (seen, _mm256_movemask_epi8(apart) == -1)
}

/// A byte for each of eight bits, the lowest first.
const fn bytes(bits: u32) -> u64 {
    let each = (bits as u64 * (u64::MAX / 255)) & 0x8040_2010_0804_0201;
    (each + 0x7F7F_7F7F_7F7F_7F7F) >> 7 & (u64::MAX / 255)
}
