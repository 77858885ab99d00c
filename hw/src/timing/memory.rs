//! What answers a miss: a second-level cache or not, and a memory of fixed latency or DRAM.

use alloc::{vec, vec::Vec};

use super::{
    dram::{Dram, Row},
    parameters::{MainMemory, MemoryParameters, SecondLevelParameters},
    queue::Fifo,
};
use crate::cache::{Cache, Geometry, GeometryError, Outcome, Policy};

/// When and how a line came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fetch {
    /// The clock the memory took the request in.
    pub taken: u64,
    /// The first clock in which the line can be read.
    pub filled: u64,
    /// What a DRAM bank held; none where no DRAM was asked.
    pub row: Option<Row>,
    /// Whether the second level had the line; none without one.
    pub second_level_hit: Option<bool>,
}

/// Fixed latency and one link.
#[derive(Clone, Debug)]
struct Fixed {
    latency: u64,
    transfer: u64,
    next_take: u64,
    link_free: u64,
}

#[derive(Clone, Debug)]
enum Main {
    Fixed(Fixed),
    Dram(Dram),
}

impl Main {
    fn new(parameters: &MainMemory, block: u32) -> Self {
        match *parameters {
            MainMemory::Fixed { latency, bytes_per_clock } => Self::Fixed(Fixed {
                latency: latency.into(),
                transfer: block.div_ceil(bytes_per_clock).into(),
                next_take: 0,
                link_free: 0,
            }),
            MainMemory::Dram(dram) => Self::Dram(Dram::new(dram, block)),
        }
    }

    fn fetch(&mut self, address: u64, earliest: u64) -> Fetch {
        match self {
            Self::Fixed(fixed) => {
                let taken = earliest.max(fixed.next_take);
                let filled = (taken + fixed.latency).max(fixed.link_free) + fixed.transfer;
                (fixed.next_take, fixed.link_free) = (taken + 1, filled);
                Fetch { taken, filled, row: None, second_level_hit: None }
            }
            Self::Dram(dram) => dram.fetch(address, earliest),
        }
    }
}

#[derive(Clone, Debug)]
struct SecondLevel {
    cache: Cache,
    latency: u64,
    transfer: u64,
    miss_queue: Fifo,
    /// Clock at which the line of each slot is there.
    arrival: Vec<u64>,
    next_take: u64,
    link_free: u64,
    lookups: u64,
    hits: u64,
}

impl SecondLevel {
    fn new(parameters: &SecondLevelParameters, line: u32) -> Result<Self, GeometryError> {
        let geometry = Geometry { sets: parameters.sets, ways: parameters.ways, line: parameters.line };
        Ok(Self {
            cache: Cache::new(geometry, Policy::Lru)?,
            latency: parameters.latency.into(),
            transfer: line.div_ceil(parameters.bytes_per_clock).into(),
            miss_queue: Fifo::new(parameters.miss_queue),
            arrival: vec![0; geometry.lines() as usize],
            next_take: 0,
            link_free: 0,
            lookups: 0,
            hits: 0,
        })
    }

    fn fetch(&mut self, main: &mut Main, address: u64, earliest: u64) -> Fetch {
        let mut taken = earliest.max(self.next_take);
        self.lookups += 1;
        let (ready, row, hit) = match self.cache.access(address) {
            Outcome::Hit { slot } => {
                self.hits += 1;
                ((taken + self.latency).max(self.arrival[slot as usize]), None, true)
            }
            Outcome::Miss { slot, .. } => {
                taken = taken.max(self.miss_queue.room());
                let line = u64::from(self.cache.geometry().line);
                let below = main.fetch(address & !(line - 1), taken + self.latency);
                self.miss_queue.pass(taken, below.taken + 1);
                self.arrival[slot as usize] = below.filled;
                (below.filled, below.row, false)
            }
        };
        let filled = ready.max(self.link_free) + self.transfer;
        (self.next_take, self.link_free) = (taken + 1, filled);
        Fetch { taken, filled, row, second_level_hit: Some(hit) }
    }
}

/// The memory behind the first-level cache.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    second_level: Option<SecondLevel>,
    main: Main,
    /// Bytes asked of the main memory at a time.
    block: u32,
    requests: u64,
    /// Requests by what they found: row hit, miss, conflict.
    rows: [u64; 3],
}

impl Memory {
    pub(super) fn new(parameters: &MemoryParameters, line: u32) -> Result<Self, GeometryError> {
        let block = parameters.second_level.map_or(line, |second| second.line);
        let second_level = parameters.second_level.map(|second| SecondLevel::new(&second, line)).transpose()?;
        Ok(Self { second_level, main: Main::new(&parameters.main, block), block, requests: 0, rows: [0; 3] })
    }

    /// Fetches the line at an address; the memory can be asked from `earliest` on.
    pub(super) fn fetch(&mut self, address: u64, earliest: u64) -> Fetch {
        let fetch = match &mut self.second_level {
            Some(second) => second.fetch(&mut self.main, address, earliest),
            None => self.main.fetch(address, earliest),
        };
        self.requests += u64::from(fetch.second_level_hit != Some(true));
        if let Some(row) = fetch.row {
            self.rows[row as usize] += 1;
        }
        fetch
    }

    /// Requests that went to the main memory.
    pub(super) const fn requests(&self) -> u64 {
        self.requests
    }

    /// Bytes that came from the main memory.
    pub(super) const fn bytes(&self) -> u64 {
        self.requests * self.block as u64
    }

    /// Clocks of transfer, over all channels.
    pub(super) const fn transfer_clocks(&self) -> u64 {
        self.requests
            * match &self.main {
                Main::Fixed(fixed) => fixed.transfer,
                Main::Dram(dram) => dram.transfer(),
            }
    }

    /// Row hits, misses and conflicts.
    pub(super) const fn rows(&self) -> [u64; 3] {
        self.rows
    }

    /// Lookups and hits of the second level.
    pub(super) fn second_level(&self) -> (u64, u64) {
        self.second_level.as_ref().map_or((0, 0), |second| (second.lookups, second.hits))
    }

    /// Clocks of places held in the channels' queues, and the most held in one.
    pub(super) fn queue_use(&self) -> (u64, u64) {
        match &self.main {
            Main::Fixed(_) => (0, 0),
            Main::Dram(dram) => dram.queue_use(),
        }
    }
}
