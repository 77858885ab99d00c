//! Tags kept in order of use: LRU of up to 16 ways without a search, the loop that most runs spend their time in.

use alloc::vec::Vec;
use core::slice::IterMut;

use super::{
    Observer, Outcome, Run,
    changes::Changes,
    tags::{access_until, look_up},
};

/// Low bits of an entry: the way.
const WAY_BITS: u32 = 4;
const WAY: u64 = (1 << WAY_BITS) - 1;

/// The tag memory of an LRU cache whose number of ways is known at compile time. The entries of each set, a line and the way it is in,
/// are kept from the most to the least recent, so a lookup shifts them along until it meets its own.
///
/// Empty ways come last and the lowest of them very last, so that replacement alone fills them in order. They hold a line that never
/// comes to their set: one of another set, or, where there is only one set, the largest number. Lines are of 16 bytes or more, in
/// one set of more than 16, so that a line's number leaves room for the way and is not that largest one.
#[derive(Clone, Debug)]
pub(super) struct RecencyTags<const WAYS: usize> {
    sets: Vec<[u64; WAYS]>,
}

impl<const WAYS: usize> RecencyTags<WAYS> {
    pub(super) fn new(sets: usize) -> Self {
        let entry = |set, position: usize| Self::empty(set, sets) << WAY_BITS | (WAYS - 1 - position) as u64;
        Self { sets: (0..sets).map(|set| core::array::from_fn(|position| entry(set, position))).collect() }
    }

    /// Whether lines of so many bytes in so many sets can be kept like this.
    pub(super) const fn suits(sets: u32, line: u32) -> bool {
        line > 1 << WAY_BITS || line == 1 << WAY_BITS && sets > 1
    }

    const fn empty(set: usize, sets: usize) -> u64 {
        match (set, sets) {
            (0, 1) => u64::MAX >> WAY_BITS,
            (0, _) => 1,
            _ => 0,
        }
    }

    /// Looks `line` up in `set`, which must be its own.
    #[inline(always)]
    pub(super) fn access(&mut self, set: usize, line: u64) -> Outcome {
        Self::access_either(&mut self.sets, set, line)
    }

    /// [`access_until`] with these tags.
    #[inline(always)]
    pub(super) fn access_until<'i>(
        &mut self,
        runs: &mut IterMut<'i, Run>,
        set_of: impl Fn(u64, usize) -> usize,
        go_on: impl FnMut(&mut Run, Outcome) -> bool,
    ) -> Option<(&'i mut Run, Outcome)> {
        let sets = self.sets.as_mut_slice();
        let count = sets.len();
        access_until(runs, go_on, |line| Self::access_either(sets, set_of(line, count), line))
    }

    /// Looks up one that is likely in either of the two most recent places: taps of two levels take turns, and a host cannot guess in which.
    #[inline(always)]
    fn access_either(sets: &mut [[u64; WAYS]], set: usize, line: u64) -> Outcome {
        let key = line << WAY_BITS;
        let entries = &mut sets[set];
        if WAYS > 1 {
            let (first, second) = (entries[0], entries[1]);
            let (from_first, from_second) = (first ^ key, second ^ key);
            if from_first.min(from_second) <= WAY {
                let (front, other) = if from_first <= WAY { (first, second) } else { (second, first) };
                entries[0] = front;
                entries[1] = other;
                return Outcome::Hit { slot: (set * WAYS) as u32 + (front & WAY) as u32 };
            }
        }
        Self::access_in(sets, set, line)
    }

    #[inline(always)]
    fn access_in(sets: &mut [[u64; WAYS]], set: usize, line: u64) -> Outcome {
        let key = line << WAY_BITS;
        let count = sets.len();
        let slot = |entry: u64| (set * WAYS) as u32 + (entry & WAY) as u32;
        let entries = &mut sets[set];
        let mut carried = entries[0];
        if carried ^ key <= WAY {
            return Outcome::Hit { slot: slot(carried) };
        }
        for position in 1..WAYS {
            let next = core::mem::replace(&mut entries[position], carried);
            if next ^ key <= WAY {
                entries[0] = next;
                return Outcome::Hit { slot: slot(next) };
            }
            carried = next;
        }
        entries[0] = key | carried & WAY;
        let former = carried >> WAY_BITS;
        Outcome::Miss { slot: slot(carried), evicted: (former != Self::empty(set, count)).then_some(former) }
    }

    /// Looks up the lines of byte addresses; the answer is the number of misses. Compiled on its own: among the loops of other engines the host
    /// has no registers left for this one.
    #[inline(never)]
    pub(super) fn run<O: Observer>(
        &mut self,
        addresses: &[u64],
        changes: Changes,
        line_of: impl Fn(u64) -> u64,
        set_of: impl Fn(u64, usize) -> usize,
        observer: &mut O,
    ) -> u64 {
        let sets = self.sets.as_mut_slice();
        let count = sets.len();
        look_up(addresses, changes, line_of, observer, |line| Self::access_in(sets, set_of(line, count), line))
    }

    /// Lines held now.
    pub(super) fn resident(&self) -> u64 {
        let count = self.sets.len();
        let held = |(set, entries): (usize, &[u64; WAYS])| {
            entries.iter().filter(|&&entry| entry >> WAY_BITS != Self::empty(set, count)).count() as u64
        };
        self.sets.iter().enumerate().map(held).sum()
    }
}
