//! The fully associative LRU cache that a real cache is compared with.

use alloc::{vec, vec::Vec};

use super::line_index::LineIndex;

/// No slot, no place.
const NONE: u32 = u32::MAX;

/// A fully associative LRU cache with as many lines as the real one and shown the same lookups.
///
/// Keeping a list of its lines in order of use costs more than the real cache itself. But nobody looks at that order until a
/// line must leave. So a hit in the real cache only notes the time, in the slot where the real cache holds the line, and
/// lines are sorted by it when a victim is wanted and the last sorting is used up. Lines of that sorting that were used since
/// are skipped: they are newer than all that were not. Every line in a sorting takes at least one lookup to use up,
/// so the cost per lookup is at most that of sorting one line, log2(lines) steps.
#[derive(Clone, Debug)]
pub(super) struct Shadow {
    /// Lookups so far: the time.
    now: u64,
    /// For each slot of the real cache, what is known of its line.
    slots: Vec<Slot>,
    /// Lines of this cache by place.
    lines: Vec<u64>,
    /// What is known of them.
    places: Vec<Place>,
    index: LineIndex,
    /// Places filled, the lowest ones.
    filled: usize,
    /// Time of use and place, from old to new, as they were at the last sorting.
    sorted: Vec<(u64, u32)>,
    /// How many of these are used up.
    used_up: usize,
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    /// When its line was last used.
    used: u64,
    /// Where the line is here; `NONE` where it has been thrown out here but not there.
    place: u32,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    /// When its line was last used, if the real cache has it no more.
    used: u64,
    /// Where the real cache has it, or `NONE`.
    slot: u32,
}

impl Shadow {
    pub(super) fn new(lines: usize) -> Self {
        Self {
            now: 0,
            slots: vec![Slot { used: 0, place: NONE }; lines],
            lines: vec![0; lines],
            places: vec![Place { used: 0, slot: NONE }; lines],
            index: LineIndex::new(lines),
            filled: 0,
            sorted: Vec::new(),
            used_up: 0,
        }
    }

    /// The real cache hit in this slot.
    #[inline(always)]
    pub(super) fn hit(&mut self, line: u64, slot: usize) {
        self.now += 1;
        let state = &mut self.slots[slot];
        state.used = self.now;
        if state.place == NONE {
            self.fill(line, slot);
        }
    }

    /// The real cache missed and has put the line into this slot; the answer is whether it is here.
    #[inline(always)]
    pub(super) fn miss(&mut self, line: u64, slot: usize) -> bool {
        self.now += 1;
        let former = self.slots[slot];
        if let Some(place) = self.places.get_mut(former.place as usize) {
            *place = Place { used: former.used, slot: NONE };
        }
        self.slots[slot].used = self.now;
        let here = self.index.find(line, &self.lines);
        match here {
            Some(place) => self.link(place, slot),
            None => self.fill(line, slot),
        }
        here.is_some()
    }

    #[inline(always)]
    fn link(&mut self, place: u32, slot: usize) {
        self.slots[slot].place = place;
        self.places[place as usize].slot = slot as u32;
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
            if let Some(slot) = self.slots.get_mut(self.places[place as usize].slot as usize) {
                slot.place = NONE;
            }
            place
        };
        self.lines[place as usize] = line;
        self.index.insert(line, place);
        self.link(place, slot);
    }

    #[inline(always)]
    fn used(&self, place: u32) -> u64 {
        let Place { used, slot } = self.places[place as usize];
        self.slots.get(slot as usize).map_or(used, |slot| slot.used)
    }

    /// The place of the line not used for longest.
    #[inline(always)]
    fn oldest(&mut self) -> u32 {
        loop {
            while let Some(&(used, place)) = self.sorted.get(self.used_up) {
                self.used_up += 1;
                if self.used(place) == used {
                    return place;
                }
            }
            self.sort();
        }
    }

    #[cold]
    fn sort(&mut self) {
        let mut sorted = core::mem::take(&mut self.sorted);
        sorted.clear();
        sorted.extend((0..self.lines.len() as u32).map(|place| (self.used(place), place)));
        sorted.sort_unstable();
        (self.sorted, self.used_up) = (sorted, 0);
    }
}
