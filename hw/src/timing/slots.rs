//! Where the cache found, or put, the lines of runs.

use alloc::vec::Vec;

use crate::cache::{Run, RunHits, RunObserver};

/// A slot each, in order, with the bit [`MISSED`](Self::MISSED).
#[derive(Clone, Debug, Default)]
pub(super) struct Slots {
    slots: Vec<u32>,
    count: usize,
}

impl Slots {
    /// The line was not there. Slots are fewer than this.
    pub(super) const MISSED: u32 = 1 << 31;

    /// Begins again, with room for the runs of so many taps.
    pub(super) fn clear(&mut self, taps: usize) {
        self.count = 0;
        if self.slots.len() < 4 * taps {
            self.slots.resize(4 * taps, 0);
        }
    }

    fn note(&mut self, slot: u32) {
        self.slots[self.count] = slot;
        self.count += 1;
    }

    /// Those of the runs since then.
    pub(super) fn slots(&self) -> &[u32] {
        &self.slots[..self.count]
    }
}

/// Slots of hits.
pub(super) struct SlotHits<'h> {
    slots: &'h mut [u32],
    count: usize,
    /// Where that comes back to.
    back: &'h mut usize,
}

impl RunHits for SlotHits<'_> {
    #[inline(always)]
    fn hit(&mut self, _: &Run, slot: u32) -> bool {
        self.slots[self.count] = slot;
        self.count += 1;
        true
    }

    #[inline(always)]
    fn close(self) {
        *self.back = self.count;
    }
}

impl RunObserver for Slots {
    type Hits<'h> = SlotHits<'h>;

    #[inline(always)]
    fn hits(&mut self) -> SlotHits<'_> {
        SlotHits { slots: &mut self.slots, count: self.count, back: &mut self.count }
    }

    #[inline(always)]
    fn hit(&mut self, _: &Run, slot: u32) {
        self.note(slot);
    }

    #[inline(always)]
    fn miss(&mut self, _: &Run, slot: u32, _: Option<u64>) {
        self.note(slot | Self::MISSED);
    }
}

const _: () = assert!(crate::cache::Geometry::LINES_MAX <= Slots::MISSED as u64);
