//! What an architect can turn, and which machines cannot run (docs/timing.md, sections 2 and 8).

use super::{banks::BankHash, dram::DramParameters};

/// Whether misses hold up what comes behind them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Mode {
    /// Tags run ahead of data (Igehy, Eldridge & Proudfoot 1998).
    #[default]
    Prefetching,
    /// A miss holds up every access behind it until its line is there.
    Blocking,
}

/// The pipeline of docs/timing.md. Depths, widths, ports and latencies are counts and clocks, at least 1 unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameters {
    /// Prefetching or blocking.
    pub mode: Mode,
    /// Requests a clock that enter, pass the LOD unit, and leave.
    pub pixel_pipes: u32,
    /// Taps a clock through sequencer, tag unit, data banks and datapath.
    pub taps_per_clock: u32,
    /// Places for requests before the LOD unit.
    pub request_fifo: u32,
    /// Places for requests before the sequencer.
    pub lod_fifo: u32,
    /// Places for taps before the tag unit.
    pub tap_fifo: u32,
    /// Places for taps between tags and data: what hides the latency of the memory.
    pub fragment_fifo: u32,
    /// Places for finished requests.
    pub result_fifo: u32,
    /// Banks of the tag memory.
    pub tag_banks: u32,
    /// Line accesses a clock of each tag bank.
    pub tag_ports: u32,
    /// Which tag bank a line number is in.
    pub tag_hash: BankHash,
    /// Miss-status entries: lines on their way at a time.
    pub miss_status: u32,
    /// Lookups that may be merged with one line on its way; 0 is allowed.
    pub merges: u32,
    /// Places for misses the memory has not taken yet.
    pub miss_queue: u32,
    /// Lines asked for and not yet read by the tap that missed.
    pub reorder_buffer: u32,
    /// Banks of the data memory.
    pub data_banks: u32,
    /// Bytes of a word of a data bank, a power of two.
    pub data_bank_bytes: u32,
    /// Words a clock of each data bank.
    pub data_ports: u32,
    /// Which data bank a word number is in.
    pub data_hash: BankHash,
    /// Bytes a clock from the reorder buffer into the banks, which read nothing meanwhile; 0 is a port of its own.
    pub fill_write_bytes: u32,
    /// Clocks of the LOD unit.
    pub lod_latency: u32,
    /// Clocks from the sequencer through the address unit.
    pub address_latency: u32,
    /// Clocks of a tag lookup.
    pub tag_latency: u32,
    /// Clocks of a read of the data banks.
    pub data_latency: u32,
    /// Clocks of the datapath.
    pub filter_latency: u32,
    /// Clocks of the decompressor between memory and cache, where there is one.
    pub decompress_latency: u32,
    /// Texels a clock that leave it.
    pub decompress_texels_per_clock: u32,
}

impl Default for Parameters {
    /// One trilinear request in two clocks, latencies of a few clocks, and 64 taps between tags and data. A decompressor makes as many
    /// texels a clock as a block of 4 x 4 has: as fast as the default memory brings blocks of 16 bytes (BC3, BC7), half as fast as those of 8 (BC1);
    /// its four clocks are those of a block's mode, end points, indices, and the interpolation. Both are assumptions.
    fn default() -> Self {
        Self {
            mode: Mode::Prefetching,
            pixel_pipes: 1,
            taps_per_clock: 1,
            request_fifo: 8,
            lod_fifo: 8,
            tap_fifo: 8,
            fragment_fifo: 64,
            result_fifo: 16,
            tag_banks: 4,
            tag_ports: 1,
            tag_hash: BankHash::Low,
            miss_status: 32,
            merges: 64,
            miss_queue: 8,
            reorder_buffer: 32,
            data_banks: 16,
            data_bank_bytes: 4,
            data_ports: 1,
            data_hash: BankHash::Low,
            fill_write_bytes: 0,
            lod_latency: 2,
            address_latency: 3,
            tag_latency: 1,
            data_latency: 1,
            filter_latency: 4,
            decompress_latency: 4,
            decompress_texels_per_clock: 16,
        }
    }
}

/// The memory behind the cache (docs/timing.md, section 5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryParameters {
    /// What is at the end.
    pub main: MainMemory,
    /// A cache in between, if any.
    pub second_level: Option<SecondLevelParameters>,
}

/// The memory at the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MainMemory {
    /// The same latency for every line, one link.
    Fixed {
        /// Clocks from request to the first byte; 0 is allowed.
        latency: u32,
        /// Width of the link.
        bytes_per_clock: u32,
    },
    /// Channels, banks and rows.
    Dram(DramParameters),
}

/// The second-level cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SecondLevelParameters {
    /// Sets, any number.
    pub sets: u32,
    /// Ways, any number.
    pub ways: u32,
    /// Bytes of a line, at least those of the first level's.
    pub line: u32,
    /// Clocks of a lookup and its answer.
    pub latency: u32,
    /// Width of the link to the first level.
    pub bytes_per_clock: u32,
    /// Places for misses the memory has not taken yet.
    pub miss_queue: u32,
}

impl Default for MemoryParameters {
    /// 100 clocks, 16 bytes a clock.
    fn default() -> Self {
        Self { main: MainMemory::Fixed { latency: 100, bytes_per_clock: 16 }, second_level: None }
    }
}

