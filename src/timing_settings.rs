//! The sections `[timing]` and `[memory]` of a machine (docs/timing.md, section 2 and 5).

use serde::{Deserialize, Serialize};
use texunit_hw::timing::{
    BankHash, DramParameters, MainMemory, Mapping, MemoryParameters, Mode, Page, Parameters, SecondLevelParameters,
    TimingError,
};

use crate::{
    error::{Error, Result},
    names::by_name,
};

/// Declares a section: the struct, the default taken from the chip's, and the way there and back.
macro_rules! section {
    ($(#[$meta:meta])* $section:ident of $chip:ident {
        named { $($(#[doc = $named_doc:literal])* $named:ident: $type:ty,)* }
        flags { $($(#[doc = $flag_doc:literal])* $flag:ident,)* }
        numbers { $($(#[doc = $doc:literal])* $number:ident,)* }
    }) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
        pub struct $section {
            $($(#[doc = $named_doc])* #[serde(with = "by_name")] pub $named: $type,)*
            $($(#[doc = $flag_doc])* pub $flag: bool,)*
            $($(#[doc = $doc])* pub $number: u32,)*
        }

        impl From<$chip> for $section {
            fn from(chip: $chip) -> Self {
                Self { $($named: chip.$named,)* $($flag: chip.$flag,)* $($number: chip.$number,)* }
            }
        }

        impl From<&$section> for $chip {
            fn from(section: &$section) -> Self {
                Self { $($named: section.$named,)* $($flag: section.$flag,)* $($number: section.$number,)* }
            }
        }

        impl Default for $section {
            fn default() -> Self {
                $chip::default().into()
            }
        }
    };
}

section! {
    /// The pipeline. Counts and clocks, at least 1 unless said otherwise.
    TimingSettings of Parameters {
        named {
            /// prefetching (tags ahead of data) or blocking.
            mode: Mode,
            /// low (number modulo banks) or xor, of line numbers.
            tag_hash: BankHash,
            /// low or xor, of word numbers.
            data_hash: BankHash,
        }
        flags {}
        numbers {
            /// Requests a clock that enter and leave.
            pixel_pipes,
            /// Taps a clock.
            taps_per_clock,
            /// Places for requests before the LOD unit.
            request_fifo,
            /// Places for requests before the sequencer.
            lod_fifo,
            /// Places for taps before the tag unit.
            tap_fifo,
            /// Places for taps between tags and data.
            fragment_fifo,
            /// Places for finished requests.
            result_fifo,
            /// Banks of the tag memory.
            tag_banks,
            /// Line accesses a clock of each.
            tag_ports,
            /// Lines on their way at a time.
            miss_status,
            /// Lookups merged with a line on its way; may be 0.
            merges,
            /// Places for misses the memory has not taken.
            miss_queue,
            /// Lines asked for and not yet read.
            reorder_buffer,
            /// Banks of the data memory.
            data_banks,
            /// Bytes of a bank's word, a power of two.
            data_bank_bytes,
            /// Words a clock of each.
            data_ports,
            /// Bytes a clock written into the banks, which read nothing meanwhile; 0: a port of its own.
            fill_write_bytes,
            /// Clocks of the LOD unit.
            lod_latency,
            /// Clocks of sequencer and address unit.
            address_latency,
            /// Clocks of a tag lookup.
            tag_latency,
            /// Clocks of a data read.
            data_latency,
            /// Clocks of the datapath.
            filter_latency,
            /// Clocks of the decompressor, where texture.decompress is before-cache.
            decompress_latency,
            /// Texels a clock of it.
            decompress_texels_per_clock,
        }
    }
}

impl TimingSettings {
    /// As the chip takes them.
    #[must_use]
    pub fn parameters(&self) -> Parameters {
        self.into()
    }
}

/// What is at the end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MemoryKind {
    /// One latency, one link.
    #[default]
    Fixed,
    /// Channels, banks, rows.
    Dram,
}

/// The memory.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct MemorySettings {
    /// fixed or dram.
    #[serde(with = "by_name")]
    pub kind: MemoryKind,
    /// Of the fixed memory, in clocks.
    pub latency: u32,
    /// Of the fixed memory.
    pub bytes_per_clock: u32,
    /// Between texel cache and memory.
    pub second_level: SecondLevelSettings,
    /// Read where `kind` is dram.
    pub dram: DramSettings,
}

impl Default for MemorySettings {
    fn default() -> Self {
        Self {
            kind: MemoryKind::Fixed,
            latency: 100,
            bytes_per_clock: 16,
            second_level: SecondLevelSettings::default(),
            dram: DramSettings::default(),
        }
    }
}

/// A second-level cache, LRU.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct SecondLevelSettings {
    /// Whether there is one.
    pub enabled: bool,
    /// Sets, any number.
    pub sets: u32,
    /// Ways, any number.
    pub ways: u32,
    /// Bytes of a line, at least those of the texel cache.
    pub line: u32,
    /// Clocks of a lookup.
    pub latency: u32,
    /// Link to the texel cache.
    pub bytes_per_clock: u32,
    /// Places for misses the memory has not taken.
    pub miss_queue: u32,
}

impl Default for SecondLevelSettings {
    fn default() -> Self {
        Self { enabled: false, sets: 512, ways: 8, line: 64, latency: 20, bytes_per_clock: 32, miss_queue: 16 }
    }
}

section! {
    /// DRAM. Times in clocks of the texture unit.
    DramSettings of DramParameters {
        named {
            /// open or closed.
            page: Page,
            /// row-bank-column or row-column-bank.
            mapping: Mapping,
        }
        flags {
            /// Bank exclusive-ored with the low bits of the row.
            bank_xor,
        }
        numbers {
            /// Channels.
            channels,
            /// Bytes that lie together in a channel.
            interleave,
            /// Banks of a channel.
            banks,
            /// Bytes of a row.
            row_bytes,
            /// Places for requests in each channel.
            queue,
            /// Clocks to the channel.
            controller_latency,
            /// Activation to column command.
            trcd,
            /// Precharge to activation.
            trp,
            /// Column command to data.
            tcas,
            /// Activation to precharge.
            tras,
            /// Beats of a burst.
            burst_length,
            /// Bytes of a beat.
            bus_bytes,
            /// Beats a clock.
            beats_per_clock,
        }
    }
}

impl MemorySettings {
    /// As the chip takes them.
    #[must_use]
    pub fn parameters(&self) -> MemoryParameters {
        let second = &self.second_level;
        MemoryParameters {
            main: match self.kind {
                MemoryKind::Fixed => MainMemory::Fixed { latency: self.latency, bytes_per_clock: self.bytes_per_clock },
                MemoryKind::Dram => MainMemory::Dram((&self.dram).into()),
            },
            second_level: second.enabled.then_some(SecondLevelParameters {
                sets: second.sets,
                ways: second.ways,
                line: second.line,
                latency: second.latency,
                bytes_per_clock: second.bytes_per_clock,
                miss_queue: second.miss_queue,
            }),
        }
    }
}

/// Refuses a machine that cannot run, or would hang, on taps of four reads of `bytes_per_read` bytes.
///
/// # Errors
/// The key at fault, its value, and what would do.
pub fn check(timing: &TimingSettings, memory: &MemorySettings, line: u32, bytes_per_read: u32) -> Result<()> {
    let refuse = |section: &str, error: TimingError| {
        Error::setting(
            format!("{section}.{}", error.key),
            error.value,
            error.problem,
            format!("{} {}", error.remedy, error.limit),
        )
    };
    timing.parameters().check(4, bytes_per_read).map_err(|error| refuse("timing", error))?;
    memory.parameters().check(line).map_err(|error| refuse("memory", error))
}
