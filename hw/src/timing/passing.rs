//! Taps on their way through the tag and the data unit of a machine of [`Ample`](super::ample::Ample)'s kind.

use alloc::vec::Vec;
use core::cell::Cell;

use super::{
    banks::BankOf,
    counters::PlaneTiming,
    data_banks::DataBanks,
    events::{FillTimes, StoredFetch, TimingObserver},
    miss_status::StatusHits,
    misses::{Misses, Waiting},
    pipeline::Counts,
    slots::Slots,
    tap_reads::Access,
    taps::Taps,
};
use crate::cache::Run;

/// The taps of a batch on their way, and the one at hand.
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
    pub(super) now: Now,
    pub(super) rest: Rest<'a, O>,
}

/// What the tag and the data unit are at.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Now {
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
}

/// What taps need that hit and wait for nothing: laid open and by value, for as long as there are such.
pub(super) struct Hits<'h, T> {
    taps: &'h T,
    /// By tap: the room it finds in the fragment FIFO, when its place can be taken again, and its clocks. All of one length, of which a compiler
    /// then looks at one.
    rooms: &'h [Cell<u64>],
    frees: &'h [Cell<u64>],
    tags: &'h mut [u64],
    data_done: &'h mut [u64],
    planes: &'h mut [PlaneTiming],
    status: StatusHits<'h>,
    tag_bank: BankOf,
    all_apart: bool,
    /// Whether nobody must be told of taps.
    unwatched: bool,
    waiting: &'h mut Waiting,
    data_banks: &'h mut DataBanks,
    counts: &'h mut Counts,
    line_write: u64,
    tag_latency: u64,
    now: Now,
    /// Where that comes back to.
    back: &'h mut Now,
}

/// What is not used for every access.
pub(super) struct Rest<'a, O> {
    pub(super) counts: &'a mut Counts,
    pub(super) data_banks: &'a mut DataBanks,
    pub(super) line_write: u64,
    pub(super) line_shift: u32,
    /// For an observer.
    pub(super) watched: &'a mut Watched,
    /// A tap that may access a line more than once, and how many it has accessed, these.
    pub(super) repeated: (usize, usize),
    pub(super) lines: [u64; 4],
    /// Where the first clocks the units are free in come back to.
    pub(super) free: [&'a mut u64; 2],
    pub(super) observer: core::marker::PhantomData<O>,
}

/// A tap of so many lines missed is at the door of the data unit, and waits until they are there. They are written, and the answer is when it
/// is taken. Not a method: what is in registers must not be written for it.
#[inline(never)]
fn wait_and_write(waiting: &mut Waiting, counts: &mut Counts, [door, filled, writes]: [u64; 3], missed: usize) -> u64 {
    let data = door.max(filled);
    counts.data_stall_fill += data - door;
    counts.fill_write_clocks += writes;
    waiting.read(missed, data);
    data
}

/// The clock of the last word of a tap whose reads begin at `begin`. Not a method, as above.
#[inline(never)]
fn read(data_banks: &mut DataBanks, counts: &mut Counts, addresses: &[u64], begin: u64) -> u64 {
    let (done, words) = data_banks.read(addresses, begin);
    counts.data_words += words;
    counts.data_conflict_clocks += done - begin;
    done
}

impl<T: Taps> Hits<'_, T> {
    /// The next access is a hit of this tap; false if it must be made otherwise.
    #[inline(always)]
    fn hit(&mut self, run: &Run, slot: u32) -> bool {
        if !run.is_plainly_of(self.now.tap) {
            let tap = run.tap();
            if !run.is_plainly_of(self.now.tap + 1) || !self.unwatched {
                return false;
            }
            self.leave();
            self.enter(tap);
        }
        self.access(run.line, slot)
    }

    /// That was the last one.
    #[inline(always)]
    fn close(self) {
        *self.back = self.now;
    }

    /// The next tap, which is this, enters the tag unit.
    #[inline(always)]
    fn enter(&mut self, tap: usize) {
        let now = &mut self.now;
        let tag = now.tag_free.max(self.rooms[tap].get());
        now.waited += tag - now.tag_free;
        self.tags[tap] = tag;
        (now.tap, now.plane, now.done) = (tap, usize::from(self.taps.plane(tap)), tag);
        (now.banks_taken, now.hits) = (0, 0);
    }

    /// The tap at hand leaves it, and passes the data unit; when that takes it.
    #[inline(always)]
    fn leave(&mut self) -> u64 {
        let now = &mut self.now;
        let row = &mut self.planes[now.plane];
        let door = now.data_free.max(now.done + self.tag_latency);
        let (mut data, mut data_done) = (door, door);
        if now.missed > 0 {
            let writes = now.missed as u64 * self.line_write;
            data = wait_and_write(self.waiting, self.counts, [door, now.filled, writes], now.missed);
            data_done = data + writes;
            row.stall_wait_read += data - door;
            now.missed = 0;
        }
        if !self.all_apart {
            data_done = read(self.data_banks, self.counts, self.taps.addresses(now.tap), data_done);
        }
        row.taps += 1;
        row.reads += self.taps.reads(now.tap);
        row.fetches_ok += now.hits & 0xFFFF_FFFF;
        row.fetches_merged += now.hits >> 32;
        self.data_done[now.tap] = data_done;
        self.frees[now.tap].set(data + 1);
        (now.tag_free, now.data_free) = (now.done + 1, data_done + 1);
        data
    }

    /// A hit of the tap at hand that waits for nothing; false of one that does.
    #[inline(always)]
    fn access(&mut self, line: u64, slot: u32) -> bool {
        let now = &mut self.now;
        let bank = self.tag_bank.bank(line);
        let conflict = now.banks_taken >> bank & 1;
        let clock = now.done + conflict;
        let Some(merged) = self.status.hit(slot, clock) else { return false };
        now.conflicts += conflict;
        now.hits += 1 + (u64::from(merged) << 32);
        now.banks_taken = now.banks_taken & conflict.wrapping_sub(1) | 1 << bank;
        now.done = clock;
        true
    }
}

