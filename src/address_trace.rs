//! Anyone's address traces: little-endian u64 or u32, and the `din` text of Dinero IV. Read in blocks, never whole.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Read, Write},
    path::{Path, PathBuf},
};

use crate::error::{Error, Result};

/// How addresses are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum AddressFormat {
    /// Eight bytes each, little-endian.
    U64,
    /// Four bytes each, little-endian.
    U32,
    /// Text, a line each: a label (0 read, 1 write, 2 instruction fetch), the byte address in hexadecimal, and whatever
    /// else, ignored. Every record is one access of the byte at its address, whatever its label.
    Din,
}

impl AddressFormat {
    /// What a file's name says: `.din` and `.u32`, and u64 for all others.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("din") => Self::Din,
            Some("u32") => Self::U32,
            _ => Self::U64,
        }
    }

    /// Writes one address, as a read where the format can say so. Of a u32 the low 32 bits are written.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write(self, address: u64, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::U64 => out.write_all(&address.to_le_bytes()),
            Self::U32 => out.write_all(&(address as u32).to_le_bytes()),
            Self::Din => writeln!(out, "0 {address:x}"),
        }
    }
}

/// A trace being read.
///
/// ```
/// use texunit::address_trace::{AddressFormat, AddressTrace};
/// let text = "2 0 ifetch\n0 1f40\n\n1 0xffc0 4\n";
/// let mut trace = AddressTrace::new("example.din", text.as_bytes(), AddressFormat::Din);
/// let mut addresses = Vec::new();
/// assert!(trace.next_block(&mut addresses)?);
/// assert_eq!(addresses, [0, 0x1f40, 0xffc0]);
/// assert!(!trace.next_block(&mut addresses)?);
/// # Ok::<(), texunit::error::Error>(())
/// ```
pub struct AddressTrace {
    path: PathBuf,
    source: BufReader<Box<dyn Read>>,
    format: AddressFormat,
    /// Bytes of the source read so far.
    position: u64,
    /// Lines of text read so far.
    lines: u64,
    /// The block or line being read.
    buffer: Vec<u8>,
}

/// Addresses per block: few enough to stay in the second-level cache of the host.
const BLOCK: usize = 1 << 14;
/// No line of a `din` file is anywhere near as long.
const LINE_BYTES_MAX: u64 = 1 << 16;

impl AddressTrace {
    /// Opens a file, or standard input where the path is `-`. Without a format the name decides.
    ///
    /// # Errors
    /// [`Error::Io`] with the path.
    pub fn open(path: &Path, format: Option<AddressFormat>) -> Result<Self> {
        let format = format.unwrap_or_else(|| AddressFormat::of(path));
        if path == Path::new("-") {
            return Ok(Self::new("standard input", io::stdin(), format));
        }
        let file = File::open(path).map_err(Error::io(path))?;
        Ok(Self::new(path, file, format))
    }

    /// Reads from any source; `name` is for messages.
    pub fn new(name: impl Into<PathBuf>, source: impl Read + 'static, format: AddressFormat) -> Self {
        let source = BufReader::with_capacity(1 << 18, Box::new(source) as Box<dyn Read>);
        Self { path: name.into(), source, format, position: 0, lines: 0, buffer: Vec::new() }
    }

    /// Bytes read so far.
    #[must_use]
    pub const fn position(&self) -> u64 {
        self.position
    }

    /// Replaces the contents of `addresses` with the next ones. False at the end of the trace.
    ///
    /// # Errors
    /// What cannot be read, a record cut short, or a line that is no `din` record, with its number.
    pub fn next_block(&mut self, addresses: &mut Vec<u64>) -> Result<bool> {
        addresses.clear();
        match self.format {
            AddressFormat::U64 => self.binary::<8>(addresses, u64::from_le_bytes)?,
            AddressFormat::U32 => self.binary::<4>(addresses, |bytes| u32::from_le_bytes(bytes).into())?,
            AddressFormat::Din => self.din(addresses)?,
        }
        Ok(!addresses.is_empty())
    }

    fn binary<const N: usize>(&mut self, addresses: &mut Vec<u64>, address: impl Fn([u8; N]) -> u64) -> Result<()> {
        self.buffer.clear();
        let wanted = (BLOCK * N) as u64;
        let read = self.source.by_ref().take(wanted).read_to_end(&mut self.buffer).map_err(Error::io(&self.path))?;
        self.position += read as u64;
        let (records, rest) = self.buffer.as_chunks::<N>();
        if !rest.is_empty() {
            return Err(Error::file(
                &self.path,
                format!("byte {}", self.position - rest.len() as u64),
                format!("the last address has {} of its {N} bytes", rest.len()),
                "the trace is cut short, or of another --format (u64, u32, din)",
            ));
        }
        addresses.extend(records.iter().map(|&bytes| address(bytes)));
        Ok(())
    }

    fn din(&mut self, addresses: &mut Vec<u64>) -> Result<()> {
        while addresses.len() < BLOCK {
            self.buffer.clear();
            let read = self.source.by_ref().take(LINE_BYTES_MAX).read_until(b'\n', &mut self.buffer);
            let read = read.map_err(Error::io(&self.path))? as u64;
            if read == 0 {
                break;
            }
            self.position += read;
            self.lines += 1;
            if !self.buffer.trim_ascii().is_empty() {
                addresses.push(din_address(&self.buffer).map_err(|(problem, remedy)| {
                    Error::file(&self.path, format!("line {}", self.lines), problem, remedy)
                })?);
            }
        }
        Ok(())
    }
}

/// The address of a record, or what is wrong with it and what would be right.
fn din_address(record: &[u8]) -> Result<u64, (String, &'static str)> {
    let mut fields = record.split(u8::is_ascii_whitespace).filter(|field| !field.is_empty());
    let shown = |field: &[u8]| String::from_utf8_lossy(&field[..field.len().min(40)]).into_owned();
    let label = fields.next().unwrap_or_default();
    if !matches!(label, b"0" | b"1" | b"2") {
        let remedy = "a record is `LABEL ADDRESS`, LABEL 0 read, 1 write or 2 instruction fetch, ADDRESS hexadecimal; \
                      binary traces need --format u64 or u32";
        return Err((format!("the label is `{}`", shown(label)), remedy));
    }
    let field = fields.next().unwrap_or_default();
    let digits = field.strip_prefix(b"0x").or_else(|| field.strip_prefix(b"0X")).unwrap_or(field);
    // A sign, which from_str_radix would take, is not a digit.
    let digits = Some(digits).filter(|digits| digits.iter().all(u8::is_ascii_hexdigit));
    digits.and_then(|digits| u64::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()).ok_or_else(|| {
        (format!("the address is `{}`", shown(field)), "give 1 to 16 hexadecimal digits, with or without 0x")
    })
}
