//! Where the cache found, or put, the lines of runs.

use crate::cache::{Run, RunHits, RunObserver};

/// Notes in each run the slot of its line, with the bit [`MISSED`](Self::MISSED).
pub(super) struct Slots;

impl Slots {
    /// The line was not there. Slots are fewer than this.
    pub(super) const MISSED: u32 = 1 << 31;
}

impl RunHits for Slots {
    #[inline(always)]
    fn hit(&mut self, run: &mut Run, slot: u32) -> bool {
        run.note(slot);
        true
    }

    #[inline(always)]
    fn close(self) {}
}

impl RunObserver for Slots {
    type Hits<'h> = Self;

    #[inline(always)]
    fn hits(&mut self) -> Self {
        Self
    }

    #[inline(always)]
    fn hit(&mut self, run: &mut Run, slot: u32) {
        run.note(slot);
    }

    #[inline(always)]
    fn miss(&mut self, run: &mut Run, slot: u32, _: Option<u64>) {
        run.note(slot | Self::MISSED);
    }
}

const _: () = assert!(crate::cache::Geometry::LINES_MAX <= Slots::MISSED as u64);
