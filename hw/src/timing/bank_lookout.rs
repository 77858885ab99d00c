//! Which banks the taps of a batch read, seen before any of them is looked up: eight at a time where the host can.

use alloc::vec::Vec;

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
        let (taps, texels) = (batch.taps(), batch.texels_per_tap);
        let lanes = self.lanes.filter(|_| texels == 4);
        self.clashes.resize(taps, 0);
        let (mut number, mut outside, mut all_apart) = (0, false, lanes.is_some());
        while number < taps {
            let mut next = number;
            if let Some(lanes) = lanes {
                let (eights, apart) = lanes.look(batch.taps, number / LANES, &mut self.clashes[number..]);
                next += eights * LANES;
                all_apart &= apart;
            }
            // What lanes leave, eight at most; what they look at is inside.
            number = taps.min(next + LANES);
            all_apart &= next == number;
            outside |= batch.any_outside(next..number);
            for tap in next..number {
                let addresses = batch.taps.addresses(tap);
                let [first, last] = [0, texels - 1].map(|texel| addresses[texel] >> self.line_shift);
                let clash = first != last && self.tag_bank.bank(first) == self.tag_bank.bank(last);
                self.clashes[tap] = clash.into();
            }
        }
        Seen { outside, all_apart: all_apart || texels == 1 }
    }

    /// By tap of the last batch, 1 if its first and its last texel are in two lines of one tag bank.
    pub(super) fn clashes(&self) -> &[u8] {
        &self.clashes
    }
}
