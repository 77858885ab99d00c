//! Time: when each tap passes each unit, exactly, without a clock.
//!
//! The pipeline is in order and its FIFOs are bounded, so the clock at which an item enters a unit is a maximum of sums of earlier
//! clocks (max-plus). [`Timing`] computes them tap by tap as the address stream passes. The machine is docs/timing.md; the
//! simulator that ticks, and with which this must agree on every clock, is in the tests.

mod banks;
mod counters;
mod data_banks;
mod dram;
mod events;
mod memory;
mod miss_status;
mod parameters;
mod queue;
mod tap_reads;

pub use banks::BankHash;
pub use counters::{HISTOGRAM_MAX, Histograms, PlaneTiming, TimingCounters};
pub use dram::{DramParameters, Mapping, Page, Row};
pub use events::{FillTimes, RequestTimes, TapTimes, TimingObserver};
pub use memory::Fetch;
pub use parameters::{MainMemory, MemoryParameters, Mode, Parameters, SecondLevelParameters, TimingError};

use alloc::vec::Vec;

use crate::{
    address::{Footprint, is_outside},
    cache::TexelCache,
    unit::{Batch, Sink},
};
use banks::Banks;
use counters::Spread;
use data_banks::DataBanks;
use memory::Memory;
use miss_status::MissStatus;
use queue::{Fifo, Ledger, Width};
use tap_reads::{Access, READS_MAX, TapReads};

/// Why a timing model cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimingBuildError {
    /// A parameter of the pipeline or the memory.
    Timing(TimingError),
    /// The shape of the second-level cache.
    SecondLevel(crate::cache::GeometryError),
}

impl core::fmt::Display for TimingBuildError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Timing(error) => error.fmt(f),
            Self::SecondLevel(error) => write!(f, "second-level.{error}"),
        }
    }
}

impl core::error::Error for TimingBuildError {}

/// A cache in time: takes the place of the [`TexelCache`] it holds as the sink of a unit, and counts the same hits and misses.
///
/// ```
/// use texunit_hw::{Geometry, Policy};
/// use texunit_hw::cache::{Detail, TexelCache};
/// use texunit_hw::timing::{MainMemory, MemoryParameters, Parameters, Timing};
/// let cache = TexelCache::new(Geometry { sets: 64, ways: 4, line: 64 }, Policy::Lru, 4, Detail::default()).unwrap();
/// let memory = MemoryParameters { main: MainMemory::Fixed { latency: 100, bytes_per_clock: 16 }, second_level: None };
/// let mut timing = Timing::new(&Parameters::default(), &memory, cache, 4, ())?;
/// timing.request([(0, &[0x100u64, 0x104, 0x110, 0x114][..])]); // one bilinear tap of plane 0: one line
/// let counters = timing.counters();
/// // enter 0, LOD 1, issue 3, tags 6, memory 7 + 100 + 4, data 111, datapath 112, leaves 116
/// assert_eq!((counters.cycles, counters.fills, counters.stall_wait_read), (117, 1, 104));
/// # Ok::<(), texunit_hw::timing::TimingBuildError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Timing<O = ()> {
    parameters: Parameters,
    cache: TexelCache,
    line_shift: u32,
    /// Clocks of writing one line into the banks.
    line_write: u64,
    memory: Memory,
    observer: O,

    entry: Width,
    lod: Width,
    sequencer: Width,
    /// Taps by the clock they finish in.
    tag: Width,
    data: Width,
    result: Width,
    request_fifo: Fifo,
    lod_fifo: Fifo,
    tap_fifo: Fifo,
    fragment_fifo: Fifo,
    result_fifo: Fifo,
    miss_queue: Fifo,
    reorder_buffer: Fifo,
    miss_status: MissStatus,
    tag_banks: Banks,
    data_banks: DataBanks,
    /// In blocking mode, the first clock the next access can be made in.
    unblocked: u64,

    /// Accesses of the tap at hand, and the clocks of those that missed.
    reads: TapReads,
    miss_clocks: [u64; READS_MAX],

    ledgers: Ledgers,
    counters: TimingCounters,
    planes: Vec<PlaneTiming>,
    histograms: Histograms,
    request_latency: Spread,
    fill_latency: Spread,
}

