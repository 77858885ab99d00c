//! The three classes of misses (Hill & Smith 1989): compulsory, capacity, conflict.

use super::{
    Geometry, GeometryError, LineSet, Observer, Outcome,
    shadow::{Hits, Shadow},
};

/// Why a line was not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MissClass {
    /// Nobody ever asked for the line before.
    Compulsory,
    /// A fully associative LRU cache with as many lines would have missed as well.
    Capacity,
    /// That cache would have hit.
    Conflict,
}

/// Misses by class; they add up to the misses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MissClasses {
    /// Misses that were the first reference to their line.
    pub compulsory: u64,
    /// Other misses that a fully associative LRU cache with as many lines, shown the same lookups, has too.
    pub capacity: u64,
    /// The rest.
    pub conflict: u64,
}

impl MissClasses {
    /// Counts one miss.
    #[inline]
    pub fn count(&mut self, class: MissClass) {
        match class {
            MissClass::Compulsory => self.compulsory += 1,
            MissClass::Capacity => self.capacity += 1,
            MissClass::Conflict => self.conflict += 1,
        }
    }
}

/// Tells the class of every miss of one cache, of which it must see every lookup from the first on.
///
/// ```
/// use texunit_hw::cache::{Cache, Geometry, MissClassifier, Policy};
/// let geometry = Geometry { sets: 2, ways: 1, line: 64 };
/// let mut cache = Cache::new(geometry, Policy::Lru)?;
/// let mut classifier = MissClassifier::new(geometry)?;
/// cache.access_all(&[0, 128, 0, 64, 256, 0], &mut classifier);
/// let classes = classifier.classes();
/// assert_eq!((classes.compulsory, classes.conflict, classes.capacity), (4, 1, 1));
/// # Ok::<(), texunit_hw::cache::GeometryError>(())
/// ```
#[derive(Clone, Debug)]
pub struct MissClassifier {
    seen: LineSet,
    shadow: Shadow,
    classes: MissClasses,
}

impl MissClassifier {
    /// For a new cache of this shape.
    ///
    /// # Errors
    /// What [`Geometry::check`] refuses.
    pub fn new(geometry: Geometry) -> Result<Self, GeometryError> {
        geometry.check()?;
        Ok(Self {
            seen: LineSet::default(),
            shadow: Shadow::new(geometry.lines() as usize),
            classes: MissClasses::default(),
        })
    }

    /// Misses so far.
    #[must_use]
    pub const fn classes(&self) -> MissClasses {
        self.classes
    }

    /// Takes note of one lookup; the class if it missed. Lookups of the line looked up just before need not be told.
    #[inline(always)]
    pub fn classify(&mut self, line: u64, outcome: Outcome) -> Option<MissClass> {
        match outcome {
            Outcome::Hit { slot } => {
                self.hit(line, slot);
                None
            }
            Outcome::Miss { slot, .. } => Some(self.miss(line, slot)),
        }
    }

    /// For hits that are likely to follow.
    #[inline(always)]
    pub(super) fn hits(&mut self) -> Hits<'_> {
        self.shadow.hits()
    }

    /// Takes note of a hit.
    #[inline(always)]
    pub(super) fn hit(&mut self, line: u64, slot: u32) {
        self.shadow.hit(line, slot as usize);
    }

    /// Takes note of a miss, and says of which class.
    #[inline(never)]
    pub(super) fn miss(&mut self, line: u64, slot: u32) -> MissClass {
        let slot = slot as usize;
        let class = if self.shadow.miss(line, slot) {
            MissClass::Conflict
        } else if self.seen.insert(line) {
            MissClass::Compulsory
        } else {
            MissClass::Capacity
        };
        self.classes.count(class);
        class
    }
}

impl Observer for MissClassifier {
    const EVERY: bool = false;

    #[inline(always)]
    fn lookup(&mut self, _: u64, line: u64, outcome: Outcome) {
        self.classify(line, outcome);
    }
}
