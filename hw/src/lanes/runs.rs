//! Taps divided into runs of texels of one line (see `cache::runs`), eight taps at a time.

use core::arch::x86_64::*;

use super::{LANES, RunShape, footprints::low_words, machine::Machine, room::Avx2};
use crate::{address_stream::Places, cache::Run};

/// Runs of a tap at most.
const MOST: usize = 4;

/// Places that eight taps may write to.
pub(crate) const PLACES: usize = MOST * (LANES + 1);

/// For each set of eight lanes, how many of the set are in the lanes up to each: a byte a lane.
const UP_TO: [u64; 256] = {
    let mut up_to = [0; 256];
    let mut set = 0;
    while set < 256 {
        let mut lane = 0;
        while lane < LANES {
            if set >> lane & 1 != 0 {
                up_to[set] += (u64::MAX / 255) << (8 * lane);
            }
            lane += 1;
        }
        set += 1;
    }
    up_to
};

/// Divides taps, on machines that can.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunLanes(Avx2);

impl RunLanes {
    pub(crate) fn detect() -> Option<Self> {
        Avx2::detect().map(Self)
    }

    /// Writes the runs of taps, eight by eight from the eight numbered `first`, in lines of at most 32 texels, up to a tap that has an address beyond 32
    /// bits or outside, or more than one run in a line, and how many runs each tap has. How many eights of taps it was, and how many runs.
    ///
    /// # Panics
    /// If there are not [`PLACES`] beyond those of runs written before, of which a tap has four at most.
    #[inline(always)]
    pub(crate) fn write(
        self,
        taps: Places<'_>,
        first: usize,
        shape: RunShape,
        runs: &mut [Run],
        counts: &mut [u8],
    ) -> (usize, usize) {
        self.0.write_runs(taps, first, shape, runs, counts.as_chunks_mut().0)
    }
}

/// [`RunLanes::write`].
#[target_feature(enable = "avx2")]
pub(super) fn write(
    m: Avx2,
    taps: Places<'_>,
    first: usize,
    shape: RunShape,
    runs: &mut [Run],
    counts: &mut [[u8; LANES]],
) -> (usize, usize) {
    let line_shift = _mm_cvtsi32_si128(shape.line_shift.cast_signed());
    let texel_shift = _mm_cvtsi32_si128(shape.texel_shift.cast_signed());
    let in_line = m.splat((1 << (shape.line_shift - shape.texel_shift)) - 1);
    let both = |x, y| m.and(x, y);
    let any = |x, y| m.or(x, y);
    let same = |x, y| _mm256_cmpeq_epi32(x, y);
    let lanes = |x| _mm256_movemask_ps(_mm256_castsi256_ps(x)) as u32;
    let mut numbers = m.add(m.splat((first * LANES) as i32), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    let mut count = 0;
    let eights = taps.len() / LANES - first;
    for (number, counts) in counts[..eights].iter_mut().enumerate() {
        let Some(corners) = low_words(m, taps, first + number) else { return (number, count) };
        let line = |corner| _mm256_srl_epi32(corner, line_shift);
        let mark = |corner| _mm256_sllv_epi32(m.splat(1), both(_mm256_srl_epi32(corner, texel_shift), in_line));
        let [a, b, c, d] = corners;
        let (lines, [a, b, c, d]) = ([line(a), line(b), line(c), line(d)], [mark(a), mark(b), mark(c), mark(d)]);
        let (top, bottom) = (same(lines[0], lines[1]), same(lines[2], lines[3]));
        let (left, right) = (same(lines[0], lines[2]), same(lines[1], lines[3]));
        let rows = both(top, bottom);
        // Left, right, left, right: the second round finds and leaves everything as the first left it.
        let mut columns = both(left, right);
        if let Some(mask) = shape.set_mask {
            let mask = m.splat(mask.cast_signed());
            let one_set = same(both(lines[0], mask), both(lines[1], mask));
            // Texels of one line are of one run whatever the set.
            columns = m.and_not(m.and_not(rows, one_set), columns);
        }
        let one = both(rows, columns);
        let two = any(rows, columns);
        let diagonal = any(same(lines[0], lines[3]), same(lines[1], lines[2]));
        let not_four = any(any(any(top, bottom), any(left, right)), diagonal);
        // Neither one run nor two, nor four of as many lines.
        if lanes(m.and_not(two, not_four)) != 0 {
            return (number, count);
        }
        let first = any(any(a, both(b, rows)), any(both(c, columns), both(d, one)));
        let second = any(both(d, two), _mm256_blendv_epi8(b, c, rows));
        let second_line = _mm256_blendv_epi8(lines[1], lines[2], rows);

        // Words of runs side by side: each half of a register is the run of a tap, in the order of the taps 0 and 4, 1 and 5, 2 and 6, 3 and 7.
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
        let quarters =
            [in_runs(lines[0], first), in_runs(second_line, second), in_runs(lines[2], c), in_runs(lines[3], d)];
        // Runs up to each tap: one, and another, and another two.
        let ends = UP_TO[0xFF] + UP_TO[(lanes(one) ^ 0xFF) as usize] + 2 * UP_TO[(lanes(two) ^ 0xFF) as usize];
        let begins = ends << 8;
        *counts = (ends - begins).to_le_bytes();
        let places: &mut [Run; PLACES] = runs[count..].first_chunk_mut().expect("room for eight taps");
        for tap in 0..LANES {
            let [first, second, third, fourth] = quarters.map(|quarter| quarter[tap % 4]);
            let halves = |low, high| {
                if tap < 4 {
                    _mm256_permute2x128_si256::<0x20>(low, high)
                } else {
                    _mm256_permute2x128_si256::<0x31>(low, high)
                }
            };
            // Four are written whether there are as many or not. The mask changes nothing, and tells the compiler so.
            let begin = (begins >> (8 * tap)) as usize & (MOST * LANES - 1);
            if let Some(places) = places[begin..].first_chunk_mut() {
                m.store_runs(places, [halves(first, second), halves(third, fourth)]);
            }
        }
        count += (ends >> 56) as usize;
        numbers = m.add(numbers, m.splat(LANES as i32));
    }
    (eights, count)
}
