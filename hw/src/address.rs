//! The address unit: from a tap to the byte addresses of its texels.
//!
//! Layouts are separable, so each axis of each plane has one table from texel index to byte offset, and the address mode is
//! folded into it: an index beyond the border simply has the entry of the texel that answers for it. One look-up is address mode
//! and layout together, for every mode and every layout.

use alloc::vec::Vec;

use crate::{
    coordinate::{AddressMode, COORDINATE_BITS, period_mask, resolve, texel_pair, texel_under},
    surface::Surface,
};

/// An address with this bit or the one above is outside the texture: nothing is read, the texel is transparent black.
pub(crate) const OUTSIDE: u64 = 1 << 62;

/// Tables start at this index: clamped coordinates saturate two texels before the border.
pub(crate) const FIRST_INDEX: i64 = -2;

/// One axis of one plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    /// First entry in the tables.
    pub(crate) start: usize,
    /// Largest lower index a coordinate can saturate to.
    pub(crate) last: i64,
    pub(crate) size: u32,
    pub(crate) mask: i64,
}

/// A tap with its addresses: all that the cache and the datapath need to know.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Footprint {
    /// Byte addresses of texels (i0, j0), (i1, j0), (i0, j1), (i1, j1); a point tap has the first only.
    pub address: [u64; 4],
    /// Bilinear fractions of u and v.
    pub fraction: [u16; 2],
    /// Weight of the tap in its request.
    pub weight: u32,
    /// Storage index of the plane.
    pub plane: u16,
    /// Where each of the four texels lies in its block, four bits each, the first lowest; 0 where elements are texels.
    pub positions: u16,
}

impl Footprint {
    /// Position in its block of one of the four texels.
    #[inline]
    #[must_use]
    pub const fn position(&self, texel: usize) -> u32 {
        (self.positions >> (4 * texel) & 15) as u32
    }
}

/// Whether an address from a [`Footprint`] lies outside the texture (clip only).
#[inline]
#[must_use]
pub const fn is_outside(address: u64) -> bool {
    address >= OUTSIDE
}

/// The address unit of one surface under one pair of address modes.
#[derive(Clone, Debug)]
pub struct AddressUnit {
    pub(crate) axes: Vec<[Axis; 2]>,
    pub(crate) tables: Vec<u64>,
    filter_bits: u32,
    /// Entries carry the position in the block in their lowest four bits, below the byte offset.
    blocks: bool,
}

/// Bits below the byte offset in an entry of a block format: 2 of x, 2 of y, which never carry.
const POSITION_BITS: u32 = 4;

impl AddressUnit {
    /// Fills the tables.
    #[must_use]
    pub fn new(surface: &Surface, modes: [AddressMode; 2], filter_bits: u8) -> Self {
        let mut tables = Vec::new();
        let blocks = surface.format.log2_block() > 0;
        let axes = surface
            .planes
            .iter()
            .map(|plane| {
                [0, 1].map(|axis| {
                    let size = plane.size()[axis];
                    let last = i64::from(if modes[axis] == AddressMode::Mirror { 2 * size } else { size });
                    let start = tables.len();
                    // The base is added once, by the u axis.
                    let base = if axis == 0 { plane.base } else { 0 };
                    tables.extend((FIRST_INDEX..=last + 1).map(|index| {
                        resolve(index, size, modes[axis]).map_or(OUTSIDE, |texel| {
                            let offset = base + plane.offset(axis, texel);
                            if blocks {
                                offset << POSITION_BITS | u64::from(plane.position(axis, texel))
                            } else {
                                offset
                            }
                        })
                    }));
                    Axis { start, last, size, mask: period_mask(modes[axis]) }
                })
            })
            .collect();
        Self { axes, tables, filter_bits: filter_bits.into(), blocks }
    }

    /// Byte offsets of the two texels of a bilinear tap on one axis, and the fraction.
    #[inline]
    fn pair(&self, axis: &Axis, coordinate: i64) -> ([u64; 2], u32) {
        let pair = texel_pair(coordinate & axis.mask, axis.size, self.filter_bits);
        let entry = axis.start + (pair.lower.clamp(FIRST_INDEX, axis.last) - FIRST_INDEX) as usize;
        // Both entries exist: a table is one longer than the last lower index.
        let pair_of = self.tables[entry..].first_chunk::<2>();
        (pair_of.copied().unwrap_or([OUTSIDE; 2]), pair.fraction)
    }

    /// Byte offset of the texel under a coordinate on one axis.
    #[inline]
    fn entry(&self, axis: &Axis, coordinate: i64) -> u64 {
        let index = texel_under(coordinate & axis.mask, axis.size).clamp(FIRST_INDEX, axis.last);
        self.tables[axis.start + (index - FIRST_INDEX) as usize]
    }

    /// Texels of a plane along both axes.
    #[inline]
    pub(crate) fn size(&self, plane: usize) -> [u32; 2] {
        let [u, v] = &self.axes[plane];
        [u.size, v.size]
    }

    /// The address of a texel of the plane itself.
    #[inline]
    pub(crate) fn texel(&self, plane: usize, index: [i64; 2]) -> u64 {
        let [u, v] = [0, 1].map(|i| self.tables[self.axes[plane][i].start + (index[i] - FIRST_INDEX) as usize]);
        u + v
    }

    /// A bilinear tap at a 12.20 coordinate of any width.
    #[inline(always)]
    #[must_use]
    pub fn bilinear(&self, plane: usize, u: i64, v: i64, weight: u32) -> Footprint {
        let [axis_u, axis_v] = &self.axes[plane];
        let ([left, right], fraction_u) = self.pair(axis_u, u);
        let ([top, bottom], fraction_v) = self.pair(axis_v, v);
        let footprint = Footprint {
            address: [left + top, right + top, left + bottom, right + bottom],
            fraction: [fraction_u as u16, fraction_v as u16],
            weight,
            plane: plane as u16,
            positions: 0,
        };
        if self.blocks { split_positions(footprint) } else { footprint }
    }

    /// A point tap.
    #[inline(always)]
    #[must_use]
    pub fn point(&self, plane: usize, u: i64, v: i64, weight: u32) -> Footprint {
        let [axis_u, axis_v] = &self.axes[plane];
        let (left, top) = (self.entry(axis_u, u), self.entry(axis_v, v));
        let footprint =
            Footprint { address: [left + top, 0, 0, 0], fraction: [0; 2], weight, plane: plane as u16, positions: 0 };
        if self.blocks { split_positions(footprint) } else { footprint }
    }
}

/// Moves the positions from the low bits of the sums to a field of their own: from here on addresses are of bytes.
///
/// A call of its own, so that taps of other formats are short enough to become part of the loops over them.
#[inline(never)]
fn split_positions(mut footprint: Footprint) -> Footprint {
    for (number, address) in footprint.address.iter_mut().enumerate() {
        if !is_outside(*address) {
            footprint.positions |= ((*address & ((1 << POSITION_BITS) - 1)) as u16) << (4 * number);
            *address >>= POSITION_BITS;
        }
    }
    footprint
}

// Coordinates carry at most 40 bits into the scaler, sides 21: the product stays within 64.
const _: () = assert!(40 + 21 < 63 && COORDINATE_BITS == 20);
