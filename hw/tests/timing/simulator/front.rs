//! From the entry to the issue of taps.

use super::{Simulator, account::Clock};

impl Simulator<'_> {
    pub fn entry(&mut self) -> Clock {
        let (mut busy, mut cause) = (false, None);
        for _ in 0..self.p.pixel_pipes {
            if self.entered == self.requests {
                break;
            }
            if self.request_fifo.full() {
                cause = Some("request_fifo");
                break;
            }
            self.request_fifo.take();
            self.log.requests[self.entered][0] = self.t;
            self.entered += 1;
            busy = true;
        }
        (busy, cause)
    }

    pub fn lod(&mut self) -> Clock {
        let (mut busy, mut cause) = (false, None);
        for _ in 0..self.p.pixel_pipes {
            if self.at_lod >= self.entered || self.log.requests[self.at_lod][0] + 1 > self.t {
                break;
            }
            if self.lod_fifo.full() {
                cause = Some("lod_fifo");
                break;
            }
            self.lod_fifo.take();
            self.request_fifo.give_back();
            self.log.requests[self.at_lod][1] = self.t;
            self.at_lod += 1;
            busy = true;
        }
        (busy, cause)
    }

    pub fn sequencer(&mut self) -> Clock {
        let (mut busy, mut cause) = (false, None);
        for _ in 0..self.p.taps_per_clock {
            if self.issued == self.taps.len() {
                break;
            }
            let request = self.request_of[self.issued];
            if request >= self.at_lod || self.log.requests[request][1] + u64::from(self.p.lod_latency) > self.t {
                break;
            }
            if self.tap_fifo.full() {
                cause = Some("tap_fifo");
                break;
            }
            self.tap_fifo.take();
            self.log.taps[self.issued].issue = self.t;
            if self.is_last(self.issued) {
                self.lod_fifo.give_back();
            }
            self.issued += 1;
            busy = true;
        }
        (busy, cause)
    }
}
