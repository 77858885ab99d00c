//! Which banks the taps of a batch read, seen before any of them is looked up: eight at a time where the host can.

use alloc::vec::Vec;
use core::ops::Range;

use super::{
    banks::{BankHash, BankOf},
    parameters::Parameters,
};
use crate::{
    address_stream::AddressBatch,
    lanes::{BankLanes, LANES},
};

/// Looks at taps.
#[derive(Clone, Debug, Default)]
pub(super) struct BankLookout {
    lanes: Option<BankLanes>,
    tag_bank: BankOf,
    line_shift: u32,
    /// Of each tap of the batch, 1 if its first and its last texel are in two lines of one tag bank.
    clashes: Vec<u8>,
}

/// What was seen of a batch.
pub(super) struct Seen {
    /// Whether a texel is outside the texture.
    pub(super) outside: bool,
    /// Whether the words of each tap are known to be in as many data banks as they are.
    pub(super) all_apart: bool,
}

impl BankLookout {
    /// For a machine with lines of `line` bytes.
    pub(super) fn new(p: &Parameters, line: u32) -> Self {
        let line_shift = line.trailing_zeros();
        let lanes = BankLanes::new([p.data_bank_bytes.trailing_zeros(), p.data_banks], [line_shift, p.tag_banks]);
        Self {
            lanes: lanes.filter(|_| [p.data_hash, p.tag_hash] == [BankHash::Low; 2]),
            tag_bank: BankOf::new(p.tag_banks, p.tag_hash),
            line_shift,
            clashes: Vec::new(),
        }
    }

    /// Looks at the taps of a batch.
    pub(super) fn look(&mut self, batch: AddressBatch<'_>) -> Seen {
        let Self { tag_bank, line_shift, clashes, .. } = self;
        let (taps, texels) = (batch.taps(), batch.texels_per_tap);
        let clash = |tap: usize| {
            let addresses = batch.taps.addresses(tap);
            let [first, last] = [0, texels - 1].map(|texel| addresses[texel] >> *line_shift);
            u8::from(first != last && tag_bank.bank(first) == tag_bank.bank(last))
        };
        clashes.clear();
        clashes.reserve(taps);
        let (mut outside, mut all_apart) = (false, true);
        let mut one_by_one = |taps: Range<usize>, clashes: &mut Vec<u8>| {
            outside |= batch.any_outside(taps.clone());
            clashes.extend(taps.map(clash));
        };
        let mut seen = 0;
        if let Some(lanes) = self.lanes.filter(|_| texels == 4) {
            seen = taps - taps % LANES;
            for eight in 0..taps / LANES {
                if let Some((apart, of_eight)) = lanes.look(batch.taps, eight) {
                    // Addresses of 32 bits are inside.
                    all_apart &= apart;
                    clashes.extend_from_slice(&of_eight);
                } else {
                    all_apart = false;
                    one_by_one(eight * LANES..(eight + 1) * LANES, clashes);
                }
            }
        }
        one_by_one(seen..taps, clashes);
        Seen { outside, all_apart: texels == 1 || all_apart && seen == taps }
    }

    /// By tap of the last batch, 1 if its first and its last texel are in two lines of one tag bank.
    pub(super) fn clashes(&self) -> &[u8] {
        &self.clashes
    }
}
