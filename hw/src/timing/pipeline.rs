//! The pipeline: when each request and each tap passes each unit (docs/timing.md, sections 3, 4 and 6).
//!
//! A batch is one loop over its taps. What the loop carries on from tap to tap is taken out of the model for as long, so that the
//! host keeps it in registers: behind a reference it would be written and read again with every place of a FIFO.

use alloc::vec::Vec;

use super::{
    banks::Banks,
    counters::{HISTOGRAM_MAX, Histograms, PlaneTiming, Spread, TimingCounters},
    data_banks::DataBanks,
    events::{FillTimes, RequestTimes, TapTimes, TimingObserver},
    misses::Misses,
    parameters::Parameters,
    queue::{Fifo, Ledger, Width},
    tap_reads::TapReads,
    taps::Taps,
};

/// The units and FIFOs a tap always passes.
#[derive(Clone, Debug, Default)]
pub(super) struct Pipeline {
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
    tag_banks: Banks,
    data_banks: DataBanks,
    ledgers: Ledgers,
    counts: Counts,
    request_latency: Spread,
}

/// Where the clocks of each unit went.
#[derive(Clone, Copy, Debug, Default)]
struct Ledgers {
    lod: Ledger,
    sequencer: Ledger,
    tag: Ledger,
    data: Ledger,
}

/// What is counted on the way; the names are those of the counters.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    pub(super) cycles: u64,
    pub(super) requests: u64,
    pub(super) taps: u64,
    pub(super) data_words: u64,
    pub(super) data_conflict_clocks: u64,
    pub(super) fill_write_clocks: u64,
    pub(super) tag_bank_conflicts: u64,
    pub(super) lod_stall_lod_fifo: u64,
    pub(super) sequencer_stall_tap_fifo: u64,
    pub(super) tag_stall_fragment_fifo: u64,
    pub(super) tag_stall_merge: u64,
    pub(super) tag_stall_blocked: u64,
    pub(super) data_stall_fill: u64,
    pub(super) data_stall_result_fifo: u64,
}

/// What is kept beside the pipeline.
pub(super) struct Beside<'a, O> {
    pub(super) parameters: &'a Parameters,
    /// Clocks of writing one line into the banks.
    pub(super) line_write: u64,
    pub(super) line_shift: u32,
    pub(super) misses: &'a mut Misses,
    pub(super) planes: &'a mut Vec<PlaneTiming>,
    pub(super) histograms: &'a mut Histograms,
    pub(super) observer: &'a mut O,
}

impl Pipeline {
    pub(super) fn new(p: &Parameters) -> Self {
        Self {
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
            tag_banks: Banks::new(p.tag_banks, p.tag_ports, p.tag_hash),
            data_banks: DataBanks::new(p),
            ..Self::default()
        }
    }

