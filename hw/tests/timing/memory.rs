//! The memory of docs/timing.md, section 5, with a clock.

use std::collections::VecDeque;

use texunit_hw::timing::{DramParameters, MainMemory, Mapping, MemoryParameters, Page, SecondLevelParameters};

/// LRU by linear search: lines of a set from the most to the least recent, each with whatever the owner wants to know of it.
pub struct Lru {
    pub sets: u64,
    pub ways: usize,
    pub line: u64,
    contents: Vec<Vec<(u64, usize)>>,
}

impl Lru {
    pub fn new(sets: u32, ways: u32, line: u32) -> Self {
        let contents = (0..sets).map(|_| Vec::new()).collect();
        Self { sets: sets.into(), ways: ways as usize, line: line.into(), contents }
    }

    /// The note of the line if it is there, else leaves `note` with it.
    pub fn look_up(&mut self, address: u64, note: usize) -> Result<usize, ()> {
        let line = address / self.line;
        let set = &mut self.contents[(line % self.sets) as usize];
        if let Some(place) = set.iter().position(|(held, _)| *held == line) {
            let entry = set.remove(place);
            set.insert(0, entry);
            return Ok(entry.1);
        }
        set.insert(0, (line, note));
        set.truncate(self.ways);
        Err(())
    }

    pub fn contains(&self, address: u64) -> bool {
        let line = address / self.line;
        self.contents[(line % self.sets) as usize].iter().any(|(held, _)| *held == line)
    }
}

/// Clock from which each request to a memory can be read, once that is known.
pub type Filled = Vec<Option<u64>>;

#[derive(Default)]
pub struct Tally {
    pub requests: u64,
    pub bytes: u64,
    pub transfer_clocks: u64,
    pub row_hits: u64,
    pub row_misses: u64,
    pub row_conflicts: u64,
    pub queue_sum: u64,
    pub queue_max: u64,
    pub second_lookups: u64,
    pub second_hits: u64,
}

/// Bytes wanted, from an address on.
#[derive(Clone, Copy)]
pub struct Wanted {
    pub address: u64,
    pub bytes: u64,
}

struct DramRequest {
    id: usize,
    bank: usize,
    row: u64,
    taken: u64,
    transfer: u64,
    begun: bool,
    prepared: bool,
    activate_at: Option<u64>,
}

#[derive(Clone, Default)]
struct DramBank {
    open: Option<u64>,
    act: u64,
    end: u64,
    free: u64,
}

struct DramChannel {
    queue: VecDeque<DramRequest>,
    banks: Vec<DramBank>,
    last_begin: Option<u64>,
    column_end: Option<u64>,
}

enum Main {
    /// Waiting: request, clock it was taken, clocks of its transfer.
    Fixed {
        latency: u64,
        bytes_per_clock: u64,
        waiting: VecDeque<(usize, u64, u64)>,
        link_free: u64,
    },
    Dram {
        p: DramParameters,
        channels: Vec<DramChannel>,
    },
}

struct Second {
    p: SecondLevelParameters,
    cache: Lru,
    /// Main-memory request and first clock it can be made.
    queue: VecDeque<(usize, u64, u64)>,
    /// First-level request and its bytes, clock of the lookup if it hit, main-memory request it waits for.
    answers: VecDeque<(usize, u64, Option<u64>, usize)>,
    link_free: u64,
    main_filled: Filled,
}

/// Everything behind the miss queue.
pub struct Memory {
    main: Main,
    second: Option<Second>,
    filled: Filled,
    pub tally: Tally,
}

