//! Taps on their way through the tag and the data unit of a machine of [`Ample`](super::ample::Ample)'s kind, while the cache is asked: what it
//! finds goes no further than to the next addition.

use alloc::vec::Vec;

use super::{
    banks::BankOf,
    counters::PlaneTiming,
    data_banks::DataBanks,
    events::{FillTimes, StoredFetch, TimingObserver},
    misses::Misses,
    pipeline::Counts,
    tap_reads::Access,
    taps::Taps,
};
use crate::cache::{Run, RunObserver};

/// The taps of a batch on their way, and the one at hand. Flat, and by value, where it is used for every access.
pub(super) struct Passing<'a, T, O> {
    pub(super) taps: &'a T,
    /// Places of the fragment FIFO.
    pub(super) places: &'a mut [u64],
    pub(super) depth: usize,
    /// Clocks of the batch.
    pub(super) tags: &'a mut [u64],
    pub(super) data_done: &'a mut [u64],
    pub(super) planes: &'a mut [PlaneTiming],
    pub(super) misses: &'a mut Misses,
    pub(super) tag_bank: BankOf,
    pub(super) all_apart: bool,
    pub(super) tag_latency: u64,

    /// First clocks the units are free in.
    pub(super) tag_free: u64,
    pub(super) data_free: u64,
    /// The tap at hand: its plane, the clock of its last access so far, and the banks with an access in that clock.
    pub(super) tap: usize,
    pub(super) plane: usize,
    pub(super) done: u64,
    pub(super) banks_taken: u64,
    /// Its accesses that hit, and in the upper half how many of them were merged.
    pub(super) hits: u64,
    /// How many lines it missed, and when the last of them is there.
    pub(super) missed: usize,
    pub(super) filled: u64,

    pub(super) waited: u64,
    pub(super) conflicts: u64,
    pub(super) rest: Rest<'a, O>,
}

/// What is not used for every access.
pub(super) struct Rest<'a, O> {
    pub(super) counts: &'a mut Counts,
    pub(super) data_banks: &'a mut DataBanks,
    pub(super) line_write: u64,
    pub(super) line_shift: u32,
    /// For an observer.
    pub(super) watched: &'a mut Watched,
    /// A tap whose texels are told one by one, and how many lines it has accessed, these.
    pub(super) alone: (usize, usize),
    pub(super) lines: [u64; 4],
    /// Where the first clocks the units are free in come back to.
    pub(super) free: [&'a mut u64; 2],
    pub(super) observer: core::marker::PhantomData<O>,
}

