//! The texel cache: any number of sets and ways, exact to the lookup. It holds tags only; what a line would contain is the
//! business of whoever asks.
//!
//! A line lives in set `line number modulo sets`. Ways that hold nothing are filled first, the lowest way first; what a
//! full set gives up is the [`Policy`]'s choice. Lookups are counted one by one in the order they arrive: no merging of
//! equal neighbours, no ports, no time.

mod changes;
mod counters;
mod first_reference;
mod line_index;
mod line_use;
mod miss_class;
mod recency_tags;
mod replacement;
mod shadow;
mod tags;
mod texel_cache;
mod watches;

pub use counters::{Counters, PlaneCounters};
pub use first_reference::LineSet;
pub use line_use::LineUse;
use line_use::Marks;
pub use miss_class::{MissClass, MissClasses, MissClassifier};
pub use texel_cache::{Detail, TexelCache};

use crate::lanes::ChangeLanes;
use changes::Changes;
use recency_tags::RecencyTags;
use replacement::{FillOrder, RecencyList, Splitmix, TreeBits};
use shadow::Hits as ShadowHits;
use tags::Tags;

/// Shape of a cache.
///
/// ```
/// use texunit_hw::cache::Geometry;
/// let vortex = Geometry { sets: 64, ways: 2, line: 64 };
/// assert_eq!(vortex.check(), Ok(()));
/// assert_eq!(vortex.size_bytes(), 8192);
/// assert!(Geometry { line: 48, ..vortex }.check().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Geometry {
    /// Number of sets, at least 1, a power of two or not.
    pub sets: u32,
    /// Lines per set, at least 1, a power of two or not.
    pub ways: u32,
    /// Bytes per line: a power of two, 1 to 4096.
    pub line: u32,
}

/// A cache that cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GeometryError {
    /// The setting at fault: `sets`, `ways`, `line` or `texel`.
    pub key: &'static str,
    /// Its value.
    pub value: u32,
    /// What is wrong with it.
    pub problem: &'static str,
    /// What would be right.
    pub remedy: &'static str,
}

impl core::fmt::Display for GeometryError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} = {}: {} ({})", self.key, self.value, self.problem, self.remedy)
    }
}

impl core::error::Error for GeometryError {}

impl Geometry {
    /// Largest line, in bytes.
    pub const LINE_MAX: u32 = 4096;
    /// Largest number of lines: slots are kept in 32 bits, and the tags alone of this many take 2 GiB.
    pub const LINES_MAX: u64 = 1 << 28;

    /// Whether a cache of this shape can be built.
    ///
    /// # Errors
    /// The first setting that stands in the way, with the remedy.
    pub fn check(&self) -> Result<(), GeometryError> {
        let refuse = |key, value, problem, remedy| Err(GeometryError { key, value, problem, remedy });
        if self.sets == 0 {
            return refuse("sets", 0, "a cache has at least one set", "give 1 or more; 1 makes it fully associative");
        }
        if self.ways == 0 {
            return refuse("ways", 0, "a set has at least one way", "give 1 or more; 1 makes it direct-mapped");
        }
        if !self.line.is_power_of_two() || self.line > Self::LINE_MAX {
            return refuse("line", self.line, "not a line size", "give a power of two from 1 to 4096 bytes");
        }
        if self.lines() > Self::LINES_MAX {
            let (key, value) = if self.sets > self.ways { ("sets", self.sets) } else { ("ways", self.ways) };
            return refuse(key, value, "too many lines", "sets times ways may be at most 2^28 = 268435456");
        }
        Ok(())
    }

    /// Number of lines, sets times ways.
    #[must_use]
    pub const fn lines(&self) -> u64 {
        self.sets as u64 * self.ways as u64
    }

    /// Bytes of data the cache holds (saturating, for shapes [`Geometry::check`] refuses).
    #[must_use]
    pub const fn size_bytes(&self) -> u64 {
        self.lines().saturating_mul(self.line as u64)
    }

    /// The number of the line that holds a byte. The line size must be a power of two.
    #[must_use]
    pub const fn line_number(&self, address: u64) -> u64 {
        address >> self.line.trailing_zeros()
    }
}

/// Which line a full set gives up on a miss.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Policy {
    /// The least recently used.
    #[default]
    Lru,
    /// The one filled longest ago; hits change nothing.
    Fifo,
    /// Tree pseudo-LRU: a binary tree over the ways, one bit a node. A hit or fill turns every node on its path away from
    /// the way touched; the victim is found by following the bits, 0 to the lower half. Where the ways are not a
    /// power of two the tree is that of the next one, and a node whose upper half has no way always leads to the lower.
    Plru,
    /// A way drawn by splitmix64: one draw for every miss in a full set, in the order of the misses and over all sets
    /// together, none otherwise. The way is the high word of the draw times the number of ways.
    Random {
        /// First state of the generator.
        seed: u64,
    },
}

impl Policy {
    /// The name on the command line and in reports.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Lru => "lru",
            Self::Fifo => "fifo",
            Self::Plru => "plru",
            Self::Random { .. } => "random",
        }
    }
}

