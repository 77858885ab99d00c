//! Where is a line? A hash table from line number to slot, for caches whose sets are too wide to search.

use alloc::{vec, vec::Vec};

/// Separate chaining through the slots. The line numbers themselves stay in the tag memory, which every call is handed.
#[derive(Clone, Debug)]
pub(super) struct LineIndex {
    /// First slot of each chain, plus 1; 0 ends a chain. Four chains a line: few chains hold two.
    heads: Vec<u32>,
    /// What follows each slot.
    next: Vec<u32>,
    shift: u32,
}

impl LineIndex {
    /// An index for up to `lines` lines.
    pub(super) fn new(lines: usize) -> Self {
        let chains = (lines * 4).next_power_of_two();
        Self { heads: vec![0; chains], next: vec![0; lines], shift: 64 - chains.trailing_zeros() }
    }

    /// Multiplicative hashing by the golden ratio: neighbouring lines never meet.
    #[inline(always)]
    fn chain(&self, line: u64) -> usize {
        (line.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> self.shift) as usize
    }

    /// The slot of a line.
    #[inline(always)]
    pub(super) fn find(&self, line: u64, lines: &[u64]) -> Option<u32> {
        let mut at = self.heads[self.chain(line)];
        loop {
            let slot = at.checked_sub(1)?;
            if lines[slot as usize] == line {
                return Some(slot);
            }
            at = self.next[slot as usize];
        }
    }

    /// Adds a line that is not there yet.
    #[inline(always)]
    pub(super) fn insert(&mut self, line: u64, slot: u32) {
        let chain = self.chain(line);
        self.next[slot as usize] = core::mem::replace(&mut self.heads[chain], slot + 1);
    }

    /// Removes the line in `slot`, where it is.
    #[inline(always)]
    pub(super) fn remove(&mut self, line: u64, slot: u32) {
        let chain = self.chain(line);
        let follows = self.next[slot as usize];
        if self.heads[chain] == slot + 1 {
            self.heads[chain] = follows;
            return;
        }
        let mut before = self.heads[chain] as usize - 1;
        while self.next[before] != slot + 1 {
            before = self.next[before] as usize - 1;
        }
        self.next[before] = follows;
    }
}
