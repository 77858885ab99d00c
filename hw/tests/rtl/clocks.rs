//! When every texel passes every stage of unit.sv: the machine as a recurrence of maxima and sums (docs/hardware.md).
//!
//! Written from the description of the machine, not from its registers; the testbench counts the clocks of the RTL and both must agree.

/// What the recurrence depends on.
#[derive(Clone, Copy)]
pub struct Machine {
    /// Entries of the fragment FIFO.
    pub fragment_fifo: usize,
    /// Clocks from a line's request to its being there.
    pub latency: u64,
}

/// Clocks of the last texels. Clock 0 is the one in which the first request is taken.
pub struct Clocks {
    machine: Machine,
    /// Clock in which a texel leaves the tap unit, the plane register, the tags (into the FIFO), the data banks.
    tap: u64,
    plane: u64,
    tag: u64,
    bank: Vec<u64>,
    /// The request before has been taken.
    started: bool,
    taken: u64,
    first_of_request: bool,
}

impl Clocks {
    /// An idle machine.
    pub const fn new(machine: Machine) -> Self {
        Self { machine, tap: 0, plane: 0, tag: 0, bank: Vec::new(), started: false, taken: 0, first_of_request: false }
    }

    /// The next request, offered as early as can be: it enters in the clock in which the last texel before it leaves the tap unit.
    pub const fn request(&mut self) {
        self.taken = if self.started { self.tap } else { 0 };
        self.started = true;
        self.first_of_request = true;
    }

    /// Its next texel.
    pub fn texel(&mut self, miss: bool) {
        let next = |last: u64, started: bool| if started { last + 1 } else { 0 };
        let any = !self.bank.is_empty();
        let offered = if self.first_of_request { self.taken + 1 } else { self.tap + 1 };
        self.first_of_request = false;
        // A register is free in the clock in which its content leaves.
        let tap = offered.max(next(self.tap, any)).max(self.plane);
        let plane = (tap + 1).max(next(self.plane, any)).max(self.tag);
        let room = self.bank.len().checked_sub(self.machine.fragment_fifo).map_or(0, |index| self.bank[index] + 1);
        let tag = (plane + 1).max(next(self.tag, any)).max(room);
        let line = if miss { tag + self.machine.latency } else { 0 };
        let bank = (tag + 1).max(self.bank.last().map_or(0, |last| last + 1)).max(line);
        (self.tap, self.plane, self.tag) = (tap, plane, tag);
        self.bank.push(bank);
    }

    /// Clocks from the first request to the last response, both included: one for the bank's register, four for the datapath.
    pub fn total(&self) -> u64 {
        self.bank.last().map_or(0, |last| last + 5 + 1)
    }
}
