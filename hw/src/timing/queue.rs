//! The two things that hold items up: a FIFO without a place and a unit as wide as it is. And the ledger of a unit's clocks.

use alloc::{boxed::Box, vec};

/// A FIFO by the clocks at which its places can be taken again.
#[derive(Clone, Debug, Default)]
pub(super) struct Fifo {
    /// For the place of each of the last items, the first clock at which another can take it.
    free: Box<[u64]>,
    /// Place of the next item.
    next: usize,
    /// Most places held, at least 1 here, and the place of the item that many before the next: one more are held when the next enters only if
    /// that one still is.
    most: usize,
    before: usize,
    /// Sum over items of the clocks they held a place.
    clocks: u64,
}

impl Fifo {
    pub(super) fn new(depth: u32) -> Self {
        let free = vec![0; depth as usize].into();
        Self { free, next: 0, most: 1, before: depth as usize - 1, clocks: 0 }
    }

    /// The first clock at which the next item can take a place.
    #[inline(always)]
    pub(super) fn room(&self) -> u64 {
        self.free[self.next]
    }

    /// The same for the item `ahead` places behind the next, `ahead` below the depth.
    #[inline(always)]
    pub(super) fn room_ahead(&self, ahead: usize) -> u64 {
        let place = self.next + ahead;
        self.free[if place < self.free.len() { place } else { place - self.free.len() }]
    }

    /// The next item takes its place in clock `enter`; another can take it from `free` on, which is later.
    #[inline(always)]
    pub(super) fn pass(&mut self, enter: u64, free: u64) {
        let depth = self.free.len();
        // A FIFO that has been full once has held the most it can.
        if self.most < depth {
            if self.free[self.before] > enter {
                self.most += 1;
            } else {
                self.before = if self.before + 1 == depth { 0 } else { self.before + 1 };
            }
        }
        self.clocks += free - enter;
        self.free[self.next] = free;
        self.next = if self.next + 1 == depth { 0 } else { self.next + 1 };
    }

    pub(super) const fn most(&self) -> u64 {
        if self.clocks == 0 { 0 } else { self.most as u64 }
    }

    pub(super) const fn clocks(&self) -> u64 {
        self.clocks
    }
}

/// At most so many items a clock, in order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Width {
    clock: u64,
    used: u32,
    width: u32,
    /// Clocks with an item.
    busy: u64,
}

impl Width {
    pub(super) const fn new(width: u32) -> Self {
        Self { clock: 0, used: 0, width, busy: 0 }
    }

    /// The first clock from `earliest` on with room.
    #[inline(always)]
    pub(super) fn earliest(&self, earliest: u64) -> u64 {
        if earliest > self.clock { earliest } else { self.clock + u64::from(self.used >= self.width) }
    }

    /// Counts an item in a clock that is not before the last.
    #[inline(always)]
    pub(super) fn count(&mut self, clock: u64) {
        let fresh = clock != self.clock || self.used == 0;
        self.used = if fresh { 1 } else { self.used + 1 };
        self.busy += u64::from(fresh);
        self.clock = clock;
    }

    /// Both.
    #[inline(always)]
    pub(super) fn take(&mut self, earliest: u64) -> u64 {
        let clock = self.earliest(earliest);
        self.count(clock);
        clock
    }

    /// Of a width of 1, the first clock with room.
    pub(super) fn next(&self) -> u64 {
        self.clock + u64::from(self.used)
    }

    /// Of a width of 1, some items more, after which `next` is the first clock with room.
    pub(super) fn add(&mut self, next: u64, items: u64) {
        if items > 0 {
            (self.clock, self.used) = (next - 1, 1);
            self.busy += items;
        }
    }

    /// Clocks with an item.
    pub(super) const fn busy(&self) -> u64 {
        self.busy
    }

    /// The clock of the last item.
    #[inline(always)]
    pub(super) const fn last(&self) -> u64 {
        self.clock
    }
}

/// Where the clocks of a unit went. Every clock is entered once, in order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ledger {
    /// First clock not entered yet.
    next: u64,
    pub(super) busy: u64,
    pub(super) idle: u64,
}

impl Ledger {
    /// A ledger whose first clock without an entry is this.
    pub(super) fn at(next: u64) -> Self {
        Self { next, ..Self::default() }
    }

    /// The first clock without an entry.
    #[inline(always)]
    pub(super) fn next(&self) -> u64 {
        self.next
    }

    /// Enters all clocks before `next`, so many of them busy and idle.
    pub(super) fn add(&mut self, next: u64, busy: u64, idle: u64) {
        self.next = next;
        self.busy += busy;
        self.idle += idle;
    }

    /// Nothing at the door before `clock`.
    #[inline(always)]
    pub(super) fn idle_until(&mut self, clock: u64) {
        if clock > self.next {
            self.idle += clock - self.next;
            self.next = clock;
        }
    }

    /// Held up until `clock`, for the cause whose counter this is. The answer is the number of clocks charged.
    #[inline(always)]
    pub(super) fn stall_until(&mut self, clock: u64, cause: &mut u64) -> u64 {
        let clocks = clock.saturating_sub(self.next);
        *cause += clocks;
        self.next += clocks;
        clocks
    }

    /// An item at the door from `door` on, held up until `room` for a cause, and taken in `clock`.
    #[inline(always)]
    pub(super) fn take(&mut self, door: u64, room: u64, clock: u64, cause: &mut u64) {
        if clock < self.next {
            return;
        }
        if clock > self.next {
            self.idle_until(door);
            self.stall_until(room, cause);
        }
        self.work(clock);
    }

    /// Something done in `clock`, the next one or the last one entered.
    #[inline(always)]
    pub(super) fn work(&mut self, clock: u64) {
        if clock >= self.next {
            debug_assert_eq!(clock, self.next, "a clock without an entry");
            self.busy += 1;
            self.next = clock + 1;
        }
    }

    /// Something done in every clock from the next one, or one already entered, to `last`.
    #[inline(always)]
    pub(super) fn work_through(&mut self, last: u64) {
        if last >= self.next {
            self.busy += last + 1 - self.next;
            self.next = last + 1;
        }
    }
}
