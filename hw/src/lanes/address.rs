//! The address unit in lanes (see `address`): the same tables, in words of 32 bits that count texels.

use core::arch::x86_64::__m256i;

use alloc::vec::Vec;

use super::{
    machine::{Machine, transposed},
    room::{Avx2, Table},
};
use crate::{
    address::{AddressUnit, FIRST_INDEX, Footprint, OUTSIDE},
    coordinate::COORDINATE_BITS,
};

/// Texels of a surface are fewer than this, so that an index, or the sum of an index and `OUTSIDE_INDEX`, or twice the latter is a
/// positive number of 32 bits.
const MOST_TEXELS: u64 = 1 << OUTSIDE_SHIFT;
const OUTSIDE_SHIFT: u32 = 29;
/// Stands for `OUTSIDE`.
const OUTSIDE_INDEX: u32 = 1 << OUTSIDE_SHIFT;

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

    /// Writes the tap of each request as the one of its footprints with this number.
    ///
    /// # Panics
    /// If there are fewer requests' footprints than lanes.
    #[inline(always)]
    pub(super) fn write<M: Machine, const TAPS: usize>(
        &self,
        m: M,
        taps: &Taps<M>,
        weight: M::Words,
        plane: M::Words,
        number: usize,
        to: &mut [[Footprint; TAPS]],
    ) {
        let to = &mut to[..M::LANES];
        let corners = transposed(m, taps.corners);
        let fractions = m.or(taps.fractions[0], m.shl(taps.fractions[1], 16));
        let rests = transposed(m, [fractions, weight, plane, m.splat(0)]);
        for part in 0..M::LANES / 4 {
            for lane in 0..4 {
                let index = m.eight().widen(m.part(corners[lane], part));
                let addresses = if self.clips { marked(m.eight(), index) } else { m.eight().shl64(index, 2) };
                let footprint = &mut to[4 * part + lane][number];
                m.eight().store_footprint(footprint, addresses, m.part(rests[lane], part));
            }
        }
    }
}

/// Byte addresses of four texels, with the marks of those outside as a [`Footprint`] has them: how often an index holds `OUTSIDE_INDEX`
/// moves up to be how often the address holds `OUTSIDE`.
#[inline(always)]
fn marked(m: Avx2, index: __m256i) -> __m256i {
    let marks = m.shl64(m.shr64(index, OUTSIDE_SHIFT as i32), OUTSIDE.trailing_zeros() as i32);
    let within = m.and(index, m.splat64(i64::from(OUTSIDE_INDEX) - 1));
    m.or(m.shl64(within, 2), marks)
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
