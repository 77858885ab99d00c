//! The taps that are timed: their planes and the addresses they read.

use alloc::vec::Vec;

use crate::address::Footprint;

/// Taps to be timed, by number.
pub(super) trait Taps {
    /// Storage index of the plane.
    fn plane(&self, tap: usize) -> u16;
    /// The addresses it reads, in order.
    fn addresses(&self, tap: usize) -> &[u64];
    /// Whether it is known that they are in as many data banks.
    fn apart(&self, tap: usize) -> bool;
}

/// Taps whose addresses are those of their footprints.
pub(super) struct InPlace<'a> {
    pub(super) taps: &'a [Footprint],
    /// Addresses of one that count.
    pub(super) texels: usize,
    /// Eight taps a byte: whether their words are known to lie in different banks.
    pub(super) apart: &'a [u8],
}

impl Taps for InPlace<'_> {
    #[inline(always)]
    fn plane(&self, tap: usize) -> u16 {
        self.taps[tap].plane
    }

    #[inline(always)]
    fn addresses(&self, tap: usize) -> &[u64] {
        &self.taps[tap].address[..self.texels]
    }

    #[inline(always)]
    fn apart(&self, tap: usize) -> bool {
        self.apart.get(tap / 8).is_some_and(|eight| eight >> (tap % 8) & 1 != 0)
    }
}

/// Taps whose addresses are written out.
#[derive(Clone, Debug, Default)]
pub(super) struct Gathered {
    addresses: Vec<u64>,
    /// Plane of each tap, and where its addresses begin.
    taps: Vec<(u16, usize)>,
}

impl Gathered {
    pub(super) fn clear(&mut self) {
        self.addresses.clear();
        self.taps.clear();
    }

    /// The next reads are those of a tap on this plane.
    pub(super) fn tap(&mut self, plane: u16) {
        self.taps.push((plane, self.addresses.len()));
    }

    pub(super) fn read(&mut self, address: u64) {
        self.addresses.push(address);
    }

    pub(super) fn len(&self) -> usize {
        self.taps.len()
    }
}

impl Taps for Gathered {
    fn plane(&self, tap: usize) -> u16 {
        self.taps[tap].0
    }

    fn addresses(&self, tap: usize) -> &[u64] {
        let end = self.taps.get(tap + 1).map_or(self.addresses.len(), |&(_, begin)| begin);
        &self.addresses[self.taps[tap].1..end]
    }

    fn apart(&self, _: usize) -> bool {
        false
    }
}
