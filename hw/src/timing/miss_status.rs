//! Miss-status entries: which lines are on their way, and who waits for them.

use alloc::{collections::VecDeque, vec, vec::Vec};

/// Entries by the clocks they come free, and the state of every slot's line.
#[derive(Clone, Debug)]
pub(super) struct MissStatus {
    entries: usize,
    /// First clocks at which the entries held can be taken again, in order. Lines may come out of order, so this is sorted.
    held: VecDeque<u64>,
    most: usize,
    clocks: u64,
    merges: u32,
    slots: Vec<Slot>,
}

/// Hits one after the other.
pub(super) struct StatusHits<'h> {
    merges: u32,
    slots: &'h mut [Slot],
}

impl StatusHits<'_> {
    /// A hit in this clock, and whether it is merged; nothing of one that must wait for the line.
    #[inline(always)]
    pub(super) fn hit(&mut self, slot: u32, clock: u64) -> Option<bool> {
        let slot = &mut self.slots[slot as usize];
        if clock >= slot.filled {
            return Some(false);
        }
        if slot.merged >= self.merges {
            return None;
        }
        slot.merged += 1;
        Some(true)
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    /// Clock from which the slot's line can be read.
    filled: u64,
    /// Hits before that.
    merged: u32,
}

impl MissStatus {
    pub(super) fn new(entries: u32, merges: u32, slots: usize) -> Self {
        let entries = entries as usize;
        Self { entries, held: VecDeque::new(), most: 0, clocks: 0, merges, slots: vec![Slot::default(); slots] }
    }

    /// Hits the line of a slot in a clock that is not before that of the hit before. The answer is the clock in which that can be done, which is when the
    /// line is there if it is on its way and takes no more merges; and whether it is merged.
    #[inline(always)]
    pub(super) fn hit(&mut self, slot: u32, clock: u64) -> (u64, bool) {
        match self.hits().hit(slot, clock) {
            Some(merged) => (clock, merged),
            None => (self.slots[slot as usize].filled, false),
        }
    }

    /// For hits that are likely to follow.
    #[inline(always)]
    pub(super) fn hits(&mut self) -> StatusHits<'_> {
        StatusHits { merges: self.merges, slots: &mut self.slots }
    }

    /// A slot gets a new line.
    pub(super) fn fill(&mut self, slot: u32, filled: u64) {
        self.slots[slot as usize] = Slot { filled, merged: 0 };
    }

    /// The first clock from `clock` on with a free entry.
    pub(super) fn room(&mut self, clock: u64) -> u64 {
        self.release(clock);
        if self.held.len() < self.entries { clock } else { self.held[0] }
    }

    /// Takes an entry in `clock`, as [`Self::room`] allows, that can be taken again from `free` on.
    #[inline(always)]
    pub(super) fn hold(&mut self, clock: u64, free: u64) {
        self.release(clock);
        // Most lines come in order.
        if self.held.back().is_none_or(|&last| last <= free) {
            self.held.push_back(free);
        } else {
            let place = self.held.iter().rposition(|&earlier| earlier <= free).map_or(0, |before| before + 1);
            self.held.insert(place, free);
        }
        self.most = self.most.max(self.held.len());
        self.clocks += free - clock;
    }

    fn release(&mut self, clock: u64) {
        while self.held.front().is_some_and(|&free| free <= clock) {
            self.held.pop_front();
        }
    }

    /// Clocks of entries held, and the most held.
    pub(super) const fn usage(&self) -> (u64, u64) {
        (self.clocks, self.most as u64)
    }
}
