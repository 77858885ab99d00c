//! A log of uses without those that are not the last of their place (see `cache::shadow`), eight at a time.

use core::arch::x86_64::*;

use super::{
    LANES,
    compress::{KEPT, order},
    machine::Machine,
    room::Avx2,
};

/// Drops them, on machines that can.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UseLanes(Avx2);

impl UseLanes {
    pub(crate) fn detect() -> Option<Self> {
        Avx2::detect().map(Self)
    }

    /// Moves the entries of a log from number `first` on whose number is that of the last use of their place to its front, as far as there are
    /// eights of entries. How many it moved, and the number of the entry it came to. There are places, fewer than 2^31.
    #[inline(always)]
    pub(crate) fn move_last(self, log: &mut [u32], first: usize, last: &[u32]) -> (usize, usize) {
        self.0.move_last_uses(log, first, last)
    }
}

/// By sets of four lanes of 32 bits.
const ORDER: [[u32; 4]; 16] = order();

/// [`UseLanes::move_last`]. Whether an entry is the last use is not to be guessed: there is no branch on it.
#[target_feature(enable = "avx2")]
pub(super) fn move_last(m: Avx2, log: &mut [u32], first: usize, last: &[u32]) -> (usize, usize) {
    let (mut kept, mut number) = (0, first);
    let mut numbers = m.add(m.splat(first as i32), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    while let Some(entries) = log[number..].first_chunk::<LANES>() {
        let entries = m.load_words(entries);
        let same = _mm256_cmpeq_epi32(m.gather_words(last, entries), numbers);
        let sets = _mm256_movemask_ps(_mm256_castsi256_ps(same)) as usize;
        for (half, set) in [sets & 15, sets >> 4].into_iter().enumerate() {
            let order = m.load_four_words(&ORDER[set]);
            let moved = _mm_castps_si128(_mm_permutevar_ps(_mm_castsi128_ps(m.part(entries, half)), order));
            // No further than the entries just read.
            if let Some(places) = log[kept..].first_chunk_mut() {
                m.store_four_words(places, moved);
            }
            kept += usize::from(KEPT[set]);
        }
        number += LANES;
        numbers = m.add(numbers, m.splat(LANES as i32));
    }
    (kept, number)
}
