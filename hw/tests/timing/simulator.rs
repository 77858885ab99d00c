//! The machine of docs/timing.md with a clock, written from that page: slow and obvious. It shares no code with the model.

use std::collections::{BTreeMap, VecDeque};

use texunit_hw::timing::{BankHash, MemoryParameters, Mode, Parameters};

use crate::memory::{Lru, Memory};

/// A tap to run: plane and addresses read, in order.
#[derive(Clone, Debug)]
pub struct Tap {
    pub plane: usize,
    pub addresses: Vec<u64>,
}

/// What is to be simulated.
#[derive(Clone, Debug)]
pub struct Machine {
    pub pipeline: Parameters,
    pub memory: MemoryParameters,
    pub sets: u32,
    pub ways: u32,
    pub line: u32,
}

/// Clocks of one tap.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TapClocks {
    pub issue: u64,
    pub tag: u64,
    pub tag_done: u64,
    pub data: u64,
    pub data_done: u64,
    pub datapath: u64,
    pub misses: u64,
}

/// Clocks of one miss.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissClocks {
    pub address: u64,
    pub access: u64,
    pub taken: u64,
    pub filled: u64,
}

#[derive(Default)]
pub struct Log {
    /// Entry, LOD, result of each request.
    pub requests: Vec<[u64; 3]>,
    pub taps: Vec<TapClocks>,
    pub misses: Vec<MissClocks>,
    pub counters: BTreeMap<String, u64>,
}

/// Places, of which those given back in a clock can be taken in the next.
struct Places {
    name: &'static str,
    depth: usize,
    used: usize,
    given_back: usize,
    sum: usize,
    most: usize,
}

impl Places {
    fn new(name: &'static str, depth: u32) -> Self {
        Self { name, depth: depth as usize, used: 0, given_back: 0, sum: 0, most: 0 }
    }
    fn full(&self) -> bool {
        self.used >= self.depth
    }
    fn take(&mut self) {
        assert!(!self.full());
        self.used += 1;
    }
    fn give_back(&mut self) {
        self.given_back += 1;
    }
    fn end_clock(&mut self) {
        self.sum += self.used;
        self.most = self.most.max(self.used);
        self.used -= self.given_back;
        self.given_back = 0;
    }
}

fn bank(hash: BankHash, banks: u32, mut number: u64) -> usize {
    let banks = u64::from(banks);
    (match hash {
        BankHash::Low => number % banks,
        BankHash::Xor => {
            let mut sum = 0;
            while banks > 1 && number > 0 {
                sum ^= number % banks;
                number /= banks;
            }
            sum
        }
    }) as usize
}

