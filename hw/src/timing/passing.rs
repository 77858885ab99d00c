//! Taps on their way through the tag and the data unit of a machine of [`Ample`](super::ample::Ample)'s kind.
//!
//! A tap waits for the fragment FIFO as long as the tap that many before it is not at its data, so as many taps as that is deep can pass the tag unit before
//! any passes the data unit: a loop for each unit, and in it only what that unit does.

use alloc::vec::Vec;
use core::ops::Range;

use super::{
    banks::BankOf,
    counters::PlaneTiming,
    data_banks::DataBanks,
    events::{FillTimes, StoredFetch, TimingObserver},
    misses::Misses,
    pipeline::Counts,
    plain::Plain,
    slots::Slots,
    tap_reads::Access,
    taps::Taps,
};
use crate::cache::{Run, Runs};

/// The taps of a batch on their way.
pub(super) struct Passing<'a, T, O> {
    pub(super) taps: &'a T,
    /// Places of the fragment FIFO: by tap, when it finds one, and `depth` behind, when another can take it.
    pub(super) places: &'a mut [u64],
    pub(super) depth: usize,
    pub(super) clocks: &'a mut TapClocks,
    pub(super) planes: &'a mut [PlaneTiming],
    pub(super) misses: &'a mut Misses,
    pub(super) tag_bank: BankOf,
    pub(super) all_apart: bool,
    pub(super) tag_latency: u64,
    /// First clocks the units are free in.
    pub(super) tag_free: u64,
    pub(super) data_free: u64,
    /// Clocks that taps spent in the tag unit beyond one each.
    pub(super) spent: u64,
    pub(super) at_hand: AtHand,
    pub(super) rest: Rest<'a, O>,
}

/// When the taps of a batch pass the units.
#[derive(Clone, Debug, Default)]
pub(super) struct TapClocks {
    /// By tap: when it enters the tag unit, when it is at the door of the data unit with all its lines there, and when its last word is read.
    pub(super) tags: Vec<u64>,
    pub(super) ready: Vec<u64>,
    pub(super) data_done: Vec<u64>,
    /// Those that have missed lines and not passed the data unit.
    waiting: Vec<Waiting>,
    /// By plane, accesses that hit, and merged ones.
    hits: Vec<u64>,
}

/// A tap that has missed lines.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    tap: usize,
    missed: usize,
    /// When it is at the door of the data unit, lines or not.
    door: u64,
}

/// The tap in the tag unit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AtHand {
    number: usize,
    plane: usize,
    /// The clock of its last access so far, and the banks with an access in that clock.
    done: u64,
    banks_taken: u64,
    /// How many lines it missed, and when the last of them is there.
    missed: usize,
    filled: u64,
}

/// A hit, and a merged one, as they are counted by plane.
pub(super) const HIT: u64 = 1;
pub(super) const MERGED: u64 = 1 << 32;

/// What is not used for every access.
pub(super) struct Rest<'a, O> {
    pub(super) counts: &'a mut Counts,
    pub(super) data_banks: &'a mut DataBanks,
    pub(super) line_write: u64,
    pub(super) line_shift: u32,
    /// For an observer.
    pub(super) watched: &'a mut Watched,
    /// Where the first clocks the units are free in come back to.
    pub(super) free: [&'a mut u64; 2],
    pub(super) observer: core::marker::PhantomData<O>,
}

impl TapClocks {
    /// Room for so many taps, of so many planes.
    pub(super) fn begin(&mut self, taps: usize, planes: usize) {
        for clocks in [&mut self.tags, &mut self.ready, &mut self.data_done] {
            clocks.resize(taps, 0);
        }
        self.hits.resize(planes, 0);
    }
}