    /// Times requests, whose taps end where `ends` says, and whose line accesses are known.
    #[inline(always)]
    pub(super) fn time<O: TimingObserver>(
        &mut self,
        ends: &[u32],
        taps: &impl Taps,
        reads: &TapReads,
        beside: Beside<'_, O>,
    ) {
        let mut pipe = core::mem::take(self);
        let Beside { parameters: p, line_write, line_shift, misses, planes, histograms, observer } = beside;
        let [lod_latency, address_latency, tag_latency, data_latency, filter_latency] = latencies(p);
        let (mut number, mut accesses) = (0, reads.accesses().iter().peekable());
        for &end in ends {
            // Entry and LOD unit.
            let entry = pipe.entry.take(pipe.request_fifo.room());
            let room = pipe.lod_fifo.room();
            let lod = pipe.lod.take(room.max(entry + 1));
            pipe.ledgers.lod.take(entry + 1, room, lod, &mut pipe.counts.lod_stall_lod_fifo);
            pipe.request_fifo.pass(entry, lod + 1);
            let at_sequencer = lod + lod_latency;

            let end = end as usize;
            let (mut issue, mut data, mut datapath) = (0, 0, 0);
            for tap in number..end {
                let plane = taps.plane(tap);
                if plane >= planes.len() {
                    planes.resize(plane + 1, PlaneTiming::default());
                }
                let row = &mut planes[plane];

                // Sequencer and address unit.
                let room = pipe.tap_fifo.room();
                issue = pipe.sequencer.take(room.max(at_sequencer));
                let stalls = &mut pipe.counts.sequencer_stall_tap_fifo;
                pipe.ledgers.sequencer.take(at_sequencer, room, issue, stalls);

                // Tag unit.
                let at_door = issue + address_latency;
                pipe.ledgers.tag.idle_until(at_door);
                let room = pipe.fragment_fifo.room();
                pipe.ledgers.tag.stall_until(room, &mut pipe.counts.tag_stall_fragment_fifo);
                let tag = pipe.tag.earliest(at_door.max(room));
                pipe.tap_fifo.pass(issue, tag + 1);
                // Clock of the last access, clock at which all lines missed are there, and how many they are.
                let (mut tag_done, mut filled, mut missed) = (tag, 0, 0);
                let mut made = 0;
                while let Some(access) = accesses.next_if(|access| access.tap as usize == tap) {
                    made += 1;
                    let bank = pipe.tag_banks.bank(access.line);
                    let from = tag_done.max(misses.unblocked);
                    pipe.ledgers.tag.stall_until(from, &mut pipe.counts.tag_stall_blocked);
                    let mut clock = pipe.tag_banks.earliest(bank, from);
                    pipe.counts.tag_bank_conflicts += u64::from(clock > from);
                    if access.hit {
                        let (made, merged) = misses.status.hit(access.slot, clock);
                        row.fetches_merged += u64::from(merged);
                        if made > clock {
                            pipe.ledgers.tag.stall_until(made, &mut pipe.counts.tag_stall_merge);
                            clock = made;
                        }
                    } else {
                        let next = pipe.ledgers.tag.next();
                        let miss = misses.miss(access.line, access.slot, clock, next, row);
                        clock = miss.clock;
                        pipe.ledgers.tag.entered_until(miss.next);
                        filled = filled.max(miss.fetch.filled);
                        missed += 1;
                        let fill = FillTimes {
                            tap: pipe.counts.taps,
                            plane: plane as u16,
                            address: access.line << line_shift,
                            access: clock,
                            fetch: miss.fetch,
                        };
                        observer.fill(fill, misses.stored());
                    }
                    pipe.tag_banks.take(bank, clock);
                    pipe.ledgers.tag.work(clock);
                    tag_done = clock;
                }
                if made == 0 {
                    pipe.ledgers.tag.work(tag);
                }
                pipe.tag.count(tag_done);

                // Data banks.
                let at_door = tag_done + tag_latency;
                pipe.ledgers.data.idle_until(at_door);
                let waited = pipe.ledgers.data.stall_until(filled, &mut pipe.counts.data_stall_fill);
                let mut ready = at_door.max(filled);
                if tap + 1 == end {
                    let room = pipe.result_fifo.room();
                    pipe.ledgers.data.stall_until(room, &mut pipe.counts.data_stall_result_fifo);
                    ready = ready.max(room);
                }
                data = pipe.data.earliest(ready);
                let mut writes = 0;
                if missed > 0 {
                    writes = missed as u64 * line_write;
                    if writes > 0 && data == pipe.data.last() {
                        data += 1;
                    }
                    misses.read(missed, data);
                }
                let (data_done, words) = taps.with_addresses(tap, |addresses| {
                    row.reads += addresses.len() as u64;
                    pipe.data_banks.read(addresses, data + writes)
                });
                pipe.counts.data_words += words;
                pipe.data.count(data_done);
                pipe.ledgers.data.work_through(data_done);
                pipe.fragment_fifo.pass(tag, data + 1);

                datapath = data_done + data_latency;
                pipe.counts.fill_write_clocks += writes;
                pipe.counts.data_conflict_clocks += data_done - data - writes;
                row.taps += 1;
                row.fetches_ok += made - missed as u64;
                row.stall_wait_read += waited;
                observer.tap(TapTimes {
                    tap: pipe.counts.taps,
                    request: pipe.counts.requests,
                    plane: plane as u16,
                    issue,
                    tag,
                    tag_done,
                    data,
                    data_done,
                    datapath,
                    misses: missed as u32,
                });
                pipe.counts.taps += 1;
            }

            // Datapath and result.
            let result = pipe.result.take(datapath + filter_latency);
            pipe.lod_fifo.pass(lod, issue + 1);
            pipe.result_fifo.pass(data, result + 1);
            observer.request(RequestTimes { request: pipe.counts.requests, entry, lod, result });
            pipe.counts.requests += 1;
            pipe.counts.cycles = result + 1;
            pipe.request_latency.add(result - entry);
            histograms.add((end - number, planes_among(taps, number, end)), 1);
            number = end;
        }
        *self = pipe;
    }

