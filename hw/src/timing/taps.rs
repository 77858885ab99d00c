//! The taps that are timed: their planes and the addresses they read.

use alloc::vec::Vec;

use crate::{address::Footprint, batch::count_planes};

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
    /// Tells of which planes taps are, as [`count_planes`] does or one by one; last, how much each of them reads.
    fn count_planes(&self, add: impl FnMut(&[u16], u64, u64));
    /// More than the storage index of any plane.
    fn planes(&self) -> usize;
    /// Whether the words of each tap are known to be in as many data banks as they are.
    fn all_apart(&self) -> bool;
}

/// Taps whose addresses are those of their footprints.
pub(super) struct InPlace<'a> {
    pub(super) taps: &'a [Footprint],
    /// Addresses of one that count.
    pub(super) texels: usize,
    /// See [`Taps::all_apart`].
    pub(super) all_apart: bool,
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
        count_planes(self.taps, |planes, times| add(planes, times, self.texels as u64));
    }

    /// Not those of a surface: whoever has several textures in one memory numbers their planes one after the other.
    fn planes(&self) -> usize {
        usize::from(self.taps.iter().fold(0, |most, tap| most.max(tap.plane))) + 1
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

    fn planes(&self) -> usize {
        self.taps.iter().map(|&(plane, _)| usize::from(plane) + 1).max().unwrap_or(0)
    }

    fn all_apart(&self) -> bool {
        false
    }
}
