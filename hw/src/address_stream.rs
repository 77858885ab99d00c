//! What is between the address unit and the datapath, as far as a cache sees it: where the texels of taps are, and of which planes the taps are.

use alloc::vec::Vec;
use core::ops::Range;

use crate::{
    address::{Footprint, OUTSIDE, is_outside},
    batch::{Batch, Requests},
    surface::Surface,
};

/// Taps of a batch at most: few enough to stay in the first-level caches of the host.
pub(crate) const BATCH_TAPS: usize = 256;

/// Reads of a tap at most: four texels of four channels.
const MOST_READS: usize = 16;

/// The addresses of a batch of requests, in order of issue.
#[derive(Clone, Copy, Debug)]
pub struct AddressBatch<'b> {
    pub(crate) taps: Places<'b>,
    /// How the taps divide into requests.
    pub requests: Requests<'b>,
    /// Texels of one tap, 1 or 4.
    pub texels_per_tap: usize,
    /// What the addresses are addresses of.
    pub surface: &'b Surface,
}

/// Whoever looks at the address stream between the address unit and the datapath.
pub trait Sink {
    /// Whether it looks at all: where it does not, a unit need not have its taps in memory at any time.
    const LOOKS: bool = true;

    /// Takes the next batch.
    fn take(&mut self, batch: AddressBatch<'_>);
}

/// Nobody looks.
impl Sink for () {
    const LOOKS: bool = false;

    #[inline]
    fn take(&mut self, _batch: AddressBatch<'_>) {}
}

/// Where the texels of taps are, as the scalar unit or its lanes have it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Places<'b> {
    Footprints(&'b [Footprint]),
    /// So many, from the first.
    Rows(&'b TapRows, usize),
}

/// Taps that lanes made: a row for each corner, for lanes to read as they were written.
#[derive(Clone, Debug)]
pub(crate) struct TapRows {
    /// Byte addresses of texels as in a [`Footprint`], below 2^31, or [`OUTSIDE`](Self::OUTSIDE).
    pub(crate) corners: [[u32; BATCH_TAPS]; 4],
    /// Storage indices of planes.
    pub(crate) planes: [u32; BATCH_TAPS],
}

impl TapRows {
    /// Stands for an address outside the texture.
    pub(crate) const OUTSIDE: u32 = 1 << 31;

    pub(crate) const fn new() -> Self {
        Self { corners: [[0; BATCH_TAPS]; 4], planes: [0; BATCH_TAPS] }
    }

    /// Adds taps that lanes did not make, from the one numbered `first`.
    pub(crate) fn add(&mut self, first: usize, taps: &[Footprint]) {
        for (tap, number) in taps.iter().zip(first..) {
            for (row, address) in self.corners.iter_mut().zip(tap.address) {
                row[number] = if is_outside(address) { Self::OUTSIDE } else { address as u32 };
            }
            self.planes[number] = tap.plane.into();
        }
    }
}

impl Places<'_> {
    pub(crate) const fn len(self) -> usize {
        match self {
            Self::Footprints(taps) => taps.len(),
            Self::Rows(_, taps) => taps,
        }
    }

    /// The addresses of a tap, as in a [`Footprint`].
    #[inline]
    pub(crate) fn addresses(self, tap: usize) -> [u64; 4] {
        match self {
            Self::Footprints(taps) => taps[tap].address,
            Self::Rows(rows, _) => {
                let [a, b, c, d] = &rows.corners;
                [a[tap], b[tap], c[tap], d[tap]].map(|word| match word {
                    TapRows::OUTSIDE => OUTSIDE,
                    address => address.into(),
                })
            }
        }
    }

    /// Storage index of the plane of a tap.
    #[inline]
    pub(crate) fn plane(self, tap: usize) -> usize {
        match self {
            Self::Footprints(taps) => taps[tap].plane.into(),
            Self::Rows(rows, _) => rows.planes[tap] as usize,
        }
    }
}

impl<'b> From<Batch<'b>> for AddressBatch<'b> {
    fn from(Batch { taps, requests, texels_per_tap, surface }: Batch<'b>) -> Self {
        Self { taps: Places::Footprints(taps), requests, texels_per_tap, surface }
    }
}

impl AddressBatch<'_> {
    /// Requests in it.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.requests.number(self.taps.len())
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Taps of all requests.
    #[must_use]
    pub const fn taps(&self) -> usize {
        self.taps.len()
    }

    /// Storage index of the plane of a tap, and the byte addresses of its texels as [`Footprint::address`] has them.
    #[must_use]
    pub fn tap(&self, number: usize) -> (usize, [u64; 4]) {
        (self.taps.plane(number), self.taps.addresses(number))
    }

    /// Calls `see` for each tap, in order of issue, with the number of its request, the storage index of its plane, and the addresses it reads: one a
    /// texel, or one a channel where the layout keeps channels apart; none for a texel outside the texture.
    ///
    /// # Panics
    /// If the last request ends before the last tap.
    #[inline]
    pub fn for_each_tap(&self, mut see: impl FnMut(usize, usize, &[u64])) {
        let channels_apart = self.surface.reads_per_texel() > 1;
        let (mut request, mut reads) = (0, [0; MOST_READS]);
        for number in 0..self.taps() {
            while self.requests.end(request) <= number {
                request += 1;
            }
            let (plane, addresses) = self.tap(number);
            let mut count = 0;
            for &address in addresses[..self.texels_per_tap].iter().filter(|&&address| !is_outside(address)) {
                reads[count] = address;
                count += 1;
                if channels_apart {
                    for distance in self.surface.planes[plane].channels {
                        reads[count] = address + distance;
                        count += 1;
                    }
                }
            }
            see(request, plane, &reads[..count]);
        }
    }

    /// Calls `read` for each of these reads, with the storage index of the plane.
    #[inline]
    pub fn for_each_read(&self, mut read: impl FnMut(usize, u64)) {
        self.for_each_tap(|_, plane, reads| reads.iter().for_each(|&address| read(plane, address)));
    }

    /// Whether a texel of one of these taps is outside the texture.
    pub(crate) fn any_outside(&self, mut taps: Range<usize>) -> bool {
        taps.any(|tap| self.taps.addresses(tap)[..self.texels_per_tap].iter().any(|&address| is_outside(address)))
    }
}

/// Of which planes taps are: two by two as they come, and how many times in a row, for mostly two are of the same planes as the two before.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlanePairs {
    pairs: Vec<([u32; 2], u64)>,
    /// Of the one that may be left.
    odd: Option<u32>,
}

impl PlanePairs {
    /// Those of taps of these planes.
    pub(crate) fn count(&mut self, planes: &[u32]) {
        self.pairs.clear();
        let (pairs, rest) = planes.as_chunks();
        for alike in pairs.chunk_by(PartialEq::eq) {
            self.pairs.push((alike[0], alike.len() as u64));
        }
        self.odd = rest.first().copied();
    }

    /// Tells of the planes of two, or one, and how many times.
    #[inline(always)]
    pub(crate) fn for_each(&self, mut tell: impl FnMut(&[u32], u64)) {
        self.pairs.iter().for_each(|(pair, times)| tell(pair, *times));
        self.odd.iter().for_each(|&odd| tell(&[odd], 1));
    }
}
