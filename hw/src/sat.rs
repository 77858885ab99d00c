//! The summed-area table: a small unit of its own beside the tap programs (Crow 1984; docs/numerics.md, section 5.3).
//!
//! An entry holds the sums of all texels to its left and above, modulo 2^32: the sum over any box of at most 2^24 texels is
//! exact in words that wrap around (X20). What a box takes beyond the border becomes more reads with signed multiplicities,
//! so the table itself knows of no address mode.

use crate::{
    address::Footprint,
    coordinate::{AddressMode, COORDINATE_BITS},
    datapath::Texel,
    request::Request,
    surface::Surface,
    taps::{Program, TapUnit, coordinates},
};

/// Bytes of an entry: four sums of 32 bits, little-endian.
pub const ENTRY_BYTES: u32 = 16;

/// The widest box of one axis, in texels: the sum over a box of both stays below 2^32.
const WIDEST: i64 = 4096;

/// Positions on one axis that a box is read at, with what each counts: rising, no position 0, no count 0.
#[derive(Clone, Copy, Debug, Default)]
struct Terms {
    terms: [(i64, i64); 4],
    count: usize,
}

impl Terms {
    /// Adds a count to a position, in order.
    #[inline]
    fn add(&mut self, position: i64, multiplicity: i64) {
        if position == 0 {
            return;
        }
        let place = self.terms[..self.count].partition_point(|&(known, _)| known < position);
        if place < self.count && self.terms[place].0 == position {
            self.terms[place].1 += multiplicity;
        } else {
            self.terms.copy_within(place..self.count, place + 1);
            self.terms[place] = (position, multiplicity);
            self.count += 1;
        }
    }

    /// Adds `sign` times the sum of all texels with an index below `border`, whatever the mode makes of the index.
    #[inline]
    fn add_below(&mut self, border: i64, size: i64, mode: AddressMode, sign: i64) {
        match mode {
            AddressMode::Wrap => {
                self.add(border.rem_euclid(size), sign);
                self.add(size, sign * border.div_euclid(size));
            }
            AddressMode::Mirror => {
                let (period, within) = (border.div_euclid(2 * size), border.rem_euclid(2 * size));
                if within < size {
                    self.add(within, sign);
                    self.add(size, sign * 2 * period);
                } else {
                    self.add(2 * size - within, -sign);
                    self.add(size, sign * (2 * period + 2));
                }
            }
            AddressMode::Clamp => {
                if border < 0 {
                    self.add(1, sign * border);
                } else if border <= size {
                    self.add(border, sign);
                } else {
                    self.add(size, sign * (1 + border - size));
                    self.add(size - 1, sign * (size - border));
                }
            }
            AddressMode::Clip => self.add(border.clamp(0, size), sign),
        }
    }

    /// The terms of a box.
    #[inline]
    fn of_box(low: i64, high: i64, size: i64, mode: AddressMode) -> Self {
        let mut terms = Self::default();
        terms.add_below(high, size, mode, 1);
        terms.add_below(low, size, mode, -1);
        terms
    }

    #[inline]
    fn nonzero(&self) -> impl Iterator<Item = (i64, i64)> + '_ {
        self.terms[..self.count].iter().copied().filter(|&(_, multiplicity)| multiplicity != 0)
    }
}

/// Width and lower border of the box of one axis.
#[inline]
fn box_of(coordinate: i64, vectors: [i64; 2], size: i64) -> (i64, i64) {
    let extent = (vectors[0].abs() + vectors[1].abs()) * size;
    let width = ((extent + (1 << (COORDINATE_BITS - 1))) >> COORDINATE_BITS).clamp(1, WIDEST);
    let low = (2 * coordinate * size - (width << COORDINATE_BITS) + (1 << COORDINATE_BITS)) >> (COORDINATE_BITS + 1);
    (low, width)
}

/// The reads of a box: a tap an entry, its weight the multiplicity modulo 2^32, its fractions the box's width and height.
pub(crate) struct Sat;

impl Program for Sat {
    const WEIGHT_BITS: u32 = 0;
    const MOST_TAPS: usize = 9;
    const ALWAYS: bool = false;
    const TEXELS: usize = 1;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let (at, modes) = (coordinates(request), unit.sampler().address);
        let vectors = request.axes.map(|axis| axis.map(|component| i64::from(component.to_bits())));
        let size = unit.address().size(0).map(i64::from);
        let mut extent = [0; 2];
        let [columns, rows] = [0, 1].map(|axis| {
            let (low, width) = box_of(at[axis], [vectors[0][axis], vectors[1][axis]], size[axis]);
            extent[axis] = width as u16;
            Terms::of_box(low, low + width, size[axis], modes[axis])
        });
        let mut written = 0;
        for (row, down) in rows.nonzero() {
            for (column, across) in columns.nonzero() {
                let address = unit.address().texel(0, [column - 1, row - 1]);
                let weight = (across as u32).wrapping_mul(down as u32);
                taps[written] =
                    Footprint { address: [address, 0, 0, 0], fraction: extent, weight, ..Footprint::default() };
                written += 1;
            }
        }
        (written, [0; 2])
    }
}

/// The entry at an address.
#[inline]
fn entry(bytes: &[u8], address: u64) -> [u32; 4] {
    let mut sums = [0; 4];
    let words = bytes[address as usize..][..ENTRY_BYTES as usize].chunks_exact(4);
    for (sum, word) in sums.iter_mut().zip(words) {
        *sum = u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
    }
    sums
}

/// The mean over a box, half up: the sums of its reads modulo 2^32, and one division a channel.
#[inline]
pub(crate) fn mean(bytes: &[u8], taps: &[Footprint]) -> Texel {
    let Some(first) = taps.first() else { return [0; 4] };
    let area = u64::from(first.fraction[0]) * u64::from(first.fraction[1]);
    let mut sums = [0u32; 4];
    for tap in taps {
        for (sum, word) in sums.iter_mut().zip(entry(bytes, tap.address[0])) {
            *sum = sum.wrapping_add(word.wrapping_mul(tap.weight));
        }
    }
    sums.map(|sum| ((2 * u64::from(sum) + area) / (2 * area)) as u8)
}

/// Adds up the texels of level 0, row by row, and stores the sums at their addresses: what a driver does once a texture.
///
/// # Panics
/// If `texels` is not the size of the surface or `bytes` not as many as it has.
pub fn store_table(surface: &Surface, texels: &[Texel], bytes: &mut [u8]) {
    let plane = &surface.planes[0];
    assert_eq!(texels.len() as u64, u64::from(plane.width) * u64::from(plane.height));
    assert_eq!(bytes.len() as u64, surface.bytes);
    let mut above = alloc::vec![[0u32; 4]; plane.width as usize];
    for (y, row) in (0..).zip(texels.chunks_exact(plane.width as usize)) {
        let mut of_row = [0u32; 4];
        for ((x, texel), sums) in (0..).zip(row).zip(&mut above) {
            let address = plane.address(x, y) as usize;
            for (channel, word) in bytes[address..address + ENTRY_BYTES as usize].chunks_exact_mut(4).enumerate() {
                of_row[channel] = of_row[channel].wrapping_add(texel[channel].into());
                sums[channel] = sums[channel].wrapping_add(of_row[channel]);
                word.copy_from_slice(&sums[channel].to_le_bytes());
            }
        }
    }
}
