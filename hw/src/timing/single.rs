//! The pipeline of a machine that does one thing a clock: the same clocks as [`Pipeline::time`] has, with less to do for each.
//!
//! Where a unit takes one item a clock, the first clock it is free in is also the first that its ledger has no entry for, and its
//! busy clocks are all those that were neither idle nor stalled. So a unit is one number, and most of its books are kept once a batch.

use super::{
    counters::PlaneTiming,
    events::{FillTimes, RequestTimes, TapTimes, TimingObserver},
    parameters::{Mode, Parameters},
    pipeline::{Beside, Pipeline, latencies, planes_among},
    queue::Ledger,
    tap_reads::TapReads,
    taps::Taps,
};

/// A unit that takes one item a clock: the first clock it is free in.
#[derive(Clone, Copy)]
struct Stage {
    next: u64,
    idle: u64,
    stalled: u64,
    began: u64,
}

impl Stage {
    fn new(ledger: Ledger) -> Self {
        Self { next: ledger.next(), idle: 0, stalled: 0, began: ledger.next() }
    }

    /// Free, with nothing at the door before `clock`.
    #[inline(always)]
    fn idle_until(&mut self, clock: u64) {
        let clocks = clock.saturating_sub(self.next);
        self.idle += clocks;
        self.next += clocks;
    }

    /// Held up until `clock`; the answer is for how long.
    #[inline(always)]
    fn stall_until(&mut self, clock: u64) -> u64 {
        let clocks = clock.saturating_sub(self.next);
        self.stalled += clocks;
        self.next += clocks;
        clocks
    }

    /// Takes an item, and answers when.
    #[inline(always)]
    fn take(&mut self) -> u64 {
        self.next += 1;
        self.next - 1
    }

    /// Enters what became of the clocks of a batch.
    fn close(self, ledger: &mut Ledger) {
        let busy = self.next - self.began - self.idle - self.stalled;
        ledger.add(self.next, busy, self.idle);
    }
}

impl Pipeline {
    /// Whether a machine does one thing a clock.
    pub(super) fn is_single(p: &Parameters) -> bool {
        p.mode == Mode::Prefetching
            && [p.pixel_pipes, p.taps_per_clock, p.tag_ports, p.data_ports] == [1; 4]
            && p.tag_banks.max(p.data_banks) <= 64
    }

