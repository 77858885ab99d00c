//! The fully associative LRU cache that a real cache is compared with.

use alloc::{vec, vec::Vec};

use super::line_index::LineIndex;

/// No slot, no place.
const NONE: u32 = u32::MAX;

/// A fully associative LRU cache with as many lines as the real one and shown the same lookups.
///
/// Keeping a list of its lines in order of use costs more than the real cache itself. But nobody looks at that order until a
/// line must leave. So a use only writes the line's place at the end of a log, and its index in the log at the place. When a victim is
/// wanted, the log is read on from where it was left: an entry counts if the place still has its index, else the line was used
/// since. Every entry is read once; when the log is full, what no longer counts is dropped.
#[derive(Clone, Debug)]
pub(super) struct Shadow {
    /// Places as they were used.
    log: Vec<u32>,
    /// Where the next entry goes, and the first that has not been read.
    next: usize,
    first: usize,
    /// For each slot of the real cache the place of its line, or `NONE` where that has been thrown out here but not there.
    slots: Vec<u32>,
    /// Lines of this cache by place, where the log has their last use, and the slots of the real cache they are in, or `NONE`.
    lines: Vec<u64>,
    used: Vec<u32>,
    slot_of: Vec<u32>,
    index: LineIndex,
    /// Places filled, the lowest ones.
    filled: usize,
}

impl Shadow {
    pub(super) fn new(lines: usize) -> Self {
        Self {
            // Long enough that dropping, which costs as much as there are lines, is rare; short enough for the host's cache.
            log: vec![NONE; (8 * lines).max(64)],
            next: 0,
            first: 0,
            slots: vec![NONE; lines],
            lines: vec![0; lines],
            used: vec![NONE; lines],
            slot_of: vec![NONE; lines],
            index: LineIndex::new(lines),
            filled: 0,
        }
    }

    /// The real cache hit in this slot.
    #[inline(always)]
    pub(super) fn hit(&mut self, line: u64, slot: usize) {
        match self.slots[slot] {
            NONE => self.fill(line, slot),
            place => self.touch(place),
        }
    }

    /// The real cache missed and has put the line into this slot; the answer is whether it is here.
    #[inline(always)]
    pub(super) fn miss(&mut self, line: u64, slot: usize) -> bool {
        if let Some(slot) = self.slot_of.get_mut(self.slots[slot] as usize) {
            *slot = NONE;
        }
        let here = self.index.find(line, &self.lines);
        match here {
            Some(place) => self.link(place, slot),
            None => self.fill(line, slot),
        }
        here.is_some()
    }

    /// Notes the use of a line.
    #[inline(always)]
    fn touch(&mut self, place: u32) {
        if self.next == self.log.len() {
            self.drop_used();
        }
        if let (Some(entry), Some(used)) = (self.log.get_mut(self.next), self.used.get_mut(place as usize)) {
            (*entry, *used) = (place, self.next as u32);
            self.next += 1;
        }
    }

    /// Notes the use of a line that the real cache has in `slot`.
    #[inline(always)]
    fn link(&mut self, place: u32, slot: usize) {
        self.slots[slot] = place;
        self.slot_of[place as usize] = slot as u32;
        self.touch(place);
    }

    /// Brings in a line that the real cache has in `slot`.
    #[inline(never)]
    fn fill(&mut self, line: u64, slot: usize) {
        let place = if self.filled < self.lines.len() {
            self.filled += 1;
            self.filled as u32 - 1
        } else {
            let place = self.oldest();
            self.index.remove(self.lines[place as usize], place);
            if let Some(place) = self.slots.get_mut(self.slot_of[place as usize] as usize) {
                *place = NONE;
            }
            place
        };
        self.lines[place as usize] = line;
        self.index.insert(line, place);
        self.link(place, slot);
    }

    /// The place of the line not used for longest, which there is.
    #[inline(always)]
    fn oldest(&mut self) -> u32 {
        loop {
            let place = self.log[self.first];
            self.first += 1;
            if self.used[place as usize] as usize == self.first - 1 {
                return place;
            }
        }
    }

    /// Drops what does not count from a full log.
    #[cold]
    fn drop_used(&mut self) {
        let mut kept = 0;
        for number in self.first..self.log.len() {
            let place = self.log[number];
            let Some(used) = self.used.get_mut(place as usize) else { continue };
            if *used as usize == number {
                *used = kept as u32;
                self.log[kept] = place;
                kept += 1;
            }
        }
        (self.first, self.next) = (0, kept);
    }
}
