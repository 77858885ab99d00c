//! From a miss to a line that can be read: the requests a miss becomes, and the decompressor where there is one.

use texunit_hw::timing::MainMemory;

use super::{
    Machine, Simulator,
    account::{Clock, bump},
};
use crate::memory::{Memory, Wanted};

/// A line on its way.
pub struct Fill {
    /// The numbers of its requests in the memory.
    pub ids: std::ops::Range<usize>,
    /// From a decompressor, the clock in which it can be read, once that is known.
    pub there: Option<u64>,
}

/// Element by element: what to ask for, so that `line` can be filled.
pub fn requests_of(machine: &Machine, line: u64) -> Vec<Wanted> {
    let Some(stored) = &machine.stored else {
        return vec![Wanted { address: line * u64::from(machine.line), bytes: machine.line.into() }];
    };
    let size = u64::from(stored.element_bytes);
    let cut = match (machine.memory.second_level, machine.memory.main) {
        (Some(second), _) => Some(u64::from(second.line)),
        (None, MainMemory::Dram(dram)) => Some(u64::from(dram.interleave)),
        (None, MainMemory::Fixed { .. }) => None,
    };
    let mut bytes: Vec<u64> = Vec::new();
    let texels = u64::from(machine.line) / 4;
    for texel in line * texels..(line + 1) * texels {
        if let Some(element) = stored.elements[texel as usize] {
            bytes.extend(element..element + size);
        }
    }
    bytes.sort_unstable();
    bytes.dedup();
    let apart = |one: &u64, next: &u64| one + 1 == *next && cut.is_none_or(|cut| !next.is_multiple_of(cut));
    bytes.chunk_by(apart).map(|run| Wanted { address: run[0], bytes: run.len() as u64 }).collect()
}

/// Lines on their way, and the decompressor they pass where there is one.
pub struct Decompressor {
    exists: bool,
    /// Clocks of work a line takes, and from its end to the line being there.
    work: u64,
    latency: u64,
    /// The line of each miss.
    pub fills: Vec<Fill>,
    /// The next miss to be decompressed, and clocks of work left on the one before.
    next: usize,
    working: u64,
}

impl Decompressor {
    pub fn new(machine: &Machine) -> Self {
        let p = &machine.pipeline;
        Self {
            exists: machine.stored.is_some(),
            work: (u64::from(machine.line) / 4).div_ceil(p.decompress_texels_per_clock.into()),
            latency: p.decompress_latency.into(),
            fills: Vec::new(),
            next: 0,
            working: 0,
        }
    }

    /// The latest clock in which bytes of a miss's requests are there, once all are known.
    fn came(&self, memory: &Memory, miss: usize) -> Option<u64> {
        let fill = self.fills.get(miss)?;
        fill.ids.clone().try_fold(0, |latest, id| Some(latest.max(memory.filled(id)?)))
    }

    /// The clock in which the line of a miss can be read, once it is known.
    pub fn there(&self, memory: &Memory, miss: usize) -> Option<u64> {
        if self.exists { self.fills.get(miss)?.there } else { self.came(memory, miss) }
    }

    /// A line begins in a clock in which all its bytes are there and the line before is done. The answer is whether there is work in
    /// this clock, and for how many clocks the line that begins has waited.
    fn tick(&mut self, t: u64, memory: &Memory) -> (bool, u64) {
        let mut waited = 0;
        if self.exists
            && self.working == 0
            && let Some(came) = self.came(memory, self.next).filter(|came| *came <= t)
        {
            self.working = self.work;
            self.fills[self.next].there = Some(t + self.work - 1 + self.latency);
            self.next += 1;
            waited = t - came;
        }
        let busy = self.working > 0;
        self.working -= u64::from(busy);
        (busy, waited)
    }
}

impl Simulator<'_> {
    pub fn decompressor(&mut self) -> Clock {
        let (busy, waited) = self.lines.tick(self.t, &self.memory);
        bump(&mut self.counters, "decompressor_wait_sum", waited);
        (busy, None)
    }
}