impl<T: Taps, O: TimingObserver> Passing<'_, T, O> {
    /// Lays open what hits need.
    #[inline(always)]
    fn open(&mut self) -> Hits<'_, T> {
        let number = self.taps.number();
        let places = Cell::from_mut(&mut *self.places).as_slice_of_cells();
        Hits {
            taps: self.taps,
            rooms: &places[..number],
            frees: &places[self.depth..][..number],
            tags: &mut self.tags[..number],
            data_done: &mut self.data_done[..number],
            planes: self.planes,
            status: self.misses.status.hits(),
            tag_bank: self.tag_bank,
            all_apart: self.all_apart,
            unwatched: !O::WATCHES,
            waiting: &mut self.misses.waiting,
            data_banks: self.rest.data_banks,
            counts: self.rest.counts,
            line_write: self.rest.line_write,
            tag_latency: self.tag_latency,
            now: self.now,
            back: &mut self.now,
        }
    }

    /// The next tap, which is this, enters the tag unit.
    pub(super) fn enter(&mut self, tap: usize) {
        let mut hits = self.open();
        hits.enter(tap);
        hits.close();
    }

    /// The tap at hand leaves it, and passes the data unit.
    fn leave(&mut self) {
        let tag_done = self.now.done;
        let mut hits = self.open();
        let data = hits.leave();
        hits.close();
        if O::WATCHES {
            self.rest.watched.tag_done.push(tag_done);
            self.rest.watched.data.push(data);
        }
    }

    /// What follows is of this tap.
    #[inline(never)]
    fn go_to(&mut self, tap: usize) {
        while self.now.tap != tap {
            self.leave();
            self.enter(self.now.tap + 1);
        }
    }

    #[inline(never)]
    fn hits(&mut self, line: u64, slot: u32) {
        let mut hits = self.open();
        let made = hits.access(line, slot);
        hits.close();
        if !made {
            self.waits_to_merge(line, slot);
        }
    }

    /// The first clock of the tag unit without an entry: another bank may be accessed in the clock of the access before.
    fn next(&self) -> u64 {
        self.now.done + u64::from(self.now.banks_taken != 0)
    }

    /// The bank of a line, and the first clock from that of the access before on in which it can be accessed, in which it is counted.
    fn clock(&mut self, line: u64) -> (usize, u64) {
        let bank = self.tag_bank.bank(line);
        let conflict = self.now.banks_taken >> bank & 1;
        self.now.conflicts += conflict;
        (bank, self.now.done + conflict)
    }

    /// A hit that is made when the line is there.
    fn waits_to_merge(&mut self, line: u64, slot: u32) {
        let (bank, clock) = self.clock(line);
        let (made, _) = self.misses.status.hit(slot, clock);
        self.now.hits += 1;
        self.rest.counts.tag_stall_merge += made - self.next();
        (self.now.banks_taken, self.now.done) = (1 << bank, made);
    }

    #[inline(never)]
    fn misses(&mut self, line: u64, slot: u32) {
        let (bank, clock) = self.clock(line);
        let (next, now) = (self.next(), &mut self.now);
        let miss = self.misses.miss(line, slot, clock, now.missed, next, &mut self.planes[now.plane]);
        now.filled = if now.missed == 0 { miss.fetch.filled } else { now.filled.max(miss.fetch.filled) };
        now.missed += 1;
        if O::WATCHES {
            let (tap, address) = (self.rest.counts.taps + now.tap as u64, line << self.rest.line_shift);
            let fill = FillTimes { tap, plane: now.plane as u16, address, access: miss.clock, fetch: miss.fetch };
            self.rest.watched.fills.push((fill, self.misses.stored().into()));
        }
        now.banks_taken = if miss.clock == now.done { now.banks_taken } else { 0 } | 1 << bank;
        now.done = miss.clock;
    }

    /// Whether the tap at hand has accessed a line before this access.
    fn has_accessed(&mut self, line: u64) -> bool {
        let Rest { repeated: (tap, count), lines, .. } = &mut self.rest;
        let before = if *tap == self.now.tap { *count } else { 0 };
        let has = lines.iter().take(before).fold(false, |has, &before| has | (before == line));
        if let Some(place) = lines.get_mut(before) {
            *place = line;
        }
        (*tap, *count) = (self.now.tap, before + 1);
        has
    }

    /// All runs of the taps, and the slots of their lines. The texels of a run after the first hit the line the first accessed.
    pub(super) fn pass_runs(mut self, runs: &[Run], slots: &[u32]) {
        let mut accesses = runs.iter().zip(slots.iter().copied());
        loop {
            let mut hits = self.open();
            let other = accesses.find(|&(run, slot)| slot & Slots::MISSED != 0 || !hits.hit(run, slot));
            hits.close();
            let Some((run, slot)) = other else { break };
            self.go_to(run.tap());
            let again = run.is_repeated() && self.has_accessed(run.line);
            if slot & Slots::MISSED != 0 {
                self.misses(run.line, slot & !Slots::MISSED);
            } else if !again {
                self.hits(run.line, slot);
            }
        }
        self.finish();
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
        counts.tag_stall_fragment_fifo += self.now.waited;
        counts.tag_bank_conflicts += self.now.conflicts;
        if self.all_apart {
            counts.data_words += (0..number).map(|tap| self.taps.reads(tap)).sum::<u64>();
        }
        (*tag_free, *data_free) = (self.now.tag_free, self.now.data_free);
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