#[derive(Clone, Copy, Debug, Default)]
struct Ledgers {
    lod: Ledger,
    sequencer: Ledger,
    tag: Ledger,
    miss_port: Ledger,
    data: Ledger,
}

/// A request on its way through the front end.
#[derive(Clone, Copy, Debug)]
struct Started {
    entry: u64,
    lod: u64,
    /// First clock its taps can be issued in.
    ready: u64,
}

/// A tap that has been timed, as far as its request needs to know.
#[derive(Clone, Copy, Debug)]
struct Timed {
    issue: u64,
    data: u64,
    datapath: u64,
}

/// The planes of one request, counted without an allocation: a filter reads few.
#[derive(Clone, Copy, Debug, Default)]
struct PlanesRead {
    seen: [usize; 8],
    count: usize,
}

impl PlanesRead {
    #[inline(always)]
    fn add(&mut self, plane: usize) {
        if self.count < self.seen.len() && !self.seen[..self.count].contains(&plane) {
            self.seen[self.count] = plane;
            self.count += 1;
        }
    }
}

impl<O: TimingObserver> Timing<O> {
    /// A machine at rest with this cache, for taps of at most `reads_per_tap` reads.
    ///
    /// # Errors
    /// A machine that cannot run, or would hang.
    pub fn new(
        parameters: &Parameters,
        memory: &MemoryParameters,
        cache: TexelCache,
        reads_per_tap: u32,
        observer: O,
    ) -> Result<Self, TimingBuildError> {
        let geometry = cache.cache().geometry();
        parameters.check(reads_per_tap, cache.bytes_per_read()).map_err(TimingBuildError::Timing)?;
        memory.check(geometry.line).map_err(TimingBuildError::Timing)?;
        let p = *parameters;
        Ok(Self {
            parameters: p,
            line_shift: geometry.line.trailing_zeros(),
            line_write: match p.fill_write_bytes {
                0 => 0,
                bytes => geometry.line.div_ceil(bytes).into(),
            },
            memory: Memory::new(memory, geometry.line).map_err(TimingBuildError::SecondLevel)?,
            observer,
            entry: Width::new(p.pixel_pipes),
            lod: Width::new(p.pixel_pipes),
            sequencer: Width::new(p.taps_per_clock),
            tag: Width::new(p.taps_per_clock),
            data: Width::new(p.taps_per_clock),
            result: Width::new(p.pixel_pipes),
            request_fifo: Fifo::new(p.request_fifo),
            lod_fifo: Fifo::new(p.lod_fifo),
            tap_fifo: Fifo::new(p.tap_fifo),
            fragment_fifo: Fifo::new(p.fragment_fifo),
            result_fifo: Fifo::new(p.result_fifo),
            miss_queue: Fifo::new(p.miss_queue),
            reorder_buffer: Fifo::new(p.reorder_buffer),
            miss_status: MissStatus::new(p.miss_status, p.merges, geometry.lines() as usize),
            tag_banks: Banks::new(p.tag_banks, p.tag_ports, p.tag_hash),
            data_banks: DataBanks::new(&p),
            unblocked: 0,
            reads: TapReads::default(),
            miss_clocks: [0; READS_MAX],
            ledgers: Ledgers::default(),
            counters: TimingCounters::default(),
            planes: Vec::new(),
            histograms: Histograms::default(),
            request_latency: Spread::default(),
            fill_latency: Spread::default(),
            cache,
        })
    }

