//! What went to memory, for other models of it.

use std::io::{Result, Write};

use texunit_hw::timing::FillTimes;

/// Whose format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// DRAMSim3: `address READ clock`, address in hexadecimal.
    #[default]
    Dramsim3,
    /// Ramulator 2, load-store frontend: `LD address`.
    Ramulator2,
}

/// Writes a line for every request to the main memory, in order; `block` bytes each, a power of two. The clock is the one the memory (or the
/// second level, if there is one) took the request in.
///
/// # Errors
/// Those of the writer.
pub fn write(writer: &mut dyn Write, fills: &[FillTimes], block: u32, format: Format) -> Result<()> {
    for fill in fills.iter().filter(|fill| fill.fetch.second_level_hit != Some(true)) {
        let address = fill.address & !(u64::from(block) - 1);
        match format {
            Format::Dramsim3 => writeln!(writer, "{address:#x} READ {}", fill.fetch.taken)?,
            Format::Ramulator2 => writeln!(writer, "LD {address:#x}")?,
        }
    }
    Ok(())
}
