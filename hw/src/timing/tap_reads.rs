//! The reads of taps as the cache saw them, reduced to line accesses.

use alloc::vec::Vec;

use crate::cache::{Observer, Outcome, TapObserver};

/// Most reads of a tap: four texels, three channels apart.
pub(super) const READS_MAX: usize = 12;

/// A read that misses, or the first read of its line in the tap.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Access {
    pub(super) line: u64,
    pub(super) slot: u32,
    pub(super) hit: bool,
}

/// The line accesses of some taps, in order. Hits do not depend on time, so the cache can be asked for all of them first.
#[derive(Clone, Debug, Default)]
pub(super) struct TapReads {
    accesses: Vec<Access>,
    /// Where the accesses of each tap begin.
    begins: Vec<usize>,
}

impl TapReads {
    pub(super) fn clear(&mut self) {
        self.accesses.clear();
        self.begins.clear();
    }

    /// The accesses of a tap.
    #[inline(always)]
    pub(super) fn of_tap(&self, tap: usize) -> core::ops::Range<usize> {
        self.begins[tap]..self.begins.get(tap + 1).copied().unwrap_or(self.accesses.len())
    }

    #[inline(always)]
    pub(super) fn access(&self, number: usize) -> Access {
        self.accesses[number]
    }

    #[inline(always)]
    fn read(&mut self, line: u64, outcome: Outcome) {
        let hit = outcome.is_hit();
        let begin = self.begins.last().copied().unwrap_or(0);
        if !(hit && self.accesses[begin..].iter().any(|access| access.line == line)) {
            self.accesses.push(Access { line, slot: outcome.slot(), hit });
        }
    }
}

impl TapObserver for TapReads {
    #[inline(always)]
    fn tap(&mut self, _: u16, _: u64) {
        self.begins.push(self.accesses.len());
    }

    /// The texels of a run after the first hit the line the first accessed.
    #[inline(always)]
    fn run<const TEXELS: usize>(&mut self, _: &[u64; TEXELS], line: u64, outcome: Outcome) {
        self.read(line, outcome);
    }

    #[inline(always)]
    fn again<const TEXELS: usize>(&mut self, _: &[u64; TEXELS], line: u64, slot: u32) {
        self.read(line, Outcome::Hit { slot });
    }
}

impl Observer for TapReads {
    #[inline(always)]
    fn lookup(&mut self, _: u64, line: u64, outcome: Outcome) {
        self.read(line, outcome);
    }
}