/// Clocks of a unit: busy, idle, and stalled by cause.
struct Account {
    unit: &'static str,
    busy: u64,
    idle: u64,
    stalls: Vec<(&'static str, u64)>,
}

impl Account {
    fn new(unit: &'static str) -> Self {
        Self { unit, busy: 0, idle: 0, stalls: Vec::new() }
    }
    fn clock(&mut self, busy: bool, cause: Option<&'static str>) {
        match (busy, cause) {
            (true, _) => self.busy += 1,
            (false, None) => self.idle += 1,
            (false, Some(cause)) => match self.stalls.iter_mut().find(|(known, _)| *known == cause) {
                Some((_, clocks)) => *clocks += 1,
                None => self.stalls.push((cause, 1)),
            },
        }
    }
}

struct Access {
    line: u64,
    /// The miss that brings the line: of this access, or of an earlier one.
    miss: usize,
    is_miss: bool,
}

struct TagTap {
    tap: usize,
    accesses: VecDeque<Access>,
}

struct DataTap {
    tap: usize,
    reads_begin: u64,
    words: Vec<u64>,
}

struct Miss {
    address: u64,
    access: u64,
    taken: u64,
    merged: u32,
}

pub fn simulate(machine: &Machine, requests: &[Vec<Tap>]) -> Log {
    let p = &machine.pipeline;
    let mut log = Log::default();
    let taps: Vec<&Tap> = requests.iter().flatten().collect();
    let request_of: Vec<usize> =
        requests.iter().enumerate().flat_map(|(q, taps)| taps.iter().map(move |_| q)).collect();
    let is_last = |tap: usize| tap + 1 == taps.len() || request_of[tap + 1] != request_of[tap];
    log.requests = vec![[0; 3]; requests.len()];
    log.taps = vec![TapClocks::default(); taps.len()];

    let mut request_fifo = Places::new("request_fifo", p.request_fifo);
    let mut lod_fifo = Places::new("lod_fifo", p.lod_fifo);
    let mut tap_fifo = Places::new("tap_fifo", p.tap_fifo);
    let mut fragment_fifo = Places::new("fragment_fifo", p.fragment_fifo);
    let mut result_fifo = Places::new("result_fifo", p.result_fifo);
    let mut miss_queue = Places::new("miss_queue", p.miss_queue);
    let mut reorder_buffer = Places::new("reorder_buffer", p.reorder_buffer);
    let mut miss_status = Places::new("miss_status", p.miss_status);

    let (mut entered, mut at_lod, mut issued, mut at_tag, mut at_data, mut left) = (0, 0, 0, 0, 0, 0);
    let mut cache = Lru::new(machine.sets, machine.ways, machine.line);
    let mut memory = Memory::new(&machine.memory, machine.line);
    let mut misses: Vec<Miss> = Vec::new();
    // Misses of each tap, those the memory has not taken, those that hold a miss-status entry.
    let mut own_misses: Vec<Vec<usize>> = vec![Vec::new(); taps.len()];
    let mut untaken = VecDeque::new();
    let mut held: Vec<usize> = Vec::new();
    let mut in_tag: Option<TagTap> = None;
    let mut in_data: Option<DataTap> = None;
    let mut blocked_by: Option<usize> = None;
    let mut conflicted = false;
    let mut counters = BTreeMap::new();
    let mut t = 0;
    let [mut entry, mut lod, mut sequencer, mut tag, mut miss_port, mut data, mut datapath, mut result] =
        ["entry", "lod", "sequencer", "tag", "miss_port", "data", "datapath", "result"].map(Account::new);
    let bump = |counters: &mut BTreeMap<String, u64>, name: &str, by: u64| {
        *counters.entry(name.to_owned()).or_default() += by;
    };

    while left < requests.len() {
        assert!(t < 50_000_000, "it hangs");
        // Entry.
        let (mut busy, mut cause) = (false, None);
        for _ in 0..p.pixel_pipes {
            if entered == requests.len() {
                break;
            }
            if request_fifo.full() {
                cause = Some("request_fifo");
                break;
            }
            request_fifo.take();
            log.requests[entered][0] = t;
            entered += 1;
            busy = true;
        }
        entry.clock(busy, cause);

        // LOD.
        let (mut busy, mut cause) = (false, None);
        for _ in 0..p.pixel_pipes {
            if at_lod >= entered || log.requests[at_lod][0] + 1 > t {
                break;
            }
            if lod_fifo.full() {
                cause = Some("lod_fifo");
                break;
            }
            lod_fifo.take();
            request_fifo.give_back();
            log.requests[at_lod][1] = t;
            at_lod += 1;
            busy = true;
        }
        lod.clock(busy, cause);

        // Sequencer.
        let (mut busy, mut cause) = (false, None);
        for _ in 0..p.taps_per_clock {
            if issued == taps.len() {
                break;
            }
            let request = request_of[issued];
            if request >= at_lod || log.requests[request][1] + u64::from(p.lod_latency) > t {
                break;
            }
            if tap_fifo.full() {
                cause = Some("tap_fifo");
                break;
            }
            tap_fifo.take();
            log.taps[issued].issue = t;
            if is_last(issued) {
                lod_fifo.give_back();
            }
            issued += 1;
            busy = true;
        }
        sequencer.clock(busy, cause);

        // Miss port and memory.
        let (mut busy, mut cause) = (false, None);
        if let Some(&miss) = untaken.front() {
            let miss: usize = miss;
            if t >= misses[miss].access + u64::from(p.tag_latency) {
                if memory.take(t, miss, misses[miss].address) {
                    misses[miss].taken = t;
                    untaken.pop_front();
                    miss_queue.give_back();
                    busy = true;
                } else {
                    cause = Some("memory");
                }
            }
        }
        miss_port.clock(busy, cause);
        memory.tick(t);
        let filled = |miss: usize| memory.filled.get(miss).copied().flatten();
        held.retain(|&miss| {
            let there = filled(miss) == Some(t);
            if there {
                miss_status.give_back();
            }
            !there
        });

        // Tags.
        let (mut busy, mut cause, mut finished) = (false, None, 0);
        let mut ports = [0; 16];
        loop {
            if in_tag.is_none() {
                if at_tag >= issued || log.taps[at_tag].issue + u64::from(p.address_latency) > t {
                    break;
                }
                if finished == p.taps_per_clock {
                    break;
                }
                if fragment_fifo.full() {
                    cause = Some("fragment_fifo");
                    break;
                }
                fragment_fifo.take();
                tap_fifo.give_back();
                log.taps[at_tag].tag = t;
                // The cache answers in the order of the reads; when is decided below.
                let mut accesses = VecDeque::new();
                let mut seen = Vec::new();
                let mut number = misses.len();
                for &address in &taps[at_tag].addresses {
                    let line = address / u64::from(machine.line);
                    let (miss, is_miss) = match cache.look_up(address, number) {
                        Ok(miss) => (miss, false),
                        Err(()) => (number, true),
                    };
                    if is_miss || !seen.contains(&line) {
                        accesses.push_back(Access { line, miss, is_miss });
                    }
                    number += usize::from(is_miss);
                    seen.push(line);
                    bump(&mut counters, "reads", 1);
                }
                if accesses.is_empty() {
                    busy = true;
                }
                in_tag = Some(TagTap { tap: at_tag, accesses });
                at_tag += 1;
            }
            let Some(tap) = in_tag.as_mut() else { break };
            let Some(access) = tap.accesses.front() else {
                log.taps[tap.tap].tag_done = t;
                finished += 1;
                in_tag = None;
                continue;
            };
            if let Some(miss) = blocked_by
                && filled(miss).is_none_or(|filled| t < filled + 1)
            {
                cause = Some("blocked");
                break;
            }
            let port = bank(p.tag_hash, p.tag_banks, access.line);
            if ports[port] == p.tag_ports {
                conflicted = true;
                break;
            }
            if access.is_miss {
                if p.mode == Mode::Prefetching {
                    if reorder_buffer.full() {
                        cause = Some("reorder_buffer");
                        break;
                    }
                    if miss_status.full() {
                        cause = Some("miss_status");
                        break;
                    }
                }
                if miss_queue.full() {
                    cause = Some("miss_queue");
                    break;
                }
                let number = misses.len();
                assert_eq!(number, access.miss);
                miss_queue.take();
                if p.mode == Mode::Prefetching {
                    reorder_buffer.take();
                    miss_status.take();
                    held.push(number);
                } else {
                    blocked_by = Some(number);
                }
                let address = access.line * u64::from(machine.line);
                misses.push(Miss { address, access: t, taken: 0, merged: 0 });
                own_misses[tap.tap].push(number);
                untaken.push_back(number);
                log.taps[tap.tap].misses += 1;
                bump(&mut counters, "fetches_failed", 1);
            } else {
                if filled(access.miss).is_none_or(|filled| t < filled) {
                    if misses[access.miss].merged == p.merges {
                        cause = Some("merge");
                        break;
                    }
                    misses[access.miss].merged += 1;
                    bump(&mut counters, "fetches_merged", 1);
                }
                bump(&mut counters, "fetches_ok", 1);
            }
            if conflicted {
                bump(&mut counters, "tag_bank_conflicts", 1);
                conflicted = false;
            }
            ports[port] += 1;
            busy = true;
            tap.accesses.pop_front();
        }
        tag.clock(busy, cause);

        // Data.
        let (mut busy, mut cause, mut finished) = (in_data.is_some(), None, 0);
        let mut ports = [0; 16];
        loop {
            if in_data.is_none() {
                let ready = at_data < at_tag
                    && in_tag.as_ref().is_none_or(|tap| tap.tap != at_data)
                    && t >= log.taps[at_data].tag_done + u64::from(p.tag_latency);
                if !ready || finished == p.taps_per_clock {
                    break;
                }
                if own_misses[at_data].iter().any(|&miss| filled(miss).is_none_or(|filled| t < filled)) {
                    cause = Some("fill");
                    break;
                }
                if is_last(at_data) && result_fifo.full() {
                    cause = Some("result_fifo");
                    break;
                }
                let mut writes = 0;
                if p.fill_write_bytes > 0 {
                    writes = own_misses[at_data].len() as u64 * u64::from(machine.line.div_ceil(p.fill_write_bytes));
                }
                if writes > 0 && finished > 0 {
                    break;
                }
                fragment_fifo.give_back();
                if p.mode == Mode::Prefetching {
                    own_misses[at_data].iter().for_each(|_| reorder_buffer.give_back());
                }
                if is_last(at_data) {
                    result_fifo.take();
                }
                log.taps[at_data].data = t;
                let mut words: Vec<u64> =
                    taps[at_data].addresses.iter().map(|address| address / u64::from(p.data_bank_bytes)).collect();
                words.sort_unstable();
                words.dedup();
                bump(&mut counters, "data_words", words.len() as u64);
                bump(&mut counters, "fill_write_clocks", writes);
                in_data = Some(DataTap { tap: at_data, reads_begin: t + writes, words });
                at_data += 1;
                busy = true;
            }
            let Some(tap) = in_data.as_mut() else { break };
            if t < tap.reads_begin {
                break;
            }
            tap.words.retain(|&word| {
                let port = &mut ports[bank(p.data_hash, p.data_banks, word)];
                let read = *port < p.data_ports;
                *port += u32::from(read);
                !read
            });
            if !tap.words.is_empty() {
                bump(&mut counters, "data_conflict_clocks", 1);
                break;
            }
            log.taps[tap.tap].data_done = t;
            log.taps[tap.tap].datapath = t + u64::from(p.data_latency);
            finished += 1;
            in_data = None;
        }
        data.clock(busy, cause);

        // Datapath and result.
        let done = at_data - usize::from(in_data.is_some());
        let busy = log.taps[..done].iter().rev().take_while(|tap| tap.datapath >= t).any(|tap| tap.datapath == t);
        datapath.clock(busy, None);
        let mut busy = false;
        for _ in 0..p.pixel_pipes {
            let last_tap = request_of.partition_point(|&request| request <= left) - 1;
            if left == requests.len()
                || last_tap >= done
                || log.taps[last_tap].datapath + u64::from(p.filter_latency) > t
            {
                break;
            }
            log.requests[left][2] = t;
            result_fifo.give_back();
            left += 1;
            busy = true;
        }
        result.clock(busy, None);

        for places in [
            &mut request_fifo,
            &mut lod_fifo,
            &mut tap_fifo,
            &mut fragment_fifo,
            &mut result_fifo,
            &mut miss_queue,
            &mut reorder_buffer,
            &mut miss_status,
        ] {
            places.end_clock();
        }
        t += 1;
    }

    for account in [entry, lod, sequencer, tag, miss_port, data, datapath, result] {
        counters.insert(format!("{}_busy", account.unit), account.busy);
        counters.insert(format!("{}_idle", account.unit), account.idle);
        for (cause, clocks) in account.stalls {
            counters.insert(format!("{}_stall_{cause}", account.unit), clocks);
        }
    }
    for places in
        [request_fifo, lod_fifo, tap_fifo, fragment_fifo, result_fifo, miss_queue, reorder_buffer, miss_status]
    {
        counters.insert(format!("{}_sum", places.name), places.sum as u64);
        counters.insert(format!("{}_max", places.name), places.most as u64);
    }
    log.misses = misses
        .iter()
        .enumerate()
        .map(|(number, miss)| MissClocks {
            address: miss.address,
            access: miss.access,
            taken: miss.taken,
            filled: memory.filled[number].unwrap_or_default(),
        })
        .collect();
    total(&mut counters, &log, &memory, t, machine.line.into());
    log.counters = counters;
    log
}

/// The counters that are sums of others.
fn total(counters: &mut BTreeMap<String, u64>, log: &Log, memory: &Memory, cycles: u64, line: u64) {
    let get = |counters: &BTreeMap<String, u64>, name: &str| counters.get(name).copied().unwrap_or(0);
    let misses = log.misses.len() as u64;
    let tally = &memory.tally;
    let block = memory_block(memory, line);
    let skipped = get(counters, "reads") - get(counters, "fetches_ok") - get(counters, "fetches_failed");
    let fetch = ["merge", "reorder_buffer", "miss_status", "miss_queue", "blocked"]
        .iter()
        .map(|cause| get(counters, &format!("tag_stall_{cause}")))
        .sum();
    let spread = |values: Vec<u64>| {
        [values.iter().sum(), values.iter().min().copied().unwrap_or(0), values.iter().max().copied().unwrap_or(0)]
    };
    let request_latency = spread(log.requests.iter().map(|[entry, _, result]| result - entry).collect());
    let fill_latency = spread(log.misses.iter().map(|miss| miss.filled - miss.access).collect());
    let derived = [
        ("cycles", cycles),
        ("requests", log.requests.len() as u64),
        ("taps", log.taps.len() as u64),
        ("fetches_skipped", skipped),
        ("fills", misses),
        ("bytes_filled", misses * line),
        ("stall_address", get(counters, "sequencer_stall_tap_fifo")),
        ("stall_fetch", fetch),
        ("stall_wait_read", get(counters, "data_stall_fill")),
        ("stall_ready_read", get(counters, "data_stall_result_fifo") + get(counters, "data_conflict_clocks")),
        ("request_latency_sum", request_latency[0]),
        ("request_latency_min", request_latency[1]),
        ("request_latency_max", request_latency[2]),
        ("fill_latency_sum", fill_latency[0]),
        ("fill_latency_min", fill_latency[1]),
        ("fill_latency_max", fill_latency[2]),
        ("second_level_lookups", tally.second_lookups),
        ("second_level_hits", tally.second_hits),
        ("second_level_misses", tally.second_lookups - tally.second_hits),
        ("memory_requests", tally.requests),
        ("memory_bytes", tally.requests * block),
        ("memory_transfer_clocks", tally.transfer_clocks),
        ("row_hits", tally.row_hits),
        ("row_misses", tally.row_misses),
        ("row_conflicts", tally.row_conflicts),
        ("channel_queue_sum", tally.queue_sum),
        ("channel_queue_max", tally.queue_max),
    ];
    for (name, value) in derived {
        counters.insert(name.to_owned(), value);
    }
}

fn memory_block(memory: &Memory, line: u64) -> u64 {
    memory.second_line().unwrap_or(line)
}
