//! The pipeline of a machine that does one thing a clock, with FIFOs deep enough never to limit that: the same clocks as
//! [`Pipeline`](super::pipeline::Pipeline) has, with less to do for each.
//!
//! In such a machine nothing in front of the tag unit ever holds it up, but for the first tap on its way there. By induction: the tap
//! before was at the door no later than it was taken. This one was issued in the clock after that one, and then is at the door in time;
//! or when a place came free in the tap FIFO, as many taps ago as that is deep, which is more than the latency between; or when its
//! request came out of the LOD unit, which in the same way took it right behind the one before, or when a place came free in the LOD
//! FIFO, deeper than its latency; and an LOD unit with two places in front of it finds a request there.
//!
//! So the tag unit waits for the fragment FIFO and for misses only ([`Passing`]), what is in front of it follows from the clocks taps
//! entered it, and no unit in front is idle between its first item and its last. The result FIFO, deeper than the clocks from data to
//! result, always has a place by the same count.

use alloc::vec::Vec;
use core::marker::PhantomData;

use super::{
    bank_lookout::{BankLookout, Seen},
    banks::BankOf,
    counters::{Histograms, PlaneTiming, Spread, TimingCounters},
    data_banks::DataBanks,
    events::{RequestTimes, TapTimes, TimingObserver},
    parameters::{Mode, Parameters},
    passing::{Passing, TapClocks, Watched},
    pipeline::{Beside, Counts, count_fifos, latencies, planes_among},
    queue::Fifo,
    tag_unit::{AtHand, TagUnit},
    taps::Taps,
};
use crate::{address_stream::AddressBatch, batch::Requests};

/// A machine of this kind.
#[derive(Clone, Debug, Default)]
pub(super) struct Ample {
    /// First clocks the units are free in.
    entry: u64,
    lod: u64,
    sequencer: u64,
    tag: u64,
    data: u64,
    /// What the first item finds.
    first_issue: u64,
    first_tag: u64,
    request_fifo: Fifo,
    lod_fifo: Fifo,
    tap_fifo: Fifo,
    fragment_fifo: Fifo,
    result_fifo: Fifo,
    tag_bank: BankOf,
    lookout: BankLookout,
    data_banks: DataBanks,
    counts: Counts,
    request_latency: Spread,
    batch: Clocks,
}

/// When the items of a batch pass the units.
#[derive(Clone, Debug, Default)]
struct Clocks {
    /// By tap.
    issue: Vec<u64>,
    taps: TapClocks,
    watched: Watched,
    /// By request; `issued` and `data` are those of its last tap.
    entry: Vec<u64>,
    lod: Vec<u64>,
    issued: Vec<u64>,
    data: Vec<u64>,
    result: Vec<u64>,
}

impl Ample {
    /// Whether a machine is of this kind.
    pub(super) fn fits(p: &Parameters) -> bool {
        p.mode == Mode::Prefetching
            && [p.pixel_pipes, p.taps_per_clock, p.tag_ports, p.data_ports] == [1; 4]
            && p.tag_banks.max(p.data_banks) <= 64
            && p.request_fifo > 1
            && p.lod_fifo > p.lod_latency
            && p.tap_fifo > p.address_latency
            && p.result_fifo > p.data_latency + p.filter_latency
    }

    /// With lines of `line` bytes.
    pub(super) fn new(p: &Parameters, line: u32) -> Self {
        let [lod_latency, address_latency, ..] = latencies(p);
        let first_issue = 1 + lod_latency;
        let first_tag = first_issue + address_latency;
        Self {
            lod: 1,
            sequencer: first_issue,
            tag: first_tag,
            first_issue,
            first_tag,
            request_fifo: Fifo::new(p.request_fifo),
            lod_fifo: Fifo::new(p.lod_fifo),
            tap_fifo: Fifo::new(p.tap_fifo),
            fragment_fifo: Fifo::new(p.fragment_fifo),
            result_fifo: Fifo::new(p.result_fifo),
            tag_bank: BankOf::new(p.tag_banks, p.tag_hash),
            lookout: BankLookout::new(p, line),
            data_banks: DataBanks::new(p),
            ..Self::default()
        }
    }

