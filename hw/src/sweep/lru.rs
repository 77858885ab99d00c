//! All LRU caches of a grid in one pass.

use alloc::{vec, vec::Vec};

use super::{Grid, WAYS_MAX};
use crate::cache::GeometryError;

const WAYS: usize = WAYS_MAX as usize;

/// LRU caches of every geometry of a [`Grid`].
///
/// An LRU set of many ways holds what one of fewer ways holds, so one list of lines in order of use serves every number of ways:
/// a lookup at depth d hits where there are more than d ways. There is one list per set and number of sets (Hill & Smith 1989).
/// Three facts save most of the work:
///
/// * The line looked up last is the first of its list for every number of sets: nothing moves.
/// * A line that is first in its list stays first where the sets are finer, for those sets hold fewer other lines: from
///   there on nothing moves either.
/// * Two lines looked up in turns (the halves of a footprint that straddles tiles, the two levels of trilinear) only swap the
///   first two places of the lists they share, those of up to as many sets as their numbers have low bits in common. The swap
///   is put off until a third line comes: an even number of swaps is none.
///
/// ```
/// use texunit_hw::sweep::{Grid, LruSweep};
/// let mut sweep = LruSweep::new(Grid { log2_sets: 1, ways: 2, line: 64 })?;
/// sweep.access_all(&[0, 128, 0, 64]);
/// assert_eq!(sweep.misses(0, 1), 4);
/// assert_eq!(sweep.misses(0, 2), 3); // one set of two ways keeps line 0
/// assert_eq!(sweep.misses(1, 1), 4); // lines 0 and 2 share a set
/// # Ok::<(), texunit_hw::cache::GeometryError>(())
/// ```
#[derive(Clone, Debug)]
pub struct LruSweep {
    grid: Grid,
    lists: Lists,
    lookups: u64,
    /// Lookups found at each depth of the lists of each number of sets; the last place counts those not found. What was not
    /// even looked for, because it had to be first, is not in here.
    found: Vec<[u64; WAYS + 1]>,
    /// Turns of two lines by the number of low bits their line numbers share, up to all that choose a set.
    turns: Vec<u64>,
}

/// Line numbers take 32 bits until one needs more.
#[derive(Clone, Debug)]
enum Lists {
    Narrow(Recency<u32>),
    Wide(Recency<u64>),
}

/// The lists of lines in order of use.
#[derive(Clone, Debug)]
struct Recency<T> {
    /// Those of one set first, then those of two sets, and so on: set s of 2^k is number 2^k - 1 + s.
    lists: Vec<[T; WAYS]>,
    /// The line looked up last, and the one looked up last before that; the lists have them the other way round if `swapped`.
    last: T,
    before: T,
    swapped: bool,
}

/// A line number in few or many bits.
trait Tag: Copy + Eq {
    /// No line.
    const EMPTY: Self;
    fn number(self) -> u64;
    fn of(line: u64) -> Self;
}

impl Tag for u32 {
    const EMPTY: Self = Self::MAX;
    fn number(self) -> u64 {
        self.into()
    }
    fn of(line: u64) -> Self {
        line as Self
    }
}

impl Tag for u64 {
    const EMPTY: Self = Self::MAX;
    fn number(self) -> u64 {
        self
    }
    fn of(line: u64) -> Self {
        line
    }
}

impl LruSweep {
    /// Empty caches.
    ///
    /// # Errors
    /// What [`Grid::check`] refuses.
    pub fn new(grid: Grid) -> Result<Self, GeometryError> {
        grid.check()?;
        let levels = grid.log2_sets as usize + 1;
        Ok(Self {
            grid,
            lists: Lists::Narrow(Recency::new(levels)),
            lookups: 0,
            found: vec![[0; WAYS + 1]; levels],
            turns: vec![0; levels],
        })
    }

    /// Looks up the lines of byte addresses one after the other, in every cache.
    pub fn access_all(&mut self, addresses: &[u64]) {
        let shift = self.grid.line.trailing_zeros();
        self.lookups += addresses.len() as u64;
        if let Lists::Narrow(recency) = &mut self.lists {
            let all = addresses.iter().fold(0, |all, address| all | address);
            if all >> shift < u64::from(u32::EMPTY) {
                recency.run(addresses, shift, &mut self.found, &mut self.turns);
                return;
            }
            self.lists = Lists::Wide(recency.widen());
        }
        if let Lists::Wide(recency) = &mut self.lists {
            recency.run(addresses, shift, &mut self.found, &mut self.turns);
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
        assert!((1..=self.grid.ways).contains(&ways) && log2_sets <= self.grid.log2_sets, "not in the grid");
        let found: u64 = self.found[log2_sets as usize][ways as usize..].iter().sum();
        // The other of two lines that share the set is second in its list: a miss where there is one way.
        let turns: u64 = if ways == 1 { self.turns[log2_sets as usize..].iter().sum() } else { 0 };
        found + turns
    }
}

impl<T: Tag> Recency<T> {
    fn new(levels: usize) -> Self {
        let lists = vec![[T::EMPTY; WAYS]; (1 << levels) - 1];
        Self { lists, last: T::EMPTY, before: T::EMPTY, swapped: false }
    }

    /// Few bits turned into many.
    fn widen(&self) -> Recency<u64> {
        let wide = |tag: T| if tag == T::EMPTY { u64::EMPTY } else { tag.number() };
        Recency {
            lists: self.lists.iter().map(|list| list.map(wide)).collect(),
            last: wide(self.last),
            before: wide(self.before),
            swapped: self.swapped,
        }
    }

    fn run(&mut self, addresses: &[u64], shift: u32, found: &mut [[u64; WAYS + 1]], turns: &mut [u64]) {
        let finest = found.len() as u32 - 1;
        let (mut last, mut before, mut swapped) = (self.last, self.before, self.swapped);
        for &address in addresses {
            let line = T::of(address >> shift);
            if line == last {
                continue;
            }
            if line == before {
                let shared = (last.number() ^ line.number()).trailing_zeros().min(finest);
                turns[shared as usize] += 1;
                swapped = !swapped;
            } else {
                if swapped {
                    swap(&mut self.lists, last.number(), before.number(), finest);
                    swapped = false;
                }
                find(&mut self.lists, line, found);
            }
            (before, last) = (last, line);
        }
        (self.last, self.before, self.swapped) = (last, before, swapped);
    }
}

/// Carries out a turn of two lines: they change places at the front of every list that holds both.
#[inline]
fn swap<T: Tag>(lists: &mut [[T; WAYS]], one: u64, other: u64, finest: u32) {
    let shared = (one ^ other).trailing_zeros().min(finest);
    for level in 0..=shared {
        let sets = 1_u64 << level;
        let list = &mut lists[(sets - 1 + (one & (sets - 1))) as usize];
        (list[0], list[1]) = (list[1], list[0]);
    }
}

/// Looks for a line from the one set to the many, moving it to the front, up to where it is at the front.
#[inline(always)]
fn find<T: Tag>(lists: &mut [[T; WAYS]], line: T, found: &mut [[u64; WAYS + 1]]) {
    let (number, mut mask) = (line.number(), 0);
    for found in found {
        let list = &mut lists[(mask + (number & mask)) as usize];
        mask = mask << 1 | 1;
        let mut carried = list[0];
        if carried == line {
            return;
        }
        let mut depth = 1;
        while depth < WAYS {
            let next = core::mem::replace(&mut list[depth], carried);
            if next == line {
                break;
            }
            carried = next;
            depth += 1;
        }
        list[0] = line;
        found[depth] += 1;
    }
}
