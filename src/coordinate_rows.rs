//! Coordinates in a CSV file, read in blocks: what `texunit sample` is asked.

use std::{io::BufRead, path::PathBuf};

use crate::{
    error::Result,
    scene::{Fragment, Gradient},
    text_lines::TextLines,
};

/// Most rows of a block.
pub const BLOCK: usize = 1 << 14;

/// What a row says beside u and v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    /// A level of detail.
    Level,
    /// The change per pixel step.
    Gradient,
}

const LEVEL_COLUMNS: &[&str] = &["u", "v", "lod"];
const GRADIENT_COLUMNS: &[&str] = &["u", "v", "dudx", "dvdx", "dudy", "dvdy"];

/// One row of the input.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Normalised coordinate to the right.
    pub u: f64,
    /// The same, down.
    pub v: f64,
    /// What selects the level.
    pub detail: RowDetail,
}

/// What selects the level of a row.
#[derive(Clone, Copy, Debug)]
pub enum RowDetail {
    /// Itself.
    Level(f64),
    /// The change of the coordinates per pixel step.
    Gradient(Gradient),
}

impl Row {
    /// The gradient; of a level, that of a round footprint.
    #[must_use]
    pub fn gradient(&self, size: [u32; 2]) -> Gradient {
        match self.detail {
            RowDetail::Gradient(gradient) => gradient,
            RowDetail::Level(level) => {
                let [ux, vy] = size.map(|texels| libm::exp2(level) / f64::from(texels));
                Gradient { ux, vy, ..Gradient::default() }
            }
        }
    }

    /// As a fragment of no pixel; a level has no gradient.
    #[must_use]
    pub fn fragment(&self) -> Fragment {
        let gradient = match self.detail {
            RowDetail::Gradient(gradient) => gradient,
            RowDetail::Level(_) => Gradient::default(),
        };
        Fragment { x: 0, y: 0, u: self.u, v: self.v, gradient }
    }
}

/// The rows of a CSV file, read in blocks. Numbers need no quotes: they are taken off where a spreadsheet put them.
///
/// ```
/// use texunit::coordinate_rows::Rows;
/// let mut rows = Rows::new("coordinates.csv", "v,u,lod\n0.5,0.25,1".as_bytes())?;
/// let mut block = Vec::new();
/// rows.block(&mut block)?;
/// assert_eq!((block[0].u, block[0].v), (0.25, 0.5));
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Debug)]
pub struct Rows<R> {
    lines: TextLines<R>,
    columns: Columns,
    /// Which value each place of a row holds, in the order of the names.
    values: Vec<usize>,
}

impl<R: BufRead> Rows<R> {
    /// Reads the names of the columns; `path` is for messages.
    ///
    /// # Errors
    /// What cannot be read; columns that are not known, missing or named twice.
    pub fn new(path: impl Into<PathBuf>, input: R) -> Result<Self> {
        let mut lines = TextLines::new(path, input);
        lines.advance()?;
        let names: Vec<&str> = fields(lines.text().trim_start_matches('\u{FEFF}')).collect();
        // Every column once, and no other.
        let values = |columns: &[&str]| -> Option<Vec<usize>> {
            let all = columns.iter().all(|column| names.contains(column)) && names.len() == columns.len();
            names
                .iter()
                .map(|name| columns.iter().position(|column| column == name))
                .collect::<Option<_>>()
                .filter(|_| all)
        };
        let found = values(GRADIENT_COLUMNS).map(|values| (Columns::Gradient, values));
        match found.or_else(|| values(LEVEL_COLUMNS).map(|values| (Columns::Level, values))) {
            Some((columns, values)) => Ok(Self { lines, columns, values }),
            None => {
                let problem = format!("the columns are `{}`", names.join(","));
                Err(lines.error(problem, "name them u,v,lod or u,v,dudx,dvdx,dudy,dvdy, in any order"))
            }
        }
    }

    /// What the columns beside u and v are.
    #[must_use]
    pub const fn columns(&self) -> Columns {
        self.columns
    }

    /// Replaces `block` with the next rows, at most [`BLOCK`]; empty at the end.
    ///
    /// # Errors
    /// What cannot be read, or is no number, with its line.
    pub fn block(&mut self, block: &mut Vec<Row>) -> Result<()> {
        block.clear();
        while block.len() < BLOCK && self.lines.advance()? {
            if !self.lines.text().is_empty() {
                block.push(self.row().map_err(|problem| {
                    self.lines.error(problem, "give one number for each column of the first line")
                })?);
            }
        }
        Ok(())
    }

    /// The row of a line, or what is wrong with it.
    fn row(&self) -> Result<Row, String> {
        let columns = self.values.len();
        let mut values = [0.0f64; 6];
        let mut found = 0;
        for text in fields(self.lines.text()) {
            if let Some(&value) = self.values.get(found) {
                values[value] = text.parse().map_err(|_| {
                    let names = if self.columns == Columns::Level { LEVEL_COLUMNS } else { GRADIENT_COLUMNS };
                    format!("{} = `{text}` is not a number", names[value])
                })?;
            }
            found += 1;
        }
        if found != columns {
            return Err(format!("{found} values where {columns} columns are named"));
        }
        let [u, v, ux, vx, uy, vy] = values;
        let detail = match self.columns {
            Columns::Level => RowDetail::Level(ux),
            Columns::Gradient => RowDetail::Gradient(Gradient { ux, uy, vx, vy }),
        };
        Ok(Row { u, v, detail })
    }
}

/// The fields of a line of CSV.
fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(|field| field.trim().trim_matches('"').trim())
}