    /// [`Self::time`] for such a machine.
    #[inline(always)]
    pub(super) fn time_single<O: TimingObserver>(
        &mut self,
        taps_of_requests: impl Iterator<Item = usize>,
        taps: &impl Taps,
        reads: &TapReads,
        beside: Beside<'_, O>,
    ) {
        let mut pipe = core::mem::take(self);
        let Beside { parameters: p, line_write, line_shift, misses, planes, histograms, observer } = beside;
        let [lod_latency, address_latency, tag_latency, data_latency, filter_latency] = latencies(p);
        let mut entry_unit = pipe.entry.next();
        let mut result_unit = pipe.result.next();
        let mut lod_unit = Stage::new(pipe.ledgers.lod);
        let mut sequencer = Stage::new(pipe.ledgers.sequencer);
        let mut tag_unit = Stage::new(pipe.ledgers.tag);
        let mut data_unit = Stage::new(pipe.ledgers.data);
        let mut counts = pipe.counts;
        let (mut tap, mut accesses) = (0, reads.accesses());
        // Most requests are of the same shape as the one before.
        let (mut shape, mut of_shape) = ((0, 0), 0);
        for count in taps_of_requests {
            if count == 0 {
                continue;
            }
            // Entry and LOD unit.
            let entry = entry_unit.max(pipe.request_fifo.room());
            entry_unit = entry + 1;
            lod_unit.idle_until(entry + 1);
            lod_unit.stall_until(pipe.lod_fifo.room());
            let lod = lod_unit.take();
            pipe.request_fifo.pass(entry, lod + 1);
            let at_sequencer = lod + lod_latency;

            let (begin, end) = (tap, tap + count);
            let (mut issue, mut data, mut datapath) = (0, 0, 0);
            while tap < end {
                let (plane, addresses) = (taps.plane(tap), taps.addresses(tap));
                if usize::from(plane) >= planes.len() {
                    planes.resize(usize::from(plane) + 1, PlaneTiming::default());
                }
                let row = &mut planes[usize::from(plane)];

                // Sequencer and address unit.
                sequencer.idle_until(at_sequencer);
                sequencer.stall_until(pipe.tap_fifo.room());
                issue = sequencer.take();

                // Tag unit.
                tag_unit.idle_until(issue + address_latency);
                counts.tag_stall_fragment_fifo += tag_unit.stall_until(pipe.fragment_fifo.room());
                let tag = tag_unit.take();
                pipe.tap_fifo.pass(issue, tag + 1);
                // Clock of the last access, the banks that have an access in it, and clock at which all lines missed are there.
                let (mut tag_done, mut banks_taken) = (tag, 0u64);
                let (mut filled, mut missed) = (0, 0);
                let made_before = accesses.len();
                while let [access, rest @ ..] = accesses
                    && access.tap as usize == tap
                {
                    accesses = rest;
                    let bank = pipe.tag_banks.bank(access.line);
                    // The unit is free from the clock after that of the access before, which another bank may use as well.
                    let conflict = banks_taken >> bank & 1;
                    counts.tag_bank_conflicts += conflict;
                    let mut clock = tag_done + conflict;
                    if access.hit {
                        let arrives = misses.status.filled(access.slot);
                        if clock < arrives {
                            if misses.status.merge(access.slot) {
                                row.fetches_merged += 1;
                            } else {
                                // For the first access, the clock it was to be made in has been entered as taken.
                                let first = u64::from(banks_taken == 0);
                                tag_unit.next -= first;
                                counts.tag_stall_merge += tag_unit.stall_until(arrives);
                                clock = arrives;
                            }
                        }
                    } else {
                        let first = u64::from(banks_taken == 0);
                        let ledger = Ledger::at(tag_unit.next - first);
                        let miss = misses.miss(access.line, access.slot, clock, missed, ledger, row);
                        clock = miss.clock;
                        tag_unit.stalled += miss.tag.next() - ledger.next();
                        tag_unit.next = miss.tag.next();
                        filled = filled.max(miss.fetch.filled);
                        missed += 1;
                        let fill = FillTimes {
                            tap: counts.taps,
                            plane,
                            address: access.line << line_shift,
                            access: clock,
                            fetch: miss.fetch,
                        };
                        observer.fill(fill, misses.stored());
                    }
                    tag_unit.next = tag_unit.next.max(clock + 1);
                    banks_taken = if clock == tag_done { banks_taken } else { 0 } | 1 << bank;
                    tag_done = clock;
                }
                let made = made_before - accesses.len();

                // Data banks.
                data_unit.idle_until(tag_done + tag_latency);
                let waited = data_unit.stall_until(filled);
                if tap + 1 == end {
                    counts.data_stall_result_fifo += data_unit.stall_until(pipe.result_fifo.room());
                }
                data = data_unit.take();
                let mut data_done = data;
                if missed > 0 {
                    misses.read(missed, data);
                    let writes = missed as u64 * line_write;
                    counts.fill_write_clocks += writes;
                    counts.data_stall_fill += waited;
                    row.stall_wait_read += waited;
                    data_done += writes;
                }
                let mut words = addresses.len() as u64;
                if !taps.apart(tap) {
                    let done;
                    (done, words) = pipe.data_banks.read(addresses, data_done);
                    counts.data_conflict_clocks += done - data_done;
                    data_done = done;
                }
                counts.data_words += words;
                data_unit.next = data_done + 1;
                pipe.fragment_fifo.pass(tag, data + 1);

                datapath = data_done + data_latency;
                row.taps += 1;
                row.reads += addresses.len() as u64;
                row.fetches_ok += (made - missed) as u64;
                observer.tap(TapTimes {
                    tap: counts.taps,
                    request: counts.requests,
                    plane,
                    issue,
                    tag,
                    tag_done,
                    data,
                    data_done,
                    datapath,
                    misses: missed as u32,
                });
                counts.taps += 1;
                tap += 1;
            }

            // Datapath and result.
            let result = result_unit.max(datapath + filter_latency);
            result_unit = result + 1;
            pipe.lod_fifo.pass(lod, issue + 1);
            pipe.result_fifo.pass(data, result + 1);
            observer.request(RequestTimes { request: counts.requests, entry, lod, result });
            counts.requests += 1;
            counts.cycles = result + 1;
            pipe.request_latency.add(result - entry);
            let shape_now = (count, planes_among(taps, begin, end));
            if shape_now != shape {
                histograms.add(shape, of_shape);
                (shape, of_shape) = (shape_now, 0);
            }
            of_shape += 1;
        }
        histograms.add(shape, of_shape);

        let (new_requests, new_taps) = (counts.requests - pipe.counts.requests, counts.taps - pipe.counts.taps);
        counts.lod_stall_lod_fifo += lod_unit.stalled;
        counts.sequencer_stall_tap_fifo += sequencer.stalled;
        pipe.counts = counts;
        pipe.entry.add(entry_unit, new_requests);
        pipe.result.add(result_unit, new_requests);
        pipe.data.add(data_unit.next, new_taps);
        lod_unit.close(&mut pipe.ledgers.lod);
        sequencer.close(&mut pipe.ledgers.sequencer);
        tag_unit.close(&mut pipe.ledgers.tag);
        data_unit.close(&mut pipe.ledgers.data);
        *self = pipe;
    }
}
