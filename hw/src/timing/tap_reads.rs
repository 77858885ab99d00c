//! The reads of one tap as the cache saw them, reduced to its line accesses.

use crate::cache::{Observer, Outcome};

/// Most reads of a tap: four texels, three channels apart.
pub(super) const READS_MAX: usize = 12;

/// A read that misses, or the first read of its line in the tap.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Access {
    pub(super) line: u64,
    pub(super) slot: u32,
    pub(super) hit: bool,
}

/// The line accesses of a tap, in order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TapReads {
    /// Reads seen.
    pub(super) reads: u64,
    count: usize,
    /// Line of the read before.
    last: u64,
    accesses: [Access; READS_MAX],
}

impl TapReads {
    #[inline(always)]
    pub(super) const fn clear(&mut self) {
        (self.reads, self.count) = (0, 0);
    }

    #[inline(always)]
    pub(super) const fn count(&self) -> usize {
        self.count
    }

    #[inline(always)]
    pub(super) const fn access(&self, number: usize) -> Access {
        self.accesses[number]
    }
}

impl Observer for TapReads {
    #[inline(always)]
    fn lookup(&mut self, _: u64, line: u64, outcome: Outcome) {
        self.reads += 1;
        let hit = outcome.is_hit();
        let again = line == self.last && self.count > 0;
        self.last = line;
        if hit && (again || self.accesses[..self.count].iter().any(|access| access.line == line)) {
            return;
        }
        self.accesses[self.count] = Access { line, slot: outcome.slot(), hit };
        self.count += 1;
    }
}
