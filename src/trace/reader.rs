//! Reading a trace: whatever is wrong with one, the message names the line.

use std::{
    fs::File,
    io::{BufRead, BufReader, Read as _},
    path::{Path, PathBuf},
};

use super::{Profile, Record, Trace, UNIT, VERSION, record::shortened, writer::fields_line};
use crate::{
    annotated,
    error::{Error, Result},
    text_lines::TextLines,
};

/// How every trace begins.
const FIRST_WORDS: &str = "// texunit trace ";

/// No head has anywhere near as many lines.
const HEAD_LINES_MAX: u64 = 1 << 12;

/// The lines of a head that are not part of the profile, each exactly once.
const KEYS: [&str; 5] = ["unit", "model", "seed", "fields", "count"];

/// Said where only a fresh trace will do.
const RECORD_AGAIN: &str = "the file is damaged: take it from where it came, or record it again (texunit trace record)";

/// Whether a file begins like a trace, of this version or another.
///
/// # Errors
/// [`Error::Io`] with the path.
pub fn is_trace(path: &Path) -> Result<bool> {
    let mut start = Vec::new();
    let mut file = File::open(path).map_err(Error::io(path))?.take(FIRST_WORDS.len() as u64);
    file.read_to_end(&mut start).map_err(Error::io(path))?;
    Ok(start == FIRST_WORDS.as_bytes())
}

impl Trace {
    /// Reads a trace from a file.
    ///
    /// # Errors
    /// What cannot be read; a trace of a newer version, a damaged, a short or a long one, with the line at fault.
    pub fn load(path: &Path) -> Result<Self> {
        Self::parse(path, BufReader::new(File::open(path).map_err(Error::io(path))?))
    }

    /// Reads a trace from any source; `path` is for messages.
    ///
    /// # Errors
    /// As [`Trace::load`].
    pub fn parse(path: impl Into<PathBuf>, source: impl BufRead) -> Result<Self> {
        let mut lines = TextLines::new(path, source);
        let mut head = Head::begin(&mut lines)?;
        while lines.advance()? {
            if let Some(comment) = lines.text().strip_prefix("//") {
                head.line(&lines, comment)?;
            } else if !lines.text().trim().is_empty() {
                break;
            } else {
                head.source.push('\n');
            }
        }
        let (profile, count) = head.finish(&lines)?;
        let mut trace = Self {
            profile,
            seed: head.number(&lines, "seed")?,
            model: head.value(&lines, "model")?.1.clone(),
            records: Vec::new(),
            lines: Vec::new(),
        };
        let mut more = !lines.text().is_empty();
        while more {
            let line = lines.text().trim();
            if !line.is_empty() && !line.starts_with("//") {
                if trace.records.len() as u64 == count {
                    let problem = format!("a record after the {count} that the head counts");
                    return Err(lines.error(problem, RECORD_AGAIN));
                }
                trace.records.push(Record::parse(line).map_err(|problem| lines.error(problem, RECORD_AGAIN))?);
                trace.lines.push(lines.number());
            }
            more = lines.advance()?;
        }
        if (trace.records.len() as u64) < count {
            let problem = format!("the trace ends after {} of {count} records", trace.records.len());
            return Err(lines.error(problem, "it was cut short: take it from where it came, or record it again"));
        }
        Ok(trace)
    }
}

/// What is known of the head so far.
#[derive(Default)]
struct Head {
    /// The text as it is, for messages.
    source: String,
    /// The same length of TOML: the profile's lines without their slashes, blanks for all others.
    masked: String,
    /// Line and value of [`KEYS`].
    values: [Option<(u64, String)>; KEYS.len()],
}

