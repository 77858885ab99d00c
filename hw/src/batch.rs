//! What is between the address unit and the datapath: a batch of taps, and whoever looks at them.

use alloc::vec::Vec;

use crate::{
    address::{Footprint, is_outside},
    surface::Surface,
};

/// The taps of a batch of requests, in order of issue.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'b> {
    /// All taps, request by request.
    pub taps: &'b [Footprint],
    /// How they divide into requests.
    pub requests: Requests<'b>,
    /// Texels of one tap, 1 or 4: how many addresses of a [`Footprint`] count.
    pub texels_per_tap: usize,
    /// What the addresses are addresses of.
    pub surface: &'b Surface,
}

/// How the taps of a batch divide into requests.
#[derive(Clone, Copy, Debug)]
pub enum Requests<'b> {
    /// Each has this many.
    Each(usize),
    /// Each ends where this says, in taps from the start of the batch.
    Ends(&'b [u32]),
}

impl Requests<'_> {
    /// The same where each has as many taps, else those that end there.
    pub(crate) const fn ending(self, ends: &[u32]) -> Requests<'_> {
        match self {
            Self::Each(taps) => Requests::Each(taps),
            Self::Ends(_) => Requests::Ends(ends),
        }
    }
}

impl<'b> Batch<'b> {
    /// Requests in it.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self.requests {
            Requests::Each(taps) => self.taps.len() / taps,
            Requests::Ends(ends) => ends.len(),
        }
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where the taps of each request end, in taps from the start of the batch.
    pub(crate) fn ends_into(&self, ends: &mut Vec<u32>) {
        match self.requests {
            Requests::Each(taps) => ends.extend((1..=self.len()).map(|number| (number * taps) as u32)),
            Requests::Ends(these) => ends.extend_from_slice(these),
        }
    }

    /// The taps of each request.
    pub fn per_request(&self) -> impl Iterator<Item = &'b [Footprint]> + use<'b> {
        let (taps, requests) = (self.taps, self.requests);
        let mut begin = 0;
        (0..self.len()).map(move |number| {
            let end = match requests {
                Requests::Each(taps) => begin + taps,
                Requests::Ends(ends) => ends[number] as usize,
            };
            let of_request = &taps[begin..end];
            begin = end;
            of_request
        })
    }
}

impl Batch<'_> {
    /// Calls `read` for each read of memory, in order of issue, with the storage index of the plane: once a texel, or once a
    /// channel where the layout keeps channels apart; not at all for a texel outside the texture.
    #[inline]
    pub fn for_each_read(&self, mut read: impl FnMut(usize, u64)) {
        let channels_apart = self.surface.reads_per_texel() > 1;
        for tap in self.taps {
            let plane = usize::from(tap.plane);
            for &address in tap.address[..self.texels_per_tap].iter().filter(|&&address| !is_outside(address)) {
                read(plane, address);
                if channels_apart {
                    for distance in self.surface.planes[plane].channels {
                        read(plane, address + distance);
                    }
                }
            }
        }
    }
}

/// Of which planes taps are: two by two as they come, and how many times in a row, for mostly two are of the same planes as the two before.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlanePairs {
    pairs: Vec<([u16; 2], u64)>,
    /// Of the one that may be left.
    odd: Option<u16>,
}

impl PlanePairs {
    /// Those of these taps.
    pub(crate) fn count(&mut self, taps: &[Footprint]) {
        self.pairs.clear();
        let (pairs, rest) = taps.as_chunks();
        let (mut last, mut times) = ([0; 2], 0);
        for [first, second] in pairs {
            let now = [first.plane, second.plane];
            if now != last {
                self.pairs.push((last, times));
                (last, times) = (now, 0);
            }
            times += 1;
        }
        self.pairs.push((last, times));
        self.odd = rest.first().map(|tap| tap.plane);
    }

    /// Tells of the planes of two, or one, and how many times.
    #[inline(always)]
    pub(crate) fn for_each(&self, mut tell: impl FnMut(&[u16], u64)) {
        self.pairs.iter().for_each(|(pair, times)| tell(pair, *times));
        self.odd.iter().for_each(|&odd| tell(&[odd], 1));
    }
}

/// Whoever looks at the address stream between the address unit and the datapath.
pub trait Sink {
    /// Whether it looks at all: where it does not, a unit need not have its taps in memory at any time.
    const LOOKS: bool = true;

    /// Takes the next batch.
    fn take(&mut self, batch: Batch<'_>);
}

/// Nobody looks.
impl Sink for () {
    const LOOKS: bool = false;

    #[inline]
    fn take(&mut self, _batch: Batch<'_>) {}
}
