//! The address unit in lanes (see `address`): the same tables, in words of 32 bits that count texels.

use alloc::vec::Vec;

use super::{machine::Machine, room::Table};
use crate::{
    address::{AddressUnit, FIRST_INDEX, OUTSIDE},
    address_stream::TapRows,
    coordinate::COORDINATE_BITS,
};

/// Texels of a surface are fewer than this, so that an index, or the sum of an index and `OUTSIDE_INDEX`, or twice the latter is a
/// positive number of 32 bits.
const MOST_TEXELS: u64 = 1 << OUTSIDE_SHIFT;
const OUTSIDE_SHIFT: u32 = 29;
/// Stands for `OUTSIDE`.
const OUTSIDE_INDEX: u32 = 1 << OUTSIDE_SHIFT;
// As the address of a texel of four bytes.
const _: () = assert!(OUTSIDE_INDEX << 2 == TapRows::OUTSIDE);

/// Sides are at most this, so that the index of a texel under any coordinate is a number of 32 bits.
const LARGEST_SIDE: u32 = 1 << 19;

/// Words of a row of `AddressUnit::planes`: side, first entry and last lower index of u, the same of v, two to spare.
const ROW: usize = 8;

/// Where texels lie, for a tap a lane at a time.
#[derive(Clone, Debug)]
pub(super) struct Addresses {
    entries: Table,
    /// A row a plane.
    planes: Table,
    /// The bits of a coordinate that each axis keeps.
    masks: [i32; 2],
    /// Whether all products of a kept coordinate and a side are below 2^31.
    narrow: [bool; 2],
    /// Whether an index beyond the border can come up, which a periodic mode with its masked coordinates rules out.
    saturates: [bool; 2],
    /// Whether a texel can be outside.
    clips: bool,
}

/// A tap a lane: the texels' indices in memory, and the fractions.
#[derive(Clone, Copy)]
pub(super) struct Taps<M: Machine> {
    /// Texels (i0, j0), (i1, j0), (i0, j1), (i1, j1).
    pub(super) corners: [M::Words; 4],
    /// Of u and v, of 256.
    pub(super) fractions: [M::Words; 2],
}

impl Addresses {
    /// The same tables, if words of 32 bits can hold them. Addresses must be those of texels of four bytes.
    pub(super) fn new(unit: &AddressUnit, bytes: u64) -> Option<Self> {
        if bytes / 4 >= MOST_TEXELS || unit.axes.as_flattened().iter().any(|axis| axis.size > LARGEST_SIDE) {
            return None;
        }
        let entries: Vec<u32> = unit
            .tables
            .iter()
            .map(|&entry| if entry == OUTSIDE { OUTSIDE_INDEX } else { (entry / 4) as u32 })
            .collect();
        let clips = unit.tables.contains(&OUTSIDE);
        let mut planes = Vec::with_capacity(ROW * unit.axes.len());
        for axes in &unit.axes {
            for axis in axes {
                planes.extend([axis.size, (axis.start as i64 - FIRST_INDEX) as u32, axis.last as u32]);
            }
            planes.extend([0; 2]);
        }
        let any_plane = &unit.axes[0];
        Some(Self {
            entries: Table::new(entries)?,
            planes: Table::new(planes)?,
            masks: [0, 1].map(|axis| any_plane[axis].mask as i32),
            narrow: [0, 1].map(|axis| {
                let axes = unit.axes.iter().map(|plane| &plane[axis]);
                axes.map(|of_plane| (of_plane.mask + 1) * i64::from(of_plane.size))
                    .all(|end| (1..=1 << 31).contains(&end))
            }),
            saturates: [0, 1].map(|axis| any_plane[axis].mask == -1),
            clips,
        })
    }

    /// Bilinear taps at 12.20 coordinates.
    #[inline(always)]
    pub(super) fn bilinear<M: Machine>(&self, m: M, plane: M::Words, [u, v]: [M::Words; 2]) -> Taps<M> {
        let [along, down] = self.axes_of(m, plane);
        let ([left, right], fraction_u) = self.pair(m, 0, &along, u);
        let ([top, bottom], fraction_v) = self.pair(m, 1, &down, v);
        let corners = [m.add(left, top), m.add(right, top), m.add(left, bottom), m.add(right, bottom)];
        Taps { corners, fractions: [fraction_u, fraction_v] }
    }

    /// Point taps: their only texels, in the place of the first.
    #[inline(always)]
    pub(super) fn point<M: Machine>(&self, m: M, plane: M::Words, [u, v]: [M::Words; 2]) -> M::Words {
        let [along, down] = self.axes_of(m, plane);
        let (column, _) = self.lower(m, 0, &along, u, 0);
        let (row, _) = self.lower(m, 1, &down, v, 0);
        m.add(m.gather(&self.entries, m.add(column, along.first)), m.gather(&self.entries, m.add(row, down.first)))
    }

    /// What the planes of taps have by way of axes.
    #[inline(always)]
    fn axes_of<M: Machine>(&self, m: M, plane: M::Words) -> [Axis<M>; 2] {
        // Neighbours mostly take the same plane: then its row is read once for all.
        if let Some(plane) = m.common(plane)
            && let Some(row) = self.planes.entries().as_chunks::<ROW>().0.get(plane as usize)
        {
            let [size_u, first_u, last_u, size_v, first_v, last_v, ..] = row;
            [Axis::common(m, size_u, first_u, last_u), Axis::common(m, size_v, first_v, last_v)]
        } else {
            let row = m.shl(plane, ROW.trailing_zeros() as i32);
            [Axis::gathered(m, &self.planes, row, 0), Axis::gathered(m, &self.planes, row, 3)]
        }
    }

