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

/// Writes every request to the main memory, in order, `block` bytes each, a power of two. The clock is the one the memory (or the
/// second level, if there is one) took the request in. The readers move a fixed number of bytes a line of the file: blocks longer than
/// `bytes`, a power of two, become several lines of one clock.
///
/// # Errors
/// Those of the writer.
pub fn write(writer: &mut dyn Write, fills: &[FillTimes], block: u32, bytes: u32, format: Format) -> Result<()> {
    for fill in fills.iter().filter(|fill| fill.fetch.second_level_hit != Some(true)) {
        let first = fill.address & !(u64::from(block) - 1);
        for address in (first..first + u64::from(block)).step_by(bytes as usize) {
            match format {
                Format::Dramsim3 => writeln!(writer, "{address:#x} READ {}", fill.fetch.taken)?,
                Format::Ramulator2 => writeln!(writer, "LD {address:#x}")?,
            }
        }
    }
    Ok(())
}
