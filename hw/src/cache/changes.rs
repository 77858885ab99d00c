//! The lines of addresses without those that come twice running.
//!
//! Such a line is there the second time, and touching it again changes nothing in any policy. What is left is looked up in a loop of its own, in
//! which a host need not guess which lines come again.

use crate::lanes::{ChangeLanes, Kept};

/// Leaves them out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Changes {
    line_shift: u32,
    /// The address before.
    last: u64,
    lanes: Option<ChangeLanes>,
}

impl Changes {
    /// For addresses from `first` on, in lines of two to the power of `line_shift` bytes.
    pub(super) fn new(first: u64, line_shift: u32, lanes: Option<ChangeLanes>) -> Self {
        // In another line than the first, whatever the lines.
        Self { line_shift, last: !first, lanes }
    }

    /// Writes the lines of a block of addresses that are not the line of the address before; the answer is how many.
    #[inline(always)]
    pub(super) fn keep(&mut self, addresses: &[u64], kept: &mut Kept) -> usize {
        let (eights, rest) = addresses.as_chunks();
        let (mut count, mut one_by_one) = (0, addresses);
        if let (Some(lanes), Some(last)) = (self.lanes, eights.last()) {
            count = lanes.keep(eights, self.last, self.line_shift, kept);
            (self.last, one_by_one) = (last[last.len() - 1], rest);
        }
        for &address in one_by_one {
            if (address ^ self.last) >> self.line_shift != 0 {
                kept[count] = address >> self.line_shift;
                count += 1;
            }
            self.last = address;
        }
        count
    }

    /// The address of a line.
    #[inline(always)]
    pub(super) const fn address(&self, line: u64) -> u64 {
        line << self.line_shift
    }
}
