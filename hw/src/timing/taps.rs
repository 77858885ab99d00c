//! The taps that are timed: their planes and the addresses they read.

use alloc::vec::Vec;

use crate::{
    address_stream::{AddressBatch, Places},
    cache::{Runs, TapsOfRuns},
};

/// Taps to be timed, by number.
pub(super) trait Taps {
    /// How many.
    fn number(&self) -> usize;
    /// Storage index of the plane.
    fn plane(&self, tap: usize) -> usize;
    /// Calls `see` with the addresses it reads, in order.
    fn with_addresses<R>(&self, tap: usize, see: impl FnOnce(&[u64]) -> R) -> R;
    /// How many all taps read.
    fn reads(&self) -> u64;
    /// Tells of which planes taps are, as [`PlanePairs`](crate::address_stream::PlanePairs) does or one by one; last, how much each of them reads.
    fn count_planes(&self, add: impl FnMut(&[u32], u64, u64));
    /// Whether the words of each tap are known to be in as many data banks as they are.
    fn all_apart(&self) -> bool;
}

/// Taps whose addresses are where the unit made them.
pub(super) struct InPlace<'a> {
    places: Places<'a>,
    of_runs: TapsOfRuns<'a>,
    /// Addresses of one that count.
    texels: usize,
    /// See [`Taps::all_apart`].
    all_apart: bool,
}

impl<'a> InPlace<'a> {
    /// Those of a batch with these runs.
    pub(super) const fn new(batch: AddressBatch<'a>, runs: Runs<'a>, all_apart: bool) -> Self {
        Self { places: batch.taps, of_runs: runs.taps, texels: batch.texels_per_tap, all_apart }
    }
}

impl Taps for InPlace<'_> {
    fn number(&self) -> usize {
        self.places.len()
    }

    #[inline(always)]
    fn plane(&self, tap: usize) -> usize {
        self.of_runs.planes[tap] as usize
    }

    #[inline(always)]
    fn with_addresses<R>(&self, tap: usize, see: impl FnOnce(&[u64]) -> R) -> R {
        see(&self.places.addresses(tap)[..self.texels])
    }

    fn reads(&self) -> u64 {
        (self.number() * self.texels) as u64
    }

    #[inline(always)]
    fn count_planes(&self, mut add: impl FnMut(&[u32], u64, u64)) {
        self.of_runs.pairs.for_each(|planes, times| add(planes, times, self.texels as u64));
    }

    fn all_apart(&self) -> bool {
        self.all_apart
    }
}

/// Taps whose addresses are written out.
#[derive(Clone, Debug, Default)]
pub(super) struct Gathered {
    addresses: Vec<u64>,
    /// Plane of each tap, and where its addresses begin.
    taps: Vec<(u32, usize)>,
}

impl Gathered {
    pub(super) fn clear(&mut self) {
        self.addresses.clear();
        self.taps.clear();
    }

    /// Adds a tap on this plane.
    pub(super) fn tap(&mut self, plane: usize, reads: &[u64]) {
        self.taps.push((plane as u32, self.addresses.len()));
        self.addresses.extend_from_slice(reads);
    }

    /// The addresses a tap reads.
    pub(super) fn addresses(&self, tap: usize) -> &[u64] {
        let end = self.taps.get(tap + 1).map_or(self.addresses.len(), |&(_, begin)| begin);
        &self.addresses[self.taps[tap].1..end]
    }

    /// More than the storage index of any plane.
    pub(super) fn planes(&self) -> usize {
        self.taps.iter().map(|&(plane, _)| plane as usize + 1).max().unwrap_or(0)
    }
}

impl Taps for Gathered {
    fn number(&self) -> usize {
        self.taps.len()
    }

    fn plane(&self, tap: usize) -> usize {
        self.taps[tap].0 as usize
    }

    fn with_addresses<R>(&self, tap: usize, see: impl FnOnce(&[u64]) -> R) -> R {
        see(self.addresses(tap))
    }

    fn reads(&self) -> u64 {
        self.addresses.len() as u64
    }

    fn count_planes(&self, mut add: impl FnMut(&[u32], u64, u64)) {
        for tap in 0..self.taps.len() {
            add(&[self.taps[tap].0], 1, self.addresses(tap).len() as u64);
        }
    }

    fn all_apart(&self) -> bool {
        false
    }
}
