//! The lines of addresses without those that come twice running (see `cache::changes`).

use core::arch::x86_64::*;

use super::{
    BLOCK, Kept,
    compress::{KEPT, order},
    room::{Avx2, Avx512, ask_ahead},
};

/// Bytes of addresses asked for before they are needed: the lookups between two blocks are long.
const AHEAD: usize = 4096;

/// Addresses at a time.
pub(crate) const EIGHT: usize = 8;

/// Leaves them out, on machines that can.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChangeLanes {
    machine: Avx2,
    wide: Option<Avx512>,
}

impl ChangeLanes {
    pub(crate) fn detect() -> Option<Self> {
        Avx2::detect().map(|machine| Self { machine, wide: Avx512::detect() })
    }

    /// The same lanes, of 256 bits at most.
    pub(crate) fn narrow(self) -> Self {
        Self { wide: None, ..self }
    }

    /// Writes the lines of `addresses`, what is above `line_shift` bits, to `kept`: those that are not the line of the address before, before
    /// the first of `last`. How many.
    ///
    /// # Panics
    /// If there are more than a block of addresses.
    #[inline(always)]
    pub(crate) fn keep(self, addresses: &[[u64; EIGHT]], last: u64, line_shift: u32, kept: &mut Kept) -> usize {
        assert!(addresses.len() <= BLOCK / EIGHT, "more than a block");
        match self.wide {
            Some(machine) => machine.keep_changes(addresses, last, line_shift, kept),
            None => self.machine.keep_changes(addresses, last, line_shift, kept),
        }
    }
}

/// By sets of four lanes of 64 bits.
const ORDER: [[u32; 8]; 16] = order();

/// [`ChangeLanes::keep`], four at a time.
#[target_feature(enable = "avx2")]
pub(super) fn keep_fours(m: Avx2, addresses: &[[u64; EIGHT]], last: u64, line_shift: u32, kept: &mut Kept) -> usize {
    let shift = _mm_cvtsi32_si128(line_shift.cast_signed());
    let mut before = _mm256_srl_epi64(_mm256_set1_epi64x(last.cast_signed()), shift);
    let mut count = 0;
    for eight in addresses {
        ask_ahead(eight, AHEAD);
        for four in eight.as_chunks().0 {
            let line = _mm256_srl_epi64(m.load_four(four), shift);
            let turned = _mm256_permute4x64_epi64::<0b10_01_00_11>(line);
            let same = _mm256_cmpeq_epi64(line, _mm256_blend_epi32::<0b11>(turned, before));
            before = turned;
            let keep = (!_mm256_movemask_pd(_mm256_castsi256_pd(same)) & 0b1111) as usize;
            let kept_first = _mm256_permutevar8x32_epi32(line, m.load_words(&ORDER[keep]));
            // The mask changes nothing, and tells the compiler so.
            if let Some(places) = kept[count & (BLOCK - 1)..].first_chunk_mut() {
                m.store_four(places, kept_first);
            }
            count += usize::from(KEPT[keep]);
        }
    }
    count
}

/// The same, eight at a time.
#[target_feature(enable = "avx2,avx512f,avx512bw")]
pub(super) fn keep_eights(m: Avx512, addresses: &[[u64; EIGHT]], last: u64, line_shift: u32, kept: &mut Kept) -> usize {
    let shift = _mm_cvtsi32_si128(line_shift.cast_signed());
    let mut before = _mm512_srl_epi64(_mm512_set1_epi64(last.cast_signed()), shift);
    let mut count = 0;
    for eight in addresses {
        ask_ahead(eight, AHEAD);
        let line = _mm512_srl_epi64(m.load_eight(eight), shift);
        let keep = _mm512_cmpneq_epi64_mask(line, _mm512_alignr_epi64::<7>(line, before));
        before = line;
        // As above.
        if let Some(places) = kept[count & (BLOCK - 1)..].first_chunk_mut() {
            m.store_eight(places, _mm512_maskz_compress_epi64(keep, line));
        }
        count += usize::from(KEPT[usize::from(keep & 15)] + KEPT[usize::from(keep >> 4)]);
    }
    count
}
