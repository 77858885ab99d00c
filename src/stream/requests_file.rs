//! A request stream as CSV, or as Parquet with the feature of that name: a request a row.
//!
//! Columns `u`, `v`, `dudx`, `dvdx`, `dudy`, `dvdy` (normalised coordinates, change per pixel step) are required; `x`, `y` (pixel),
//! `texture` (a name) and `filter` may be there. Any other column is an error: a misspelt one would be silently ignored.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{BufReader, Read},
    path::{Path, PathBuf},
};

use serde::Deserialize;
use texunit_hw::Filter;

use super::{NamedTexture, Stream, StreamRequest};
use crate::{
    error::{Error, Result},
    names::Named,
    scene::{Fragment, Gradient},
    texture_file,
};

/// A row as it stands in the file.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    #[serde(default)]
    x: Option<u16>,
    #[serde(default)]
    y: Option<u16>,
    #[serde(default)]
    texture: Option<String>,
    u: f64,
    v: f64,
    dudx: f64,
    dvdx: f64,
    dudy: f64,
    dvdy: f64,
    #[serde(default)]
    filter: Option<String>,
}

/// What a reader of rows does with each: its number in the file, from 1, and the row.
type Take<'t> = dyn FnMut(u64, Row) -> Result<()> + 't;

const REMEDY: &str = "columns are u, v, dudx, dvdx, dudy, dvdy, and if wanted x, y, texture, filter";

/// Pixels go so far on both axes, as those of a scene: a row alone must not ask for a picture of 16 GiB.
pub const PIXEL_MAX: u16 = 16383;

/// Reads a stream. `textures` gives names files; a name it does not know is a file beside the stream's, and rows without one take
/// the only texture given.
///
/// # Errors
/// A missing or damaged file, a row that is none (with its number), a texture that cannot be read, a filter nobody knows.
pub fn load(path: &Path, textures: &[(String, PathBuf)]) -> Result<Stream> {
    if path.extension().is_some_and(|extension| extension == "parquet") {
        collect(path, textures, |take| read_parquet(path, take))
    } else {
        read(path, BufReader::new(File::open(path).map_err(Error::io(path))?), textures)
    }
}

/// The same from CSV of any source; `path` is for messages, and the folder of the textures it names.
///
/// # Errors
/// As [`load`].
pub fn read(path: &Path, source: impl Read, textures: &[(String, PathBuf)]) -> Result<Stream> {
    collect(path, textures, |take| read_csv(path, source, take))
}

/// A stream of all rows that `read` finds.
fn collect(
    path: &Path,
    textures: &[(String, PathBuf)],
    read: impl FnOnce(&mut Take<'_>) -> Result<()>,
) -> Result<Stream> {
    let mut loader = Loader { path, textures, stream: Stream::default(), known: BTreeMap::new() };
    let mut end = Some([0_u32; 2]);
    let mut take = |number: u64, row: Row| {
        end = match (end, row.x, row.y) {
            (Some([right, below]), Some(x), Some(y)) => {
                Some([right.max(u32::from(x) + 1), below.max(u32::from(y) + 1)])
            }
            _ => None,
        };
        loader.take(number, row)
    };
    read(&mut take)?;
    let mut stream = loader.stream;
    if stream.requests.is_empty() {
        return Err(Error::file(path, "row 1", "there is no request", REMEDY));
    }
    stream.size = end;
    Ok(stream)
}

struct Loader<'l> {
    path: &'l Path,
    textures: &'l [(String, PathBuf)],
    stream: Stream,
    known: BTreeMap<String, usize>,
}

