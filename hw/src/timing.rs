//! Time: when each tap passes each unit, exactly, without a clock.
//!
//! The pipeline is in order and its FIFOs are bounded, so the clock at which an item enters a unit is a maximum of sums of earlier
//! clocks (max-plus). [`Timing`] computes them tap by tap as the address stream passes. The machine is docs/timing.md; the
//! simulator that ticks, and with which this must agree on every clock, is in the tests.

mod ample;
mod bank_lookout;
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
mod passing;
mod pipeline;
mod queue;
mod slots;
mod tag_unit;
mod tap_reads;
mod taps;

use bank_lookout::Seen;
pub use banks::BankHash;
pub use counters::{HISTOGRAM_MAX, Histograms, PlaneTiming, TimingCounters};
pub use dram::{DramParameters, Mapping, Page, Row};
pub use events::{FillTimes, RequestTimes, StoredFetch, TapTimes, TimingObserver};
pub use memory::Fetch;
pub use parameters::{MainMemory, MemoryParameters, Mode, Parameters, SecondLevelParameters, TimingError};

use alloc::vec::Vec;

use crate::{
    address_stream::{AddressBatch, Sink},
    batch::Requests,
    cache::TexelCache,
};
use ample::Ample;
use misses::Misses;
use pipeline::{Beside, Pipeline};
use slots::Slots;
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
    pipe: Pipe,
    misses: Misses,
    observer: O,
    planes: Vec<PlaneTiming>,
    histograms: Histograms,

    /// What the cache made of the taps at hand.
    reads: TapReads,
    /// Their addresses, where they are not those of footprints.
    gathered: Gathered,
    /// Where the requests of the batch at hand end.
    ends: Vec<u32>,
}

/// What taps pass: the way of any machine, or that of one whose tag unit is the first to be held up.
#[derive(Clone, Debug)]
enum Pipe {
    Any(Pipeline),
    Ample(Ample),
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
        Ok(Self {
            parameters: p,
            line_shift: geometry.line.trailing_zeros(),
            line_write: match p.fill_write_bytes {
                0 => 0,
                bytes => geometry.line.div_ceil(bytes).into(),
            },
            pipe: if Ample::fits(&p) {
                Pipe::Ample(Ample::new(&p, geometry.line))
            } else {
                Pipe::Any(Pipeline::new(&p))
            },
            misses: Misses::new(&p, memory, &cache)?,
            observer,
            planes: Vec::new(),
            histograms: Histograms::default(),
            reads: TapReads::default(),
            gathered: Gathered::default(),
            ends: Vec::new(),
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
            gathered.tap(plane, addresses);
        }
        self.ends.clear();
        self.ends.push(gathered.number() as u32);
        self.look_up_and_time(&gathered, Requests::Ends(&[]));
        self.gathered = gathered;
    }

    /// Looks up taps address by address, and times them.
    fn look_up_and_time(&mut self, taps: &Gathered, requests: Requests<'_>) {
        self.reads.clear(taps.number());
        for tap in 0..taps.number() {
            self.reads.tap();
            self.cache.read_observed(taps.plane(tap), taps.addresses(tap), &mut self.reads);
        }
        let (pipe, _, reads, ends, mut beside) = self.parts();
        if ends.is_empty() {
            return;
        }
        match pipe {
            Pipe::Any(pipe) => pipe.time(ends, taps, reads, beside),
            Pipe::Ample(pipe) => {
                pipe.begin(taps, taps.planes(), &mut beside).pass(reads.accesses());
                pipe.end(requests.ending(ends), ends, taps, beside);
            }
        }
    }

