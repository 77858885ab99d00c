//! What the cache counts, each to the unit.

use super::MissClasses;

/// Totals of a [`super::TexelCache`].
///
/// `lookups = hits + misses`; `misses = compulsory + capacity + conflict` where classes were asked for;
/// `fills = misses`; `bytes_filled = fills * line`; `bytes_used <= bytes_filled` and `<= bytes_requested`; `bytes_fetched` is
/// `bytes_filled` unless a decompressor stands between memory and cache.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Texels asked for, one by one.
    pub lookups: u64,
    /// Lookups that found their line.
    pub hits: u64,
    /// Lookups that did not.
    pub misses: u64,
    /// Misses that were the first reference to their line ever. 0 where classes were not asked for.
    pub compulsory: u64,
    /// Other misses which a fully associative LRU cache with as many lines has too. 0 where classes were not asked for.
    pub capacity: u64,
    /// The rest of the misses. 0 where classes were not asked for.
    pub conflict: u64,
    /// Lines fetched from memory, one for every miss.
    pub fills: u64,
    /// Fills that had to throw out a line; the others found an empty way.
    pub evictions: u64,
    /// Bytes of the texels asked for: what the memory would deliver if there were no cache.
    pub bytes_requested: u64,
    /// Bytes that came from memory.
    pub bytes_fetched: u64,
    /// Bytes of the lines filled.
    pub bytes_filled: u64,
    /// Of those, bytes of texels that were read before their line left, or so far if it has not; a line fetched twice
    /// counts twice. 0 where line use was not asked for.
    pub bytes_used: u64,
}

/// The share of one plane in the [`Counters`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlaneCounters {
    /// Texels of this plane asked for.
    pub lookups: u64,
    /// Lookups that found their line.
    pub hits: u64,
    /// Lookups that did not.
    pub misses: u64,
    /// These misses by class; all 0 where classes were not asked for.
    pub classes: MissClasses,
}
