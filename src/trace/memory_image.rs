//! The texture memory of a trace as text, for whoever replays it outside: RTL, another model.

use std::io::{Result, Write};

use super::{Profile, writer::write_profile};
use crate::texture_memory::TextureMemory;

/// The version of the format.
const VERSION: u32 = 1;

/// Writes what lies in memory when a trace of this profile is played, as docs/trace-format.md says: the table of planes, then 32 bits
/// a line, the byte of the lowest address lowest.
///
/// # Errors
/// Those of the writer.
pub(super) fn write(profile: &Profile, memory: &TextureMemory, out: &mut dyn Write) -> Result<()> {
    writeln!(out, "// texunit memory {VERSION}")?;
    writeln!(out, "// model {}", env!("CARGO_PKG_VERSION"))?;
    write_profile(profile, out)?;
    for (number, plane) in memory.surface.planes.iter().enumerate() {
        let [width, height] = plane.size();
        let held = if plane.held { "" } else { " not held" };
        writeln!(
            out,
            "// plane {number} halved {} {} size {width} {height} at {:08x}{held}",
            plane.lu, plane.lv, plane.base
        )?;
    }
    writeln!(out, "// fields word:32")?;
    let words = memory.bytes.chunks(4).map(|bytes| {
        let mut word = [0; 4];
        word[..bytes.len()].copy_from_slice(bytes);
        u32::from_le_bytes(word)
    });
    writeln!(out, "// count {}", words.len())?;
    words.into_iter().try_for_each(|word| writeln!(out, "{word:08x}"))
}
