//! The tag memory and the lookup itself, for any replacement policy.

use alloc::{vec, vec::Vec};
use core::slice::IterMut;

use super::{Observer, Outcome, Run, changes::Changes, line_index::LineIndex, replacement::Replacement};
use crate::lanes::{BLOCK, Kept};

/// Sets wider than this are searched through an index instead of way by way.
const SCANNED_WAYS_MAX: usize = 16;

/// Looks up the lines of byte addresses; the answer is the number of misses. A line that comes twice running, as most do, is not looked up twice.
#[inline(always)]
pub(super) fn look_up<O: Observer>(
    addresses: &[u64],
    mut changes: Changes,
    line_of: impl Fn(u64) -> u64,
    observer: &mut O,
    mut access: impl FnMut(u64) -> Outcome,
) -> u64 {
    let Some(&first) = addresses.first() else { return 0 };
    let mut misses = 0;
    if !O::EVERY {
        let mut kept: Kept = [0; _];
        for block in addresses.chunks(BLOCK) {
            let count = changes.keep(block, &mut kept);
            for &line in &kept[..count] {
                let outcome = access(line);
                if !outcome.is_hit() {
                    misses += 1;
                }
                observer.lookup(changes.address(line), line, outcome);
            }
        }
        return misses;
    }
    let (mut last, mut slot) = (!line_of(first), 0);
    for &address in addresses {
        let line = line_of(address);
        if line == last {
            observer.lookup(address, line, Outcome::Hit { slot });
            continue;
        }
        let outcome = access(line);
        (last, slot) = (line, outcome.slot());
        misses += u64::from(!outcome.is_hit());
        observer.lookup(address, line, outcome);
    }
    misses
}

/// Looks up runs for as long as `go_on` says of each and its outcome; the one of which it did not, if there was one.
#[inline(always)]
pub(super) fn access_until<'i>(
    runs: &mut IterMut<'i, Run>,
    mut go_on: impl FnMut(&mut Run, Outcome) -> bool,
    mut access: impl FnMut(u64) -> Outcome,
) -> Option<(&'i mut Run, Outcome)> {
    runs.find_map(|run| {
        let outcome = access(run.line);
        (!go_on(run, outcome)).then_some((run, outcome))
    })
}

/// Tags of `sets * ways` lines, each in its way for as long as it stays.
#[derive(Clone, Debug)]
pub(super) struct Tags<R> {
    ways: usize,
    sets: Vec<Set>,
    lines: Vec<u64>,
    index: Option<LineIndex>,
    resident: u64,
    replacement: R,
}

/// What is known of a set. Touching the line touched last changes nothing in any policy, so a lookup that finds it here
/// is done: most lookups of a texture unit are.
#[derive(Clone, Copy, Debug, Default)]
struct Set {
    /// The line touched last; in an empty set, a line of another set.
    last: u64,
    /// Its slot.
    slot: u32,
    /// Ways filled: the lowest ones, for lines never leave but by replacement.
    filled: u32,
}

impl<R: Replacement> Tags<R> {
    pub(super) fn new(sets: usize, ways: usize, replacement: R) -> Self {
        // Line 0 belongs to set 0 and so marks every other set empty; line 1 does so for set 0 (with one set: see `prime`).
        let mut states = vec![Set::default(); sets];
        states[0].last = 1;
        Self {
            ways,
            sets: states,
            lines: vec![0; sets * ways],
            index: (ways > SCANNED_WAYS_MAX).then(|| LineIndex::new(sets * ways)),
            resident: 0,
            replacement,
        }
    }

    /// Looks `line` up in `set`, which must be its own.
    #[inline(always)]
    pub(super) fn access(&mut self, set: usize, line: u64) -> Outcome {
        self.prime(line);
        self.access_primed(set, line)
    }

    /// [`access_until`] with these tags.
    #[inline(always)]
    pub(super) fn access_until<'i>(
        &mut self,
        runs: &mut IterMut<'i, Run>,
        set_of: impl Fn(u64, usize) -> usize,
        go_on: impl FnMut(&mut Run, Outcome) -> bool,
    ) -> Option<(&'i mut Run, Outcome)> {
        access_until(runs, go_on, |line| self.access(set_of(line, self.sets.len()), line))
    }

    /// With one set there is no line of another set to mark it empty, but any line other than the first to come does.
    #[inline(always)]
    fn prime(&mut self, first: u64) {
        if self.resident == 0 && self.sets.len() == 1 {
            self.sets[0].last = !first;
        }
    }

    #[inline(always)]
    fn access_primed(&mut self, set: usize, line: u64) -> Outcome {
        let state = self.sets[set];
        if state.last == line { Outcome::Hit { slot: state.slot } } else { self.access_other(set, line) }
    }

    /// A lookup of another line than the one touched last in the set.
    #[inline(always)]
    fn access_other(&mut self, set: usize, line: u64) -> Outcome {
        let ways = self.ways;
        let base = set * ways;
        let state = &mut self.sets[set];
        let lines = &mut self.lines[base..base + ways];

        let found = match &self.index {
            Some(index) => index.find(line, &self.lines).map(|slot| slot as usize - base),
            None => {
                // All ways are compared, as in the chip: no branch but one on the answer.
                let equal =
                    lines.iter().enumerate().fold(0, |equal, (way, &tag)| equal | u32::from(tag == line) << way);
                let valid = equal & ((1 << state.filled) - 1);
                (valid != 0).then(|| valid.trailing_zeros() as usize)
            }
        };
        if let Some(way) = found {
            self.replacement.hit(set, way);
            let slot = (base + way) as u32;
            (state.last, state.slot) = (line, slot);
            return Outcome::Hit { slot };
        }

        let (way, evicted) = if (state.filled as usize) < ways {
            let way = state.filled as usize;
            state.filled += 1;
            self.resident += 1;
            self.replacement.fill(set, way);
            (way, None)
        } else {
            let way = self.replacement.replace(set);
            (way, Some(self.lines[base + way]))
        };
        let slot = (base + way) as u32;
        if let Some(index) = &mut self.index {
            if evicted.is_some() {
                index.remove(self.lines[slot as usize], slot);
            }
            index.insert(line, slot);
        }
        self.lines[base + way] = line;
        (state.last, state.slot) = (line, slot);
        Outcome::Miss { slot, evicted }
    }

    /// Looks up the lines of byte addresses; the answer is the number of misses. Compiled on its own: among the loops of other engines the host
    /// has no registers left for this one.
    #[inline(never)]
    pub(super) fn run<O: Observer>(
        &mut self,
        addresses: &[u64],
        changes: Changes,
        line_of: impl Fn(u64) -> u64,
        set_of: impl Fn(u64, usize) -> usize,
        observer: &mut O,
    ) -> u64 {
        let Some(&first) = addresses.first() else { return 0 };
        self.prime(line_of(first));
        look_up(addresses, changes, line_of, observer, |line| {
            let set = set_of(line, self.sets.len());
            self.access_primed(set, line)
        })
    }

    /// Lines held now.
    pub(super) fn resident(&self) -> u64 {
        self.resident
    }
}
