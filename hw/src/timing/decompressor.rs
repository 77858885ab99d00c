//! The decompressor between memory and cache (docs/timing.md, section 5): what it asks the memory for, and when lines leave it.

use alloc::sync::Arc;

use super::{memory::Memory, parameters::Parameters};
use crate::decompression::{Piece, StoredLines};

/// One line at a time, in the order of the misses.
#[derive(Clone, Debug)]
pub(super) struct Decompressor {
    behind: Arc<StoredLines>,
    /// Largest power of two of bytes that the memory can be asked for at once.
    together: u64,
    latency: u64,
    /// Clocks of one line.
    work: u64,
    free: u64,
    pub(super) bytes: u64,
    pub(super) busy: u64,
    pub(super) wait: u64,
}

/// Bytes of a texel of a decompressed line.
const TEXEL_BYTES: u32 = 4;

impl Decompressor {
    pub(super) fn new(p: &Parameters, behind: Arc<StoredLines>, line: u32, memory: &Memory) -> Self {
        Self {
            behind,
            together: memory.together(),
            latency: p.decompress_latency.into(),
            work: (line / TEXEL_BYTES).div_ceil(p.decompress_texels_per_clock).max(1).into(),
            free: 0,
            bytes: 0,
            busy: 0,
            wait: 0,
        }
    }

    /// What the memory is to be asked for, in order, to fill a line.
    pub(super) fn requests(&self, line: u64) -> impl Iterator<Item = Piece> {
        let together = self.together;
        self.behind.pieces(line).iter().flat_map(move |piece| {
            let (mut at, end) = (piece.address, piece.address + u64::from(piece.bytes));
            core::iter::from_fn(move || {
                let address = at;
                at = end.min((address / together + 1) * together);
                (address < end).then_some(Piece { address, bytes: (at - address) as u32 })
            })
        })
    }

    /// The first clock a line can be read in, whose last bytes have come in clock `came`.
    pub(super) fn decompress(&mut self, line: u64, came: u64) -> u64 {
        let begin = came.max(self.free);
        self.free = begin + self.work;
        self.bytes += self.behind.bytes(line);
        self.busy += self.work;
        self.wait += begin - came;
        self.free - 1 + self.latency
    }
}
