//! Files are written whole or not at all: to a temporary name beside the target, then renamed.

use std::{
    fs,
    io::{BufWriter, Write},
    path::Path,
};

use crate::error::{Error, Result};

/// Writes `path` through `fill`; on any failure the target is left as it was. A link is followed; what is there and is no file (a
/// device such as /dev/null, a pipe) is written to as it is: a rename would put a file in its place.
///
/// # Errors
/// [`Error::Io`] naming `path`.
pub fn write_whole(path: &Path, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    let name = path;
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let path = target.as_path();
    if fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        let write = || {
            let mut file = BufWriter::new(fs::OpenOptions::new().write(true).open(path)?);
            fill(&mut file).and_then(|()| file.flush())
        };
        return write().map_err(Error::io(name));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let write = || -> std::io::Result<()> {
        let mut file = tempfile::Builder::new().prefix(".texunit-").suffix(".tmp").tempfile_in(folder)?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            file.as_file().set_permissions(fs::Permissions::from_mode(0o644))?;
        }
        {
            let mut buffered = BufWriter::with_capacity(1 << 20, file.as_file_mut());
            fill(&mut buffered)?;
            buffered.flush()?;
        }
        file.persist(path).map_err(|failed| failed.error)?;
        Ok(())
    };
    write().map_err(Error::io(name))
}

/// Creates a folder and its parents.
///
/// # Errors
/// [`Error::Io`] naming the folder.
pub fn create_folder(path: &Path) -> Result<()> {
    fs::create_dir_all(path).map_err(Error::io(path))
}

/// Writes results to standard output. A reader that has gone away, such as `head`, had enough of them: no error.
///
/// # Errors
/// [`Error::Io`] naming standard output.
pub fn print(fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    let mut output = BufWriter::new(std::io::stdout().lock());
    match fill(&mut output).and_then(|()| output.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(Error::io("standard output")),
    }
}

/// Writes to a file, whole or not at all, or to standard output where the path is `-`.
///
/// # Errors
/// [`Error::Io`] naming the target.
pub fn write_or_print(path: &Path, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    if path.as_os_str() == "-" { print(fill) } else { write_whole(path, fill) }
}