    /// Times one request: its taps in order, each with its plane and the addresses it reads.
    ///
    /// # Panics
    /// If a tap has more reads than the machine was built for, or than any tap has.
    pub fn request<'a>(&mut self, taps: impl IntoIterator<Item = (usize, &'a [u64])>) {
        let request = self.start();
        let (mut planes, mut count, mut last) = (PlanesRead::default(), 0, None);
        let mut taps = taps.into_iter().peekable();
        while let Some((plane, addresses)) = taps.next() {
            planes.add(plane);
            count += 1;
            self.reads.clear();
            self.look_up(plane, addresses);
            last = Some(self.tap(&request, plane, addresses, 0, taps.peek().is_none()));
        }
        if let Some(last) = last {
            self.finish(&request, last, count, planes.count);
        }
    }

    /// Looks up one more tap, address by address.
    fn look_up(&mut self, plane: usize, addresses: &[u64]) {
        self.reads.tap();
        self.cache.read_observed(plane, addresses, &mut self.reads);
    }

    #[inline(always)]
    fn start(&mut self) -> Started {
        let (ledgers, counters) = (&mut self.ledgers, &mut self.counters);
        let entry = self.entry.take(self.request_fifo.room());
        let room = self.lod_fifo.room();
        let lod = self.lod.take(room.max(entry + 1));
        ledgers.lod.take(entry + 1, room, lod, &mut counters.lod_stall_lod_fifo);
        self.request_fifo.pass(entry, lod + 1);
        Started { entry, lod, ready: lod + u64::from(self.parameters.lod_latency) }
    }

    #[inline(always)]
    fn finish(&mut self, request: &Started, last: Timed, taps: usize, planes: usize) {
        let done = last.datapath + u64::from(self.parameters.filter_latency);
        let result = self.result.take(done);
        self.lod_fifo.pass(request.lod, last.issue + 1);
        self.result_fifo.pass(last.data, result + 1);

        self.observer.request(RequestTimes {
            request: self.counters.requests,
            entry: request.entry,
            lod: request.lod,
            result,
        });
        self.counters.requests += 1;
        self.counters.cycles = result + 1;
        self.request_latency.add(result - request.entry);
        self.histograms.taps[taps.min(HISTOGRAM_MAX)] += 1;
        self.histograms.planes[planes.min(HISTOGRAM_MAX)] += 1;
        let probes = if planes == 1 { taps } else { taps / planes };
        self.histograms.anisotropy[probes.min(HISTOGRAM_MAX)] += 1;
    }

    /// One tap through every unit, `number` among those looked up.
    #[inline(always)]
    fn tap(&mut self, request: &Started, plane: usize, addresses: &[u64], number: usize, is_last: bool) -> Timed {
        if plane >= self.planes.len() {
            self.planes.resize(plane + 1, PlaneTiming::default());
        }
        let Parameters { mode, address_latency, tag_latency, data_latency, .. } = self.parameters;

        // Sequencer and address unit.
        let room = self.tap_fifo.room();
        let issue = self.sequencer.take(room.max(request.ready));
        let stalls = &mut self.counters.sequencer_stall_tap_fifo;
        self.ledgers.sequencer.take(request.ready, room, issue, stalls);

        // Tag unit.
        let at_door = issue + u64::from(address_latency);
        self.ledgers.tag.idle_until(at_door);
        let room = self.fragment_fifo.room();
        self.ledgers.tag.stall_until(room, &mut self.counters.tag_stall_fragment_fifo);
        let tag = self.tag.earliest(at_door.max(room));
        self.tap_fifo.pass(issue, tag + 1);
        let accessed = self.access_lines(plane, tag, number);
        let tag_done = accessed.done;
        self.tag.count(tag_done);

        // Data banks.
        let at_door = tag_done + u64::from(tag_latency);
        let data_ledger = &mut self.ledgers.data;
        data_ledger.idle_until(at_door);
        let waited = data_ledger.stall_until(accessed.filled, &mut self.counters.data_stall_fill);
        let mut ready = at_door.max(accessed.filled);
        if is_last {
            let room = self.result_fifo.room();
            data_ledger.stall_until(room, &mut self.counters.data_stall_result_fifo);
            ready = ready.max(room);
        }
        let mut data = self.data.earliest(ready);
        let writes = u64::from(accessed.misses) * self.line_write;
        if writes > 0 && data == self.data.last() {
            data += 1;
        }
        let (data_done, words) = self.data_banks.read(addresses, data + writes);
        self.counters.data_words += words;
        self.data.count(data_done);
        self.ledgers.data.work_through(data_done);
        self.fragment_fifo.pass(tag, data + 1);
        if mode == Mode::Prefetching {
            for &access in &self.miss_clocks[..accessed.misses as usize] {
                self.reorder_buffer.pass(access, data + 1);
            }
        }

        let datapath = data_done + u64::from(data_latency);
        let counters = &mut self.counters;
        counters.fill_write_clocks += writes;
        counters.data_conflict_clocks += data_done - data - writes;
        let row = &mut self.planes[plane];
        row.taps += 1;
        row.reads += addresses.len() as u64;
        row.stall_wait_read += waited;
        self.observer.tap(TapTimes {
            tap: counters.taps,
            request: counters.requests,
            plane: plane as u16,
            issue,
            tag,
            tag_done,
            data,
            data_done,
            datapath,
            misses: accessed.misses,
        });
        counters.taps += 1;
        Timed { issue, data, datapath }
    }

    /// The line accesses of a tap that entered the tag unit at `tag`.
    #[inline(always)]
    fn access_lines(&mut self, plane: usize, tag: u64, number: usize) -> Accessed {
        let mut accessed = Accessed { done: tag, filled: 0, misses: 0 };
        let range = self.reads.of_tap(number);
        let accesses = range.len();
        for access in range {
            let Access { line, slot, hit } = self.reads.access(access);
            let from = accessed.done.max(self.unblocked);
            self.ledgers.tag.stall_until(from, &mut self.counters.tag_stall_blocked);
            let bank = self.tag_banks.bank(line);
            let clock = self.tag_banks.earliest(bank, from);
            self.counters.tag_bank_conflicts += u64::from(clock > from);
            let clock =
                if hit { self.hit(plane, slot, clock) } else { self.miss(plane, line, slot, clock, &mut accessed) };
            self.tag_banks.take(bank, clock);
            self.ledgers.tag.work(clock);
            accessed.done = clock;
        }
        if accesses == 0 {
            self.ledgers.tag.work(tag);
        }
        let row = &mut self.planes[plane];
        row.fetches_ok += accesses as u64 - u64::from(accessed.misses);
        row.fetches_failed += u64::from(accessed.misses);
        accessed
    }

    /// The clock of an access that hits.
    #[inline(always)]
    fn hit(&mut self, plane: usize, slot: u32, clock: u64) -> u64 {
        let filled = self.miss_status.filled(slot);
        if clock >= filled {
            return clock;
        }
        if self.miss_status.merge(slot) {
            self.planes[plane].fetches_merged += 1;
            return clock;
        }
        self.ledgers.tag.stall_until(filled, &mut self.counters.tag_stall_merge);
        filled
    }

    /// The clock of an access that misses, after everything it sets going.
    #[inline(never)]
    fn miss(&mut self, plane: usize, line: u64, slot: u32, mut clock: u64, accessed: &mut Accessed) -> u64 {
        let (tag, counters) = (&mut self.ledgers.tag, &mut self.counters);
        let prefetching = self.parameters.mode == Mode::Prefetching;
        if prefetching {
            let room = self.reorder_buffer.room_ahead(accessed.misses as usize);
            tag.stall_until(room, &mut counters.tag_stall_reorder_buffer);
            let entry = self.miss_status.room(clock.max(room));
            tag.stall_until(entry, &mut counters.tag_stall_miss_status);
            clock = clock.max(entry);
        }
        let room = self.miss_queue.room();
        tag.stall_until(room, &mut counters.tag_stall_miss_queue);
        clock = clock.max(room);

        let address = line << self.line_shift;
        let at_port = clock + u64::from(self.parameters.tag_latency);
        let fetch = self.memory.fetch(address, at_port);
        let port = &mut self.ledgers.miss_port;
        port.idle_until(at_port);
        port.stall_until(fetch.taken, &mut counters.miss_port_stall_memory);
        port.work(fetch.taken);
        self.miss_queue.pass(clock, fetch.taken + 1);
        self.miss_status.fill(slot, fetch.filled);
        if prefetching {
            self.miss_status.hold(clock, fetch.filled + 1);
        } else {
            self.unblocked = fetch.filled + 1;
        }
        accessed.filled = accessed.filled.max(fetch.filled);
        self.miss_clocks[accessed.misses as usize] = clock;
        accessed.misses += 1;

        self.fill_latency.add(fetch.filled - clock);
        let row = &mut self.planes[plane];
        row.fill_latency_sum += fetch.filled - clock;
        row.second_level_hits += u64::from(fetch.second_level_hit == Some(true));
        match fetch.row {
            Some(Row::Hit) => row.row_hits += 1,
            Some(Row::Miss) => row.row_misses += 1,
            Some(Row::Conflict) => row.row_conflicts += 1,
            None => {}
        }
        self.observer.fill(FillTimes { tap: counters.taps, plane: plane as u16, address, access: clock, fetch });
        clock
    }

    /// Totals so far.
    #[must_use]
    pub fn counters(&self) -> TimingCounters {
        let mut c = self.counters;
        let cycles = c.cycles;
        let sum = |field: fn(&PlaneTiming) -> u64| self.planes.iter().map(field).sum::<u64>();
        c.reads = sum(|row| row.reads);
        c.fetches_ok = sum(|row| row.fetches_ok);
        c.fetches_failed = sum(|row| row.fetches_failed);
        c.fetches_skipped = c.reads - c.fetches_ok - c.fetches_failed;
        c.fetches_merged = sum(|row| row.fetches_merged);
        c.fills = c.fetches_failed;
        c.bytes_filled = c.fills << self.line_shift;
        c.stall_address = c.sequencer_stall_tap_fifo;
        c.stall_fetch = c.tag_stall_merge
            + c.tag_stall_reorder_buffer
            + c.tag_stall_miss_status
            + c.tag_stall_miss_queue
            + c.tag_stall_blocked;
        c.stall_wait_read = c.data_stall_fill;
        c.stall_ready_read = c.data_stall_result_fifo + c.data_conflict_clocks;

        let close = |mut ledger: Ledger| {
            ledger.idle_until(cycles);
            (ledger.busy, ledger.idle)
        };
        // The requester is never without a request before the last; the datapath takes what the data unit finishes; neither it nor
        // the result is ever held up.
        c.entry_busy = self.entry.busy();
        c.entry_idle = cycles - (self.entry.last() + 1).min(cycles);
        c.entry_stall_request_fifo = cycles - c.entry_idle - c.entry_busy;
        (c.datapath_busy, c.datapath_idle) = (self.data.busy(), cycles - self.data.busy());
        (c.result_busy, c.result_idle) = (self.result.busy(), cycles - self.result.busy());
        (c.lod_busy, c.lod_idle) = close(self.ledgers.lod);
        (c.sequencer_busy, c.sequencer_idle) = close(self.ledgers.sequencer);
        (c.tag_busy, c.tag_idle) = close(self.ledgers.tag);
        (c.miss_port_busy, c.miss_port_idle) = close(self.ledgers.miss_port);
        (c.data_busy, c.data_idle) = close(self.ledgers.data);

        let usage = |fifo: &Fifo| (fifo.clocks(), fifo.most());
        (c.request_fifo_sum, c.request_fifo_max) = usage(&self.request_fifo);
        (c.lod_fifo_sum, c.lod_fifo_max) = usage(&self.lod_fifo);
        (c.tap_fifo_sum, c.tap_fifo_max) = usage(&self.tap_fifo);
        (c.fragment_fifo_sum, c.fragment_fifo_max) = usage(&self.fragment_fifo);
        (c.result_fifo_sum, c.result_fifo_max) = usage(&self.result_fifo);
        (c.miss_queue_sum, c.miss_queue_max) = usage(&self.miss_queue);
        (c.reorder_buffer_sum, c.reorder_buffer_max) = usage(&self.reorder_buffer);
        (c.miss_status_sum, c.miss_status_max) = self.miss_status.usage();

        let spread = |spread: &Spread| (spread.sum, spread.least(), spread.most);
        (c.request_latency_sum, c.request_latency_min, c.request_latency_max) = spread(&self.request_latency);
        (c.fill_latency_sum, c.fill_latency_min, c.fill_latency_max) = spread(&self.fill_latency);

        (c.second_level_lookups, c.second_level_hits) = self.memory.second_level();
        c.second_level_misses = c.second_level_lookups - c.second_level_hits;
        c.memory_requests = self.memory.requests();
        c.memory_bytes = self.memory.bytes();
        c.memory_transfer_clocks = self.memory.transfer_clocks();
        [c.row_hits, c.row_misses, c.row_conflicts] = self.memory.rows();
        (c.channel_queue_sum, c.channel_queue_max) = self.memory.queue_use();
        c
    }

    /// The same per plane, up to the highest plane read so far.
    #[must_use]
    pub fn planes(&self) -> Vec<PlaneTiming> {
        let line = self.line_shift;
        self.planes.iter().map(|row| PlaneTiming { bytes_filled: row.fetches_failed << line, ..*row }).collect()
    }

    /// Requests by taps, planes and probes.
    #[must_use]
    pub const fn histograms(&self) -> &Histograms {
        &self.histograms
    }

    /// The cache within, with its counters.
    #[must_use]
    pub const fn cache(&self) -> &TexelCache {
        &self.cache
    }

    /// Whoever has been watching.
    #[must_use]
    pub fn into_observer(self) -> O {
        self.observer
    }
}

