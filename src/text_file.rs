//! Small text files (scenes, machines, sweeps), read whole but never without end.

use std::{fs::File, io::Read, path::Path};

use crate::error::{Error, Result};

/// No file a person writes is anywhere near as long; a device or an image named by mistake is.
pub const BYTES_MAX: u64 = 1 << 24;

/// The text of a file.
///
/// # Errors
/// [`Error::Io`] with the path, also for what is not UTF-8; a file longer than [`BYTES_MAX`].
pub fn read(path: &Path) -> Result<String> {
    let mut text = String::new();
    let file = File::open(path).map_err(Error::io(path))?;
    file.take(BYTES_MAX + 1).read_to_string(&mut text).map_err(Error::io(path))?;
    if text.len() as u64 > BYTES_MAX {
        let problem = format!("more than {BYTES_MAX} bytes");
        return Err(Error::file(path, "length", problem, "name a TOML file: this is something else"));
    }
    Ok(text)
}
