//! Which lines were ever asked for: a set of line numbers that only grows.

use alloc::{boxed::Box, collections::BTreeMap};

use bitvec::{array::BitArray, order::Lsb0, vec::BitVec};

/// A set of line numbers. Low numbers, where texture memory lies, are one bit each in a map as long as the largest of them;
/// the rest of the 64-bit space is kept in pages made when first needed.
///
/// ```
/// use texunit_hw::cache::LineSet;
/// let mut seen = LineSet::default();
/// assert!(seen.insert(7));
/// assert!(!seen.insert(7));
/// assert!(seen.insert(u64::MAX));
/// ```
#[derive(Clone, Debug, Default)]
pub struct LineSet {
    low: BitVec<u64, Lsb0>,
    high: BTreeMap<u64, Box<Page>>,
}

type Page = BitArray<[u64; PAGE_WORDS], Lsb0>;
const PAGE_WORDS: usize = 8;
const PAGE_LINES: u64 = 64 * PAGE_WORDS as u64;
/// Numbers below this are in the map: at most 2 MiB of it, a gigabyte of textures in lines of 64 bytes.
const LOW_LINES: u64 = 1 << 24;

impl LineSet {
    /// Adds a line; the answer is whether it is new.
    pub fn insert(&mut self, line: u64) -> bool {
        if line < LOW_LINES {
            let line = line as usize;
            if line >= self.low.len() {
                self.low.resize((line + 1).next_power_of_two().max(PAGE_LINES as usize), false);
            }
            !self.low.replace(line, true)
        } else {
            let page = self.high.entry(line / PAGE_LINES).or_insert_with(|| Box::new(Page::ZERO));
            !page.replace((line % PAGE_LINES) as usize, true)
        }
    }
}