impl<T: Taps, O: TimingObserver> Passing<'_, T, O> {
    /// A tap enters the tag unit.
    #[inline(always)]
    fn enter(&mut self, number: usize) {
        let tag = self.tag_free.max(self.places[number]);
        self.clocks.tags[number] = tag;
        self.at_hand = AtHand { number, plane: self.taps.plane(number).into(), done: tag, ..AtHand::default() };
    }

    /// The tap at hand leaves it.
    #[inline(always)]
    fn leave(&mut self) {
        let AtHand { number, done, missed, filled, .. } = self.at_hand;
        self.spent += done - self.clocks.tags[number];
        let door = done + self.tag_latency;
        self.clocks.ready[number] = door.max(filled);
        if missed > 0 {
            self.clocks.waiting.push(Waiting { tap: number, missed, door });
        }
        self.tag_free = done + 1;
        if O::WATCHES {
            self.rest.watched.tag_done.push(done);
        }
    }

    /// The bank of a line, and the first clock from that of the access before on in which it can be accessed, in which it is counted.
    #[inline(always)]
    fn clock(&mut self, line: u64) -> (usize, u64) {
        let bank = self.tag_bank.bank(line);
        let conflict = self.at_hand.banks_taken >> bank & 1;
        self.rest.counts.tag_bank_conflicts += conflict;
        (bank, self.at_hand.done + conflict)
    }

    /// The first clock of the tag unit without an entry: another bank may be accessed in the clock of the access before.
    #[inline(always)]
    fn next(&self) -> u64 {
        self.at_hand.done + u64::from(self.at_hand.banks_taken != 0)
    }

    /// An access was made in this clock.
    #[inline(always)]
    fn accessed(&mut self, bank: usize, clock: u64) {
        let tap = &mut self.at_hand;
        tap.banks_taken = if clock == tap.done { tap.banks_taken } else { 0 } | 1 << bank;
        tap.done = clock;
    }

    /// A hit, which may have to wait until the line is there.
    #[inline(always)]
    fn hit(&mut self, line: u64, slot: u32) {
        let (bank, clock) = self.clock(line);
        let (made, merged) = self.misses.status.hit(slot, clock);
        if made > clock {
            self.rest.counts.tag_stall_merge += made - self.next();
        }
        self.clocks.hits[self.at_hand.plane] += HIT + u64::from(merged) * MERGED;
        self.accessed(bank, made);
    }

    #[inline(always)]
    fn miss(&mut self, line: u64, slot: u32) {
        let (bank, clock) = self.clock(line);
        let (next, plane) = (self.next(), self.at_hand.plane);
        let miss = self.misses.miss(line, slot, clock, next, &mut self.planes[plane]);
        self.at_hand.filled = self.at_hand.filled.max(miss.fetch.filled);
        self.at_hand.missed += 1;
        if O::WATCHES {
            let (tap, address) = (self.rest.counts.taps + self.at_hand.number as u64, line << self.rest.line_shift);
            let fill = FillTimes { tap, plane: plane as u16, address, access: miss.clock, fetch: miss.fetch };
            self.rest.watched.fills.push((fill, self.misses.stored().into()));
        }
        self.accessed(bank, miss.clock);
    }

    /// Any tap passes the tag unit, which has these runs, some of which may be of one line. The texels of a run after the first hit the line the first
    /// accessed.
    #[inline(never)]
    fn pass_one(&mut self, tap: usize, runs: &[Run], repeated: bool) {
        self.enter(tap);
        for (number, run) in runs.iter().enumerate() {
            let slot = run.noted();
            if slot & Slots::MISSED != 0 {
                self.miss(run.line, slot & !Slots::MISSED);
            } else if !(repeated && runs[..number].iter().any(|before| before.line == run.line)) {
                self.hit(run.line, slot);
            }
        }
        self.leave();
    }

    /// Plain taps of these pass the tag unit, the first run of which has the number `at`. The first other tap, and the number of its first run.
    #[inline(always)]
    fn pass_plain(
        &mut self,
        taps: Range<usize>,
        Runs { runs, counts }: Runs<'_>,
        clashes: &[u8],
        at: usize,
    ) -> (usize, usize) {
        let Range { start: begin, end } = taps;
        let mut plain = Plain {
            counts,
            clashes,
            rooms: self.places,
            tags: &mut self.clocks.tags,
            ready: &mut self.clocks.ready,
            hits: &mut self.clocks.hits,
            status: self.misses.status.hits(),
            tag_latency: self.tag_latency,
            tag_free: self.tag_free,
            conflicts: 0,
        };
        let (tap, next) = plain.pass(taps, self.taps.planes_before(end), runs, at);
        let conflicts = plain.conflicts;
        self.tag_free = plain.tag_free;
        self.spent += conflicts;
        self.rest.counts.tag_bank_conflicts += conflicts;
        if O::WATCHES {
            let done = self.clocks.ready[begin..tap].iter().map(|ready| ready - self.tag_latency);
            self.rest.watched.tag_done.extend(done);
        }
        (tap, next)
    }

    /// Taps that have passed the tag unit pass the data unit.
    #[inline(always)]
    fn read(&mut self, taps: Range<usize>) {
        let Rest { counts, data_banks, line_write, .. } = &mut self.rest;
        let TapClocks { ready, data_done, waiting, .. } = &mut *self.clocks;
        let (ready, data_done) = (&ready[taps.clone()], &mut data_done[taps.clone()]);
        let frees = &mut self.places[self.depth..][taps.clone()];
        let mut free = self.data_free;
        if self.all_apart && *line_write == 0 {
            for ((&ready, data_done), place) in ready.iter().zip(&mut *data_done).zip(frees.iter_mut()) {
                let data = free.max(ready);
                free = data + 1;
                (*data_done, *place) = (data, free);
            }
        } else {
            let mut waiting = waiting.iter().peekable();
            for (tap, ((&ready, data_done), place)) in
                taps.clone().zip(ready.iter().zip(&mut *data_done).zip(frees.iter_mut()))
            {
                let data = free.max(ready);
                // What it missed is written, and then it is read.
                let missed = waiting.next_if(|waiting| waiting.tap == tap).map_or(0, |waiting| waiting.missed);
                let begin = data + missed as u64 * *line_write;
                counts.fill_write_clocks += begin - data;
                let (mut done, mut words) = (begin, 0);
                if !self.all_apart {
                    (done, words) = data_banks.read(self.taps.addresses(tap), begin);
                }
                counts.data_words += words;
                counts.data_conflict_clocks += done - begin;
                free = done + 1;
                (*data_done, *place) = (done, data + 1);
            }
        }
        for Waiting { tap, missed, door } in waiting.drain(..) {
            let number = tap - taps.start;
            let before = if number == 0 { self.data_free } else { data_done[number - 1] + 1 };
            let data = frees[number] - 1;
            let waited = data - door.max(before);
            counts.data_stall_fill += waited;
            self.planes[usize::from(self.taps.plane(tap))].stall_wait_read += waited;
            self.misses.read(missed, data);
        }
        self.data_free = free;
    }

    /// As many of these taps, at least one, as can pass the tag unit before any of them passes the data unit pass both, each as `pass` says; where the rest
    /// of them begin.
    #[inline(always)]
    fn pass_some(&mut self, taps: Range<usize>, mut pass: impl FnMut(&mut Self, usize, usize) -> usize) -> usize {
        let end = taps.end.min(taps.start + self.depth);
        let mut tap = taps.start;
        while tap < end && self.misses.have_room() {
            tap = pass(self, tap, end);
        }
        self.read(taps.start..tap);
        tap
    }

    /// All taps, their runs, in which slots are noted, and whether two lines of a tap of two are in one bank.
    pub(super) fn pass_runs(mut self, runs: Runs<'_>, clashes: &[u8]) {
        let (mut begin, number, mut at) = (0, self.taps.number(), 0);
        while begin < number {
            begin = self.pass_some(begin..number, |passing, tap, end| {
                let (tap, first) = passing.pass_plain(tap..end, runs, clashes, at);
                at = first;
                if tap == end {
                    return tap;
                }
                let count = runs.counts[tap];
                at += usize::from(count & !Runs::REPEATED);
                passing.pass_one(tap, &runs.runs[first..at], count & Runs::REPEATED != 0);
                tap + 1
            });
        }
        self.finish();
    }

    /// All taps, and their line accesses.
    pub(super) fn pass(mut self, accesses: &[Access]) {
        let mut accesses = accesses.iter().peekable();
        let (mut begin, number) = (0, self.taps.number());
        while begin < number {
            begin = self.pass_some(begin..number, |passing, tap, _| {
                passing.enter(tap);
                while let Some(access) = accesses.next_if(|access| access.tap as usize == tap) {
                    if access.hit {
                        passing.hit(access.line, access.slot);
                    } else {
                        passing.miss(access.line, access.slot);
                    }
                }
                passing.leave();
                tap + 1
            });
        }
        self.finish();
    }

    /// There are no more.
    fn finish(self) {
        let (number, Rest { counts, watched, free: [tag_free, data_free], .. }) = (self.taps.number(), self.rest);
        counts.tag_stall_fragment_fifo += self.tag_free - *tag_free - number as u64 - self.spent;
        if self.all_apart {
            counts.data_words += self.taps.reads();
        }
        if O::WATCHES {
            watched.data.extend(self.places[self.depth..].iter().map(|free| free - 1));
        }
        for (row, hits) in self.planes.iter_mut().zip(&mut self.clocks.hits) {
            row.fetches_ok += *hits % MERGED;
            row.fetches_merged += *hits / MERGED;
            *hits = 0;
        }
        (*tag_free, *data_free) = (self.tag_free, self.data_free);
    }
}

/// What only an observer wants to know: by tap, and of misses.
#[derive(Clone, Debug, Default)]
pub(super) struct Watched {
    pub(super) tag_done: Vec<u64>,
    pub(super) data: Vec<u64>,
    pub(super) fills: Vec<(FillTimes, Vec<StoredFetch>)>,
}

impl Watched {
    pub(super) fn clear(&mut self) {
        self.tag_done.clear();
        self.data.clear();
        self.fills.clear();
    }
}
