//! The taps that are timed: their planes and the addresses they read.

use alloc::vec::Vec;

use crate::{
    address::Footprint,
    batch::{Batch, PlanePairs},
    cache::Runs,
};

/// Taps to be timed, by number.
pub(super) trait Taps {
    /// How many.
    fn number(&self) -> usize;
    /// Storage index of the plane.
    fn plane(&self, tap: usize) -> u16;
    /// Those of taps before this one, for a loop.
    fn planes_before(&self, end: usize) -> impl Fn(usize) -> u16;
    /// The addresses it reads, in order.
    fn addresses(&self, tap: usize) -> &[u64];
    /// How many all taps read.
    fn reads(&self) -> u64;
    /// Tells of which planes taps are, as [`PlanePairs`] does or one by one; last, how much each of them reads.
    fn count_planes(&self, add: impl FnMut(&[u16], u64, u64));
    /// Whether the words of each tap are known to be in as many data banks as they are.
    fn all_apart(&self) -> bool;
}

/// Taps whose addresses are those of their footprints.
pub(super) struct InPlace<'a> {
    taps: &'a [Footprint],
    pairs: &'a PlanePairs,
    /// Addresses of one that count.
    texels: usize,
    /// See [`Taps::all_apart`].
    all_apart: bool,
}

impl<'a> InPlace<'a> {
    /// Those of a batch with these runs.
    pub(super) const fn new(batch: Batch<'a>, runs: Runs<'a>, all_apart: bool) -> Self {
        Self { taps: batch.taps, pairs: runs.pairs, texels: batch.texels_per_tap, all_apart }
    }
}

impl Taps for InPlace<'_> {
    fn number(&self) -> usize {
        self.taps.len()
    }

    #[inline(always)]
    fn plane(&self, tap: usize) -> u16 {
        self.taps[tap].plane
    }

    #[inline(always)]
    fn planes_before(&self, end: usize) -> impl Fn(usize) -> u16 {
        let taps = &self.taps[..end];
        |tap| taps[tap].plane
    }

    #[inline(always)]
    fn addresses(&self, tap: usize) -> &[u64] {
        &self.taps[tap].address[..self.texels]
    }

    fn reads(&self) -> u64 {
        (self.taps.len() * self.texels) as u64
    }

    #[inline(always)]
    fn count_planes(&self, mut add: impl FnMut(&[u16], u64, u64)) {
        self.pairs.for_each(|planes, times| add(planes, times, self.texels as u64));
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

    /// More than the storage index of any plane.
    pub(super) fn planes(&self) -> usize {
        self.taps.iter().map(|&(plane, _)| usize::from(plane) + 1).max().unwrap_or(0)
    }
}

impl Taps for Gathered {
    fn number(&self) -> usize {
        self.taps.len()
    }

    fn plane(&self, tap: usize) -> u16 {
        self.taps[tap].0
    }

    fn planes_before(&self, end: usize) -> impl Fn(usize) -> u16 {
        let taps = &self.taps[..end];
        |tap| taps[tap].0
    }

    fn addresses(&self, tap: usize) -> &[u64] {
        let end = self.taps.get(tap + 1).map_or(self.addresses.len(), |&(_, begin)| begin);
        &self.addresses[self.taps[tap].1..end]
    }

    fn reads(&self) -> u64 {
        self.addresses.len() as u64
    }

    fn count_planes(&self, mut add: impl FnMut(&[u16], u64, u64)) {
        for tap in 0..self.taps.len() {
            add(&[self.plane(tap)], 1, self.addresses(tap).len() as u64);
        }
    }

    fn all_apart(&self) -> bool {
        false
    }
}
