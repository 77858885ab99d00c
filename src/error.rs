//! What can go wrong outside the chip: every message names the file, the key or line, the value, and what would be right.

use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};

/// An error a user can mend.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{}: {source}{}", path.display(), io_remedy(source.kind()))]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file was read, and something in it is wrong.
    #[error("{}: {place}: {problem}\n  help: {remedy}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Line, row or key within it.
        place: String,
        /// What is wrong, with the value.
        problem: String,
        /// What would be right.
        remedy: String,
    },
    /// An option or setting is wrong.
    #[error("{key} = {value}: {problem}\n  help: {remedy}")]
    Setting {
        /// The option or key.
        key: String,
        /// Its value.
        value: String,
        /// What is wrong.
        problem: String,
        /// What would be right.
        remedy: String,
    },
    /// A message that already shows its place (a rendered snippet of a TOML file).
    #[error("{0}")]
    Rendered(String),
    /// The reader of our output went away, or Ctrl-C: not a failure of ours.
    #[error("interrupted; what was finished is in {}", .0.display())]
    Interrupted(PathBuf),
}

/// What can be done about the failures that a user meets.
const fn io_remedy(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::NotFound => "\n  help: check the path, and that the folder it names exists",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "\n  help: name a place that you may read and write"
        }
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "\n  help: a file stands where a folder is meant: name another place"
        }
        ErrorKind::IsADirectory => "\n  help: name a file, this is a folder",
        ErrorKind::InvalidData => "\n  help: a text file in UTF-8 is meant",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "\n  help: make room, or name another place",
        _ => "",
    }
}

/// What fallible functions outside the chip return.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// For `map_err` on file operations.
    pub fn io(path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.as_ref().to_path_buf();
        move |source| Self::Io { path, source }
    }

    /// Something wrong at a place in a file.
    pub fn file(
        path: impl AsRef<Path>,
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::File {
            path: path.as_ref().to_path_buf(),
            place: place.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// A wrong option or setting.
    pub fn setting(
        key: impl Into<String>,
        value: impl ToString,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Setting { key: key.into(), value: value.to_string(), problem: problem.into(), remedy: remedy.into() }
    }
}
