//! Taps on their way through the tag and the data unit of a machine of [`Ample`](super::ample::Ample)'s kind.
//!
//! A tap waits for the fragment FIFO as long as the tap that many before it is not at its data, so as many taps as that is deep can pass the tag unit before
//! any passes the data unit: a loop for each unit, and in it only what that unit does.

use alloc::vec::Vec;
use core::ops::Range;

use super::{
    data_banks::DataBanks,
    events::{FillTimes, StoredFetch, TimingObserver},
    tag_unit::{MERGED, TagUnit, Waiting},
    tap_reads::Access,
    taps::Taps,
};
use crate::cache::{Runs, TapsOfRuns};

/// The taps of a batch on their way.
pub(super) struct Passing<'a, T, O> {
    pub(super) taps: &'a T,
    /// Places of the fragment FIFO: by tap, when it finds one, and `depth` behind, when another can take it.
    pub(super) places: &'a mut [u64],
    pub(super) depth: usize,
    /// By tap, as in [`TapClocks`].
    pub(super) tags: &'a mut [u64],
    pub(super) ready: &'a mut [u64],
    pub(super) data_done: &'a mut [u64],
    /// By tap, where taps are passed in runs: 1 if two lines of a tap of two are in one bank.
    pub(super) clashes: &'a [u8],
    pub(super) tag_unit: TagUnit<'a, O>,
    pub(super) data_banks: &'a mut DataBanks,
    pub(super) all_apart: bool,
    pub(super) line_write: u64,
    /// First clocks the tag and the data unit are free in, and where they come back to.
    pub(super) tag_free: u64,
    pub(super) data_free: u64,
    pub(super) free: [&'a mut u64; 2],
}

/// When the taps of a batch pass the units.
#[derive(Clone, Debug, Default)]
pub(super) struct TapClocks {
    /// By tap: when it enters the tag unit, when it is at the door of the data unit with all its lines there, and when its last word is read.
    pub(super) tags: Vec<u64>,
    pub(super) ready: Vec<u64>,
    pub(super) data_done: Vec<u64>,
    /// Those that have missed lines and not passed the data unit.
    pub(super) waiting: Vec<Waiting>,
    /// By plane, accesses that hit, and merged ones.
    pub(super) hits: Vec<u64>,
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
    /// As many of these taps as can pass the tag unit, one after the other; where those begin that cannot, which is not at once. Their runs, in which slots
    /// are noted, begin at `at`, and it is moved behind them.
    #[inline(always)]
    fn pass_tags(&mut self, taps: Range<usize>, Runs { runs, taps: of_taps, .. }: Runs<'_>, at: &mut usize) -> usize {
        let end = taps.end;
        let (counts, planes, clashes) = (&of_taps.counts[..end], &of_taps.planes[..end], &self.clashes[..end]);
        let (rooms, tags, ready) = (&self.places[..end], &mut self.tags[..end], &mut self.ready[..end]);
        // Of a tap of one run the next run is looked at too, so that the last run of all is left to taps that are not plain.
        let seconds = runs.get(1..).unwrap_or_default();
        let firsts = &runs[..seconds.len()];
        let (mut tap, mut run, mut free, mut conflicts) = (taps.start, *at, self.tag_free, 0);
        loop {
            let mut unit = self.tag_unit.plain();
            while tap < end {
                let count = counts[tap];
                if run >= firsts.len() || !matches!(count, 1 | 2) {
                    break;
                }
                let tag = free.max(rooms[tap]);
                // A tap of one line has no clash.
                let clash = u64::from(clashes[tap]);
                let (done, slots) = (tag + clash, [firsts[run].noted(), seconds[run].noted()]);
                if !unit.pass(slots, count, planes[tap] as usize, [tag, done]) {
                    break;
                }
                run += usize::from(count);
                conflicts += clash;
                (tags[tap], ready[tap]) = (tag, done + unit.latency);
                if O::WATCHES {
                    unit.watched.tag_done.push(done);
                }
                free = done + 1;
                tap += 1;
            }
            if tap == end || !self.tag_unit.misses.have_room() {
                break;
            }
            let (tag, plane, count) = (free.max(rooms[tap]), planes[tap] as usize, counts[tap]);
            let (runs, repeated) = (&runs[run..], count & TapsOfRuns::REPEATED != 0);
            let count = usize::from(count & !TapsOfRuns::REPEATED);
            let (done, when) = self.tag_unit.pass_runs(tap, plane, tag, &runs[..count], repeated);
            run += count;
            (tags[tap], ready[tap]) = (tag, when);
            if O::WATCHES {
                self.tag_unit.watched.tag_done.push(done);
            }
            free = done + 1;
            tap += 1;
        }
        (*at, self.tag_free) = (run, free);
        self.tag_unit.spent += conflicts;
        self.tag_unit.counts.tag_bank_conflicts += conflicts;
        tap
    }

