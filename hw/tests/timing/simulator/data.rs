//! The data banks, the datapath and the results.

use texunit_hw::timing::Mode;

use super::{
    Simulator,
    account::{Clock, bump},
    bank,
};

pub struct DataTap {
    tap: usize,
    reads_begin: u64,
    words: Vec<u64>,
}

impl Simulator<'_> {
    pub fn data(&mut self) -> Clock {
        let (mut busy, mut cause, mut finished) = (self.in_data.is_some(), None, 0);
        let mut ports = [0; 16];
        loop {
            if self.in_data.is_none() {
                let ready = self.at_data < self.at_tag
                    && self.in_tag.as_ref().is_none_or(|tap| tap.tap != self.at_data)
                    && self.t >= self.log.taps[self.at_data].tag_done + u64::from(self.p.tag_latency);
                if !ready || finished == self.p.taps_per_clock {
                    break;
                }
                if self.own_misses[self.at_data]
                    .iter()
                    .any(|&miss| self.lines.there(&self.memory, miss).is_none_or(|filled| self.t < filled))
                {
                    cause = Some("fill");
                    break;
                }
                if self.is_last(self.at_data) && self.result_fifo.full() {
                    cause = Some("result_fifo");
                    break;
                }
                let mut writes = 0;
                if self.p.fill_write_bytes > 0 {
                    writes = self.own_misses[self.at_data].len() as u64
                        * u64::from(self.line.div_ceil(self.p.fill_write_bytes));
                }
                if writes > 0 && finished > 0 {
                    break;
                }
                self.fragment_fifo.give_back();
                if self.p.mode == Mode::Prefetching {
                    self.own_misses[self.at_data].iter().for_each(|_| self.reorder_buffer.give_back());
                }
                if self.is_last(self.at_data) {
                    self.result_fifo.take();
                }
                self.log.taps[self.at_data].data = self.t;
                let mut words: Vec<u64> = self.taps[self.at_data]
                    .addresses
                    .iter()
                    .map(|address| address / u64::from(self.p.data_bank_bytes))
                    .collect();
                words.sort_unstable();
                words.dedup();
                bump(&mut self.counters, "data_words", words.len() as u64);
                bump(&mut self.counters, "fill_write_clocks", writes);
                self.in_data = Some(DataTap { tap: self.at_data, reads_begin: self.t + writes, words });
                self.at_data += 1;
                busy = true;
            }
            let Some(tap) = self.in_data.as_mut() else { break };
            if self.t < tap.reads_begin {
                break;
            }
            tap.words.retain(|&word| {
                let port = &mut ports[bank(self.p.data_hash, self.p.data_banks, word)];
                let read = *port < self.p.data_ports;
                *port += u32::from(read);
                !read
            });
            if !tap.words.is_empty() {
                bump(&mut self.counters, "data_conflict_clocks", 1);
                break;
            }
            self.log.taps[tap.tap].data_done = self.t;
            self.log.taps[tap.tap].datapath = self.t + u64::from(self.p.data_latency);
            finished += 1;
            self.in_data = None;
        }
        (busy, cause)
    }

    /// Taps whose words have all been read.
    fn done(&self) -> usize {
        self.at_data - usize::from(self.in_data.is_some())
    }

    pub fn datapath(&mut self) -> Clock {
        let taps = &self.log.taps[..self.done()];
        (taps.iter().rev().take_while(|tap| tap.datapath >= self.t).any(|tap| tap.datapath == self.t), None)
    }

    pub fn result(&mut self) -> Clock {
        let mut busy = false;
        for _ in 0..self.p.pixel_pipes {
            let last_tap = self.request_of.partition_point(|&request| request <= self.left) - 1;
            if self.left == self.requests
                || last_tap >= self.done()
                || self.log.taps[last_tap].datapath + u64::from(self.p.filter_latency) > self.t
            {
                break;
            }
            self.log.requests[self.left][2] = self.t;
            self.result_fifo.give_back();
            self.left += 1;
            busy = true;
        }
        (busy, None)
    }
}
