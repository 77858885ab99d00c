//! Replacement: what each policy remembers of a set, and whom it gives up.

use alloc::{vec, vec::Vec};

/// What a set remembers to choose a victim. `hit` may be skipped for the way touched last in the set.
pub(super) trait Replacement {
    /// A line was found in `way`.
    fn hit(&mut self, set: usize, way: usize);
    /// A line was put into `way`, which was empty; ways below it are full.
    fn fill(&mut self, set: usize, way: usize);
    /// The set is full: chooses a way and takes note of its new line.
    fn replace(&mut self, set: usize) -> usize;
}

/// LRU of any number of ways: a ring through the slots of each set, from the newest to ever older lines and back.
#[derive(Clone, Debug)]
pub(super) struct RecencyList {
    ways: usize,
    newest: Vec<u32>,
    ring: Vec<Neighbours>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Neighbours {
    newer: u32,
    older: u32,
}

impl RecencyList {
    pub(super) fn new(sets: usize, ways: usize) -> Self {
        Self { ways, newest: vec![0; sets], ring: vec![Neighbours::default(); sets * ways] }
    }

    /// Puts a slot that is in no ring between the newest and the oldest.
    #[inline(always)]
    fn insert(&mut self, set: usize, slot: u32) {
        let newest = self.newest[set];
        let oldest = self.ring[newest as usize].newer;
        self.ring[slot as usize] = Neighbours { newer: oldest, older: newest };
        self.ring[newest as usize].newer = slot;
        self.ring[oldest as usize].older = slot;
        self.newest[set] = slot;
    }
}

impl Replacement for RecencyList {
    #[inline(always)]
    fn hit(&mut self, set: usize, way: usize) {
        let slot = (set * self.ways + way) as u32;
        let Neighbours { newer, older } = self.ring[slot as usize];
        self.ring[newer as usize].older = older;
        self.ring[older as usize].newer = newer;
        self.insert(set, slot);
    }

    #[inline(always)]
    fn fill(&mut self, set: usize, way: usize) {
        let slot = (set * self.ways + way) as u32;
        if way == 0 {
            self.ring[slot as usize] = Neighbours { newer: slot, older: slot };
            self.newest[set] = slot;
        } else {
            self.insert(set, slot);
        }
    }

    #[inline(always)]
    fn replace(&mut self, set: usize) -> usize {
        // The oldest becomes the newest where it stands: the ring turns.
        let slot = self.ring[self.newest[set] as usize].newer;
        self.newest[set] = slot;
        slot as usize - set * self.ways
    }
}

/// FIFO: ways are filled in turn, so one counter a set is enough.
#[derive(Clone, Debug)]
pub(super) struct FillOrder {
    ways: u32,
    next: Vec<u32>,
}

impl FillOrder {
    pub(super) fn new(sets: usize, ways: usize) -> Self {
        Self { ways: ways as u32, next: vec![0; sets] }
    }
}

impl Replacement for FillOrder {
    #[inline(always)]
    fn hit(&mut self, _: usize, _: usize) {}

    #[inline(always)]
    fn fill(&mut self, _: usize, _: usize) {}

    #[inline(always)]
    fn replace(&mut self, set: usize) -> usize {
        let way = self.next[set];
        self.next[set] = if way + 1 == self.ways { 0 } else { way + 1 };
        way as usize
    }
}

/// Tree pseudo-LRU. The nodes of a set are numbered like a heap: 1 is the root, `2 n` and `2 n + 1` are below `n`.
#[derive(Clone, Debug)]
pub(super) struct TreeBits {
    ways: usize,
    levels: u32,
    words: usize,
    bits: Vec<u64>,
}

impl TreeBits {
    pub(super) fn new(sets: usize, ways: usize) -> Self {
        let leaves = ways.next_power_of_two();
        let words = leaves.div_ceil(64);
        Self { ways, levels: leaves.trailing_zeros(), words, bits: vec![0; sets * words] }
    }
}

impl Replacement for TreeBits {
    #[inline(always)]
    fn hit(&mut self, set: usize, way: usize) {
        let tree = &mut self.bits[set * self.words..(set + 1) * self.words];
        let leaf = 1 << self.levels | way;
        for level in 1..=self.levels {
            let node = leaf >> level;
            let upper = (leaf >> (level - 1) & 1) as u64;
            let word = &mut tree[node / 64];
            *word = *word & !(1 << (node % 64)) | (upper ^ 1) << (node % 64);
        }
    }

    #[inline(always)]
    fn fill(&mut self, set: usize, way: usize) {
        self.hit(set, way);
    }

    #[inline(always)]
    fn replace(&mut self, set: usize) -> usize {
        let tree = &self.bits[set * self.words..(set + 1) * self.words];
        let mut node = 1;
        for level in (0..self.levels).rev() {
            let upper = (tree[node / 64] >> (node % 64) & 1) as usize;
            let first_of_upper = ((2 * node + 1) << level) - (1 << self.levels);
            node = 2 * node + if first_of_upper < self.ways { upper } else { 0 };
        }
        let way = node - (1 << self.levels);
        self.hit(set, way);
        way
    }
}

/// Random replacement by splitmix64 (Steele, Lea, Flood, OOPSLA 2014).
#[derive(Clone, Debug)]
pub(super) struct Splitmix {
    ways: u64,
    state: u64,
}

impl Splitmix {
    pub(super) fn new(seed: u64, ways: usize) -> Self {
        Self { ways: ways as u64, state: seed }
    }
}

impl Replacement for Splitmix {
    #[inline(always)]
    fn hit(&mut self, _: usize, _: usize) {}

    #[inline(always)]
    fn fill(&mut self, _: usize, _: usize) {}

    #[inline(always)]
    fn replace(&mut self, _: usize) -> usize {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^= mixed >> 31;
        ((u128::from(mixed) * u128::from(self.ways)) >> 64) as usize
    }
}