    /// Taps that have passed the tag unit pass the data unit.
    #[inline(always)]
    fn read(&mut self, taps: Range<usize>) {
        let TagUnit { counts, waiting, planes, misses, .. } = &mut self.tag_unit;
        let (ready, data_done) = (&self.ready[taps.clone()], &mut self.data_done[taps.clone()]);
        let frees = &mut self.places[self.depth..][taps.clone()];
        let mut free = self.data_free;
        let clocks = ready.iter().zip(&mut *data_done).zip(frees.iter_mut());
        if self.all_apart && self.line_write == 0 {
            for ((&ready, data_done), place) in clocks {
                let data = free.max(ready);
                free = data + 1;
                (*data_done, *place) = (data, free);
            }
        } else {
            let mut waiting = waiting.iter().peekable();
            for (tap, ((&ready, data_done), place)) in taps.clone().zip(clocks) {
                let data = free.max(ready);
                // What it missed is written, and then it is read.
                let missed = waiting.next_if(|waiting| waiting.tap == tap).map_or(0, |waiting| waiting.missed);
                let begin = data + missed as u64 * self.line_write;
                counts.fill_write_clocks += begin - data;
                let (mut done, mut words) = (begin, 0);
                if !self.all_apart {
                    (done, words) = self.taps.with_addresses(tap, |addresses| self.data_banks.read(addresses, begin));
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
            planes[self.taps.plane(tap)].stall_wait_read += waited;
            misses.read(missed, data);
        }
        self.data_free = free;
    }

    /// All taps, and their runs, in which slots are noted.
    pub(super) fn pass_runs(mut self, runs: Runs<'_>) {
        let (mut begin, number, mut at) = (0, self.taps.number(), 0);
        while begin < number {
            let tap = self.pass_tags(begin..number.min(begin + self.depth), runs, &mut at);
            self.read(begin..tap);
            begin = tap;
        }
        self.finish();
    }

    /// All taps, and their line accesses.
    pub(super) fn pass(mut self, accesses: &[Access]) {
        let mut accesses = accesses.iter().peekable();
        let (mut begin, number) = (0, self.taps.number());
        while begin < number {
            let (mut tap, end) = (begin, number.min(begin + self.depth));
            while tap < end && self.tag_unit.misses.have_room() {
                let (tag, unit) = (self.tag_free.max(self.places[tap]), &mut self.tag_unit);
                unit.enter(tap, self.taps.plane(tap), tag);
                while let Some(access) = accesses.next_if(|access| access.tap as usize == tap) {
                    if access.hit {
                        unit.hit(access.line, access.slot);
                    } else {
                        unit.miss(access.line, access.slot);
                    }
                }
                let (done, ready) = unit.leave();
                (self.tags[tap], self.ready[tap], self.tag_free) = (tag, ready, done + 1);
                if O::WATCHES {
                    unit.watched.tag_done.push(done);
                }
                tap += 1;
            }
            self.read(begin..tap);
            begin = tap;
        }
        self.finish();
    }

    /// There are no more.
    fn finish(self) {
        let TagUnit { counts, planes, hits, watched, spent, .. } = self.tag_unit;
        let ([tag_free, data_free], number) = (self.free, self.taps.number());
        counts.tag_stall_fragment_fifo += self.tag_free - *tag_free - number as u64 - spent;
        if self.all_apart {
            counts.data_words += self.taps.reads();
        }
        if O::WATCHES {
            watched.data.extend(self.places[self.depth..].iter().map(|free| free - 1));
        }
        for (row, hits) in planes.iter_mut().zip(hits) {
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
