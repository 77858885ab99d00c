//! Time: when each tap passes each unit, exactly, without a clock.
//!
//! The pipeline is in order and its FIFOs are bounded, so the clock at which an item enters a unit is a maximum of sums of earlier
//! clocks (max-plus). [`Timing`] computes them tap by tap as the address stream passes. The machine is docs/timing.md; the
//! simulator that ticks, and with which this must agree on every clock, is in the tests.

mod banks;
mod counters;
mod data_banks;
mod decompressor;
mod dram;
mod events;
mod memory;
mod miss_status;
mod misses;
mod parameters;
mod pipeline;
mod queue;
mod single;
mod tap_reads;
mod taps;

pub use banks::BankHash;
pub use counters::{HISTOGRAM_MAX, Histograms, PlaneTiming, TimingCounters};
pub use dram::{DramParameters, Mapping, Page, Row};
pub use events::{FillTimes, RequestTimes, StoredFetch, TapTimes, TimingObserver};
pub use memory::Fetch;
pub use parameters::{MainMemory, MemoryParameters, Mode, Parameters, SecondLevelParameters, TimingError};

use alloc::vec::Vec;

use crate::{
    address::{Footprint, is_outside},
    batch::{Batch, Sink},
    cache::TexelCache,
    lanes::BankLanes,
};
use counters::Spread;
use misses::Misses;
use pipeline::{Beside, Pipeline};
use queue::{Fifo, Ledger};
use tap_reads::TapReads;
use taps::{Gathered, InPlace, Taps};

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
    /// Whether the machine does one thing a clock.
    single: bool,
    pipeline: Pipeline,
    misses: Misses,
    observer: O,
    planes: Vec<PlaneTiming>,
    histograms: Histograms,

    /// What the cache made of the taps at hand.
    reads: TapReads,
    /// Their addresses, where they are not those of footprints.
    gathered: Gathered,
    bank_lanes: Option<BankLanes>,
    /// Eight taps of the batch a byte: whether their words are known to lie in different banks.
    apart: Vec<u8>,
}