    /// Enters what this knows.
    pub(super) fn count(&self, c: &mut TimingCounters) {
        self.counts.enter(c);
        let cycles = c.cycles;
        // The requester is never without a request before the last.
        c.entry_busy = self.entry.busy();
        c.entry_idle = cycles - (self.entry.last() + 1).min(cycles);
        c.entry_stall_request_fifo = cycles - c.entry_idle - c.entry_busy;
        c.datapath_busy = self.data.busy();
        c.result_busy = self.result.busy();
        (c.lod_busy, c.lod_idle) = self.ledgers.lod.closed(cycles);
        (c.sequencer_busy, c.sequencer_idle) = self.ledgers.sequencer.closed(cycles);
        (c.tag_busy, c.tag_idle) = self.ledgers.tag.closed(cycles);
        (c.data_busy, c.data_idle) = self.ledgers.data.closed(cycles);
        let fifos = [&self.request_fifo, &self.lod_fifo, &self.tap_fifo, &self.fragment_fifo, &self.result_fifo];
        count_fifos(fifos, &self.request_latency, c);
    }
}

impl Counts {
    /// Enters them all.
    pub(super) fn enter(&self, c: &mut TimingCounters) {
        c.cycles = self.cycles;
        c.requests = self.requests;
        c.taps = self.taps;
        c.data_words = self.data_words;
        c.data_conflict_clocks = self.data_conflict_clocks;
        c.fill_write_clocks = self.fill_write_clocks;
        c.tag_bank_conflicts = self.tag_bank_conflicts;
        c.lod_stall_lod_fifo = self.lod_stall_lod_fifo;
        c.sequencer_stall_tap_fifo = self.sequencer_stall_tap_fifo;
        c.tag_stall_fragment_fifo = self.tag_stall_fragment_fifo;
        c.tag_stall_merge = self.tag_stall_merge;
        c.tag_stall_blocked = self.tag_stall_blocked;
        c.data_stall_fill = self.data_stall_fill;
        c.data_stall_result_fifo = self.data_stall_result_fifo;
    }
}

/// Enters what the FIFOs held, the first to the last that a request passes, and how long requests took.
pub(super) fn count_fifos(fifos: [&Fifo; 5], latency: &Spread, c: &mut TimingCounters) {
    let [request, lod, tap, fragment, result] = fifos.map(Fifo::usage);
    (c.request_fifo_sum, c.request_fifo_max) = request;
    (c.lod_fifo_sum, c.lod_fifo_max) = lod;
    (c.tap_fifo_sum, c.tap_fifo_max) = tap;
    (c.fragment_fifo_sum, c.fragment_fifo_max) = fragment;
    (c.result_fifo_sum, c.result_fifo_max) = result;
    (c.request_latency_sum, c.request_latency_min, c.request_latency_max) = latency.all();
}

/// Clocks of the LOD, address, tag and data units and of the datapath.
pub(super) fn latencies(p: &Parameters) -> [u64; 5] {
    [p.lod_latency, p.address_latency, p.tag_latency, p.data_latency, p.filter_latency].map(u64::from)
}

impl Histograms {
    /// Counts requests of so many taps of so many planes.
    #[inline(always)]
    pub(super) fn add(&mut self, (taps, planes): (usize, usize), requests: u64) {
        if requests > 0 {
            self.taps[taps.min(HISTOGRAM_MAX)] += requests;
            self.planes[planes.min(HISTOGRAM_MAX)] += requests;
            self.anisotropy[(taps / planes).min(HISTOGRAM_MAX)] += requests;
        }
    }
}

/// Most planes of a request that are told apart: a filter reads few.
const PLANES_MAX: usize = 8;

/// The number of planes among some taps.
#[inline(always)]
pub(super) fn planes_among(taps: &impl Taps, begin: usize, end: usize) -> usize {
    if end - begin <= 2 {
        return if taps.plane(begin) == taps.plane(end - 1) { 1 } else { 2 };
    }
    let (mut seen, mut count) = ([0; PLANES_MAX], 0);
    for plane in (begin..end).map(|tap| taps.plane(tap)) {
        if count < PLANES_MAX && !seen[..count].contains(&plane) {
            seen[count] = plane;
            count += 1;
        }
    }
    count
}
