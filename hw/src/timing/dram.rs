//! DRAM as the texture unit sees it: channels that serve in order, banks with one open row (docs/timing.md, section 5).

use alloc::{vec, vec::Vec};

use super::{
    memory::Fetch,
    parameters::{TimingError, at_least_one},
    queue::Fifo,
};

/// What becomes of a row after it was read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Page {
    /// It stays open until another of its bank is wanted.
    #[default]
    Open,
    /// It is closed at once.
    Closed,
}

/// Which bits of an address in a channel choose the bank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Mapping {
    /// Banks change with each row of bytes: neighbours share a row.
    #[default]
    RowBankColumn,
    /// Banks change with each interleave: neighbours share nothing.
    RowColumnBank,
}

/// Times are clocks of the texture unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DramParameters {
    /// Channels.
    pub channels: u32,
    /// Bytes that lie together in one channel, a power of two.
    pub interleave: u32,
    /// Banks of a channel.
    pub banks: u32,
    /// Bytes of a row of a bank, a power of two.
    pub row_bytes: u32,
    /// Open or closed page.
    pub page: Page,
    /// Address mapping.
    pub mapping: Mapping,
    /// Bank exclusive-ored with the low bits of the row.
    pub bank_xor: bool,
    /// Places for requests in each channel.
    pub queue: u32,
    /// Clocks from the unit to the channel; 0 is allowed.
    pub controller_latency: u32,
    /// Activation to column command.
    pub trcd: u32,
    /// Precharge to activation.
    pub trp: u32,
    /// Column command to data.
    pub tcas: u32,
    /// Activation to precharge.
    pub tras: u32,
    /// Beats of a burst.
    pub burst_length: u32,
    /// Bytes of a beat.
    pub bus_bytes: u32,
    /// Beats a clock: 2 for double data rate at the clock of the unit.
    pub beats_per_clock: u32,
}

impl Default for DramParameters {
    /// One 64-bit channel of DDR at the clock of the unit.
    fn default() -> Self {
        Self {
            channels: 1,
            interleave: 256,
            banks: 8,
            row_bytes: 2048,
            page: Page::Open,
            mapping: Mapping::RowBankColumn,
            bank_xor: false,
            queue: 16,
            controller_latency: 20,
            trcd: 11,
            trp: 11,
            tcas: 11,
            tras: 28,
            burst_length: 8,
            bus_bytes: 8,
            beats_per_clock: 2,
        }
    }
}

impl DramParameters {
    pub(super) fn check(&self, block: u32) -> Result<(), TimingError> {
        let counts = [
            ("dram.channels", self.channels),
            ("dram.banks", self.banks),
            ("dram.queue", self.queue),
            ("dram.burst-length", self.burst_length),
            ("dram.bus-bytes", self.bus_bytes),
            ("dram.beats-per-clock", self.beats_per_clock),
        ];
        for (key, value) in counts {
            at_least_one(key, value)?;
        }
        let fit = |key, value: u32, limit: u32| {
            if value.is_power_of_two() && value >= limit {
                return Ok(());
            }
            Err(TimingError {
                key,
                value: value.into(),
                problem: "a line must lie in one row of one channel",
                remedy: "use a power of two of at least",
                limit: limit.into(),
            })
        };
        fit("dram.interleave", self.interleave, block)?;
        fit("dram.row-bytes", self.row_bytes, self.interleave)?;
        if self.bank_xor && !self.banks.is_power_of_two() {
            return Err(TimingError {
                key: "dram.banks",
                value: self.banks.into(),
                problem: "bank-xor needs a power of two of banks",
                remedy: "use",
                limit: self.banks.next_power_of_two().into(),
            });
        }
        Ok(())
    }