/// A machine that cannot run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimingError {
    /// The parameter at fault, as in docs/timing.md.
    pub key: &'static str,
    /// Its value.
    pub value: u64,
    /// What is wrong with it.
    pub problem: &'static str,
    /// What would be right.
    pub remedy: &'static str,
    /// The limit the remedy speaks of, where it depends on other parameters.
    pub limit: u64,
}

impl core::fmt::Display for TimingError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} = {}: {} ({} {})", self.key, self.value, self.problem, self.remedy, self.limit)
    }
}

impl core::error::Error for TimingError {}

/// Largest depth or number of banks: state is kept for each of them.
const LARGEST: u32 = 1 << 20;

impl Parameters {
    /// Whether a machine of these parameters can run, `line` bytes a cache line, `read` bytes a read and at most
    /// `reads_per_tap` reads a tap.
    ///
    /// ```
    /// use texunit_hw::timing::Parameters;
    /// let machine = Parameters::default();
    /// assert!(machine.check(4, 4).is_ok());
    /// let starved = Parameters { reorder_buffer: 2, ..machine };
    /// assert_eq!(starved.check(4, 4).unwrap_err().key, "reorder-buffer"); // X18: it would hang
    /// assert!(starved.check(1, 4).is_ok()); // point sampling misses one line a tap at most
    /// ```
    ///
    /// # Errors
    /// The first parameter at fault.
    pub fn check(&self, reads_per_tap: u32, bytes_per_read: u32) -> Result<(), TimingError> {
        let counts = [
            ("pixel-pipes", self.pixel_pipes),
            ("taps-per-clock", self.taps_per_clock),
            ("request-fifo", self.request_fifo),
            ("lod-fifo", self.lod_fifo),
            ("tap-fifo", self.tap_fifo),
            ("fragment-fifo", self.fragment_fifo),
            ("result-fifo", self.result_fifo),
            ("tag-banks", self.tag_banks),
            ("tag-ports", self.tag_ports),
            ("miss-status", self.miss_status),
            ("miss-queue", self.miss_queue),
            ("reorder-buffer", self.reorder_buffer),
            ("data-banks", self.data_banks),
            ("data-ports", self.data_ports),
            ("lod-latency", self.lod_latency),
            ("address-latency", self.address_latency),
            ("tag-latency", self.tag_latency),
            ("data-latency", self.data_latency),
            ("filter-latency", self.filter_latency),
            ("decompress-latency", self.decompress_latency),
            ("decompress-texels-per-clock", self.decompress_texels_per_clock),
        ];
        for (key, value) in counts {
            at_least_one(key, value)?;
        }
        self.tag_hash.check("tag-banks", self.tag_banks)?;
        self.data_hash.check("data-banks", self.data_banks)?;
        if !self.data_bank_bytes.is_power_of_two() || self.data_bank_bytes < bytes_per_read {
            return Err(TimingError {
                key: "data-bank-bytes",
                value: self.data_bank_bytes.into(),
                problem: "a word of a data bank is a power of two of bytes and holds a whole read",
                remedy: "use a power of two of at least",
                limit: bytes_per_read.into(),
            });
        }
        if self.mode == Mode::Prefetching && self.reorder_buffer < reads_per_tap {
            return Err(TimingError {
                key: "reorder-buffer",
                value: self.reorder_buffer.into(),
                problem: "deadlock: one tap can miss more lines than the reorder buffer holds, and would wait for \
                          places that only it can give back",
                remedy: "use at least",
                limit: reads_per_tap.into(),
            });
        }
        Ok(())
    }
}

impl MemoryParameters {
    /// Whether this memory can serve lines of `line` bytes.
    ///
    /// # Errors
    /// The first parameter at fault.
    pub fn check(&self, line: u32) -> Result<(), TimingError> {
        if let Some(second) = &self.second_level {
            at_least_one("second-level.latency", second.latency)?;
            at_least_one("second-level.bytes-per-clock", second.bytes_per_clock)?;
            at_least_one("second-level.miss-queue", second.miss_queue)?;
            if second.line < line {
                return Err(TimingError {
                    key: "second-level.line",
                    value: second.line.into(),
                    problem: "a second-level line holds whole first-level lines",
                    remedy: "use at least",
                    limit: line.into(),
                });
            }
        }
        let block = self.second_level.map_or(line, |second| second.line);
        match &self.main {
            MainMemory::Fixed { bytes_per_clock, .. } => at_least_one("bytes-per-clock", *bytes_per_clock),
            MainMemory::Dram(dram) => dram.check(block),
        }
    }
}

/// Refuses counts no state can be kept for.
pub(super) fn at_least_one(key: &'static str, value: u32) -> Result<(), TimingError> {
    if value == 0 {
        return Err(TimingError {
            key,
            value: 0,
            problem: "nothing would ever pass",
            remedy: "use at least",
            limit: 1,
        });
    }
    if value > LARGEST {
        return Err(TimingError {
            key,
            value: value.into(),
            problem: "larger than the model keeps state for",
            remedy: "use at most",
            limit: LARGEST.into(),
        });
    }
    Ok(())
}
