//! What went to memory, for other models of it.

use std::io::{Result, Write};

use texunit_hw::timing::StoredFetch;

use super::Recording;

/// Whose format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// DRAMSim3: `address READ clock`, address in hexadecimal.
    #[default]
    Dramsim3,
    /// Ramulator 2, load-store frontend: `LD address`.
    Ramulator2,
}

/// Writes every request to the main memory, in order, `block` bytes each, a power of two; without a second level, a decompressor's have bytes of
/// their own. The clock is the one the memory (or the second level, if there is one) took the request in. The readers move a fixed
/// number of bytes a line of the file, on a multiple of it: requests for more than `bytes`, a power of two, become several lines of one clock.
///
/// # Errors
/// Those of the writer.
pub fn write(writer: &mut dyn Write, recording: &Recording, block: u32, bytes: u32, format: Format) -> Result<()> {
    // A line of the texel cache lies in one block; what is stored behind it has blocks in the second level only.
    let lines = recording.fills.iter().filter(|_| recording.stored.is_empty());
    let lines = lines.map(|fill| (fill.address, 1, block, fill.fetch));
    let parts = recording.stored.iter().map(|(_, StoredFetch { address, bytes: many, fetch })| {
        (*address, u64::from(*many), if fetch.second_level_hit.is_some() { block } else { bytes }, *fetch)
    });
    let requests = lines.chain(parts).filter(|(.., fetch)| fetch.second_level_hit != Some(true));
    for (address, many, unit, fetch) in requests {
        let (first, end) = (address & !(u64::from(unit) - 1), (address + many).next_multiple_of(unit.into()));
        for address in (first..end).step_by(bytes as usize) {
            match format {
                Format::Dramsim3 => writeln!(writer, "{address:#x} READ {}", fetch.taken)?,
                Format::Ramulator2 => writeln!(writer, "LD {address:#x}")?,
            }
        }
    }
    Ok(())
}
