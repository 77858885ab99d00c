//! All FIFO caches of a grid in one pass.

use alloc::{vec, vec::Vec};

use super::{Grid, LineTable, WAYS_MAX};
use crate::cache::GeometryError;

/// One bit for each number of ways up to the most there can be.
type WayBits = u16;

/// FIFO caches of every geometry of a [`Grid`].
///
/// FIFO caches of different sizes hold different lines (Belady, Nelson & Shedler 1969), so each is kept for itself. But a hit
/// changes nothing in any of them: every line carries one bit for each cache that holds it, and a lookup costs only as much
/// as there are caches it misses in.
///
/// ```
/// use texunit_hw::sweep::{FifoSweep, Grid};
/// let mut sweep = FifoSweep::new(Grid { log2_sets: 0, ways: 2, line: 64 })?;
/// sweep.access_all(&[0, 64, 0, 128, 0]);
/// assert_eq!(sweep.misses(0, 2), 4); // the hit did not keep line 0
/// # Ok::<(), texunit_hw::cache::GeometryError>(())
/// ```
#[derive(Clone, Debug)]
pub struct FifoSweep {
    grid: Grid,
    lines: LineTable,
    /// For each line and number of sets, which caches lack it, by ways: bit w - 1 for w ways.
    absent: Vec<WayBits>,
    /// What the ways hold: for each number of sets, each set, and each number of ways w, a ring of w.
    rings: Vec<[Ring; WAYS_MAX as usize]>,
    last: Option<u64>,
    lookups: u64,
    misses: Vec<[u64; WAYS_MAX as usize]>,
}

/// The ways of one set of one cache: the lines by number, and the one to leave next.
#[derive(Clone, Copy, Debug)]
struct Ring {
    lines: [u32; WAYS_MAX as usize],
    next: u32,
}

/// No line.
const EMPTY: u32 = u32::MAX;

impl FifoSweep {
    /// Empty caches.
    ///
    /// # Errors
    /// What [`Grid::check`] refuses.
    pub fn new(grid: Grid) -> Result<Self, GeometryError> {
        grid.check()?;
        let levels = grid.log2_sets as usize + 1;
        let ring = Ring { lines: [EMPTY; WAYS_MAX as usize], next: 0 };
        Ok(Self {
            grid,
            lines: LineTable::default(),
            absent: Vec::new(),
            rings: vec![[ring; WAYS_MAX as usize]; (1 << levels) - 1],
            last: None,
            lookups: 0,
            misses: vec![[0; WAYS_MAX as usize]; levels],
        })
    }

    /// Looks up the lines of byte addresses one after the other, in every cache.
    pub fn access_all(&mut self, addresses: &[u64]) {
        let shift = self.grid.line.trailing_zeros();
        self.lookups += addresses.len() as u64;
        for &address in addresses {
            let line = address >> shift;
            if self.last != Some(line) {
                self.last = Some(line);
                self.access(line);
            }
        }
    }

    #[inline]
    fn access(&mut self, line: u64) {
        let levels = self.misses.len();
        let every_way = WayBits::MAX >> (WAYS_MAX - self.grid.ways);
        let number = self.lines.number(line) as usize;
        if number * levels == self.absent.len() {
            self.absent.resize(self.absent.len() + levels, every_way);
        }
        let mut mask = 0;
        for level in 0..levels {
            let set = (mask + (line & mask)) as usize;
            mask = mask << 1 | 1;
            let mut absent = core::mem::take(&mut self.absent[number * levels + level]);
            while absent != 0 {
                let cache = absent.trailing_zeros() as usize;
                absent &= absent - 1;
                self.misses[level][cache] += 1;
                let ring = &mut self.rings[set][cache];
                let way = ring.next as usize;
                ring.next = if way == cache { 0 } else { ring.next + 1 };
                let leaving = core::mem::replace(&mut ring.lines[way], number as u32);
                if leaving != EMPTY {
                    self.absent[leaving as usize * levels + level] |= 1 << cache;
                }
            }
        }
    }

    /// The caches.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// Lookups so far, the same in every cache.
    #[must_use]
    pub const fn lookups(&self) -> u64 {
        self.lookups
    }

    /// Misses so far of the cache of 2^`log2_sets` sets of `ways` ways.
    ///
    /// # Panics
    /// If it is not in the grid.
    #[must_use]
    pub fn misses(&self, log2_sets: u32, ways: u32) -> u64 {
        assert!((1..=self.grid.ways).contains(&ways), "not in the grid");
        self.misses[log2_sets as usize][ways as usize - 1]
    }
}