    /// Looks up taps run by run, and times them; whether the words of each are known to be in as many data banks as they are.
    fn look_up_in_runs_and_time(&mut self, batch: AddressBatch<'_>, all_apart: bool) {
        let (pipe, cache, reads, ends, mut beside) = self.parts();
        match pipe {
            _ if ends.is_empty() => {}
            Pipe::Any(pipe) => {
                reads.clear(batch.taps());
                let runs = cache.take_observed(batch, reads);
                pipe.time(ends, &InPlace::new(batch, runs, all_apart), reads, beside);
            }
            Pipe::Ample(pipe) => {
                let runs = cache.take_observed(batch, &mut Slots);
                let taps = InPlace::new(batch, runs, all_apart);
                pipe.begin(&taps, runs.planes, &mut beside).pass_runs(runs);
                pipe.end(batch.requests.ending(ends), ends, &taps, beside);
            }
        }
    }

    /// What taps pass, the cache, what is known of their reads, where their requests end, and all beside.
    fn parts(&mut self) -> (&mut Pipe, &mut TexelCache, &mut TapReads, &[u32], Beside<'_, O>) {
        let Self { parameters, line_write, line_shift, pipe, misses, planes, histograms, observer, .. } = self;
        let (line_write, line_shift) = (*line_write, *line_shift);
        let beside = Beside { parameters, line_write, line_shift, misses, planes, histograms, observer };
        // Requests without taps are in nobody's way.
        let ends = if self.ends.first() == Some(&0) { &self.ends[1..] } else { &self.ends };
        (pipe, &mut self.cache, &mut self.reads, ends, beside)
    }

    /// Totals so far.
    #[must_use]
    pub fn counters(&self) -> TimingCounters {
        let misses = &self.misses;
        let sum = |field: fn(&PlaneTiming) -> u64| self.planes.iter().map(field).sum::<u64>();
        let mut c = TimingCounters {
            reads: sum(|row| row.reads),
            fetches_ok: sum(|row| row.fetches_ok),
            fetches_failed: sum(|row| row.fetches_failed),
            fetches_merged: sum(|row| row.fetches_merged),
            tag_stall_reorder_buffer: misses.stalls.reorder_buffer,
            tag_stall_miss_status: misses.stalls.miss_status,
            tag_stall_miss_queue: misses.stalls.miss_queue,
            miss_port_stall_memory: misses.stalls.memory,
            ..TimingCounters::default()
        };
        match &self.pipe {
            Pipe::Any(pipe) => pipe.count(&mut c),
            Pipe::Ample(pipe) => pipe.count(&mut c),
        }
        let cycles = c.cycles;
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
        // The datapath takes what the data unit finishes; neither it nor the result is ever held up.
        c.datapath_idle = cycles - c.datapath_busy;
        c.result_idle = cycles - c.result_busy;

        (c.miss_port_busy, c.miss_port_idle) = misses.port.closed(cycles);
        (c.miss_queue_sum, c.miss_queue_max) = misses.miss_queue.usage();
        (c.reorder_buffer_sum, c.reorder_buffer_max) = misses.reorder_buffer.usage();
        (c.miss_status_sum, c.miss_status_max) = misses.status.usage();
        (c.fill_latency_sum, c.fill_latency_min, c.fill_latency_max) = misses.fill_latency.all();

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
        let used = self.planes.iter().rposition(|row| row.taps > 0).map_or(0, |last| last + 1);
        self.planes[..used].iter().map(of).collect()
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
    fn take(&mut self, batch: AddressBatch<'_>) {
        self.ends.clear();
        batch.requests.ends_into(batch.taps(), &mut self.ends);
        let Seen { outside, all_apart } = match &mut self.pipe {
            Pipe::Any(_) => Seen { outside: batch.any_outside(0..batch.taps()), all_apart: false },
            Pipe::Ample(pipe) => pipe.look(batch),
        };
        if outside || batch.surface.reads_per_texel() > 1 {
            let mut gathered = core::mem::take(&mut self.gathered);
            gathered.clear();
            batch.for_each_tap(|_, plane, reads| gathered.tap(plane, reads));
            self.look_up_and_time(&gathered, batch.requests);
            self.gathered = gathered;
            return;
        }
        self.look_up_in_runs_and_time(batch, all_apart);
    }
}
