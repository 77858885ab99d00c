//! Banked memories: which bank a number is in, and how many accesses a bank has had in a clock.

use alloc::{vec, vec::Vec};

use super::parameters::TimingError;

/// Which bank a line or word number is in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BankHash {
    /// The number modulo the banks.
    #[default]
    Low,
    /// The exclusive or of all groups of as many bits as number the banks, which are a power of two.
    Xor,
}

impl BankHash {
    pub(super) fn check(self, key: &'static str, banks: u32) -> Result<(), TimingError> {
        if self == Self::Xor && !banks.is_power_of_two() {
            return Err(TimingError {
                key,
                value: banks.into(),
                problem: "the xor hash needs a power of two of banks",
                remedy: "use",
                limit: banks.next_power_of_two().into(),
            });
        }
        Ok(())
    }
}

/// Which of some banks a number is in.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BankOf {
    banks: u32,
    hash: BankHash,
    /// Banks less one where they are a power of two and nothing is hashed; else all ones.
    mask: u64,
}

impl BankOf {
    pub(super) fn new(banks: u32, hash: BankHash) -> Self {
        let simple = hash == BankHash::Low && banks.is_power_of_two();
        let mask = if simple { u64::from(banks - 1) } else { u64::MAX };
        Self { banks, hash, mask }
    }

    /// The bank a number is in.
    #[inline(always)]
    pub(super) fn bank(&self, number: u64) -> usize {
        if self.mask != u64::MAX {
            return (number & self.mask) as usize;
        }
        (match self.hash {
            BankHash::Low => number % u64::from(self.banks),
            BankHash::Xor => fold(number, self.banks.trailing_zeros()),
        }) as usize
    }
}

/// Banks that each take a few accesses a clock.
#[derive(Clone, Debug, Default)]
pub(super) struct Banks {
    stamps: Vec<Stamp>,
    bank_of: BankOf,
    ports: u32,
}

/// The clock of a bank's last access, and how many it had in that clock.
#[derive(Clone, Copy, Debug, Default)]
struct Stamp {
    clock: u64,
    used: u32,
}

impl Banks {
    pub(super) fn new(banks: u32, ports: u32, hash: BankHash) -> Self {
        Self { stamps: vec![Stamp::default(); banks as usize], bank_of: BankOf::new(banks, hash), ports }
    }

    /// The bank a number is in.
    #[inline(always)]
    pub(super) fn bank(&self, number: u64) -> usize {
        self.bank_of.bank(number)
    }

    /// The first clock from `earliest` on at which a bank has a port left, and takes it. Later calls for the bank must not ask
    /// for an earlier clock than the answer to this one.
    #[inline(always)]
    pub(super) fn take(&mut self, bank: usize, earliest: u64) -> u64 {
        let ports = self.ports;
        let stamp = &mut self.stamps[bank];
        if stamp.clock < earliest {
            *stamp = Stamp { clock: earliest, used: 1 };
        } else if stamp.used < ports {
            stamp.used += 1;
        } else {
            *stamp = Stamp { clock: stamp.clock + 1, used: 1 };
        }
        stamp.clock
    }

    /// The clock [`Self::take`] would answer, without taking it.
    #[inline(always)]
    pub(super) fn earliest(&self, bank: usize, earliest: u64) -> u64 {
        let stamp = self.stamps[bank];
        if stamp.clock < earliest { earliest } else { stamp.clock + u64::from(stamp.used >= self.ports) }
    }
}

fn fold(mut number: u64, bits: u32) -> u64 {
    if bits == 0 {
        return 0;
    }
    let mut folded = 0;
    while number != 0 {
        folded ^= number & ((1 << bits) - 1);
        number >>= bits;
    }
    folded
}