    /// Enters what this knows, the stalls by misses having been entered.
    pub(super) fn count(&self, c: &mut TimingCounters) {
        self.counts.enter(c);
        if c.requests == 0 {
            return;
        }
        let cycles = c.cycles;
        c.entry_busy = c.requests;
        c.entry_idle = cycles - self.entry;
        c.entry_stall_request_fifo = self.entry - c.requests;
        // No unit up to the tag unit is idle between its first item and its last.
        c.lod_busy = c.requests;
        c.lod_idle = 1 + cycles - self.lod;
        c.lod_stall_lod_fifo = cycles - c.lod_busy - c.lod_idle;
        c.sequencer_busy = c.taps;
        c.sequencer_idle = self.first_issue + cycles - self.sequencer;
        c.sequencer_stall_tap_fifo = cycles - c.sequencer_busy - c.sequencer_idle;
        let stalls = [c.tag_stall_fragment_fifo, c.tag_stall_merge, c.tag_stall_reorder_buffer];
        let stalls = stalls.iter().sum::<u64>() + c.tag_stall_miss_status + c.tag_stall_miss_queue;
        c.tag_idle = self.first_tag + cycles - self.tag;
        c.tag_busy = cycles - c.tag_idle - stalls;
        c.data_busy = c.taps + c.data_conflict_clocks + c.fill_write_clocks;
        c.data_idle = cycles - c.data_busy - c.data_stall_fill;
        c.datapath_busy = c.taps;
        c.result_busy = c.requests;
        let fifos = [&self.request_fifo, &self.lod_fifo, &self.tap_fifo, &self.fragment_fifo, &self.result_fifo];
        count_fifos(fifos, &self.request_latency, c);
    }

    /// Looks at the taps of a batch before they are looked up; if they are passed in runs, which none outside is, they are those next.
    pub(super) fn look(&mut self, batch: AddressBatch<'_>) -> Seen {
        self.lookout.look(batch)
    }

    /// Sends a batch of taps, of the first so many planes, through the tag and the data unit.
    pub(super) fn begin<'a, T: Taps, O: TimingObserver>(
        &'a mut self,
        taps: &'a T,
        planes: usize,
        beside: &'a mut Beside<'_, O>,
    ) -> Passing<'a, T, O> {
        let number = taps.number();
        if beside.planes.len() < planes {
            beside.planes.resize(planes, PlaneTiming::default());
        }
        let Clocks { taps: clocks, watched, .. } = &mut self.batch;
        clocks.begin(number, beside.planes.len());
        watched.clear();
        let (places, depth) = self.fragment_fifo.places(number);
        let TapClocks { tags, ready, data_done, waiting, hits } = clocks;
        Passing {
            taps,
            places,
            depth,
            tags,
            ready,
            data_done,
            clashes: self.lookout.clashes(),
            tag_unit: TagUnit {
                misses: beside.misses,
                planes: beside.planes,
                hits,
                waiting,
                bank: self.tag_bank,
                latency: beside.parameters.tag_latency.into(),
                line_shift: beside.line_shift,
                counts: &mut self.counts,
                at_hand: AtHand::default(),
                spent: 0,
                watched,
                observer: PhantomData,
            },
            data_banks: &mut self.data_banks,
            all_apart: taps.all_apart(),
            line_write: beside.line_write,
            tag_free: self.tag,
            data_free: self.data,
            free: [&mut self.tag, &mut self.data],
        }
    }

    /// The rest of their way, which are of these requests, that end where `ends` says.
    pub(super) fn end<O: TimingObserver>(
        &mut self,
        requests: Requests<'_>,
        ends: &[u32],
        taps: &impl Taps,
        mut beside: Beside<'_, O>,
    ) {
        let mut batch = core::mem::take(&mut self.batch);
        let before = [self.counts.requests, self.counts.taps];
        self.pass_the_rest(requests, taps, &mut batch, &mut beside);
        if O::WATCHES {
            tell(ends, taps, &mut batch, before, beside);
        }
        self.batch = batch;
    }

    /// The result, and all that is in front of the tag unit.
    #[inline(never)]
    fn pass_the_rest<O: TimingObserver>(
        &mut self,
        requests: Requests<'_>,
        taps: &impl Taps,
        Clocks { issue, taps: TapClocks { tags, data_done, .. }, entry, lod, issued, data, result, .. }: &mut Clocks,
        Beside { parameters, histograms, planes, .. }: &mut Beside<'_, O>,
    ) {
        let [_, _, _, data_latency, filter_latency] = latencies(parameters);
        self.tap_fifo.pass_one_a_clock(&mut self.sequencer, tags, issue);
        // Another tap can enter the tag unit in the clock after one entered the data unit.
        let (places, depth) = self.fragment_fifo.places(tags.len());
        of_last(requests, issue, 0, issued);
        of_last(requests, &places[depth..][..tags.len()], -1, data);
        of_last(requests, data_done, (data_latency + filter_latency).cast_signed(), result);
        self.fragment_fifo.entered(tags);
        self.lod_fifo.pass_one_a_clock(&mut self.lod, issued, lod);
        self.request_fifo.pass_one_a_clock(&mut self.entry, lod, entry);
        self.result_fifo.pass_all(data, result);
        self.request_latency.add_between(entry, result);
        self.counts.cycles = result[result.len() - 1] + 1;
        self.counts.requests += result.len() as u64;
        self.counts.taps += tags.len() as u64;
        count_requests(requests, taps, histograms, planes);
    }
}

