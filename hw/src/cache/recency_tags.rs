//! Tags kept in order of use: LRU of up to 16 ways without a search, the loop that most runs spend their time in.

use alloc::{vec, vec::Vec};

use super::{Observer, Outcome};

/// The tag memory of an LRU cache whose number of ways is known at compile time. The lines of each set are kept from the
/// most to the least recent, so a lookup shifts them along until it meets its own.
///
/// An empty way holds a line that never comes to its set: one of another set, or, where there is only one set, the
/// largest number, which no line of two or more bytes has. (One set of one-byte lines is not built from this.)
#[derive(Clone, Debug)]
pub(super) struct RecencyTags<const WAYS: usize> {
    sets: Vec<[u64; WAYS]>,
    /// The ways these lines are in, 4 bits each in the same order, from the low end. Empty ways come last and the lowest
    /// of them very last, so that replacement alone fills them in order.
    ways: Vec<u64>,
}

impl<const WAYS: usize> RecencyTags<WAYS> {
    pub(super) fn new(sets: usize) -> Self {
        let mut lines = vec![[0; WAYS]; sets];
        lines[0] = [Self::empty(0, sets); WAYS];
        let ways = (0..WAYS).fold(0, |ways, way| ways << 4 | way as u64);
        // Folding puts the last way lowest, which is the front; the front is the most recent.
        Self { sets: lines, ways: vec![ways; sets] }
    }

    const fn empty(set: usize, sets: usize) -> u64 {
        match (set, sets) {
            (0, 1) => u64::MAX,
            (0, _) => 1,
            _ => 0,
        }
    }

    /// Looks `line` up in `set`, which must be its own.
    #[inline(always)]
    pub(super) fn access(&mut self, set: usize, line: u64) -> Outcome {
        Self::access_in(&mut self.sets, &mut self.ways, set, line)
    }

    #[inline(always)]
    fn access_in(sets: &mut [[u64; WAYS]], ways: &mut [u64], set: usize, line: u64) -> Outcome {
        let count = sets.len();
        let lines = &mut sets[set];
        let first = lines[0];
        if first == line {
            return Outcome::Hit { slot: (set * WAYS) as u32 + (ways[set] & 15) as u32 };
        }
        let mut carried = first;
        for position in 1..WAYS {
            let next = core::mem::replace(&mut lines[position], carried);
            if next == line {
                lines[0] = line;
                let way = Self::to_front(&mut ways[set], position);
                return Outcome::Hit { slot: (set * WAYS + way) as u32 };
            }
            carried = next;
        }
        lines[0] = line;
        let way = Self::to_front(&mut ways[set], WAYS - 1);
        let evicted = (carried != Self::empty(set, count)).then_some(carried);
        Outcome::Miss { slot: (set * WAYS + way) as u32, evicted }
    }

    /// Moves the way at a position to the front.
    #[inline(always)]
    fn to_front(ways: &mut u64, position: usize) -> usize {
        let moved = u64::MAX >> (60 - 4 * position);
        let way = *ways >> (4 * position) & 15;
        *ways = (*ways & !moved) | (*ways << 4 & moved) | way;
        way as usize
    }

    /// Looks up the lines of byte addresses; the answer is the number of misses.
    #[inline(always)]
    pub(super) fn run<O: Observer>(
        &mut self,
        addresses: &[u64],
        shift: u32,
        set_of: impl Fn(u64) -> usize,
        observer: &mut O,
    ) -> u64 {
        let (sets, ways) = (self.sets.as_mut_slice(), self.ways.as_mut_slice());
        let mut misses = 0;
        for &address in addresses {
            let line = address >> shift;
            let outcome = Self::access_in(sets, ways, set_of(line), line);
            misses += u64::from(!outcome.is_hit());
            observer.lookup(address, line, outcome);
        }
        misses
    }

    /// Lines held now.
    pub(super) fn resident(&self) -> u64 {
        let count = self.sets.len();
        let held = |(set, lines): (usize, &[u64; WAYS])| {
            lines.iter().filter(|&&line| line != Self::empty(set, count)).count() as u64
        };
        self.sets.iter().enumerate().map(held).sum()
    }
}
