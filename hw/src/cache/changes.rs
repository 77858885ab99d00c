//! Addresses without those that change nothing, whoever looks them up.
//!
//! A line that comes twice running is there the second time, and touching it again changes nothing in any policy. Where two lines take turns, as
//! those of a footprint do that straddles two columns of tiles, the second turn finds both and leaves them as the first did, if a line just used
//! is not the next victim. What is left is looked up in a loop of its own, in which a host need not guess which lines come again.

use crate::lanes::ChangeLanes;

/// Addresses at a time.
pub(super) const BLOCK: usize = 256;

/// Leaves out what changes nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Changes {
    line_shift: u32,
    turns: bool,
    /// The address before.
    last: u64,
    lanes: Option<ChangeLanes>,
}

impl Changes {
    /// For addresses from `first` on, in lines of two to the power of `line_shift` bytes; `turns` says that second turns change nothing either.
    pub(super) fn new(first: u64, line_shift: u32, turns: bool) -> Self {
        // In another line than the first, whatever the lines.
        Self { line_shift, turns, last: !first, lanes: ChangeLanes::detect() }
    }

    /// Writes those of at most [`BLOCK`] addresses that may change something; the answer is how many.
    #[inline(always)]
    pub(super) fn keep(&mut self, addresses: &[u64], kept: &mut [u64; BLOCK]) -> usize {
        let Some(&last) = addresses.last() else { return 0 };
        let (fours, rest) = addresses.as_chunks();
        let (mut count, mut alone) = (0, addresses);
        if let Some(lanes) = self.lanes {
            count = lanes.keep(fours, self.last, self.line_shift, self.turns, kept);
            self.last = fours.last().map_or(self.last, |four| four[3]);
            alone = rest;
        }
        for &address in alone {
            if (address ^ self.last) >> self.line_shift != 0 {
                kept[count] = address;
                count += 1;
            }
            self.last = address;
        }
        self.last = last;
        count
    }
}
