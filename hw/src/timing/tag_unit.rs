//! The tag unit of a machine of [`Ample`](super::ample::Ample)'s kind: what a tap does there.

use core::{hint::select_unpredictable, marker::PhantomData};

use alloc::vec::Vec;

use super::{
    banks::BankOf,
    counters::PlaneTiming,
    events::{FillTimes, TimingObserver},
    miss_status::StatusHits,
    misses::Misses,
    passing::Watched,
    pipeline::Counts,
    slots::Slots,
};
use crate::cache::Run;

/// The tag unit, and what it counts.
pub(super) struct TagUnit<'a, O> {
    pub(super) misses: &'a mut Misses,
    pub(super) planes: &'a mut [PlaneTiming],
    /// By plane, accesses that hit, and merged ones.
    pub(super) hits: &'a mut [u64],
    pub(super) waiting: &'a mut Vec<Waiting>,
    pub(super) bank: BankOf,
    pub(super) latency: u64,
    pub(super) line_shift: u32,
    pub(super) counts: &'a mut Counts,
    pub(super) at_hand: AtHand,
    /// Clocks that taps spent here beyond one each.
    pub(super) spent: u64,
    /// For an observer.
    pub(super) watched: &'a mut Watched,
    pub(super) observer: PhantomData<O>,
}

/// A tap that has missed lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct Waiting {
    pub(super) tap: usize,
    pub(super) missed: usize,
    /// When it is at the door of the data unit, lines or not.
    pub(super) door: u64,
}

/// The tap in the unit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AtHand {
    number: usize,
    plane: usize,
    /// When it came.
    tag: u64,
    /// The clock of its last access so far, and the banks with an access in that clock.
    done: u64,
    banks_taken: u64,
    /// How many lines it missed, and when the last of them is there.
    missed: usize,
    filled: u64,
}

/// A hit, and a merged one, as they are counted by plane.
const HIT: u64 = 1;
pub(super) const MERGED: u64 = 1 << 32;

/// Taps of one line or two, all there. What is needed for them is laid open for as long, so that a host can have it in registers.
pub(super) struct PlainTaps<'a> {
    status: StatusHits<'a>,
    hits: &'a mut [u64],
    pub(super) latency: u64,
    pub(super) watched: &'a mut Watched,
}

impl PlainTaps<'_> {
    /// A tap of `count` lines, one or two, which are in these slots and accessed in these clocks, if all are there: that is counted. Else, or if one must be
    /// waited for, nothing is done and the answer is false. Of one line the other slot is that of whatever follows. Which it is no host can guess.
    #[inline(always)]
    pub(super) fn pass(&mut self, slots: [u32; 2], count: u8, plane: usize, clocks: [u64; 2]) -> bool {
        let slots = [slots[0], select_unpredictable(count == 2, slots[1], self.status.nothing())];
        if (slots[0] | slots[1]) & Slots::MISSED != 0 {
            return false;
        }
        let Some(merged) = self.status.hit_two(slots, clocks) else { return false };
        self.hits[plane] += u64::from(count) * HIT + merged * MERGED;
        true
    }
}

impl<O: TimingObserver> TagUnit<'_, O> {
    /// For plain taps that are likely to follow.
    #[inline(always)]
    pub(super) fn plain(&mut self) -> PlainTaps<'_> {
        PlainTaps { status: self.misses.status.hits(), hits: self.hits, latency: self.latency, watched: self.watched }
    }

    /// Any tap, which has these runs, some of which may be of one line: the clock of its last access, and from which on it is at the door of the data
    /// unit with all its lines there. The texels of a run after the first hit the line the first accessed.
    #[inline(never)]
    pub(super) fn pass_runs(
        &mut self,
        number: usize,
        plane: usize,
        tag: u64,
        runs: &[Run],
        repeated: bool,
    ) -> (u64, u64) {
        self.enter(number, plane, tag);
        for (number, run) in runs.iter().enumerate() {
            let slot = run.noted();
            if slot & Slots::MISSED != 0 {
                self.miss(run.line, slot & !Slots::MISSED);
            } else if !(repeated && runs[..number].iter().any(|before| before.line == run.line)) {
                self.hit(run.line, slot);
            }
        }
        self.leave()
    }

    /// A tap enters.
    #[inline(always)]
    pub(super) fn enter(&mut self, number: usize, plane: usize, tag: u64) {
        self.at_hand = AtHand { number, plane, tag, done: tag, ..AtHand::default() };
    }

    /// The tap at hand leaves; the answer is that of [`Self::pass_runs`].
    #[inline(always)]
    pub(super) fn leave(&mut self) -> (u64, u64) {
        let AtHand { number, tag, done, missed, filled, .. } = self.at_hand;
        self.spent += done - tag;
        let door = done + self.latency;
        if missed > 0 {
            self.waiting.push(Waiting { tap: number, missed, door });
        }
        (done, door.max(filled))
    }

    /// The bank of a line, and the first clock from that of the access before on in which it can be accessed, in which it is counted.
    #[inline(always)]
    fn clock(&mut self, line: u64) -> (usize, u64) {
        let bank = self.bank.bank(line);
        let conflict = self.at_hand.banks_taken >> bank & 1;
        self.counts.tag_bank_conflicts += conflict;
        (bank, self.at_hand.done + conflict)
    }

    /// The first clock without an entry: another bank may be accessed in the clock of the access before.
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
    pub(super) fn hit(&mut self, line: u64, slot: u32) {
        let (bank, clock) = self.clock(line);
        let (made, merged) = self.misses.status.hit(slot, clock);
        if made > clock {
            self.counts.tag_stall_merge += made - self.next();
        }
        self.hits[self.at_hand.plane] += HIT + u64::from(merged) * MERGED;
        self.accessed(bank, made);
    }

    /// A miss.
    #[inline(always)]
    pub(super) fn miss(&mut self, line: u64, slot: u32) {
        let (bank, clock) = self.clock(line);
        let (next, plane) = (self.next(), self.at_hand.plane);
        let miss = self.misses.miss(line, slot, clock, next, &mut self.planes[plane]);
        self.at_hand.filled = self.at_hand.filled.max(miss.fetch.filled);
        self.at_hand.missed += 1;
        if O::WATCHES {
            let (tap, address) = (self.counts.taps + self.at_hand.number as u64, line << self.line_shift);
            let fill = FillTimes { tap, plane: plane as u16, address, access: miss.clock, fetch: miss.fetch };
            self.watched.fills.push((fill, self.misses.stored().into()));
        }
        self.accessed(bank, miss.clock);
    }
}