impl Memory {
    pub fn new(parameters: &MemoryParameters) -> Self {
        let main = match parameters.main {
            MainMemory::Fixed { latency, bytes_per_clock } => Main::Fixed {
                latency: latency.into(),
                bytes_per_clock: bytes_per_clock.into(),
                waiting: VecDeque::new(),
                link_free: 0,
            },
            MainMemory::Dram(p) => {
                let channel = || DramChannel {
                    queue: VecDeque::new(),
                    banks: vec![DramBank::default(); p.banks as usize],
                    last_begin: None,
                    column_end: None,
                };
                Main::Dram { p, channels: (0..p.channels).map(|_| channel()).collect() }
            }
        };
        let second = parameters.second_level.map(|p| Second {
            p,
            cache: Lru::new(p.sets, p.ways, p.line),
            queue: VecDeque::new(),
            answers: VecDeque::new(),
            link_free: 0,
            main_filled: Vec::new(),
        });
        Self { main, second, filled: Vec::new(), tally: Tally::default() }
    }

    /// Whether the request at the head of the miss queue is taken in this clock.
    pub fn take(&mut self, t: u64, id: usize, wanted: Wanted) -> bool {
        let Wanted { address, bytes } = wanted;
        if self.filled.len() <= id {
            self.filled.resize(id + 1, None);
        }
        let Some(second) = &mut self.second else {
            return self.main.take(t, id, wanted, &mut self.tally);
        };
        let hit = second.cache.contains(address);
        if !hit && second.queue.len() >= second.p.miss_queue as usize {
            return false;
        }
        self.tally.second_lookups += 1;
        let fresh = second.main_filled.len();
        match second.cache.look_up(address, fresh) {
            Ok(main_id) => {
                self.tally.second_hits += 1;
                second.answers.push_back((id, bytes, Some(t), main_id));
            }
            Err(()) => {
                second.main_filled.push(None);
                let line = u64::from(second.p.line);
                second.queue.push_back((fresh, address / line * line, t + u64::from(second.p.latency)));
                second.answers.push_back((id, bytes, None, fresh));
            }
        }
        true
    }

    /// The rest of the clock.
    pub fn tick(&mut self, t: u64) {
        let Some(second) = &mut self.second else {
            self.main.tick(t, &mut self.filled, &mut self.tally);
            return;
        };
        if let Some(&(main_id, address, earliest)) = second.queue.front()
            && t >= earliest
            && self.main.take(t, main_id, Wanted { address, bytes: second.p.line.into() }, &mut self.tally)
        {
            second.queue.pop_front();
        }
        self.main.tick(t, &mut second.main_filled, &mut self.tally);
        if let Some(&(id, bytes, looked_up, main_id)) = second.answers.front() {
            let there = second.main_filled[main_id].is_some_and(|filled| filled <= t);
            let answered = looked_up.is_none_or(|lookup| t >= lookup + u64::from(second.p.latency));
            if there && answered && t >= second.link_free {
                second.link_free = t + bytes.div_ceil(second.p.bytes_per_clock.into());
                self.filled[id] = Some(second.link_free);
                second.answers.pop_front();
            }
        }
    }
}

impl Main {
    fn take(&mut self, t: u64, id: usize, wanted: Wanted, tally: &mut Tally) -> bool {
        let Wanted { address, bytes } = wanted;
        match self {
            Self::Fixed { waiting, bytes_per_clock, .. } => {
                let transfer = bytes.div_ceil(*bytes_per_clock);
                waiting.push_back((id, t, transfer));
                tally.transfer_clocks += transfer;
            }
            Self::Dram { p, channels } => {
                // Burst by burst, from the one with the first byte to the one with the last.
                let burst = u64::from(p.burst_length) * u64::from(p.bus_bytes);
                let bursts = (address + bytes - 1) / burst - address / burst + 1;
                let transfer = bursts * u64::from(p.burst_length.div_ceil(p.beats_per_clock));
                let chunk = address / u64::from(p.interleave);
                let channel = &mut channels[(chunk % u64::from(p.channels)) as usize];
                if channel.queue.len() >= p.queue as usize {
                    return false;
                }
                let local = chunk / u64::from(p.channels) * u64::from(p.interleave) + address % u64::from(p.interleave);
                let banks = u64::from(p.banks);
                let (mut bank, row) = match p.mapping {
                    Mapping::RowBankColumn => {
                        let bytes = u64::from(p.row_bytes);
                        ((local / bytes) % banks, local / bytes / banks)
                    }
                    Mapping::RowColumnBank => {
                        let piece = local / u64::from(p.interleave);
                        (piece % banks, piece / banks / u64::from(p.row_bytes / p.interleave))
                    }
                };
                if p.bank_xor {
                    bank ^= row % banks;
                }
                let bank = bank as usize;
                channel.queue.push_back(DramRequest {
                    id,
                    bank,
                    row,
                    taken: t,
                    transfer,
                    begun: false,
                    prepared: false,
                    activate_at: None,
                });
                tally.transfer_clocks += transfer;
            }
        }
        tally.requests += 1;
        tally.bytes += bytes;
        true
    }

