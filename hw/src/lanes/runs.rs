//! Taps divided into runs of texels of one line (see `cache::runs`), eight taps at a time.

use core::arch::x86_64::*;

use super::{EightRuns, LANES, RunShape, footprints::low_words, machine::Machine, room::Avx2};
use crate::address::Footprint;

/// Divides taps, on machines that can.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunLanes(Avx2);

impl RunLanes {
    pub(crate) fn detect() -> Option<Self> {
        Avx2::detect().map(Self)
    }

    /// Finds the runs of taps, the first of which has the number `first`, in lines of at most 32 texels; false if an address is beyond 32 bits.
    #[inline(always)]
    pub(crate) fn find(self, taps: &[Footprint; LANES], first: u32, shape: RunShape, runs: &mut EightRuns) -> bool {
        self.0.find_runs(taps, first, shape, runs)
    }
}

/// [`RunLanes::find`].
#[target_feature(enable = "avx2")]
pub(super) fn find(m: Avx2, taps: &[Footprint; LANES], number: u32, shape: RunShape, runs: &mut EightRuns) -> bool {
    let Some(corners) = low_words(m, taps) else { return false };
    let line_shift = _mm_cvtsi32_si128(shape.line_shift as i32);
    let texel_shift = _mm_cvtsi32_si128(shape.texel_shift as i32);
    let in_line = _mm256_set1_epi32((1 << (shape.line_shift - shape.texel_shift)) - 1);
    let one = _mm256_set1_epi32(1);
    let shifted = |x, by| _mm256_srl_epi32(x, by);
    let [lines, marks] = {
        let [a, b, c, d] = corners;
        let mark = |x| _mm256_sllv_epi32(one, _mm256_and_si256(shifted(x, texel_shift), in_line));
        [
            [shifted(a, line_shift), shifted(b, line_shift), shifted(c, line_shift), shifted(d, line_shift)],
            [mark(a), mark(b), mark(c), mark(d)],
        ]
    };
    let same = |x: usize, y: usize| _mm256_cmpeq_epi32(lines[x], lines[y]);
    let both = |x, y| _mm256_and_si256(x, y);
    let any = |x, y| _mm256_or_si256(x, y);
    let rows = both(same(0, 1), same(2, 3));
    let mut columns = both(same(0, 2), same(1, 3));
    if let Some(mask) = shape.set_mask {
        let mask = _mm256_set1_epi32(mask as i32);
        let one_set = _mm256_cmpeq_epi32(both(lines[0], mask), both(lines[1], mask));
        // Texels of one line are of one run whatever the set.
        columns = _mm256_andnot_si256(_mm256_andnot_si256(rows, one_set), columns);
    }
    let all = both(rows, columns);
    let [a, b, c, d] = marks;
    let first = any(any(a, both(b, rows)), any(both(c, columns), both(d, all)));
    let second = any(d, _mm256_blendv_epi8(b, c, rows));
    // Words of runs side by side: each half of a register is the run of a tap, in the order of the taps 0 and 4, 1 and 5, 2 and 6, 3 and 7.
    let numbers = m.add(m.splat(number.cast_signed()), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    let in_runs = |line, texels| {
        let (line, high) = (m.unpack_low(line, m.splat(0)), m.unpack_high(line, m.splat(0)));
        let (texels, high_texels) = (m.unpack_low(texels, numbers), m.unpack_high(texels, numbers));
        [
            m.unpack_low64(line, texels),
            m.unpack_high64(line, texels),
            m.unpack_low64(high, high_texels),
            m.unpack_high64(high, high_texels),
        ]
    };
    let first = in_runs(lines[0], first);
    let second = in_runs(_mm256_blendv_epi8(lines[1], lines[2], rows), second);
    let (low, high) = runs.runs.split_at_mut(LANES / 2);
    for (number, (low, high)) in low.iter_mut().zip(high).enumerate() {
        m.store_runs(low, _mm256_permute2x128_si256::<0x20>(first[number], second[number]));
        m.store_runs(high, _mm256_permute2x128_si256::<0x31>(first[number], second[number]));
    }
    let lanes = |x| _mm256_movemask_ps(_mm256_castsi256_ps(x)) as u32;
    runs.pairs = lanes(all) ^ 0xFF;
    runs.others = lanes(any(rows, columns)) ^ 0xFF;
    true
}