impl Head {
    /// Reads the first line.
    fn begin<R: BufRead>(lines: &mut TextLines<R>) -> Result<Self> {
        lines.advance()?;
        let version = lines.text().strip_prefix(FIRST_WORDS).and_then(|rest| rest.trim().parse::<u32>().ok());
        let source = format!("{}\n", lines.text());
        let masked = format!("{}\n", " ".repeat(lines.text().len()));
        match version {
            Some(VERSION) => Ok(Self { source, masked, ..Self::default() }),
            Some(newer) if newer > VERSION => {
                let problem = format!("a trace of version {newer}, and this texunit reads up to {VERSION}");
                Err(lines.error(problem, "update texunit"))
            }
            _ => {
                let problem = format!("`{}` where a trace begins `{FIRST_WORDS}{VERSION}`", shortened(lines.text()));
                Err(lines.error(problem, "this is no texunit trace: `texunit trace record` makes one"))
            }
        }
    }

    /// One more line, `comment` without its slashes.
    fn line<R: BufRead>(&mut self, lines: &TextLines<R>, comment: &str) -> Result<()> {
        if lines.number() > HEAD_LINES_MAX {
            return Err(lines.error(format!("a head of more than {HEAD_LINES_MAX} lines"), RECORD_AGAIN));
        }
        self.source += lines.text();
        self.source.push('\n');
        let (key, value) = comment.trim().split_once(' ').unwrap_or((comment.trim(), ""));
        let value = value.trim();
        if value.starts_with('=') {
            self.masked += &format!("  {comment}\n");
            return Ok(());
        }
        self.masked += &" ".repeat(lines.text().len());
        self.masked.push('\n');
        let Some(place) = KEYS.iter().position(|known| *known == key) else {
            let problem = format!("`{}` has no meaning in the head of a trace", shortened(comment.trim()));
            let remedy = "take the line out; if a newer texunit wrote it, update texunit";
            return Err(lines.error(problem, remedy));
        };
        if let Some((first, _)) = &self.values[place] {
            return Err(lines.error(format!("`{key}` was said on line {first} already"), RECORD_AGAIN));
        }
        self.values[place] = Some((lines.number(), value.to_owned()));
        Ok(())
    }

    fn value<R: BufRead>(&self, lines: &TextLines<R>, key: &str) -> Result<&(u64, String)> {
        let place = KEYS.iter().position(|known| *known == key);
        place
            .and_then(|place| self.values[place].as_ref())
            .ok_or_else(|| lines.error(format!("the head ends here and did not say `// {key} ...`"), RECORD_AGAIN))
    }

    fn number<R: BufRead>(&self, lines: &TextLines<R>, key: &str) -> Result<u64> {
        let (line, value) = self.value(lines, key)?;
        value.parse().map_err(|_| {
            let problem = format!("{key} = `{}` is not a whole number", shortened(value));
            lines.error_at(*line, problem, RECORD_AGAIN)
        })
    }

    /// The profile and the number of records, once the head has ended.
    fn finish<R: BufRead>(&self, lines: &TextLines<R>) -> Result<(Profile, u64)> {
        for (key, expected) in [("unit", UNIT.to_owned()), ("fields", fields_line())] {
            let (line, value) = self.value(lines, key)?;
            if *value != expected {
                let problem = format!("{key} = `{}`, and this texunit reads `{expected}`", shortened(value));
                return Err(lines.error_at(*line, problem, RECORD_AGAIN));
            }
        }
        let count = self.number(lines, "count")?;
        let profile: Profile = toml::from_str(&self.masked).map_err(|found| {
            let remedy =
                "docs/trace-format.md lists the keys of a head; if a newer texunit wrote this one, update texunit";
            annotated::toml_error(lines.path(), &self.source, &found, remedy)
        })?;
        let place = |key: &str| {
            let line = self.source.lines().position(|line| {
                line.trim_start_matches(['/', ' ']).strip_prefix(key).is_some_and(|rest| rest.trim().starts_with('='))
            });
            line.map_or_else(|| format!("key {key}"), |line| format!("line {}: {key}", line + 1))
        };
        if let Err((key, problem)) = profile.texture.check() {
            return Err(Error::file(lines.path(), place(&format!("texture.{key}")), problem, RECORD_AGAIN));
        }
        profile.machine.check().map_err(|error| match error {
            Error::Setting { key, value, problem, remedy } => {
                Error::file(lines.path(), place(&format!("machine.{key}")), format!("{value} is {problem}"), remedy)
            }
            other => other,
        })?;
        Ok((profile, count))
    }
}
