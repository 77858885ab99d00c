//! What is asked and answered of the runs of eight taps, on any machine.

use super::LANES;
use crate::cache::Run;

/// How lines and texels follow from addresses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunShape {
    /// Bits of an address within a line, and within a texel.
    pub(crate) line_shift: u32,
    pub(crate) texel_shift: u32,
    /// Of a line's number, its set; `None` where a line just used is not the next victim in any case.
    pub(crate) set_mask: Option<u32>,
}

/// The runs of eight taps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EightRuns {
    /// The first run of each tap, and the second.
    pub(crate) runs: [[Run; 2]; LANES],
    /// Taps with a second run, a bit each.
    pub(crate) pairs: u32,
    /// Taps whose four texels make other runs than these, a bit each.
    pub(crate) others: u32,
}
