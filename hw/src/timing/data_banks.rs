//! The data banks: how long a tap reads.

use super::{banks::Banks, parameters::Parameters, tap_reads::READS_MAX};

/// Banks of words. Taps read one after the other, so what earlier taps still do to a tap is what they read in its first clock.
#[derive(Clone, Debug, Default)]
pub(super) struct DataBanks {
    banks: Banks,
    word_shift: u32,
    /// One port each and few enough for a mask.
    masked: bool,
    /// The last clock read in, and the banks read in it.
    last: u64,
    used: u64,
}

impl DataBanks {
    pub(super) fn new(p: &Parameters) -> Self {
        Self {
            banks: Banks::new(p.data_banks, p.data_ports, p.data_hash),
            word_shift: p.data_bank_bytes.trailing_zeros(),
            masked: p.data_banks <= 64 && p.data_ports == 1,
            last: 0,
            used: 0,
        }
    }

    /// The clock of the last word of a tap whose reads begin at `begin`, and the number of its words.
    #[inline(always)]
    pub(super) fn read(&mut self, addresses: &[u64], begin: u64) -> (u64, u64) {
        if self.masked {
            let before = if self.last == begin { self.used } else { 0 };
            let (mut used, mut clash) = (before, 0);
            for &address in addresses {
                let bank = 1 << self.banks.bank(address >> self.word_shift);
                clash |= used & bank;
                used |= bank;
            }
            if clash == 0 {
                (self.last, self.used) = (begin, used);
                return (begin, addresses.len() as u64);
            }
        }
        self.read_clashing(addresses, begin)
    }

    /// Two addresses in one bank: in one word, or one after the other.
    #[inline(never)]
    fn read_clashing(&mut self, addresses: &[u64], begin: u64) -> (u64, u64) {
        let (mut words, mut count) = ([0; READS_MAX], 0);
        for word in addresses.iter().map(|address| address >> self.word_shift) {
            if !words[..count].contains(&word) {
                words[count] = word;
                count += 1;
            }
        }
        if !self.masked {
            let done = words[..count]
                .iter()
                .fold(begin, |done, &word| done.max(self.banks.take(self.banks.bank(word), begin)));
            return (done, count as u64);
        }
        let (mut clock, mut left) = (begin, count);
        let mut used = if self.last == begin { self.used } else { 0 };
        loop {
            let mut waiting = 0;
            for number in 0..left {
                let bank = 1 << self.banks.bank(words[number]);
                if used & bank != 0 {
                    words[waiting] = words[number];
                    waiting += 1;
                }
                used |= bank;
            }
            left = waiting;
            if left == 0 {
                break;
            }
            (clock, used) = (clock + 1, 0);
        }
        (self.last, self.used) = (clock, used);
        (clock, count as u64)
    }
}