    /// The table's words for two neighbouring texels, and the fraction.
    #[inline(always)]
    fn pair<M: Machine>(
        &self,
        m: M,
        axis: usize,
        of_plane: &Axis<M>,
        coordinate: M::Words,
    ) -> ([M::Words; 2], M::Words) {
        let (lower, fraction) = self.lower(m, axis, of_plane, coordinate, 1 << (COORDINATE_BITS - 1));
        (m.gather_pairs(&self.entries, m.add(lower, of_plane.first)), fraction)
    }

    /// The index that a coordinate less `offset` has, saturated, and 8 bits of fraction.
    ///
    /// The product is of 64 bits, those of the even lanes and those of the odd lanes apart, unless it is known to fit 32.
    #[inline(always)]
    fn lower<M: Machine>(
        &self,
        m: M,
        axis: usize,
        of_plane: &Axis<M>,
        coordinate: M::Words,
        offset: i64,
    ) -> (M::Words, M::Words) {
        let kept = m.and(coordinate, m.splat(self.masks[axis]));
        if self.narrow[axis] {
            let position = m.sub(m.mul(kept, of_plane.size), m.splat(offset as i32));
            return (m.shr_signed(position, 20), m.and(m.shr(position, 12), m.splat(255)));
        }
        let offset = m.splat64(offset);
        let even = m.sub64(m.mul_even(kept, of_plane.size), offset);
        let odd = m.mul_even(m.shr64(kept, 32), m.shr64(of_plane.size, 32));
        let odd = m.sub64(odd, offset);
        // Bits 20 to 51 of each product, then bits 12 to 19.
        let mut index = m.alternate(m.shr64(even, 20), m.shl64(odd, 12));
        let fraction = m.alternate(m.shr64(even, 12), m.shl64(odd, 20));
        if self.saturates[axis] {
            let first = m.splat(FIRST_INDEX as i32);
            index = m.min(m.max(index, first), of_plane.last);
        }
        (index, m.and(fraction, m.splat(255)))
    }

    /// Writes the taps of as many requests as there are lanes, the first of them as the one numbered `first`: their first texel, or all four.
    ///
    /// # Panics
    /// If there is not room for them.
    #[inline(always)]
    pub(super) fn write<M: Machine, const TAPS: usize>(
        &self,
        m: M,
        taps: &[Taps<M>; TAPS],
        planes: [M::Words; TAPS],
        texels: usize,
        first: usize,
        rows: &mut TapRows,
    ) {
        let mut words = planes;
        store(m, words, &mut rows.planes[first..]);
        for (corner, row) in rows.corners.iter_mut().enumerate().take(texels) {
            for (words, tap) in words.iter_mut().zip(taps) {
                let index = tap.corners[corner];
                // Twice outside is outside.
                let index = if self.clips { m.min(index, m.splat(OUTSIDE_INDEX.cast_signed())) } else { index };
                *words = m.shl(index, 2);
            }
            store(m, words, &mut row[first..]);
        }
    }
}

/// Stores words of the taps of requests, a register a tap of each, in order of issue.
#[inline(always)]
fn store<M: Machine, const TAPS: usize>(m: M, words: [M::Words; TAPS], to: &mut [u32]) {
    let to = &mut to[..TAPS * M::LANES];
    let [first, second, third, fourth] = [0, 1, 2, 3].map(|number| number * M::LANES);
    match words[..] {
        [a, b] => {
            let [ab, ab_after] = m.interleaved(a, b);
            m.store(ab, &mut to[first..]);
            m.store(ab_after, &mut to[second..]);
        }
        [a, b, c, d] => {
            let ([ac, ac_after], [bd, bd_after]) = (m.interleaved(a, c), m.interleaved(b, d));
            let ([early, late], [later, last]) = (m.interleaved(ac, bd), m.interleaved(ac_after, bd_after));
            m.store(early, &mut to[first..]);
            m.store(late, &mut to[second..]);
            m.store(later, &mut to[third..]);
            m.store(last, &mut to[fourth..]);
        }
        [one, ..] => m.store(one, to),
        [] => {}
    }
}

/// One axis of the planes of taps.
#[derive(Clone, Copy)]
struct Axis<M: Machine> {
    size: M::Words,
    /// Where the table has index 0.
    first: M::Words,
    /// Largest lower index a coordinate can saturate to.
    last: M::Words,
}

impl<M: Machine> Axis<M> {
    /// The same for all taps.
    #[inline(always)]
    fn common(m: M, size: &u32, first: &u32, last: &u32) -> Self {
        Self {
            size: m.splat(size.cast_signed()),
            first: m.splat(first.cast_signed()),
            last: m.splat(last.cast_signed()),
        }
    }

    /// From the rows of the taps' planes, which start at these words.
    #[inline(always)]
    fn gathered(m: M, planes: &Table, row: M::Words, word: i32) -> Self {
        Self {
            size: m.gather(planes, m.add(row, m.splat(word))),
            first: m.gather(planes, m.add(row, m.splat(word + 1))),
            last: m.gather(planes, m.add(row, m.splat(word + 2))),
        }
    }
}
