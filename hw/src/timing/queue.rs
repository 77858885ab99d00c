//! The two things that hold items up: a FIFO without a place and a unit as wide as it is. And the ledger of a unit's clocks.

use alloc::{vec, vec::Vec};

/// A FIFO by the clocks at which its places can be taken again.
#[derive(Clone, Debug, Default)]
pub(super) struct Fifo {
    depth: usize,
    /// For the places of items, in order, the first clock at which another can take them: before `next` of items long gone, from there on of
    /// the last `depth`, and room for those to come. A list that begins again now and then costs an item less than a ring.
    free: Vec<u64>,
    /// The place the next item takes.
    next: usize,
    /// Most places held, at least 1 here: one more are held when an item enters only if the item that many before it still holds its own.
    most: usize,
    /// Sum over items of the clocks they held a place.
    clocks: u64,
}

impl Fifo {
    pub(super) fn new(depth: u32) -> Self {
        let depth = depth as usize;
        Self { depth, free: vec![0; depth + depth.max(500)], next: 0, most: 1, clocks: 0 }
    }

    /// Its places.
    #[inline(always)]
    pub(super) const fn depth(&self) -> usize {
        self.depth
    }

    /// The first clock at which the next item can take a place.
    #[inline(always)]
    pub(super) fn room(&self) -> u64 {
        self.free[self.next]
    }

    /// The same for the item `ahead` places behind the next, `ahead` below the depth.
    #[inline(always)]
    pub(super) fn room_ahead(&self, ahead: usize) -> u64 {
        self.free[self.next + ahead]
    }

    /// The next item takes its place in clock `enter`; another can take it from `free` on, which is later.
    #[inline(always)]
    pub(super) fn pass(&mut self, enter: u64, free: u64) {
        let mut end = self.next + self.depth;
        if end == self.free.len() {
            self.begin_again();
            end = self.depth;
        }
        // A FIFO that has been full once has held the most it can.
        if self.most < self.depth && self.free[end - self.most] > enter {
            self.most += 1;
        }
        self.clocks += free - enter;
        self.free[end] = free;
        self.next += 1;
    }

    /// The same of a set of places: the first that can be taken again is taken first.
    #[inline(always)]
    pub(super) fn pass_in_any_order(&mut self, enter: u64, free: u64) {
        self.pass(enter, free);
        // Most come in order. None goes beyond the last `depth`: whoever held a place then has given it back by `enter`.
        let mut place = self.next + self.depth - 1;
        while self.free[place - 1] > free {
            self.free.swap(place - 1, place);
            place -= 1;
        }
    }

    /// The places of so many items to come: the room of item `i` is at `i`, and when another can take it from item `i` is to be written at
    /// `i + depth`. To be followed by [`Self::entered`].
    pub(super) fn places(&mut self, items: usize) -> (&mut [u64], usize) {
        self.reserve(items);
        (&mut self.free[self.next..][..self.depth + items], self.depth)
    }

    /// Items entered in these clocks, whose places have been written.
    pub(super) fn entered(&mut self, enters: &[u64]) {
        self.enter(self.next + self.depth, enters);
    }

    /// [`Self::pass`] for items that take their places in clocks `enters` and give them back in clocks `leaves`.
    pub(super) fn pass_all(&mut self, enters: &[u64], leaves: &[u64]) {
        let end = self.leave(leaves);
        self.enter(end, enters);
    }

    /// The next items give their places back in clocks `leaves`, which increase. They take them one a clock from `first` on, as soon as they
    /// can: in what clocks is written to `enters`, and `first` is what it will be for those behind.
    pub(super) fn pass_one_a_clock(&mut self, first: &mut u64, leaves: &[u64], enters: &mut Vec<u64>) {
        let end = self.leave(leaves);
        let items = leaves.len();
        let rooms = &self.free[self.next..][..items];
        enters.clear();
        if self.most == self.depth {
            // When one has been held up, so are all behind it: places come free no faster than they are taken. What an item waits for is when
            // one before it leaves, so of the sums only their ends are left.
            enters.extend_from_slice(rooms);
            let ends = items.min(self.depth);
            let sum = |begin: usize| self.free[begin..][..ends].iter().sum::<u64>();
            self.clocks += sum(end + items - ends) - sum(self.next);
            self.next += items;
        } else {
            enters.extend(rooms.iter().zip(*first..).map(|(&room, free)| room.max(free)));
            self.enter(end, enters);
        }
        *first = enters.last().map_or(*first, |last| last + 1);
    }

    /// Writes down when the next items give back their places. The answer is where the first of them stands.
    fn leave(&mut self, leaves: &[u64]) -> usize {
        self.reserve(leaves.len());
        let end = self.next + self.depth;
        self.free[end..][..leaves.len()].iter_mut().zip(leaves).for_each(|(free, leave)| *free = leave + 1);
        end
    }

    /// Counts items that have been written down from `end` on.
    fn enter(&mut self, end: usize, enters: &[u64]) {
        let mut items = 0;
        // Mostly no more are held than ever before, which takes no branch to see: clocks are below 2^63.
        while self.most < self.depth && self.holds_more(end + items, &enters[items..]) {
            while self.free[end + items - self.most] <= enters[items] {
                items += 1;
            }
            self.most += 1;
            items += 1;
        }
        let held = self.free[end..][..enters.len()].iter().zip(enters).map(|(free, enter)| free.wrapping_sub(*enter));
        self.clocks = self.clocks.wrapping_add(held.fold(0, u64::wrapping_add));
        self.next += enters.len();
    }

    /// Whether one of the items that enter in these clocks, written down from `end` on, finds as many held as ever.
    fn holds_more(&self, end: usize, enters: &[u64]) -> bool {
        let frees = &self.free[end - self.most..][..enters.len()];
        let more = frees.iter().zip(enters).fold(0, |more, (free, enter)| more | enter.wrapping_sub(*free));
        more.cast_signed() < 0
    }

    fn reserve(&mut self, items: usize) {
        if self.next + self.depth + items > self.free.len() {
            self.begin_again();
            self.free.resize(self.free.len().max(self.depth + items), 0);
        }
    }

    #[inline(never)]
    fn begin_again(&mut self) {
        self.free.copy_within(self.next..self.next + self.depth, 0);
        self.next = 0;
    }

    /// Clocks of places held, and the most held.
    pub(super) const fn usage(&self) -> (u64, u64) {
        (self.clocks, if self.clocks == 0 { 0 } else { self.most as u64 })
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
    busy: u64,
    idle: u64,
}

impl Ledger {
    /// A ledger whose first clock without an entry is this.
    pub(super) const fn at(next: u64) -> Self {
        Self { next, busy: 0, idle: 0 }
    }

    /// The first clock without an entry.
    #[inline(always)]
    pub(super) fn next(&self) -> u64 {
        self.next
    }

    /// The clocks before `next` have been entered elsewhere.
    #[inline(always)]
    pub(super) fn entered_until(&mut self, next: u64) {
        self.next = next;
    }

    /// Busy and idle clocks of a run of so many.
    pub(super) fn closed(mut self, cycles: u64) -> (u64, u64) {
        self.idle_until(cycles);
        (self.busy, self.idle)
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