/// What one lookup did. A slot is `set * ways + way`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The line was there.
    Hit {
        /// Where it is.
        slot: u32,
    },
    /// The line was not there and has been filled.
    Miss {
        /// Where it is now.
        slot: u32,
        /// The line number that had to leave, if the slot held one.
        evicted: Option<u64>,
    },
}

impl Outcome {
    /// Whether the line was there.
    #[must_use]
    pub const fn is_hit(&self) -> bool {
        matches!(self, Self::Hit { .. })
    }

    /// Where the line is after the lookup, `set * ways + way`.
    #[must_use]
    pub const fn slot(&self) -> u32 {
        match *self {
            Self::Hit { slot } | Self::Miss { slot, .. } => slot,
        }
    }
}

/// What watches a cache at work. It is compiled into the lookup loop, so that a run without one pays nothing: `()` sees
/// nothing.
pub trait Observer {
    /// Whether it must see every lookup: where it need not, it sees those that may change which lines are there or in what order they were
    /// used, not those of the line looked up just before.
    const EVERY: bool = true;

    /// Called after every lookup, in order. Where it need not see every one, the address is the line's.
    fn lookup(&mut self, address: u64, line: u64, outcome: Outcome);
}

impl Observer for () {
    const EVERY: bool = false;

    #[inline(always)]
    fn lookup(&mut self, _: u64, _: u64, _: Outcome) {}
}

/// An exact set-associative cache.
///
/// ```
/// use texunit_hw::cache::{Cache, Geometry, Outcome, Policy};
/// let mut cache = Cache::new(Geometry { sets: 1, ways: 2, line: 64 }, Policy::Lru)?;
/// assert_eq!(cache.access(0x00), Outcome::Miss { slot: 0, evicted: None });
/// assert_eq!(cache.access(0x40), Outcome::Miss { slot: 1, evicted: None });
/// assert_eq!(cache.access(0x3f), Outcome::Hit { slot: 0 });
/// assert_eq!(cache.access(0x80), Outcome::Miss { slot: 1, evicted: Some(1) });
/// assert_eq!((cache.lookups(), cache.misses(), cache.evictions()), (4, 3, 1));
/// # Ok::<(), texunit_hw::cache::GeometryError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Cache {
    geometry: Geometry,
    policy: Policy,
    engine: Engine,
    lanes: Option<ChangeLanes>,
    lookups: u64,
    misses: u64,
}

/// The lookup loop is compiled once for each of these: LRU, which everyone asks for, also for each small number of ways.
#[derive(Clone, Debug)]
enum Engine {
    Lru1(RecencyTags<1>),
    Lru2(RecencyTags<2>),
    Lru3(RecencyTags<3>),
    Lru4(RecencyTags<4>),
    Lru5(RecencyTags<5>),
    Lru6(RecencyTags<6>),
    Lru7(RecencyTags<7>),
    Lru8(RecencyTags<8>),
    Lru9(RecencyTags<9>),
    Lru10(RecencyTags<10>),
    Lru11(RecencyTags<11>),
    Lru12(RecencyTags<12>),
    Lru13(RecencyTags<13>),
    Lru14(RecencyTags<14>),
    Lru15(RecencyTags<15>),
    Lru16(RecencyTags<16>),
    Lru(Tags<RecencyList>),
    Fifo(Tags<FillOrder>),
    Plru(Tags<TreeBits>),
    Random(Tags<Splitmix>),
}

/// Runs `$body` with `$tags` bound to whichever engine it is.
macro_rules! with_engine {
    ($engine:expr, $tags:ident => $body:expr) => {
        match $engine {
            Engine::Lru1($tags) => $body,
            Engine::Lru2($tags) => $body,
            Engine::Lru3($tags) => $body,
            Engine::Lru4($tags) => $body,
            Engine::Lru5($tags) => $body,
            Engine::Lru6($tags) => $body,
            Engine::Lru7($tags) => $body,
            Engine::Lru8($tags) => $body,
            Engine::Lru9($tags) => $body,
            Engine::Lru10($tags) => $body,
            Engine::Lru11($tags) => $body,
            Engine::Lru12($tags) => $body,
            Engine::Lru13($tags) => $body,
            Engine::Lru14($tags) => $body,
            Engine::Lru15($tags) => $body,
            Engine::Lru16($tags) => $body,
            Engine::Lru($tags) => $body,
            Engine::Fifo($tags) => $body,
            Engine::Plru($tags) => $body,
            Engine::Random($tags) => $body,
        }
    };
}

mod runs;
pub(crate) use runs::{Run, RunHits, RunObserver, Runs, TapsOfRuns};
use runs::{SetOf, Splitter, Told};

