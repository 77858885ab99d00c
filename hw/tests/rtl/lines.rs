//! Which lines are in the cache, by the Rust cache unit.

use texunit_hw::cache::{Cache, Geometry, Policy};

/// Bytes of a line in every trace.
pub const LINE: u64 = 64;

/// An LRU cache asked by line numbers.
pub struct CachedLines {
    cache: Cache,
}

impl CachedLines {
    /// An empty cache.
    pub fn new(sets: u64, ways: usize) -> Self {
        let geometry = Geometry { sets: sets as u32, ways: ways as u32, line: LINE as u32 };
        Self { cache: Cache::new(geometry, Policy::Lru).expect("a shape the RTL has") }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.cache = Cache::new(self.cache.geometry(), Policy::Lru).expect("the shape it had");
    }

    /// Whether a line is there, and the way it is in or would go to.
    pub fn find(&self, line: u64) -> (bool, u64) {
        let outcome = self.cache.clone().access(line * LINE);
        (outcome.is_hit(), u64::from(outcome.slot() % self.cache.geometry().ways))
    }

    /// Uses a line; the answer is whether it was there.
    pub fn touch(&mut self, line: u64) -> bool {
        self.cache.access(line * LINE).is_hit()
    }
}
