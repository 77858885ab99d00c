//! Taps of one line or two, all of them there, in the tag unit: most taps, and a loop of their own.

use core::{hint::select_unpredictable, ops::Range};

use super::{
    miss_status::StatusHits,
    passing::{HIT, MERGED},
    slots::Slots,
};
use crate::cache::Run;

/// What such taps need: laid open and by value, so that a host can have it in registers.
pub(super) struct Plain<'h> {
    /// By tap: how many lines it reads, whether two of them are in one bank, the room it finds in the fragment FIFO, and its clocks. All of one length.
    pub(super) counts: &'h [u8],
    pub(super) clashes: &'h [u8],
    pub(super) rooms: &'h [u64],
    pub(super) tags: &'h mut [u64],
    pub(super) ready: &'h mut [u64],
    /// By plane.
    pub(super) hits: &'h mut [u64],
    pub(super) status: StatusHits<'h>,
    pub(super) tag_latency: u64,
    pub(super) tag_free: u64,
    /// Accesses that waited for their bank.
    pub(super) conflicts: u64,
}

impl Plain<'_> {
    /// Passes taps from this one on, up to one that is not plain or the end: their planes are told, and their runs, in which slots are noted, begin with
    /// number `at`. The answer is that tap, and the number of its first run. The last run is left to others: it is looked ahead of a tap.
    #[inline(always)]
    pub(super) fn pass(
        &mut self,
        Range { start: mut tap, end }: Range<usize>,
        plane_of: impl Fn(usize) -> u16,
        runs: &[Run],
        mut at: usize,
    ) -> (usize, usize) {
        let (counts, clashes, rooms) = (&self.counts[..end], &self.clashes[..end], &self.rooms[..end]);
        let (tags, ready) = (&mut self.tags[..end], &mut self.ready[..end]);
        let nothing = self.status.nothing();
        let (mut free, mut conflicts) = (self.tag_free, 0);
        while tap < end && at + 1 < runs.len() {
            let (count, clash) = (counts[tap], u64::from(clashes[tap]));
            let [first, second] = [runs[at].noted(), runs[at + 1].noted()];
            // Which it is no host can guess.
            let second = select_unpredictable(count == 2, second, nothing);
            if count.wrapping_sub(1) > 1 || (first | second) & Slots::MISSED != 0 {
                break;
            }
            let tag = free.max(rooms[tap]);
            // A tap of one line has no clash.
            let done = tag + clash;
            let Some(merged) = self.status.hit_two([first, second], [tag, done]) else { break };
            self.hits[usize::from(plane_of(tap))] += u64::from(count) * HIT + merged * MERGED;
            tags[tap] = tag;
            ready[tap] = done + self.tag_latency;
            conflicts += clash;
            free = done + 1;
            at += usize::from(count);
            tap += 1;
        }
        (self.tag_free, self.conflicts) = (free, conflicts);
        (tap, at)
    }
}