impl Cache {
    /// An empty cache.
    ///
    /// # Errors
    /// What [`Geometry::check`] refuses.
    pub fn new(geometry: Geometry, policy: Policy) -> Result<Self, GeometryError> {
        geometry.check()?;
        let (sets, ways) = (geometry.sets as usize, geometry.ways as usize);
        let engine = match (policy, ways) {
            // Small lines, whose numbers are too large for the others.
            (Policy::Lru, _) if !RecencyTags::<1>::suits(geometry.sets, geometry.line) => {
                Engine::Lru(Tags::new(sets, ways, RecencyList::new(sets, ways)))
            }
            (Policy::Lru, 1) => Engine::Lru1(RecencyTags::new(sets)),
            (Policy::Lru, 2) => Engine::Lru2(RecencyTags::new(sets)),
            (Policy::Lru, 3) => Engine::Lru3(RecencyTags::new(sets)),
            (Policy::Lru, 4) => Engine::Lru4(RecencyTags::new(sets)),
            (Policy::Lru, 5) => Engine::Lru5(RecencyTags::new(sets)),
            (Policy::Lru, 6) => Engine::Lru6(RecencyTags::new(sets)),
            (Policy::Lru, 7) => Engine::Lru7(RecencyTags::new(sets)),
            (Policy::Lru, 8) => Engine::Lru8(RecencyTags::new(sets)),
            (Policy::Lru, 9) => Engine::Lru9(RecencyTags::new(sets)),
            (Policy::Lru, 10) => Engine::Lru10(RecencyTags::new(sets)),
            (Policy::Lru, 11) => Engine::Lru11(RecencyTags::new(sets)),
            (Policy::Lru, 12) => Engine::Lru12(RecencyTags::new(sets)),
            (Policy::Lru, 13) => Engine::Lru13(RecencyTags::new(sets)),
            (Policy::Lru, 14) => Engine::Lru14(RecencyTags::new(sets)),
            (Policy::Lru, 15) => Engine::Lru15(RecencyTags::new(sets)),
            (Policy::Lru, 16) => Engine::Lru16(RecencyTags::new(sets)),
            (Policy::Lru, _) => Engine::Lru(Tags::new(sets, ways, RecencyList::new(sets, ways))),
            (Policy::Fifo, _) => Engine::Fifo(Tags::new(sets, ways, FillOrder::new(sets, ways))),
            (Policy::Plru, _) => Engine::Plru(Tags::new(sets, ways, TreeBits::new(sets, ways))),
            (Policy::Random { seed }, _) => Engine::Random(Tags::new(sets, ways, Splitmix::new(seed, ways))),
        };
        Ok(Self { geometry, policy, engine, lanes: ChangeLanes::detect(), lookups: 0, misses: 0 })
    }

    /// The same cache without the lanes of the machine it runs on: what they are compared with.
    #[must_use]
    pub fn scalar(self) -> Self {
        Self { lanes: None, ..self }
    }

    /// The same cache in lanes of 256 bits at most: what machines without AVX-512 have.
    #[must_use]
    pub fn narrow_lanes(self) -> Self {
        Self { lanes: self.lanes.map(ChangeLanes::narrow), ..self }
    }

    /// Looks up the line of one byte address, filling it on a miss.
    #[inline]
    pub fn access(&mut self, address: u64) -> Outcome {
        let line = self.geometry.line_number(address);
        let set = SetOf::new(self.geometry).set(line);
        let outcome = with_engine!(&mut self.engine, tags => tags.access(set, line));
        self.lookups += 1;
        self.misses += u64::from(!outcome.is_hit());
        outcome
    }

    /// Looks up the lines of byte addresses one after the other, showing each outcome to `observer`.
    pub fn access_all<O: Observer>(&mut self, addresses: &[u64], observer: &mut O) {
        let shift = self.geometry.line.trailing_zeros();
        let sets = u64::from(self.geometry.sets);
        let Some(&first) = addresses.first() else { return };
        let changes = Changes::new(first, shift, self.lanes);
        self.lookups += addresses.len() as u64;
        self.misses += with_engine!(&mut self.engine, tags => if sets.is_power_of_two() && shift == 6 {
            // The commonest line by far: a shift by a constant is cheaper.
            tags.run(addresses, changes, |address| address >> 6, |line, sets| line as usize & (sets - 1), observer)
        } else if sets.is_power_of_two() {
            tags.run(addresses, changes, |address| address >> shift, |line, sets| line as usize & (sets - 1), observer)
        } else {
            tags.run(addresses, changes, |address| address >> shift, |line, _| (line % sets) as usize, observer)
        });
    }

    /// Its shape.
    #[must_use]
    pub const fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// Its replacement policy.
    #[must_use]
    pub const fn policy(&self) -> Policy {
        self.policy
    }

    /// Lookups so far.
    #[must_use]
    pub const fn lookups(&self) -> u64 {
        self.lookups
    }

    /// Lookups that did not find their line, so far. Each filled one line.
    #[must_use]
    pub const fn misses(&self) -> u64 {
        self.misses
    }

    /// Lines held now.
    #[must_use]
    pub fn resident(&self) -> u64 {
        with_engine!(&self.engine, tags => tags.resident())
    }

    /// Fills that had to throw a line out, so far.
    #[must_use]
    pub fn evictions(&self) -> u64 {
        self.misses - self.resident()
    }
}
