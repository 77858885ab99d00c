//! The reads of taps as the cache saw them, reduced to line accesses.

use alloc::vec::Vec;

use crate::cache::{Observer, Outcome, Run, RunHits, RunObserver};

/// Most reads of a tap: four texels, three channels apart.
pub(super) const READS_MAX: usize = 12;

/// A read that misses, or the first read of its line in the tap.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Access {
    pub(super) line: u64,
    pub(super) slot: u32,
    /// Number of the tap.
    pub(super) tap: u32,
    pub(super) hit: bool,
}

/// The line accesses of some taps, in order. Hits do not depend on time, so the cache can be asked for all of them first.
#[derive(Clone, Debug, Default)]
pub(super) struct TapReads {
    accesses: Vec<Access>,
    /// Taps whose reads are told one by one.
    taps: u32,
}

impl TapReads {
    /// Begins again, with room for the accesses of so many taps.
    pub(super) fn clear(&mut self, taps: usize) {
        self.accesses.clear();
        self.accesses.reserve(4 * taps);
        self.taps = 0;
    }

    pub(super) fn accesses(&self) -> &[Access] {
        &self.accesses
    }

    /// The next reads, told one by one, are of the next tap.
    pub(super) fn tap(&mut self) {
        self.taps += 1;
    }

    #[inline(never)]
    fn hit_in(&mut self, tap: u32, line: u64, slot: u32) {
        let mut earlier = self.accesses.iter().rev().take_while(|access| access.tap == tap);
        if !earlier.any(|access| access.line == line) {
            self.accesses.push(Access { line, slot, tap, hit: true });
        }
    }

    #[inline(always)]
    fn miss_in(&mut self, tap: u32, line: u64, slot: u32) {
        self.accesses.push(Access { line, slot, tap, hit: false });
    }
}

/// The texels of a run after the first hit the line the first accessed.
impl RunObserver for TapReads {
    type Hits<'h> = &'h mut Self;

    #[inline(always)]
    fn hits(&mut self) -> &mut Self {
        self
    }

    #[inline(always)]
    fn hit(&mut self, run: &mut Run, slot: u32) {
        if run.is_repeated() {
            self.hit_in(run.tap() as u32, run.line, slot);
        } else {
            self.accesses.push(Access { line: run.line, slot, tap: run.tap() as u32, hit: true });
        }
    }

    #[inline(always)]
    fn miss(&mut self, run: &mut Run, slot: u32, _: Option<u64>) {
        self.miss_in(run.tap() as u32, run.line, slot);
    }
}

impl RunHits for &mut TapReads {
    #[inline(always)]
    fn hit(&mut self, run: &mut Run, slot: u32) -> bool {
        RunObserver::hit(*self, run, slot);
        true
    }

    #[inline(always)]
    fn close(self) {}
}

impl Observer for TapReads {
    #[inline(always)]
    fn lookup(&mut self, _: u64, line: u64, outcome: Outcome) {
        let tap = self.taps - 1;
        match outcome {
            Outcome::Hit { slot } => self.hit_in(tap, line, slot),
            Outcome::Miss { slot, .. } => self.miss_in(tap, line, slot),
        }
    }
}
