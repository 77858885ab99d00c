//! Many caches in one pass over the addresses, each exactly as if it had run alone: what a sweep of geometries needs.
//!
//! LRU caches share their contents (Mattson, Gecsei, Slutz & Traiger 1970; Hill & Smith 1989, all-associativity simulation), FIFO
//! caches do not, and a fully associative LRU cache of every size at once is a curve of reuse distances.

mod fifo;
mod line_table;
mod lru;
mod reuse;

pub use fifo::FifoSweep;
pub use line_table::LineTable;
pub use lru::LruSweep;
pub use reuse::{Distances, ReuseDistances};

use crate::cache::GeometryError;

/// Most ways of a sweep.
pub const WAYS_MAX: u32 = 16;

/// Most sets of a sweep, as a power of two.
pub const LOG2_SETS_MAX: u32 = 16;

/// The caches of a sweep: 1, 2, 4 ... `2^log2_sets` sets times 1, 2, 3 ... `ways` ways.
///
/// ```
/// use texunit_hw::sweep::Grid;
/// let grid = Grid { log2_sets: 10, ways: 16, line: 64 };
/// assert_eq!(grid.check(), Ok(()));
/// assert_eq!(grid.geometries().count(), 176);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Grid {
    /// Largest number of sets is 2 to this, 0 to 16.
    pub log2_sets: u32,
    /// Largest number of ways, 1 to 16.
    pub ways: u32,
    /// Bytes of a line, a power of two from 2 to 4096.
    pub line: u32,
}

impl Grid {
    /// Whether one pass can simulate it.
    ///
    /// # Errors
    /// The first setting that stands in the way, with the remedy.
    pub fn check(&self) -> Result<(), GeometryError> {
        let refuse = |key, value, problem, remedy| Err(GeometryError { key, value, problem, remedy });
        if self.log2_sets > LOG2_SETS_MAX {
            return refuse("log2_sets", self.log2_sets, "too many sets for one pass", "give 0 to 16");
        }
        if self.ways == 0 || self.ways > WAYS_MAX {
            return refuse("ways", self.ways, "not in one pass", "give 1 to 16");
        }
        // With lines of one byte every u64 is a line, and none is left to stand for an empty way.
        if !self.line.is_power_of_two() || !(2..=4096).contains(&self.line) {
            return refuse("line", self.line, "not a line size of a sweep", "give a power of two from 2 to 4096 bytes");
        }
        Ok(())
    }

    /// Sets and ways of every cache, fewer sets first.
    pub fn geometries(self) -> impl Iterator<Item = crate::cache::Geometry> {
        (0..=self.log2_sets).flat_map(move |log2| {
            (1..=self.ways).map(move |ways| crate::cache::Geometry { sets: 1 << log2, ways, line: self.line })
        })
    }
}
