//! The machine of docs/timing.md with a clock, written from that page: slow and obvious. It shares no code with the model.

mod account;
mod counters;
mod data;
mod decompressor;
mod front;
mod tags;

use std::{
    collections::{BTreeMap, VecDeque},
    sync::Arc,
};

use texunit_hw::{
    decompression::StoredLines,
    timing::{BankHash, MemoryParameters, Parameters},
};

use self::{
    account::{Account, Places},
    counters::total,
    data::DataTap,
    decompressor::Decompressor,
    tags::TagTap,
};
use crate::memory::{Lru, Memory, Wanted};

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
    /// What memory holds, where a decompressor stands before the cache.
    pub stored: Option<&'static StoredTexture>,
}

/// A texture in memory, texel by texel.
#[derive(Debug)]
pub struct StoredTexture {
    /// Bytes of an element: a texel, or a block of them.
    pub element_bytes: u32,
    /// Address of the element of each texel, by the texel's own address in the cache / 4; none in padding.
    pub elements: Vec<Option<u64>>,
    /// The same as the model takes it, for lines of 16, 32 and 64 bytes.
    pub lines: [Arc<StoredLines>; 3],
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
    /// Requests to memory: clock taken, address, bytes.
    pub requested: Vec<(u64, u64, u64)>,
    pub counters: BTreeMap<String, u64>,
}

struct Miss {
    address: u64,
    access: u64,
    taken: u64,
    merged: u32,
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

/// The whole machine between two clocks.
struct Simulator<'m> {
    machine: &'m Machine,
    p: &'m Parameters,
    line: u32,
    /// How many there are.
    requests: usize,
    taps: Vec<&'m Tap>,
    request_of: Vec<usize>,
    log: Log,
    counters: BTreeMap<String, u64>,

    request_fifo: Places,
    lod_fifo: Places,
    tap_fifo: Places,
    fragment_fifo: Places,
    result_fifo: Places,
    miss_queue: Places,
    reorder_buffer: Places,
    miss_status: Places,

    /// The next request or tap of each stage.
    entered: usize,
    at_lod: usize,
    issued: usize,
    at_tag: usize,
    at_data: usize,
    left: usize,

    cache: Lru,
    memory: Memory,
    misses: Vec<Miss>,
    /// Misses of each tap.
    own_misses: Vec<Vec<usize>>,
    /// Their lines.
    lines: Decompressor,
    /// Requests the memory has not taken: miss, number, what, and whether it is the miss's last.
    untaken: VecDeque<(usize, usize, Wanted, bool)>,
    /// Misses that hold a miss-status entry.
    held: Vec<usize>,
    in_tag: Option<TagTap>,
    in_data: Option<DataTap>,
    blocked_by: Option<usize>,
    conflicted: bool,
    t: u64,
}

impl<'m> Simulator<'m> {
    fn new(machine: &'m Machine, requests: &'m [Vec<Tap>]) -> Self {
        let p = &machine.pipeline;
        let taps: Vec<&Tap> = requests.iter().flatten().collect();
        Self {
            machine,
            p,
            line: machine.line,
            requests: requests.len(),
            request_of: requests.iter().enumerate().flat_map(|(q, taps)| taps.iter().map(move |_| q)).collect(),
            log: Log {
                requests: vec![[0; 3]; requests.len()],
                taps: vec![TapClocks::default(); taps.len()],
                ..Log::default()
            },
            counters: BTreeMap::new(),
            request_fifo: Places::new("request_fifo", p.request_fifo),
            lod_fifo: Places::new("lod_fifo", p.lod_fifo),
            tap_fifo: Places::new("tap_fifo", p.tap_fifo),
            fragment_fifo: Places::new("fragment_fifo", p.fragment_fifo),
            result_fifo: Places::new("result_fifo", p.result_fifo),
            miss_queue: Places::new("miss_queue", p.miss_queue),
            reorder_buffer: Places::new("reorder_buffer", p.reorder_buffer),
            miss_status: Places::new("miss_status", p.miss_status),
            entered: 0,
            at_lod: 0,
            issued: 0,
            at_tag: 0,
            at_data: 0,
            left: 0,
            cache: Lru::new(machine.sets, machine.ways, machine.line),
            memory: Memory::new(&machine.memory),
            misses: Vec::new(),
            own_misses: vec![Vec::new(); taps.len()],
            lines: Decompressor::new(machine),
            untaken: VecDeque::new(),
            held: Vec::new(),
            in_tag: None,
            in_data: None,
            blocked_by: None,
            conflicted: false,
            t: 0,
            taps,
        }
    }

    /// Whether a tap is the last of its request.
    fn is_last(&self, tap: usize) -> bool {
        tap + 1 == self.taps.len() || self.request_of[tap + 1] != self.request_of[tap]
    }

    fn places(&mut self) -> [&mut Places; 8] {
        [
            &mut self.request_fifo,
            &mut self.lod_fifo,
            &mut self.tap_fifo,
            &mut self.fragment_fifo,
            &mut self.result_fifo,
            &mut self.miss_queue,
            &mut self.reorder_buffer,
            &mut self.miss_status,
        ]
    }
}

pub fn simulate(machine: &Machine, requests: &[Vec<Tap>]) -> Log {
    let mut machine = Simulator::new(machine, requests);
    let mut accounts = ["entry", "lod", "sequencer", "miss_port", "decompressor", "tag", "data", "datapath", "result"]
        .map(Account::new);
    while machine.left < requests.len() {
        assert!(machine.t < 50_000_000, "it hangs");
        // In this order: a stage sees what those before it did in the same clock.
        let clocks = [
            machine.entry(),
            machine.lod(),
            machine.sequencer(),
            machine.miss_port(),
            machine.decompressor(),
            machine.tags(),
            machine.data(),
            machine.datapath(),
            machine.result(),
        ];
        for (account, clock) in accounts.iter_mut().zip(clocks) {
            account.clock(clock);
        }
        machine.places().into_iter().for_each(Places::end_clock);
        machine.t += 1;
    }
    let mut counters = std::mem::take(&mut machine.counters);
    for account in accounts {
        counters.insert(format!("{}_busy", account.unit), account.busy);
        counters.insert(format!("{}_idle", account.unit), account.idle);
        for (cause, clocks) in account.stalls {
            counters.insert(format!("{}_stall_{cause}", account.unit), clocks);
        }
    }
    for places in machine.places() {
        counters.insert(format!("{}_sum", places.name), places.sum as u64);
        counters.insert(format!("{}_max", places.name), places.most as u64);
    }
    let misses = machine.misses.iter().enumerate().map(|(number, miss)| MissClocks {
        address: miss.address,
        access: miss.access,
        taken: miss.taken,
        filled: machine.lines.there(&machine.memory, number).unwrap_or_default(),
    });
    let misses = misses.collect();
    let Simulator { mut log, memory, t, line, .. } = machine;
    log.misses = misses;
    total(&mut counters, &log, &memory, t, line.into());
    log.counters = counters;
    log
}
