//! Text read line by line, counted, so that whatever is wrong can name its line; no line is unlimited.

use std::{
    io::{BufRead, Read},
    path::{Path, PathBuf},
};

use crate::error::{Error, Result};

/// No line of a file texunit reads is anywhere near as long.
const LINE_BYTES_MAX: u64 = 1 << 16;

/// The lines of a file.
///
/// ```
/// use texunit::text_lines::TextLines;
/// let mut lines = TextLines::new("notes.txt", "one\r\ntwo".as_bytes());
/// assert!(lines.advance()? && lines.text() == "one" && lines.advance()?);
/// assert_eq!((lines.text(), lines.number()), ("two", 2));
/// assert!(!lines.advance()?);
/// assert_eq!(lines.error("ends too early", "add more").to_string(), "notes.txt: line 2: ends too early\n  help: add more");
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Debug)]
pub struct TextLines<R> {
    path: PathBuf,
    source: R,
    number: u64,
    text: String,
}

impl<R: BufRead> TextLines<R> {
    /// Reads from any source; `path` is for messages.
    pub fn new(path: impl Into<PathBuf>, source: R) -> Self {
        Self { path: path.into(), source, number: 0, text: String::new() }
    }

    /// Goes to the next line; false at the end.
    ///
    /// # Errors
    /// What cannot be read, what is not UTF-8, a line without end.
    pub fn advance(&mut self) -> Result<bool> {
        let mut bytes = std::mem::take(&mut self.text).into_bytes();
        bytes.clear();
        let read = self.source.by_ref().take(LINE_BYTES_MAX).read_until(b'\n', &mut bytes);
        let read = read.map_err(Error::io(&self.path))? as u64;
        if read == 0 {
            return Ok(false);
        }
        self.number += 1;
        if read == LINE_BYTES_MAX {
            return Err(self.error(format!("a line of {LINE_BYTES_MAX} bytes or more"), "give the file that was meant"));
        }
        self.text = String::from_utf8(bytes).map_err(|_| self.error("not text", "give a text file in UTF-8"))?;
        self.text.truncate(self.text.trim_end().len());
        Ok(true)
    }

    /// The line, without white space at its end; empty after the last.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The number of the line, from 1; at the end that of the last.
    #[must_use]
    pub const fn number(&self) -> u64 {
        self.number
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Something wrong with this line.
    #[must_use]
    pub fn error(&self, problem: impl Into<String>, remedy: &str) -> Error {
        self.error_at(self.number.max(1), problem, remedy)
    }

    /// Something wrong with a line that is past.
    #[must_use]
    pub fn error_at(&self, line: u64, problem: impl Into<String>, remedy: &str) -> Error {
        Error::file(&self.path, format!("line {line}"), problem, remedy)
    }
}
