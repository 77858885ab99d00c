//! What answers a miss: a second-level cache or not, and a memory of fixed latency or DRAM.

use alloc::{vec, vec::Vec};

use super::{
    dram::{Dram, Row},
    parameters::{MainMemory, MemoryParameters, SecondLevelParameters},
    queue::Fifo,
};
use crate::cache::{Cache, Geometry, GeometryError, Outcome, Policy};

/// When and how a line came. Where a decompressor asked for it in several requests, how the last of them came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fetch {
    /// The clock the memory took the (last) request in.
    pub taken: u64,
    /// The first clock in which the line can be read.
    pub filled: u64,
    /// What a DRAM bank held; none where no DRAM was asked.
    pub row: Option<Row>,
    /// Whether the second level had the line; none without one.
    pub second_level_hit: Option<bool>,
}

/// What is asked of a memory at once: a line, or a part of what is stored behind one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ask {
    address: u64,
    bytes: u32,
    /// Clocks of the link or bus nearest to whoever asks.
    transfer: u64,
}

impl Ask {
    /// The same at another address.
    pub(super) const fn at(self, address: u64) -> Self {
        Self { address, ..self }
    }
}

/// Fixed latency and one link.
#[derive(Clone, Debug)]
struct Fixed {
    latency: u64,
    bytes_per_clock: u32,
    next_take: u64,
    link_free: u64,
}

#[derive(Clone, Debug)]
enum Main {
    Fixed(Fixed),
    Dram(Dram),
}

impl Main {
    fn new(parameters: &MainMemory) -> Self {
        match *parameters {
            MainMemory::Fixed { latency, bytes_per_clock } => {
                Self::Fixed(Fixed { latency: latency.into(), bytes_per_clock, next_take: 0, link_free: 0 })
            }
            MainMemory::Dram(dram) => Self::Dram(Dram::new(dram)),
        }
    }

    fn ask(&self, address: u64, bytes: u32) -> Ask {
        let transfer = match self {
            Self::Fixed(fixed) => bytes.div_ceil(fixed.bytes_per_clock).into(),
            Self::Dram(dram) => dram.transfer(address, bytes),
        };
        Ask { address, bytes, transfer }
    }

    fn fetch(&mut self, ask: Ask, earliest: u64) -> Fetch {
        match self {
            Self::Fixed(fixed) => {
                let taken = earliest.max(fixed.next_take);
                let filled = (taken + fixed.latency).max(fixed.link_free) + ask.transfer;
                (fixed.next_take, fixed.link_free) = (taken + 1, filled);
                Fetch { taken, filled, row: None, second_level_hit: None }
            }
            Self::Dram(dram) => dram.fetch(ask.address, ask.transfer, earliest),
        }
    }
}

#[derive(Clone, Debug)]
struct SecondLevel {
    cache: Cache,
    latency: u64,
    bytes_per_clock: u32,
    miss_queue: Fifo,
    /// A whole line of its own, at any address.
    line: Ask,
    /// Clock at which the line of each slot is there.
    arrival: Vec<u64>,
    next_take: u64,
    link_free: u64,
    lookups: u64,
    hits: u64,
}

impl SecondLevel {
    fn new(parameters: &SecondLevelParameters, main: &Main) -> Result<Self, GeometryError> {
        let geometry = Geometry { sets: parameters.sets, ways: parameters.ways, line: parameters.line };
        Ok(Self {
            cache: Cache::new(geometry, Policy::Lru)?,
            latency: parameters.latency.into(),
            bytes_per_clock: parameters.bytes_per_clock,
            miss_queue: Fifo::new(parameters.miss_queue),
            line: main.ask(0, parameters.line),
            arrival: vec![0; geometry.lines() as usize],
            next_take: 0,
            link_free: 0,
            lookups: 0,
            hits: 0,
        })
    }

    fn ask(&self, address: u64, bytes: u32) -> Ask {
        Ask { address, bytes, transfer: bytes.div_ceil(self.bytes_per_clock).into() }
    }

    fn fetch(&mut self, main: &mut Main, ask: Ask, earliest: u64) -> Fetch {
        let mut taken = earliest.max(self.next_take);
        self.lookups += 1;
        let (ready, row, hit) = match self.cache.access(ask.address) {
            Outcome::Hit { slot } => {
                self.hits += 1;
                ((taken + self.latency).max(self.arrival[slot as usize]), None, true)
            }
            Outcome::Miss { slot, .. } => {
                taken = taken.max(self.miss_queue.room());
                let address = ask.address & !(u64::from(self.line.bytes) - 1);
                let below = main.fetch(self.line.at(address), taken + self.latency);
                self.miss_queue.pass(taken, below.taken + 1);
                self.arrival[slot as usize] = below.filled;
                (below.filled, below.row, false)
            }
        };
        let filled = ready.max(self.link_free) + ask.transfer;
        (self.next_take, self.link_free) = (taken + 1, filled);
        Fetch { taken, filled, row, second_level_hit: Some(hit) }
    }
}

/// The memory behind the first-level cache.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    second_level: Option<SecondLevel>,
    main: Main,
    /// Requests to the main memory, their bytes and the clocks of their transfer.
    requests: u64,
    bytes: u64,
    transfer_clocks: u64,
    /// Requests by what they found: row hit, miss, conflict.
    rows: [u64; 3],
}

impl Memory {
    pub(super) fn new(parameters: &MemoryParameters) -> Result<Self, GeometryError> {
        let main = Main::new(&parameters.main);
        let second_level = parameters.second_level.map(|second| SecondLevel::new(&second, &main)).transpose()?;
        Ok(Self { second_level, main, requests: 0, bytes: 0, transfer_clocks: 0, rows: [0; 3] })
    }

    /// What fetches so many bytes, which lie together in whatever answers ([`Self::together`]).
    pub(super) fn ask(&self, address: u64, bytes: u32) -> Ask {
        match &self.second_level {
            Some(second) => second.ask(address, bytes),
            None => self.main.ask(address, bytes),
        }
    }

    /// Bytes, of how many on each power of two, that can be asked for at once: a line of the second level, the interleave of a DRAM.
    pub(super) fn together(&self) -> u64 {
        match (&self.second_level, &self.main) {
            (Some(second), _) => second.line.bytes.into(),
            (None, Main::Dram(dram)) => dram.interleave(),
            (None, Main::Fixed(_)) => 1 << 32,
        }
    }

    /// Fetches what is asked for; the memory can be asked from `earliest` on.
    #[inline(always)]
    pub(super) fn fetch(&mut self, ask: Ask, earliest: u64) -> Fetch {
        let (fetch, below) = match &mut self.second_level {
            Some(second) => (second.fetch(&mut self.main, ask, earliest), second.line),
            None => (self.main.fetch(ask, earliest), ask),
        };
        if fetch.second_level_hit != Some(true) {
            self.requests += 1;
            self.bytes += u64::from(below.bytes);
            self.transfer_clocks += below.transfer;
        }
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
        self.bytes
    }

    /// Clocks of transfer, over all channels.
    pub(super) const fn transfer_clocks(&self) -> u64 {
        self.transfer_clocks
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