/// Tells an observer of requests and taps, so many of which were before.
fn tell<O: TimingObserver>(
    ends: &[u32],
    taps: &impl Taps,
    batch: &mut Clocks,
    [requests, taps_before]: [u64; 2],
    beside: Beside<'_, O>,
) {
    let mut fills = batch.watched.fills.drain(..).peekable();
    let mut begin = 0;
    for (number, end) in ends.iter().map(|&end| end as usize).enumerate() {
        let request = requests + number as u64;
        for at in begin..end {
            let tap = taps_before + at as u64;
            let mut misses = 0;
            while let Some((fill, stored)) = fills.next_if(|(fill, _)| fill.tap == tap) {
                beside.observer.fill(fill, &stored);
                misses += 1;
            }
            beside.observer.tap(TapTimes {
                tap,
                request,
                plane: taps.plane(at) as u16,
                issue: batch.issue[at],
                tag: batch.taps.tags[at],
                tag_done: batch.watched.tag_done[at],
                data: batch.watched.data[at],
                data_done: batch.taps.data_done[at],
                datapath: batch.taps.data_done[at] + u64::from(beside.parameters.data_latency),
                misses,
            });
        }
        let [entry, lod, result] = [&batch.entry, &batch.lod, &batch.result].map(|clocks| clocks[number]);
        beside.observer.request(RequestTimes { request, entry, lod, result });
        begin = end;
    }
}

/// Of the clocks of taps, those of the last of each request, so many later.
fn of_last(requests: Requests<'_>, clocks: &[u64], later: i64, to: &mut Vec<u64>) {
    let later = |clock: u64| clock.wrapping_add_signed(later);
    to.clear();
    match requests {
        Requests::Each(1) => to.extend(clocks.iter().map(|&clock| later(clock))),
        Requests::Each(2) => to.extend(clocks.as_chunks().0.iter().map(|&[_, clock]| later(clock))),
        Requests::Each(taps) => to.extend(clocks.chunks(taps).map(|clocks| later(clocks[taps - 1]))),
        Requests::Ends(ends) => to.extend(ends.iter().map(|&end| later(clocks[end as usize - 1]))),
    }
}

/// Counts taps by plane, and requests by taps and planes.
fn count_requests(requests: Requests<'_>, taps: &impl Taps, histograms: &mut Histograms, planes: &mut [PlaneTiming]) {
    let (mut pairs, mut singles, number) = ([0; 2], 0, taps.number());
    taps.count_planes(|of, times, reads| {
        for &plane in of {
            let row = &mut planes[plane as usize];
            row.taps += times;
            row.reads += times * reads;
        }
        match of {
            [first, second] => pairs[usize::from(first != second)] += times,
            _ => singles += times,
        }
    });
    match requests {
        Requests::Each(1) => histograms.add((1, 1), number as u64),
        Requests::Each(2) if singles == 0 => {
            histograms.add((2, 1), pairs[0]);
            histograms.add((2, 2), pairs[1]);
        }
        Requests::Each(each) => {
            count_one_by_one((1..=number / each).map(|request| request * each), taps, histograms);
        }
        Requests::Ends(ends) => count_one_by_one(ends.iter().map(|&end| end as usize), taps, histograms),
    }
}

/// Counts requests by taps and planes. Most are of the same shape as the one before.
fn count_one_by_one(ends: impl Iterator<Item = usize>, taps: &impl Taps, histograms: &mut Histograms) {
    let (mut begin, mut shape, mut of_shape) = (0, (0, 0), 0);
    for end in ends {
        let shape_now = (end - begin, planes_among(taps, begin, end));
        if shape_now != shape {
            histograms.add(shape, of_shape);
            (shape, of_shape) = (shape_now, 0);
        }
        of_shape += 1;
        begin = end;
    }
    histograms.add(shape, of_shape);
}