impl Loader<'_> {
    fn take(&mut self, number: u64, row: Row) -> Result<()> {
        let place = format!("row {number}");
        let wrong = |problem: String, remedy: &str| Error::file(self.path, &place, problem, remedy);
        let filter = row.filter.as_deref().filter(|name| !name.is_empty()).map(Filter::from_name).transpose();
        let filter = filter.map_err(|problem| wrong(problem, "or leave the column away"))?;
        let name = match (row.texture.filter(|name| !name.is_empty()), self.textures) {
            (Some(name), _) => name,
            (None, [(name, _)]) => name.clone(),
            (None, _) => {
                return Err(wrong("it names no texture".into(), "add a column `texture`, or give one --texture"));
            }
        };
        let texture = match self.known.get(&name) {
            Some(&texture) => texture,
            None => {
                let given = self.textures.iter().find(|(known, _)| *known == name).map(|(_, file)| file.clone());
                let beside = || self.path.parent().unwrap_or(Path::new("")).join(&name);
                let file = given.unwrap_or_else(beside);
                if !file.is_file() {
                    let problem = format!("texture `{name}` is neither named by --texture nor a file");
                    return Err(wrong(problem, &format!("give --texture {name}=FILE")));
                }
                let texture = self.stream.textures.len();
                self.stream.textures.push(NamedTexture { name: name.clone(), image: texture_file::load(&file)? });
                self.known.insert(name, texture);
                texture
            }
        };
        let [x, y] = [row.x, row.y].map(Option::unwrap_or_default);
        if x.max(y) > PIXEL_MAX {
            return Err(Error::file(
                self.path,
                &place,
                format!("pixel {x}, {y}"),
                format!("0 to {PIXEL_MAX} are meant"),
            ));
        }
        let gradient = Gradient { ux: row.dudx, uy: row.dudy, vx: row.dvdx, vy: row.dvdy };
        let fragment = Fragment { x, y, u: row.u, v: row.v, gradient };
        self.stream.requests.push(StreamRequest { fragment, texture, filter });
        Ok(())
    }
}

fn read_csv(path: &Path, source: impl Read, take: &mut Take<'_>) -> Result<()> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(source);
    for (number, row) in (1..).zip(reader.deserialize()) {
        let row: Row = row.map_err(|error| match error.into_kind() {
            csv::ErrorKind::Io(error) => Error::io(path)(error),
            csv::ErrorKind::Deserialize { pos, err } => {
                let line = pos.map_or(number + 1, |position| position.line());
                Error::file(path, format!("line {line}"), err.kind().to_string(), REMEDY)
            }
            csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
                let line = pos.map_or(number + 1, |position| position.line());
                Error::file(path, format!("line {line}"), format!("{len} values, not {expected_len}"), REMEDY)
            }
            other => Error::file(path, format!("row {number}"), format!("{other:?}"), REMEDY),
        })?;
        take(number, row)?;
    }
    Ok(())
}

#[cfg(feature = "parquet")]
fn read_parquet(path: &Path, take: &mut Take<'_>) -> Result<()> {
    use parquet::{
        file::reader::{FileReader, SerializedFileReader},
        record::Field,
    };
    let wrong = |place: String, problem: String| Error::file(path, place, problem, REMEDY);
    let file = File::open(path).map_err(Error::io(path))?;
    let reader = SerializedFileReader::new(file).map_err(|error| wrong("its metadata".into(), error.to_string()))?;
    let rows = reader.get_row_iter(None).map_err(|error| wrong("its schema".into(), error.to_string()))?;
    for (number, row) in (1..).zip(rows) {
        let row = row.map_err(|error| wrong(format!("row {number}"), error.to_string()))?;
        // As a row of the CSV would have it: one reader of rows, and what is not a number stays so.
        let (mut header, mut values) = (csv::StringRecord::new(), csv::StringRecord::new());
        for (name, field) in row.get_column_iter() {
            header.push_field(name);
            match field {
                Field::Null => values.push_field(""),
                Field::Str(text) => values.push_field(text),
                field => values.push_field(&field.to_string()),
            }
        }
        let row =
            values.deserialize(Some(&header)).map_err(|error| wrong(format!("row {number}"), error.to_string()))?;
        take(number, row)?;
    }
    Ok(())
}

#[cfg(not(feature = "parquet"))]
fn read_parquet(path: &Path, _take: &mut Take<'_>) -> Result<()> {
    let problem = "this texunit was built without Parquet";
    Err(Error::file(path, "its name", problem, "build it with `--features parquet`, or give the stream as CSV"))
}
