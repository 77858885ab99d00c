//! When everything happened, for whoever draws it. Compiled into the model: `()` watches nothing and costs nothing.

use super::memory::Fetch;

/// A request, told when its last tap is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestTimes {
    /// Its number, from 0.
    pub request: u64,
    /// Clock it entered.
    pub entry: u64,
    /// Clock the LOD unit took it.
    pub lod: u64,
    /// Clock it left.
    pub result: u64,
}

/// A tap, told after its fills.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TapTimes {
    /// Its number, from 0.
    pub tap: u64,
    /// The number of its request.
    pub request: u64,
    /// Storage index of its plane.
    pub plane: u16,
    /// Clock the sequencer issued it.
    pub issue: u64,
    /// Clock it entered the tag unit.
    pub tag: u64,
    /// Clock of its last line access.
    pub tag_done: u64,
    /// Clock it entered the data unit.
    pub data: u64,
    /// Clock of its last word.
    pub data_done: u64,
    /// Clock the datapath took it.
    pub datapath: u64,
    /// Line accesses that missed.
    pub misses: u32,
}

/// A line that had to come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FillTimes {
    /// The tap that missed.
    pub tap: u64,
    /// Storage index of the plane.
    pub plane: u16,
    /// Address of the line's first byte.
    pub address: u64,
    /// Clock of the access that missed.
    pub access: u64,
    /// When and how it came.
    pub fetch: Fetch,
}

/// A request for some of what is stored behind a line, where a decompressor stands before the cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoredFetch {
    /// Address of the first byte in memory.
    pub address: u64,
    /// Bytes, which lie in one line of the second level, or one interleave of a DRAM.
    pub bytes: u32,
    /// When and how they came, to the decompressor.
    pub fetch: Fetch,
}

/// Whoever wants to know.
pub trait TimingObserver {
    /// Whether anything is done with what is told.
    const WATCHES: bool = true;
    /// A line on its way. Where it is decompressed on it, also what was asked for; otherwise that was the line and nothing is said of it.
    fn fill(&mut self, fill: FillTimes, stored: &[StoredFetch]);
    /// A tap that has been timed.
    fn tap(&mut self, tap: TapTimes);
    /// A request that has been timed.
    fn request(&mut self, request: RequestTimes);
}

impl TimingObserver for () {
    const WATCHES: bool = false;

    #[inline(always)]
    fn fill(&mut self, _: FillTimes, _: &[StoredFetch]) {}
    #[inline(always)]
    fn tap(&mut self, _: TapTimes) {}
    #[inline(always)]
    fn request(&mut self, _: RequestTimes) {}
}

impl<O: TimingObserver> TimingObserver for &mut O {
    const WATCHES: bool = O::WATCHES;

    fn fill(&mut self, fill: FillTimes, stored: &[StoredFetch]) {
        (**self).fill(fill, stored);
    }
    fn tap(&mut self, tap: TapTimes) {
        (**self).tap(tap);
    }
    fn request(&mut self, request: RequestTimes) {
        (**self).request(request);
    }
}