impl<O: TimingObserver> Timing<O> {
    /// A machine at rest with this cache, for taps of at most `reads_per_tap` reads. A decompressor stands before the cache where the cache
    /// was told so ([`TexelCache::with_decompressor`]).
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
        let one_by_one = p.data_hash == BankHash::Low && Pipeline::is_single(&p);
        Ok(Self {
            parameters: p,
            line_shift: geometry.line.trailing_zeros(),
            line_write: match p.fill_write_bytes {
                0 => 0,
                bytes => geometry.line.div_ceil(bytes).into(),
            },
            single: Pipeline::is_single(&p),
            pipeline: Pipeline::new(&p),
            misses: Misses::new(&p, memory, &cache)?,
            observer,
            planes: Vec::new(),
            histograms: Histograms::default(),
            reads: TapReads::default(),
            gathered: Gathered::default(),
            bank_lanes: BankLanes::new(p.data_bank_bytes.trailing_zeros(), p.data_banks).filter(|_| one_by_one),
            apart: Vec::new(),
            cache,
        })
    }

    /// Times one request: its taps in order, each with its plane and the addresses it reads.
    ///
    /// # Panics
    /// If a tap has more reads than the machine was built for, or than any tap has; with a decompressor, if it reads where nothing is
    /// stored.
    pub fn request<'a>(&mut self, taps: impl IntoIterator<Item = (usize, &'a [u64])>) {
        let mut gathered = core::mem::take(&mut self.gathered);
        gathered.clear();
        for (plane, addresses) in taps {
            gathered.tap(plane as u16);
            addresses.iter().for_each(|&address| gathered.read(address));
        }
        self.look_up_and_time(core::iter::once(gathered.len()), &gathered);
        self.gathered = gathered;
    }

    /// Looks up taps address by address, and times them.
    fn look_up_and_time(&mut self, taps_of_requests: impl Iterator<Item = usize>, taps: &Gathered) {
        self.reads.clear(taps.len());
        for tap in 0..taps.len() {
            self.reads.tap();
            self.cache.read_observed(taps.plane(tap).into(), taps.addresses(tap), &mut self.reads);
        }
        self.time(taps_of_requests, taps);
    }

    /// Times taps that have been looked up.
    fn time(&mut self, taps_of_requests: impl Iterator<Item = usize>, taps: &impl Taps) {
        let Self { parameters, line_write, line_shift, misses, planes, histograms, observer, reads, .. } = self;
        let (line_write, line_shift) = (*line_write, *line_shift);
        let beside = Beside { parameters, line_write, line_shift, misses, planes, histograms, observer };
        if self.single {
            self.pipeline.time_single(taps_of_requests, taps, reads, beside);
        } else {
            self.pipeline.time(taps_of_requests, taps, reads, beside);
        }
    }

    /// Totals so far.
    #[must_use]
    pub fn counters(&self) -> TimingCounters {
        let (pipe, misses, counts) = (&self.pipeline, &self.misses, &self.pipeline.counts);
        let cycles = counts.cycles;
        let sum = |field: fn(&PlaneTiming) -> u64| self.planes.iter().map(field).sum::<u64>();
        let mut c = TimingCounters {
            cycles,
            requests: counts.requests,
            taps: counts.taps,
            reads: sum(|row| row.reads),
            fetches_ok: sum(|row| row.fetches_ok),
            fetches_failed: sum(|row| row.fetches_failed),
            fetches_merged: sum(|row| row.fetches_merged),
            tag_bank_conflicts: counts.tag_bank_conflicts,
            data_words: counts.data_words,
            data_conflict_clocks: counts.data_conflict_clocks,
            fill_write_clocks: counts.fill_write_clocks,
            lod_stall_lod_fifo: counts.lod_stall_lod_fifo,
            sequencer_stall_tap_fifo: counts.sequencer_stall_tap_fifo,
            tag_stall_fragment_fifo: counts.tag_stall_fragment_fifo,
            tag_stall_merge: counts.tag_stall_merge,
            tag_stall_blocked: counts.tag_stall_blocked,
            tag_stall_reorder_buffer: misses.stalls.reorder_buffer,
            tag_stall_miss_status: misses.stalls.miss_status,
            tag_stall_miss_queue: misses.stalls.miss_queue,
            miss_port_stall_memory: misses.stalls.memory,
            data_stall_fill: counts.data_stall_fill,
            data_stall_result_fifo: counts.data_stall_result_fifo,
            ..TimingCounters::default()
        };
        c.fetches_skipped = c.reads - c.fetches_ok - c.fetches_failed;
        c.fills = c.fetches_failed;
        c.bytes_filled = c.fills << self.line_shift;
        c.bytes_fetched = c.bytes_filled;
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
        c.entry_busy = pipe.entry.busy();
        c.entry_idle = cycles - (pipe.entry.last() + 1).min(cycles);
        c.entry_stall_request_fifo = cycles - c.entry_idle - c.entry_busy;
        (c.datapath_busy, c.datapath_idle) = (pipe.data.busy(), cycles - pipe.data.busy());
        (c.result_busy, c.result_idle) = (pipe.result.busy(), cycles - pipe.result.busy());
        (c.lod_busy, c.lod_idle) = close(pipe.ledgers.lod);
        (c.sequencer_busy, c.sequencer_idle) = close(pipe.ledgers.sequencer);
        (c.tag_busy, c.tag_idle) = close(pipe.ledgers.tag);
        (c.miss_port_busy, c.miss_port_idle) = close(misses.port);
        (c.data_busy, c.data_idle) = close(pipe.ledgers.data);

        let usage = |fifo: &Fifo| (fifo.clocks(), fifo.most());
        (c.request_fifo_sum, c.request_fifo_max) = usage(&pipe.request_fifo);
        (c.lod_fifo_sum, c.lod_fifo_max) = usage(&pipe.lod_fifo);
        (c.tap_fifo_sum, c.tap_fifo_max) = usage(&pipe.tap_fifo);
        (c.fragment_fifo_sum, c.fragment_fifo_max) = usage(&pipe.fragment_fifo);
        (c.result_fifo_sum, c.result_fifo_max) = usage(&pipe.result_fifo);
        (c.miss_queue_sum, c.miss_queue_max) = usage(&misses.miss_queue);
        (c.reorder_buffer_sum, c.reorder_buffer_max) = usage(&misses.reorder_buffer);
        (c.miss_status_sum, c.miss_status_max) = misses.status.usage();

        let spread = |spread: &Spread| (spread.sum, spread.least(), spread.most);
        (c.request_latency_sum, c.request_latency_min, c.request_latency_max) = spread(&pipe.request_latency);
        (c.fill_latency_sum, c.fill_latency_min, c.fill_latency_max) = spread(&misses.fill_latency);

        c.decompressor_idle = cycles;
        if let Some(decompressor) = &misses.decompressor {
            c.bytes_fetched = decompressor.bytes;
            c.decompressor_busy = decompressor.busy;
            c.decompressor_idle -= decompressor.busy;
            c.decompressor_wait_sum = decompressor.wait;
        }
        (c.second_level_lookups, c.second_level_hits) = misses.memory.second_level();
        c.second_level_misses = c.second_level_lookups - c.second_level_hits;
        c.memory_requests = misses.memory.requests();
        c.memory_bytes = misses.memory.bytes();
        c.memory_transfer_clocks = misses.memory.transfer_clocks();
        [c.row_hits, c.row_misses, c.row_conflicts] = misses.memory.rows();
        (c.channel_queue_sum, c.channel_queue_max) = misses.memory.queue_use();
        c
    }

    /// The same per plane, up to the highest plane read so far.
    #[must_use]
    pub fn planes(&self) -> Vec<PlaneTiming> {
        let of = |row: &PlaneTiming| {
            let bytes_filled = row.fetches_failed << self.line_shift;
            let bytes_fetched = if self.misses.decompressor.is_some() { row.bytes_fetched } else { bytes_filled };
            PlaneTiming { bytes_filled, bytes_fetched, ..*row }
        };
        self.planes.iter().map(of).collect()
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

impl<O: TimingObserver> Sink for Timing<O> {
    /// Times the requests of a batch.
    fn take(&mut self, batch: Batch<'_>) {
        let taps_of_requests = batch.per_request().map(<[Footprint]>::len);
        let any_outside = |taps: &[Footprint]| {
            let addresses = taps.iter().flat_map(|tap| &tap.address[..batch.texels_per_tap]);
            is_outside(addresses.fold(0, |all, address| all | address))
        };
        let mut rest = batch.taps;
        self.apart.clear();
        let mut outside = false;
        if let Some(lanes) = self.bank_lanes.filter(|_| batch.texels_per_tap == 4) {
            let eights;
            (eights, rest) = batch.taps.as_chunks();
            for eight in eights {
                // Addresses of 32 bits are inside.
                let apart = lanes.apart(eight);
                outside |= apart.is_none() && any_outside(eight);
                self.apart.push(apart.unwrap_or(0));
            }
        }
        outside |= any_outside(rest);
        if outside || batch.surface.reads_per_texel() > 1 {
            let mut gathered = core::mem::take(&mut self.gathered);
            gathered.clear();
            for tap in batch.taps {
                gathered.tap(tap.plane);
                Batch { taps: core::slice::from_ref(tap), ..batch }.for_each_read(|_, address| gathered.read(address));
            }
            self.look_up_and_time(taps_of_requests, &gathered);
            self.gathered = gathered;
            return;
        }
        self.reads.clear(batch.taps.len());
        self.cache.take_observed(batch, &mut self.reads);
        let apart = core::mem::take(&mut self.apart);
        self.time(taps_of_requests, &InPlace { taps: batch.taps, texels: batch.texels_per_tap, apart: &apart });
        self.apart = apart;
    }
}
