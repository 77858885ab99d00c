//! Reuse distances: a fully associative LRU cache of every size at once.

use alloc::{vec, vec::Vec};

use super::LineTable;

/// Counts, for every lookup, how many other lines were looked up since the last lookup of its line.
///
/// A Fenwick tree (1994) over time has a one at the last lookup of every line, so a distance is a sum over the time between, in
/// log2 of the number of lines (Bennett & Kruskal 1975; Olken 1981). Times are dealt out anew when they run out.
///
/// ```
/// use texunit_hw::sweep::ReuseDistances;
/// let mut reuse = ReuseDistances::default();
/// assert_eq!([5, 5, 7, 9, 5].map(|line| reuse.lookup(line)), [None, Some(0), None, None, Some(2)]);
/// assert_eq!(reuse.lines(), 3);
/// ```
#[derive(Clone, Debug, Default)]
pub struct ReuseDistances {
    lines: LineTable,
    /// When each line was last looked up.
    used: Vec<u32>,
    /// The tree: entry i sums the ones of the times i - lowest bit of i + 1 to i. Times start at 1.
    tree: Vec<u32>,
    now: u32,
    last: Option<u64>,
}

/// Fewest times dealt out at once.
const TIMES_MIN: usize = 1 << 10;

impl ReuseDistances {
    /// The number of different other lines since the last lookup of this line; `None` the first time.
    #[inline]
    pub fn lookup(&mut self, line: u64) -> Option<u64> {
        if self.last == Some(line) {
            return Some(0);
        }
        self.last = Some(line);
        let number = self.lines.number(line) as usize;
        if self.now as usize + 1 >= self.tree.len() {
            self.deal_times();
        }
        self.now += 1;
        let distance = if number < self.used.len() {
            let used = core::mem::replace(&mut self.used[number], self.now);
            // All lines have a one up to now; those up to its own last use are not between.
            let distance = self.used.len() as u32 - self.sum(used);
            self.add(used, -1);
            Some(distance.into())
        } else {
            self.used.push(self.now);
            None
        };
        self.add(self.now, 1);
        distance
    }

    /// Different lines looked up so far.
    #[must_use]
    pub fn lines(&self) -> u64 {
        self.lines.len() as u64
    }

    /// Ones at the times up to this.
    fn sum(&self, time: u32) -> u32 {
        let (mut sum, mut at) = (0, time as usize);
        while at > 0 {
            sum += self.tree[at];
            at &= at - 1;
        }
        sum
    }

    fn add(&mut self, time: u32, one: i32) {
        let mut at = time as usize;
        while at < self.tree.len() {
            self.tree[at] = self.tree[at].wrapping_add_signed(one);
            at += at & at.wrapping_neg();
        }
    }

    /// Numbers the last uses from 1 without gaps, with room for three times as many.
    #[cold]
    fn deal_times(&mut self) {
        let mut order: Vec<u32> = (0..self.used.len() as u32).collect();
        order.sort_unstable_by_key(|&number| self.used[number as usize]);
        for (time, number) in (1..).zip(order) {
            self.used[number as usize] = time;
        }
        self.now = self.used.len() as u32;
        self.tree = vec![0; (4 * self.used.len()).max(TIMES_MIN)];
        for time in 1..=self.now {
            self.add(time, 1);
        }
    }
}

/// How often each distance came up: exact up to [`Distances::EXACT`], then in steps of an eighth of a power of two.
///
/// ```
/// use texunit_hw::sweep::Distances;
/// let mut distances = Distances::default();
/// for distance in [None, Some(0), Some(3), Some(3)] {
///     distances.count(distance);
/// }
/// assert_eq!((distances.lookups(), distances.first()), (4, 1));
/// assert_eq!(distances.misses(3), 3); // three lines: the distances of 3 miss, and so does the first reference
/// assert_eq!(distances.misses(4), 1);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Distances {
    first: u64,
    counts: Vec<u64>,
}

impl Distances {
    /// Distances below this are counted one by one.
    pub const EXACT: u64 = 4096;
    /// Steps to a power of two above that.
    const STEPS: u64 = 8;

    /// Counts one lookup.
    #[inline]
    pub fn count(&mut self, distance: Option<u64>) {
        let Some(distance) = distance else {
            self.first += 1;
            return;
        };
        let place = Self::place(distance);
        if place >= self.counts.len() {
            self.counts.resize(place + 1, 0);
        }
        self.counts[place] += 1;
    }

    fn place(distance: u64) -> usize {
        if distance < Self::EXACT {
            return distance as usize;
        }
        let power = u64::from(distance.ilog2());
        let step = (distance >> (power - 3)) - Self::STEPS;
        (Self::EXACT + (power - u64::from(Self::EXACT.ilog2())) * Self::STEPS + step) as usize
    }

    /// The smallest distance counted at a place.
    fn distance(place: usize) -> u64 {
        let beyond = (place as u64).saturating_sub(Self::EXACT);
        if (place as u64) < Self::EXACT {
            return place as u64;
        }
        let power = u64::from(Self::EXACT.ilog2()) + beyond / Self::STEPS;
        (Self::STEPS + beyond % Self::STEPS) << (power - 3)
    }

    /// Lookups counted.
    #[must_use]
    pub fn lookups(&self) -> u64 {
        self.first + self.counts.iter().sum::<u64>()
    }

    /// Of those, first references.
    #[must_use]
    pub const fn first(&self) -> u64 {
        self.first
    }

    /// Misses of a fully associative LRU cache of so many lines: exact up to [`Distances::EXACT`] lines and at the steps beyond,
    /// in between those of the step below.
    #[must_use]
    pub fn misses(&self, lines: u64) -> u64 {
        let place = Self::place(lines).min(self.counts.len());
        self.first + self.counts[place..].iter().sum::<u64>()
    }

    /// Fewest lines of a fully associative LRU cache that misses in at most this share of the lookups that are not first
    /// references, in parts per thousand: the working set.
    #[must_use]
    pub fn working_set(&self, per_thousand: u64) -> u64 {
        let reused: u64 = self.counts.iter().sum();
        let mut left = reused;
        for (place, count) in self.counts.iter().enumerate() {
            if left * 1000 <= reused * per_thousand {
                return Self::distance(place);
            }
            left -= count;
        }
        Self::distance(self.counts.len())
    }

    /// Number of lines and misses of the curve's corners: powers of two and halfway between, up to where nothing but first
    /// references miss.
    pub fn curve(&self) -> impl Iterator<Item = (u64, u64)> {
        let end = Self::distance(self.counts.len());
        let sizes = (0..63).flat_map(|power| [1_u64 << power, 3 << power >> 1]).filter(|&lines| lines > 0);
        let mut previous = 0;
        sizes
            .filter(move |&lines| core::mem::replace(&mut previous, lines) != lines)
            .scan(false, move |done, lines| {
                if *done {
                    return None;
                }
                *done = lines >= end;
                Some(lines)
            })
            .map(|lines| (lines, self.misses(lines)))
    }
}
