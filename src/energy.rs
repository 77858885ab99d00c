//! Energy: an estimate, from what happened and what one of it takes.

use serde::{Deserialize, Serialize};
use texunit_hw::timing::TimingCounters;

use crate::error::{Error, Result};

/// Picojoules an event. The defaults are for 45 nm, from the table of Horowitz (ISSCC 2014) as numerics-input.md, section 1.6
/// quotes it: per 64-bit access 10 pJ in 8 KB of SRAM, 20 pJ in 32 KB, 100 pJ in 1 MB, 1.3 to 2.6 nJ in DRAM; 0.03 pJ an 8-bit
/// addition, 0.2 pJ an 8-bit multiplication.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct EnergyTable {
    /// Where the numbers come from: repeated in reports.
    pub source: String,
    /// A line access in the tags. Not in the source: assumed a fifth of an 8 KB access.
    pub tag_access: f64,
    /// A byte read from the data banks: 16 KB, between 10 and 20 pJ for 8 bytes.
    pub data_read_byte: f64,
    /// A byte written into them: as a read.
    pub data_write_byte: f64,
    /// A byte from the second level: 100 pJ for 8 bytes.
    pub second_level_byte: f64,
    /// A byte from memory, rows and interface included: the middle of 1.3 and 2.6 nJ for 8 bytes.
    pub memory_byte: f64,
    /// An activation of a DRAM row beyond that; 0 where the byte includes it.
    pub row_activation: f64,
    /// An 8-bit multiplication.
    pub multiply: f64,
    /// An 8-bit addition.
    pub add: f64,
}

impl Default for EnergyTable {
    fn default() -> Self {
        Self {
            source: "Horowitz, ISSCC 2014, 45 nm (unverified; tag-access and interpolations are assumptions)".into(),
            tag_access: 2.0,
            data_read_byte: 1.75,
            data_write_byte: 1.75,
            second_level_byte: 12.5,
            memory_byte: 244.0,
            row_activation: 0.0,
            multiply: 0.2,
            add: 0.03,
        }
    }
}

/// Picojoules by unit: an estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// Line accesses.
    pub tags: f64,
    /// Words read.
    pub data: f64,
    /// Lines written into the first level.
    pub fills: f64,
    /// Bytes the second level gave.
    pub second_level: f64,
    /// Bytes and rows of the memory.
    pub memory: f64,
    /// Four channels of lerps: three a bilinear tap of two multiplications and one addition, and one of each to add the tap up.
    pub datapath: f64,
}

impl Energy {
    /// All units.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.tags + self.data + self.fills + self.second_level + self.memory + self.datapath
    }
}

impl EnergyTable {
    /// Refuses what is no energy.
    ///
    /// # Errors
    /// The key.
    pub fn check(&self) -> Result<()> {
        let entries = [
            ("tag-access", self.tag_access),
            ("data-read-byte", self.data_read_byte),
            ("data-write-byte", self.data_write_byte),
            ("second-level-byte", self.second_level_byte),
            ("memory-byte", self.memory_byte),
            ("row-activation", self.row_activation),
            ("multiply", self.multiply),
            ("add", self.add),
        ];
        match entries.iter().find(|(_, value)| !(0.0..1e9).contains(value)) {
            None => Ok(()),
            Some((key, value)) => {
                Err(Error::setting(format!("energy.{key}"), value, "no energy", "use picojoules from 0 on"))
            }
        }
    }

    /// The energy of a run. `word` bytes a word of the data banks, `texels` a tap (1 or 4), of which so many `channels` are filtered. That
    /// of a decompressor is not in it.
    #[must_use]
    pub fn of(&self, counters: &TimingCounters, word: u32, texels: u32, channels: u8) -> Energy {
        let many = |count: u64| count as f64;
        let from_second_level = if counters.second_level_lookups > 0 { counters.bytes_fetched } else { 0 };
        let lerps = if texels == 1 { 0.0 } else { 3.0 };
        let channel = lerps * (2.0 * self.multiply + self.add) + self.multiply + self.add;
        Energy {
            tags: many(counters.fetches_ok + counters.fetches_failed) * self.tag_access,
            data: many(counters.data_words * u64::from(word)) * self.data_read_byte,
            fills: many(counters.bytes_filled) * self.data_write_byte,
            second_level: many(from_second_level) * self.second_level_byte,
            memory: many(counters.memory_bytes) * self.memory_byte
                + many(counters.row_misses + counters.row_conflicts) * self.row_activation,
            datapath: many(counters.taps) * f64::from(channels) * channel,
        }
    }
}
