//! Miss-status entries: which lines are on their way, and who waits for them.

use alloc::{vec, vec::Vec};

use super::queue::Fifo;

/// Entries by the clocks they come free, and the state of every slot's line.
#[derive(Clone, Debug)]
pub(super) struct MissStatus {
    entries: Fifo,
    merges: u32,
    /// One more than there are, of no line.
    slots: Vec<Slot>,
}

/// Hits one after the other.
pub(super) struct StatusHits<'h> {
    slots: &'h mut [Slot],
}

#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    /// Clock from which the slot's line can be read.
    filled: u64,
    /// How many hits it still takes before that.
    merges: i64,
}

impl Slot {
    /// What it still takes after a hit in this clock, and whether that is merged. Less than none: the hit must wait for the line.
    #[inline(always)]
    const fn after_hit(self, clock: u64) -> (i64, u64) {
        let merged = clock < self.filled;
        (self.merges - merged as i64, merged as u64)
    }
}

impl StatusHits<'_> {
    /// A slot of no line, hits of which change nothing.
    #[inline(always)]
    pub(super) const fn nothing(&self) -> u32 {
        self.slots.len() as u32 - 1
    }

    /// Hits of two slots in two clocks, and how many of them are merged; nothing, and nothing done, if one must wait for its line.
    #[inline(always)]
    pub(super) fn hit_two(&mut self, slots: [u32; 2], clocks: [u64; 2]) -> Option<u64> {
        let [first, second] = slots.map(|slot| slot as usize);
        let (first_merges, first_merged) = self.slots[first].after_hit(clocks[0]);
        let (second_merges, second_merged) = self.slots[second].after_hit(clocks[1]);
        if first_merges | second_merges < 0 {
            return None;
        }
        self.slots[first].merges = first_merges;
        self.slots[second].merges = second_merges;
        Some(first_merged + second_merged)
    }
}

impl MissStatus {
    pub(super) fn new(entries: u32, merges: u32, slots: usize) -> Self {
        Self { entries: Fifo::new(entries), merges, slots: vec![Slot::default(); slots + 1] }
    }

    /// Hits the line of a slot in a clock that is not before that of the hit before. The answer is the clock in which that can be done, which is when the
    /// line is there if it is on its way and takes no more merges; and whether it is merged.
    #[inline(always)]
    pub(super) fn hit(&mut self, slot: u32, clock: u64) -> (u64, bool) {
        let slot = &mut self.slots[slot as usize];
        let (merges, merged) = slot.after_hit(clock);
        if merges < 0 {
            return (slot.filled, false);
        }
        slot.merges = merges;
        (clock, merged != 0)
    }

    /// For hits that are likely to follow.
    #[inline(always)]
    pub(super) fn hits(&mut self) -> StatusHits<'_> {
        StatusHits { slots: &mut self.slots }
    }

    /// A slot gets a new line.
    pub(super) fn fill(&mut self, slot: u32, filled: u64) {
        self.slots[slot as usize] = Slot { filled, merges: self.merges.into() };
    }

    /// The first clock with a free entry.
    #[inline(always)]
    pub(super) fn room(&self) -> u64 {
        self.entries.room()
    }

    /// Takes an entry in `clock`, as [`Self::room`] allows, that can be taken again from `free` on. Lines may come out of order.
    #[inline(always)]
    pub(super) fn hold(&mut self, clock: u64, free: u64) {
        self.entries.pass_in_any_order(clock, free);
    }

    /// Clocks of entries held, and the most held.
    pub(super) const fn usage(&self) -> (u64, u64) {
        self.entries.usage()
    }
}
