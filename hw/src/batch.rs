//! What the datapath filters: the taps of a batch of requests.

use alloc::vec::Vec;

use crate::{address::Footprint, surface::Surface};

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
    /// How many, of so many taps in all.
    pub(crate) const fn number(self, taps: usize) -> usize {
        match self {
            Self::Each(of_each) => taps / of_each,
            Self::Ends(ends) => ends.len(),
        }
    }

    /// Where the taps of a request end, in taps from the start of the batch.
    pub(crate) const fn end(self, request: usize) -> usize {
        match self {
            Self::Each(taps) => (request + 1) * taps,
            Self::Ends(ends) => ends[request] as usize,
        }
    }

    /// Where those of all end that have taps, of so many taps in all; one that ends at 0 is among them if it comes first.
    pub(crate) fn ends_into(self, taps: usize, to: &mut Vec<u32>) {
        match self {
            Self::Each(of_each) => to.extend((1..=taps / of_each).map(|number| (number * of_each) as u32)),
            Self::Ends(ends) => {
                to.extend_from_slice(ends);
                to.dedup();
            }
        }
    }

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
        self.requests.number(self.taps.len())
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The taps of each request.
    pub fn per_request(&self) -> impl Iterator<Item = &'b [Footprint]> + use<'b> {
        let (taps, requests) = (self.taps, self.requests);
        let mut begin = 0;
        (0..self.len()).map(move |number| {
            let end = requests.end(number);
            let of_request = &taps[begin..end];
            begin = end;
            of_request
        })
    }
}