    fn tick(&mut self, t: u64, filled: &mut Filled, tally: &mut Tally) {
        match self {
            Self::Fixed { latency, waiting, link_free, .. } => {
                if let Some(&(id, taken, transfer)) = waiting.front()
                    && t >= taken + *latency
                    && t >= *link_free
                {
                    *link_free = t + transfer;
                    filled[id] = Some(*link_free);
                    waiting.pop_front();
                }
            }
            Self::Dram { p, channels } => {
                for channel in channels {
                    tally.queue_sum += channel.queue.len() as u64;
                    tally.queue_max = tally.queue_max.max(channel.queue.len() as u64);
                    channel.tick(t, p, filled, tally);
                }
            }
        }
    }
}

impl DramChannel {
    fn tick(&mut self, t: u64, p: &DramParameters, filled: &mut Filled, tally: &mut Tally) {
        if let Some(request) = self.queue.iter_mut().find(|request| !request.begun)
            && t >= request.taken + u64::from(p.controller_latency)
            && self.last_begin.is_none_or(|last| last < t)
        {
            request.begun = true;
            self.last_begin = Some(t);
        }
        // Banks are made ready in the order of their requests; different banks do not wait for each other.
        let mut bank_taken = vec![false; self.banks.len()];
        for request in self.queue.iter_mut().filter(|request| request.begun) {
            let bank = &mut self.banks[request.bank];
            if std::mem::replace(&mut bank_taken[request.bank], true) {
                continue;
            }
            if !request.prepared && request.activate_at.is_none() {
                match bank.open {
                    Some(row) if row == request.row => {
                        tally.row_hits += 1;
                        request.prepared = true;
                    }
                    Some(_) => {
                        if t >= bank.act + u64::from(p.tras) && t >= bank.end {
                            tally.row_conflicts += 1;
                            bank.open = None;
                            request.activate_at = Some(t + u64::from(p.trp));
                        }
                    }
                    None => {
                        if t >= bank.free {
                            tally.row_misses += 1;
                            request.activate_at = Some(t);
                        }
                    }
                }
            }
            if request.activate_at.is_some_and(|at| t >= at) && !request.prepared {
                bank.act = t;
                bank.open = Some(request.row);
                request.prepared = true;
            }
        }
        if let Some(request) = self.queue.front()
            && request.prepared
            && t >= self.banks[request.bank].act + u64::from(p.trcd)
            && self.column_end.is_none_or(|end| t >= end)
        {
            let transfer = request.transfer;
            let bank = &mut self.banks[request.bank];
            self.column_end = Some(t + transfer);
            bank.end = t + transfer;
            if p.page == Page::Closed {
                bank.open = None;
                bank.free = (bank.act + u64::from(p.tras)).max(bank.end) + u64::from(p.trp);
            }
            filled[request.id] = Some(t + u64::from(p.tcas) + transfer);
            self.queue.pop_front();
        }
    }
}

impl Memory {
    /// The clock in which a request's bytes are there, once that is known.
    pub fn filled(&self, id: usize) -> Option<u64> {
        self.filled.get(id).copied().flatten()
    }
}