/// What the tag unit made of a tap.
struct Accessed {
    /// Clock of the last access.
    done: u64,
    /// Clock at which all lines missed are there.
    filled: u64,
    misses: u32,
}

impl<O: TimingObserver> Sink for Timing<O> {
    /// Times the requests of a batch.
    fn take(&mut self, batch: Batch<'_>) {
        let channels_apart = batch.surface.reads_per_texel() > 1;
        let mut gathered = [0; READS_MAX];
        self.reads.clear();
        if channels_apart {
            for tap in batch.taps {
                let addresses = gather(&batch, tap, channels_apart, &mut gathered);
                self.look_up(tap.plane.into(), addresses);
            }
        } else {
            self.cache.take_observed(batch, &mut self.reads);
        }
        let mut number = 0;
        for taps in batch.per_request() {
            let request = self.start();
            let (mut planes, mut last) = (PlanesRead::default(), None);
            for (of_request, tap) in taps.iter().enumerate() {
                planes.add(tap.plane.into());
                let addresses = gather(&batch, tap, channels_apart, &mut gathered);
                let is_last = of_request + 1 == taps.len();
                last = Some(self.tap(&request, tap.plane.into(), addresses, number, is_last));
                number += 1;
            }
            if let Some(last) = last {
                self.finish(&request, last, taps.len(), planes.count);
            }
        }
    }
}

/// The addresses a tap reads, in order: those of the footprint itself where nothing is to be added or left out.
#[inline(always)]
fn gather<'a>(
    batch: &Batch<'_>,
    tap: &'a Footprint,
    channels_apart: bool,
    gathered: &'a mut [u64; READS_MAX],
) -> &'a [u64] {
    let addresses = &tap.address[..batch.texels_per_tap];
    if !channels_apart && !addresses.iter().any(|&address| is_outside(address)) {
        return addresses;
    }
    let mut count = 0;
    Batch { taps: core::slice::from_ref(tap), ..*batch }.for_each_read(|_, address| {
        gathered[count] = address;
        count += 1;
    });
    &gathered[..count]
}
