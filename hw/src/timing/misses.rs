//! What a miss sets going: its places in the reorder buffer, the miss-status entries and the miss queue, and the memory.

use alloc::vec::Vec;

use super::{
    TimingBuildError,
    counters::{PlaneTiming, Spread},
    decompressor::Decompressor,
    dram::Row,
    events::StoredFetch,
    memory::{Ask, Fetch, Memory},
    miss_status::MissStatus,
    parameters::{MemoryParameters, Mode, Parameters},
    queue::{Fifo, Ledger},
    tap_reads::READS_MAX,
};
use crate::{cache::TexelCache, decompression::Piece};

/// The way of a miss.
#[derive(Clone, Debug)]
pub(super) struct Misses {
    line_shift: u32,
    tag_latency: u64,
    pub(super) memory: Memory,
    /// A whole line, at any address.
    line: Ask,
    pub(super) decompressor: Option<Decompressor>,
    pub(super) miss_queue: Fifo,
    /// Whether taps behind a miss pass the tag unit before its line is there: the reorder buffer and the miss-status entries are of such machines.
    prefetching: bool,
    pub(super) reorder_buffer: Fifo,
    pub(super) status: MissStatus,
    /// Clocks of the misses of taps that have not been read, and how many of them are of taps that have.
    unread: Vec<u64>,
    read: usize,
    pub(super) port: Ledger,
    /// In blocking mode, the first clock the next access can be made in.
    pub(super) unblocked: u64,
    /// What the decompressor asked for to fill the last line.
    stored: Vec<StoredFetch>,
    pub(super) stalls: MissStalls,
    pub(super) fill_latency: Spread,
}

/// Clocks by what held a miss up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MissStalls {
    pub(super) reorder_buffer: u64,
    pub(super) miss_status: u64,
    pub(super) miss_queue: u64,
    pub(super) memory: u64,
}

/// A miss that has been timed.
pub(super) struct Missed {
    /// Clock of the access.
    pub(super) clock: u64,
    pub(super) fetch: Fetch,
    /// First clock of the tag unit without an entry, those it waited entered.
    pub(super) next: u64,
}

impl Misses {
    pub(super) fn new(p: &Parameters, memory: &MemoryParameters, cache: &TexelCache) -> Result<Self, TimingBuildError> {
        let geometry = cache.cache().geometry();
        let memory = Memory::new(memory).map_err(TimingBuildError::SecondLevel)?;
        let behind = cache.stored_lines();
        Ok(Self {
            line: memory.ask(0, geometry.line),
            decompressor: behind.map(|behind| Decompressor::new(p, behind, geometry.line, &memory)),
            memory,
            line_shift: geometry.line.trailing_zeros(),
            tag_latency: p.tag_latency.into(),
            miss_queue: Fifo::new(p.miss_queue),
            prefetching: p.mode == Mode::Prefetching,
            reorder_buffer: Fifo::new(p.reorder_buffer),
            unread: Vec::new(),
            read: 0,
            status: MissStatus::new(p.miss_status, p.merges, geometry.lines() as usize),
            port: Ledger::default(),
            unblocked: 0,
            stored: Vec::new(),
            stalls: MissStalls::default(),
            fill_latency: Spread::default(),
        })
    }

    /// An access that misses `line`, which comes to `slot`, the tag unit being free for it from `clock` on and its clocks entered to
    /// before `next`.
    #[inline(always)]
    pub(super) fn miss(&mut self, line: u64, slot: u32, mut clock: u64, next: u64, row: &mut PlaneTiming) -> Missed {
        let mut tag = Ledger::at(next);
        if self.prefetching {
            let room = self.reorder_buffer.room_ahead(self.unread.len() - self.read);
            tag.stall_until(room, &mut self.stalls.reorder_buffer);
            let entry = self.status.room();
            tag.stall_until(entry, &mut self.stalls.miss_status);
            clock = clock.max(room).max(entry);
        }
        let room = self.miss_queue.room();
        tag.stall_until(room, &mut self.stalls.miss_queue);
        clock = clock.max(room);

        let at_port = clock + self.tag_latency;
        self.port.idle_until(at_port);
        let fetch = match self.decompressor.take() {
            None => self.fetch(self.line.at(line << self.line_shift), at_port, row),
            Some(mut decompressor) => {
                let fetch = self.fetch_stored(&mut decompressor, line, at_port, row);
                self.decompressor = Some(decompressor);
                fetch
            }
        };
        self.miss_queue.pass(clock, fetch.taken + 1);
        self.status.fill(slot, fetch.filled);
        if self.prefetching {
            self.status.hold(clock, fetch.filled + 1);
            self.unread.push(clock);
        } else {
            self.unblocked = fetch.filled + 1;
        }

        self.fill_latency.add(fetch.filled - clock);
        row.fetches_failed += 1;
        row.fill_latency_sum += fetch.filled - clock;
        Missed { clock, fetch, next: tag.next() }
    }

    /// Whether another tap may pass the tag unit before those in front of it are read: not if it could need a place of the reorder buffer that one of them
    /// holds.
    #[inline(always)]
    pub(super) fn have_room(&self) -> bool {
        self.unread.is_empty() || self.unread.len() + READS_MAX <= self.reorder_buffer.depth()
    }

    /// The next tap that missed lines, which are so many, is read in clock `data`.
    #[inline(always)]
    pub(super) fn read(&mut self, count: usize, data: u64) {
        if self.prefetching {
            for &access in &self.unread[self.read..][..count] {
                self.reorder_buffer.pass(access, data + 1);
            }
            self.read += count;
            if self.read == self.unread.len() {
                self.unread.clear();
                self.read = 0;
            }
        }
    }

    /// Asks the memory once.
    #[inline(always)]
    fn fetch(&mut self, ask: Ask, at_port: u64, row: &mut PlaneTiming) -> Fetch {
        let fetch = self.memory.fetch(ask, at_port);
        self.port.stall_until(fetch.taken, &mut self.stalls.memory);
        self.port.work(fetch.taken);
        row.second_level_hits += u64::from(fetch.second_level_hit == Some(true));
        match fetch.row {
            Some(Row::Hit) => row.row_hits += 1,
            Some(Row::Miss) => row.row_misses += 1,
            Some(Row::Conflict) => row.row_conflicts += 1,
            None => {}
        }
        fetch
    }

    /// Asks for what is stored behind a line, and decompresses it.
    ///
    /// # Panics
    /// If nothing is: no texel is read from such a line.
    #[inline(never)]
    fn fetch_stored(
        &mut self,
        decompressor: &mut Decompressor,
        line: u64,
        at_port: u64,
        row: &mut PlaneTiming,
    ) -> Fetch {
        let mut came = 0;
        self.stored.clear();
        for Piece { address, bytes } in decompressor.requests(line) {
            let fetch = self.fetch(self.memory.ask(address, bytes), at_port, row);
            came = came.max(fetch.filled);
            row.bytes_fetched += u64::from(bytes);
            self.stored.push(StoredFetch { address, bytes, fetch });
        }
        let last = self.stored.last().expect("a line with a texel, behind which something is stored");
        Fetch { filled: decompressor.decompress(line, came), ..last.fetch }
    }

    /// What the decompressor asked for to fill the last line; nothing without one.
    #[inline(always)]
    pub(super) fn stored(&self) -> &[StoredFetch] {
        &self.stored
    }
}