    /// Channel, bank and row of a byte.
    #[must_use]
    pub fn place(&self, address: u64) -> (usize, usize, u64) {
        let (interleave, banks) = (u64::from(self.interleave), u64::from(self.banks));
        let channels = u64::from(self.channels);
        let chunk = address / interleave;
        let channel = chunk % channels;
        let within = chunk / channels * interleave + address % interleave;
        let (bank, row) = match self.mapping {
            Mapping::RowBankColumn => {
                let row = within / u64::from(self.row_bytes);
                (row % banks, row / banks)
            }
            Mapping::RowColumnBank => {
                let piece = within / interleave;
                (piece % banks, piece / banks / u64::from(self.row_bytes / self.interleave))
            }
        };
        let bank = if self.bank_xor { bank ^ (row % banks) } else { bank };
        (channel as usize, bank as usize, row)
    }

    /// Clocks of the data bus for the bursts with a byte among so many from an address on.
    #[must_use]
    pub const fn transfer(&self, address: u64, bytes: u32) -> u64 {
        let burst = self.burst_length as u64 * self.bus_bytes as u64;
        let bursts = (address % burst + bytes as u64).div_ceil(burst);
        bursts * self.burst_length.div_ceil(self.beats_per_clock) as u64
    }
}

/// What a request found in its bank.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Row {
    /// Its row, open.
    Hit,
    /// No row.
    Miss,
    /// Another row.
    Conflict,
}

#[derive(Clone, Copy, Debug, Default)]
struct Bank {
    open: Option<u64>,
    activated: u64,
    /// End of the last transfer command; with a closed page, when the bank can be activated again.
    end: u64,
}

#[derive(Clone, Debug)]
struct Channel {
    queue: Fifo,
    banks: Vec<Bank>,
    /// First clock at which the next request can begin, and at which its column command can be given.
    next_begin: u64,
    next_column: u64,
}

/// The channels.
#[derive(Clone, Debug)]
pub(super) struct Dram {
    parameters: DramParameters,
    channels: Vec<Channel>,
    next_take: u64,
}

impl Dram {
    pub(super) fn new(parameters: DramParameters) -> Self {
        let channel = Channel {
            queue: Fifo::new(parameters.queue),
            banks: vec![Bank::default(); parameters.banks as usize],
            next_begin: 0,
            next_column: 0,
        };
        Self { parameters, channels: vec![channel; parameters.channels as usize], next_take: 0 }
    }

    pub(super) const fn transfer(&self, address: u64, bytes: u32) -> u64 {
        self.parameters.transfer(address, bytes)
    }

    pub(super) fn interleave(&self) -> u64 {
        self.parameters.interleave.into()
    }

    pub(super) fn fetch(&mut self, address: u64, transfer: u64, earliest: u64) -> Fetch {
        let p = &self.parameters;
        let [rcd, rp, cas, ras] = [p.trcd, p.trp, p.tcas, p.tras].map(u64::from);
        let (channel, bank, row) = p.place(address);
        let channel = &mut self.channels[channel];
        let bank = &mut channel.banks[bank];
        let taken = earliest.max(self.next_take).max(channel.queue.room());
        let begin = (taken + u64::from(p.controller_latency)).max(channel.next_begin);
        let found = match (p.page, bank.open) {
            (Page::Open, Some(open)) if open == row => Row::Hit,
            (Page::Open, Some(_)) => Row::Conflict,
            _ => Row::Miss,
        };
        match found {
            Row::Hit => {}
            Row::Miss => bank.activated = begin.max(bank.end),
            Row::Conflict => bank.activated = begin.max(bank.activated + ras).max(bank.end) + rp,
        }
        let column = begin.max(bank.activated + rcd).max(channel.next_column);
        bank.end = column + transfer;
        match p.page {
            Page::Open => bank.open = Some(row),
            Page::Closed => bank.end = bank.end.max(bank.activated + ras) + rp,
        }
        channel.queue.pass(taken, column + 1);
        channel.next_begin = begin + 1;
        channel.next_column = column + transfer;
        self.next_take = taken + 1;
        Fetch { taken, filled: column + cas + transfer, row: Some(found), second_level_hit: None }
    }

    /// Clocks of places held in all channels, and the most held in one.
    pub(super) fn queue_use(&self) -> (u64, u64) {
        let usages = self.channels.iter().map(|channel| channel.queue.usage());
        usages.fold((0, 0), |(all, most), (clocks, held)| (all + clocks, most.max(held)))
    }
}
