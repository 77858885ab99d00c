//! Addresses without those that change nothing (see `cache::changes`), four at a time.

use core::arch::x86_64::*;

use super::room::Avx2;

/// Leaves them out, on machines that can.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChangeLanes(Avx2);

impl ChangeLanes {
    pub(crate) fn detect() -> Option<Self> {
        Avx2::detect().map(Self)
    }

    /// Writes those of whole fours of `addresses` to `kept` whose line, which is what is above `line_shift` bits, is not that of the one before, of
    /// the first not that of `last`; and where `turns`, of two lines that take turns in such a four only the first turn. How many.
    ///
    /// # Panics
    /// If `kept` has not as many places.
    #[inline(always)]
    pub(crate) fn keep(
        self,
        addresses: &[[u64; 4]],
        last: u64,
        line_shift: u32,
        turns: bool,
        kept: &mut [u64],
    ) -> usize {
        self.0.keep_changes(addresses, last, line_shift, turns, kept)
    }
}

/// For each set of lanes kept, where they come from, two words each: those kept first.
const ORDER: [[i32; 8]; 16] = {
    let mut order = [[0; 8]; 16];
    let mut set = 0;
    while set < 16 {
        let (mut lane, mut to) = (0, 0);
        while lane < 4 {
            if set >> lane & 1 != 0 {
                order[set][to] = 2 * lane;
                order[set][to + 1] = 2 * lane + 1;
                to += 2;
            }
            lane += 1;
        }
        set += 1;
    }
    order
};

/// How many lanes are in each set.
const KEPT: [u8; 16] = [0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4];

/// [`ChangeLanes::keep`].
#[target_feature(enable = "avx2")]
pub(super) fn keep(
    m: Avx2,
    addresses: &[[u64; 4]],
    last: u64,
    line_shift: u32,
    turns: bool,
    kept: &mut [u64],
) -> usize {
    let shift = _mm_cvtsi32_si128(line_shift.cast_signed());
    let one_turn = if turns { 0b0011 } else { 0b1111 };
    let mut before = _mm256_srl_epi64(_mm256_set1_epi64x(last.cast_signed()), shift);
    let mut count = 0;
    for four in addresses {
        let address = m.load_four(four);
        let line = _mm256_srl_epi64(address, shift);
        let turned = _mm256_permute4x64_epi64::<0b10_01_00_11>(line);
        let same = lanes_of(_mm256_cmpeq_epi64(line, _mm256_blend_epi32::<0b11>(turned, before)));
        before = turned;
        let two = lanes_of(_mm256_cmpeq_epi64(line, _mm256_permute4x64_epi64::<0b01_00_11_10>(line)));
        let keep = !same & if two == 0b1111 { one_turn } else { 0b1111 } & 0b1111;
        let order = m.load_order(&ORDER[keep]);
        if let Some(places) = kept[count..].first_chunk_mut() {
            m.store_four(places, _mm256_permutevar8x32_epi32(address, order));
        }
        count += usize::from(KEPT[keep]);
    }
    count
}

/// Which of four words of 64 bits have their highest bit set.
#[inline]
#[target_feature(enable = "avx2")]
fn lanes_of(words: __m256i) -> usize {
    (_mm256_movemask_pd(_mm256_castsi256_pd(words)) & 0b1111) as usize
}
