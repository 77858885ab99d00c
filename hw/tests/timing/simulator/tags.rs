//! The tags, and the port by which their misses leave for the memory.

use std::collections::VecDeque;

use texunit_hw::timing::Mode;

use super::{
    Miss, Simulator,
    account::{Clock, bump},
    bank,
    decompressor::{Fill, requests_of},
};

pub struct Access {
    line: u64,
    /// The miss that brings the line: of this access, or of an earlier one.
    miss: usize,
    is_miss: bool,
}

pub struct TagTap {
    pub tap: usize,
    accesses: VecDeque<Access>,
}

impl Simulator<'_> {
    pub fn miss_port(&mut self) -> Clock {
        let (mut busy, mut cause) = (false, None);
        if let Some(&(miss, id, wanted, is_last)) = self.untaken.front()
            && self.t >= self.misses[miss].access + u64::from(self.p.tag_latency)
        {
            if self.memory.take(self.t, id, wanted) {
                self.misses[miss].taken = self.t;
                self.log.requested.push((self.t, wanted.address, wanted.bytes));
                self.untaken.pop_front();
                if is_last {
                    self.miss_queue.give_back();
                }
                busy = true;
            } else {
                cause = Some("memory");
            }
        }
        self.memory.tick(self.t);
        let (back, held) = self.held.iter().partition(|&&miss| self.lines.there(&self.memory, miss) == Some(self.t));
        self.held = held;
        let back: Vec<usize> = back;
        back.iter().for_each(|_| self.miss_status.give_back());
        (busy, cause)
    }

    pub fn tags(&mut self) -> Clock {
        let (mut busy, mut cause, mut finished) = (false, None, 0);
        let mut ports = [0; 16];
        loop {
            if self.in_tag.is_none() {
                if self.at_tag >= self.issued
                    || self.log.taps[self.at_tag].issue + u64::from(self.p.address_latency) > self.t
                {
                    break;
                }
                if finished == self.p.taps_per_clock {
                    break;
                }
                if self.fragment_fifo.full() {
                    cause = Some("fragment_fifo");
                    break;
                }
                self.fragment_fifo.take();
                self.tap_fifo.give_back();
                self.log.taps[self.at_tag].tag = self.t;
                // The cache answers in the order of the reads; when is decided below.
                let mut accesses = VecDeque::new();
                let mut seen = Vec::new();
                let mut number = self.misses.len();
                for &address in &self.taps[self.at_tag].addresses {
                    let line = address / u64::from(self.line);
                    let (miss, is_miss) = match self.cache.look_up(address, number) {
                        Ok(miss) => (miss, false),
                        Err(()) => (number, true),
                    };
                    if is_miss || !seen.contains(&line) {
                        accesses.push_back(Access { line, miss, is_miss });
                    }
                    number += usize::from(is_miss);
                    seen.push(line);
                    bump(&mut self.counters, "reads", 1);
                }
                if accesses.is_empty() {
                    busy = true;
                }
                self.in_tag = Some(TagTap { tap: self.at_tag, accesses });
                self.at_tag += 1;
            }
            let Some(tap) = self.in_tag.as_mut() else { break };
            let Some(access) = tap.accesses.front() else {
                self.log.taps[tap.tap].tag_done = self.t;
                finished += 1;
                self.in_tag = None;
                continue;
            };
            if let Some(miss) = self.blocked_by
                && self.lines.there(&self.memory, miss).is_none_or(|filled| self.t < filled + 1)
            {
                cause = Some("blocked");
                break;
            }
            let port = bank(self.p.tag_hash, self.p.tag_banks, access.line);
            if ports[port] == self.p.tag_ports {
                self.conflicted = true;
                break;
            }
            if access.is_miss {
                if self.p.mode == Mode::Prefetching {
                    if self.reorder_buffer.full() {
                        cause = Some("reorder_buffer");
                        break;
                    }
                    if self.miss_status.full() {
                        cause = Some("miss_status");
                        break;
                    }
                }
                if self.miss_queue.full() {
                    cause = Some("miss_queue");
                    break;
                }
                let number = self.misses.len();
                assert_eq!(number, access.miss);
                self.miss_queue.take();
                if self.p.mode == Mode::Prefetching {
                    self.reorder_buffer.take();
                    self.miss_status.take();
                    self.held.push(number);
                } else {
                    self.blocked_by = Some(number);
                }
                let address = access.line * u64::from(self.line);
                self.misses.push(Miss { address, access: self.t, taken: 0, merged: 0 });
                self.own_misses[tap.tap].push(number);
                let requests = requests_of(self.machine, access.line);
                let first = self.lines.fills.last().map_or(0, |fill| fill.ids.end);
                self.lines.fills.push(Fill { ids: first..first + requests.len(), there: None });
                for (place, &wanted) in requests.iter().enumerate() {
                    self.untaken.push_back((number, first + place, wanted, place + 1 == requests.len()));
                    bump(&mut self.counters, "bytes_fetched", wanted.bytes);
                }
                self.log.taps[tap.tap].misses += 1;
                bump(&mut self.counters, "fetches_failed", 1);
            } else {
                if self.lines.there(&self.memory, access.miss).is_none_or(|filled| self.t < filled) {
                    if self.misses[access.miss].merged == self.p.merges {
                        cause = Some("merge");
                        break;
                    }
                    self.misses[access.miss].merged += 1;
                    bump(&mut self.counters, "fetches_merged", 1);
                }
                bump(&mut self.counters, "fetches_ok", 1);
            }
            if self.conflicted {
                bump(&mut self.counters, "tag_bank_conflicts", 1);
                self.conflicted = false;
            }
            ports[port] += 1;
            busy = true;
            tap.accesses.pop_front();
        }
        (busy, cause)
    }
}
