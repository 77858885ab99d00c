//! The fully associative LRU cache that a real cache is compared with.

use alloc::{vec, vec::Vec};

use super::line_index::LineIndex;
use crate::lanes::UseLanes;

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
    uses: Uses,
    /// For each slot of the real cache the place of its line, or `NONE` where that has been thrown out here but not there.
    slots: Vec<u32>,
    /// Lines of this cache by place, and the slots of the real cache they are in, or `NONE`.
    lines: Vec<u64>,
    slot_of: Vec<u32>,
    index: LineIndex,
    /// Places filled, the lowest ones.
    filled: usize,
}

/// The log of uses.
#[derive(Clone, Debug)]
struct Uses {
    /// Places as they were used.
    log: Vec<u32>,
    /// For each place where the log has its last use.
    last: Vec<u32>,
    /// Where the next entry goes, and the first that has not been read.
    next: usize,
    first: usize,
}

/// Hits of lines that are here as well, one after the other, for as long as the log has room.
pub(super) struct Hits<'a> {
    log: &'a mut [u32],
    last: &'a mut [u32],
    slots: &'a [u32],
    next: usize,
    /// Where that comes back to.
    back: &'a mut usize,
}

impl Hits<'_> {
    /// The real cache hit in this slot; false if this is to be told to [`Shadow::hit`].
    #[inline(always)]
    pub(super) fn hit(&mut self, slot: usize) -> bool {
        let place = self.slots[slot];
        // A place that is none has no last use.
        let (Some(entry), Some(last)) = (self.log.get_mut(self.next), self.last.get_mut(place as usize)) else {
            return false;
        };
        (*entry, *last) = (place, self.next as u32);
        self.next += 1;
        true
    }

    /// That was the last one.
    #[inline(always)]
    pub(super) fn close(self) {
        *self.back = self.next;
    }
}

impl Shadow {
    pub(super) fn new(lines: usize) -> Self {
        Self {
            // Long enough that dropping, which costs as much as there are lines, is rare; short enough for the host's cache.
            uses: Uses { log: vec![NONE; (8 * lines).max(64)], last: vec![NONE; lines], next: 0, first: 0 },
            slots: vec![NONE; lines],
            lines: vec![0; lines],
            slot_of: vec![NONE; lines],
            index: LineIndex::new(lines),
            filled: 0,
        }
    }

    /// For hits that are likely to follow.
    #[inline(always)]
    pub(super) fn hits(&mut self) -> Hits<'_> {
        let Uses { log, last, next, .. } = &mut self.uses;
        Hits { log, last, slots: &self.slots, next: *next, back: next }
    }

    /// The real cache hit in this slot.
    #[inline(always)]
    pub(super) fn hit(&mut self, line: u64, slot: usize) {
        match self.slots[slot] {
            NONE => self.fill(line, slot),
            place => self.uses.touch(place),
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

    /// Notes the use of a line that the real cache has in `slot`.
    #[inline(always)]
    fn link(&mut self, place: u32, slot: usize) {
        self.slots[slot] = place;
        self.slot_of[place as usize] = slot as u32;
        self.uses.touch(place);
    }

    /// Brings in a line that the real cache has in `slot`.
    #[inline(never)]
    fn fill(&mut self, line: u64, slot: usize) {
        let place = if self.filled < self.lines.len() {
            self.filled += 1;
            self.filled as u32 - 1
        } else {
            let place = self.uses.oldest();
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
}

impl Uses {
    /// Notes the use of a place.
    #[inline(always)]
    fn touch(&mut self, place: u32) {
        if self.next == self.log.len() {
            self.drop_former();
        }
        if let (Some(entry), Some(last)) = (self.log.get_mut(self.next), self.last.get_mut(place as usize)) {
            (*entry, *last) = (place, self.next as u32);
            self.next += 1;
        }
    }

    /// The place not used for longest, of which there is one.
    #[inline(always)]
    fn oldest(&mut self) -> u32 {
        loop {
            let place = self.log[self.first];
            self.first += 1;
            if self.last[place as usize] as usize == self.first - 1 {
                return place;
            }
        }
    }

    /// Drops uses that were not the last of their place from a full log.
    #[cold]
    fn drop_former(&mut self) {
        let Self { log, last, .. } = self;
        let lanes = UseLanes::detect();
        let (mut kept, rest) = lanes.map_or((0, self.first), |lanes| lanes.move_last(log, self.first, last));
        for number in rest..log.len() {
            let place = log[number];
            // Written in any case: whether it stays is not to be guessed.
            log[kept] = place;
            kept += usize::from(last[place as usize] as usize == number);
        }
        for (number, &place) in log[..kept].iter().enumerate() {
            last[place as usize] = number as u32;
        }
        (self.first, self.next) = (0, kept);
    }
}
