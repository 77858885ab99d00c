//! The reads of taps as the cache saw them, reduced to line accesses.

use alloc::vec::Vec;

use crate::cache::{Observer, Outcome, Run, RunObserver};

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
        let begin = |tap| self.begins.get(tap).copied().unwrap_or(self.accesses.len());
        begin(tap)..begin(tap + 1)
    }

    /// The next reads are of the next tap.
    #[inline(always)]
    pub(super) fn tap(&mut self) {
        self.begins.push(self.accesses.len());
    }

    #[inline(always)]
    pub(super) fn access(&self, number: usize) -> Access {
        self.accesses[number]
    }

    /// The texels of a run after the first hit the line the first accessed.
    #[inline(always)]
    fn run(&mut self, run: &Run, outcome: Outcome) {
        while self.begins.len() <= run.tap as usize {
            self.tap();
        }
        self.read(run.line, outcome);
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

impl RunObserver for TapReads {
    #[inline(always)]
    fn hit(&mut self, run: &Run, slot: u32) {
        self.run(run, Outcome::Hit { slot });
    }

    #[inline(always)]
    fn miss(&mut self, run: &Run, slot: u32, evicted: Option<u64>) {
        self.run(run, Outcome::Miss { slot, evicted });
    }
}

impl Observer for TapReads {
    #[inline(always)]
    fn lookup(&mut self, _: u64, line: u64, outcome: Outcome) {
        self.read(line, outcome);
    }
}
