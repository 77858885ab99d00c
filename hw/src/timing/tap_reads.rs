//! The reads of one tap as the cache saw them, and which of them are line accesses.

use crate::cache::{Observer, Outcome};

/// Most reads of a tap: four texels, three channels apart.
pub(super) const READS_MAX: usize = 12;

/// Reads in order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TapReads {
    count: usize,
    lines: [u64; READS_MAX],
    slots: [u32; READS_MAX],
    hits: [bool; READS_MAX],
}

impl TapReads {
    #[inline(always)]
    pub(super) const fn len(&self) -> usize {
        self.count
    }

    /// Line, slot and hit of every line access: a read that misses, or the first read of its line in the tap.
    #[inline(always)]
    pub(super) fn accesses(&self) -> impl Iterator<Item = (u64, u32, bool)> {
        (0..self.count).filter_map(|number| {
            let line = self.lines[number];
            let access = !self.hits[number] || !self.lines[..number].contains(&line);
            access.then_some((line, self.slots[number], self.hits[number]))
        })
    }
}

impl Observer for TapReads {
    #[inline(always)]
    fn lookup(&mut self, _: u64, line: u64, outcome: Outcome) {
        self.lines[self.count] = line;
        self.slots[self.count] = outcome.slot();
        self.hits[self.count] = outcome.is_hit();
        self.count += 1;
    }
}
