//! What units and FIFOs keep count of.

use std::collections::BTreeMap;

/// A unit's clock: whether it was busy, or else why it stalled, if it did.
pub type Clock = (bool, Option<&'static str>);

/// Places, of which those given back in a clock can be taken in the next.
pub struct Places {
    pub name: &'static str,
    depth: usize,
    used: usize,
    given_back: usize,
    pub sum: usize,
    pub most: usize,
}

impl Places {
    pub fn new(name: &'static str, depth: u32) -> Self {
        Self { name, depth: depth as usize, used: 0, given_back: 0, sum: 0, most: 0 }
    }
    pub fn full(&self) -> bool {
        self.used >= self.depth
    }
    pub fn take(&mut self) {
        assert!(!self.full());
        self.used += 1;
    }
    pub fn give_back(&mut self) {
        self.given_back += 1;
    }
    pub fn end_clock(&mut self) {
        self.sum += self.used;
        self.most = self.most.max(self.used);
        self.used -= self.given_back;
        self.given_back = 0;
    }
}

/// Clocks of a unit: busy, idle, and stalled by cause.
pub struct Account {
    pub unit: &'static str,
    pub busy: u64,
    pub idle: u64,
    pub stalls: Vec<(&'static str, u64)>,
}

impl Account {
    pub fn new(unit: &'static str) -> Self {
        Self { unit, busy: 0, idle: 0, stalls: Vec::new() }
    }
    pub fn clock(&mut self, clock: Clock) {
        match clock {
            (true, _) => self.busy += 1,
            (false, None) => self.idle += 1,
            (false, Some(cause)) => match self.stalls.iter_mut().find(|(known, _)| *known == cause) {
                Some((_, clocks)) => *clocks += 1,
                None => self.stalls.push((cause, 1)),
            },
        }
    }
}

pub fn bump(counters: &mut BTreeMap<String, u64>, name: &str, by: u64) {
    *counters.entry(name.to_owned()).or_default() += by;
}