impl<T: Taps, O: TimingObserver> Passing<'_, T, O> {
    /// The next tap, which is this, enters the tag unit.
    #[inline(always)]
    pub(super) fn enter(&mut self, tap: usize) {
        let tag = self.tag_free.max(self.places[tap]);
        self.waited += tag - self.tag_free;
        self.tags[tap] = tag;
        (self.tap, self.plane, self.done) = (tap, usize::from(self.taps.plane(tap)), tag);
        self.banks_taken = 0;
        self.hits = 0;
    }

    /// It leaves it, and passes the data unit.
    #[inline(always)]
    fn leave(&mut self) {
        let row = &mut self.planes[self.plane];
        row.taps += 1;
        row.reads += self.taps.reads(self.tap);
        row.fetches_ok += self.hits & 0xFFFF_FFFF;
        row.fetches_merged += self.hits >> 32;
        let mut data = self.data_free.max(self.done + self.tag_latency);
        let mut data_done = data;
        if self.missed > 0 {
            (data, data_done) = self.fill(data);
        }
        if !self.all_apart {
            data_done = self.read(data_done);
        }
        if O::WATCHES {
            self.rest.watched.tag_done.push(self.done);
            self.rest.watched.data.push(data);
        }
        self.data_done[self.tap] = data_done;
        self.places[self.tap + self.depth] = data + 1;
        (self.tag_free, self.data_free) = (self.done + 1, data_done + 1);
    }

    /// What follows is of this tap.
    #[inline(always)]
    fn go_to(&mut self, tap: usize) {
        if self.tap != tap {
            self.leave();
            self.enter(self.tap + 1);
            while self.tap != tap {
                self.skip();
            }
        }
    }

    /// Past a tap without an access, of which there are few.
    #[inline(never)]
    fn skip(&mut self) {
        self.leave();
        self.enter(self.tap + 1);
    }

    #[inline(always)]
    fn hits(&mut self, line: u64, slot: u32) {
        let bank = self.tag_bank.bank(line);
        let conflict = self.banks_taken >> bank & 1;
        self.conflicts += conflict;
        let clock = self.done + conflict;
        let (made, merged) = self.misses.status.hit(slot, clock);
        self.hits += 1 + (u64::from(merged) << 32);
        if made > clock {
            self.waits_to_merge(bank, made);
        } else {
            self.banks_taken = self.banks_taken & conflict.wrapping_sub(1) | 1 << bank;
            self.done = clock;
        }
    }

    /// The first clock of the tag unit without an entry: another bank may be accessed in the clock of the access before.
    fn next(&self) -> u64 {
        self.done + u64::from(self.banks_taken != 0)
    }

    /// A hit that is made no earlier than in this clock, when the line is there.
    #[inline(never)]
    fn waits_to_merge(&mut self, bank: usize, made: u64) {
        self.rest.counts.tag_stall_merge += made - self.next();
        (self.banks_taken, self.done) = (1 << bank, made);
    }

    #[inline(never)]
    fn misses(&mut self, line: u64, slot: u32) {
        let bank = self.tag_bank.bank(line);
        let conflict = self.banks_taken >> bank & 1;
        self.conflicts += conflict;
        let (clock, next) = (self.done + conflict, self.next());
        let miss = self.misses.miss(line, slot, clock, self.missed, next, &mut self.planes[self.plane]);
        self.filled = if self.missed == 0 { miss.fetch.filled } else { self.filled.max(miss.fetch.filled) };
        self.missed += 1;
        if O::WATCHES {
            let (tap, address) = (self.rest.counts.taps + self.tap as u64, line << self.rest.line_shift);
            let fill = FillTimes { tap, plane: self.plane as u16, address, access: miss.clock, fetch: miss.fetch };
            self.rest.watched.fills.push((fill, self.misses.stored().into()));
        }
        self.banks_taken = if miss.clock == self.done { self.banks_taken } else { 0 } | 1 << bank;
        self.done = miss.clock;
    }

    /// The data unit, for a tap with misses that is at its door in clock `door`: when it takes it, and when its reads begin.
    #[inline(never)]
    fn fill(&mut self, door: u64) -> (u64, u64) {
        let data = door.max(self.filled);
        self.rest.counts.data_stall_fill += data - door;
        self.planes[self.plane].stall_wait_read += data - door;
        self.misses.read(self.missed, data);
        let writes = self.missed as u64 * self.rest.line_write;
        self.rest.counts.fill_write_clocks += writes;
        self.missed = 0;
        (data, data + writes)
    }

    /// The clock of the last word of a tap whose reads begin at `begin`.
    #[inline(never)]
    fn read(&mut self, begin: u64) -> u64 {
        let (done, words) = self.rest.data_banks.read(self.taps.addresses(self.tap), begin);
        self.rest.counts.data_words += words;
        self.rest.counts.data_conflict_clocks += done - begin;
        done
    }

    /// Whether the tap at hand, whose texels are told one by one, has accessed a line before this access.
    #[inline(always)]
    fn has_accessed(&mut self, line: u64) -> bool {
        let Rest { alone: (tap, count), lines, .. } = &mut self.rest;
        let before = if *tap == self.tap { *count } else { 0 };
        let has = lines.iter().take(before).fold(false, |has, &before| has | (before == line));
        if let Some(place) = lines.get_mut(before) {
            *place = line;
        }
        (*tap, *count) = (self.tap, before + 1);
        has
    }

    /// All line accesses of the taps.
    pub(super) fn pass(mut self, accesses: &[Access]) {
        for access in accesses {
            self.go_to(access.tap as usize);
            if access.hit {
                self.hits(access.line, access.slot);
            } else {
                self.misses(access.line, access.slot);
            }
        }
        self.finish();
    }

    /// There are no more.
    pub(super) fn finish(mut self) {
        let number = self.taps.number();
        self.go_to(number - 1);
        self.leave();
        let Rest { counts, free: [tag_free, data_free], .. } = self.rest;
        counts.tag_stall_fragment_fifo += self.waited;
        counts.tag_bank_conflicts += self.conflicts;
        if self.all_apart {
            counts.data_words += (0..number).map(|tap| self.taps.reads(tap)).sum::<u64>();
        }
        (*tag_free, *data_free) = (self.tag_free, self.data_free);
    }
}

/// The texels of a run after the first hit the line the first accessed.
impl<T: Taps, O: TimingObserver> RunObserver for Passing<'_, T, O> {
    #[inline(always)]
    fn hit(&mut self, run: &Run, slot: u32) {
        self.go_to(run.tap());
        if run.is_alone() && self.has_accessed(run.line) {
            return;
        }
        self.hits(run.line, slot);
    }

    #[inline(always)]
    fn miss(&mut self, run: &Run, slot: u32, _: Option<u64>) {
        self.go_to(run.tap());
        if run.is_alone() {
            self.has_accessed(run.line);
        }
        self.misses(run.line, slot);
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
