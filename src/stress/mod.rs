//! The extreme inputs of the design (X1 to X23): what a careless unit answers, what this one answers, what is right.
//!
//! A careless answer is computed, by the code somebody might have written. A case fails if one of ours is farther from the
//! ideal than it allows, or if none of the careless ones is: then it would show nothing.

mod alpha;
mod anisotropy;
mod coordinates;
mod differencing;
mod horizon;
mod lab;
mod levels;
mod pipeline;
mod pyramids;
mod shapes;
mod widths;

use std::str::FromStr;

use serde::Serialize;
use serde_json::{Value, json};

use crate::error::Result;

/// One input.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What goes in.
    pub input: String,
    /// What the answers are in: LSB of an 8-bit channel, level, texel, ...
    pub unit: &'static str,
    /// What the careless unit says.
    pub careless: f64,
    /// What this one says.
    pub ours: f64,
    /// What is right.
    pub ideal: f64,
    /// How far ours may be from it.
    pub allowed: f64,
}

/// Steps of an 8-bit channel.
const LSB: &str = "LSB";
/// Levels of detail.
const LEVEL: &str = "level";
/// Texels of level 0.
const TEXEL: &str = "texel";

impl Row {
    /// How far the careless answer is from the ideal.
    #[must_use]
    pub fn careless_error(&self) -> f64 {
        (self.careless - self.ideal).abs()
    }

    /// How far ours is.
    #[must_use]
    pub fn error(&self) -> f64 {
        (self.ours - self.ideal).abs()
    }

    /// Whether ours is near enough; what is not a number never is.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.error() <= self.allowed
    }

    /// Whether the careless answer is not.
    #[must_use]
    pub fn shows_carelessness(&self) -> bool {
        self.careless_error() > self.allowed || self.careless.is_nan()
    }
}

/// A fixed-point format of coordinates, for instance 9.23: one sign bit among the integer bits.
///
/// ```
/// use texunit::stress::Q;
/// let q: Q = "9.23".parse().unwrap();
/// assert_eq!((q.integer, q.fraction), (9, 23));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Q {
    /// Bits before the point.
    pub integer: u32,
    /// Bits behind it.
    pub fraction: u32,
}

impl FromStr for Q {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.split_once('.')
            .and_then(|(integer, fraction)| {
                Some(Self { integer: integer.parse().ok()?, fraction: fraction.parse().ok()? })
            })
            .filter(|q| (1..=32).contains(&q.integer) && (1..=40).contains(&q.fraction))
            .ok_or_else(|| {
                "write integer.fraction bits, 1 to 32 before the point and 1 to 40 behind it, for instance 9.23".into()
            })
    }
}

impl std::fmt::Display for Q {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.integer, self.fraction)
    }
}

/// What a user can choose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Wider internal formats that X10 tries.
    pub formats: Vec<Q>,
}

impl Default for Options {
    fn default() -> Self {
        Self { formats: vec![Q { integer: 9, fraction: 23 }, Q { integer: 12, fraction: 32 }] }
    }
}

/// An extreme.
#[derive(Clone, Copy)]
pub struct Case {
    /// X1 to X23.
    pub name: &'static str,
    /// What is extreme.
    pub title: &'static str,
    /// What goes wrong in a careless unit.
    pub wrong: &'static str,
    run: fn(&Options) -> Result<Vec<Row>>,
}

/// What a case came to.
#[derive(Clone, Debug)]
pub struct Finding {
    /// X1 to X23.
    pub name: &'static str,
    /// What is extreme.
    pub title: &'static str,
    /// What goes wrong in a careless unit.
    pub wrong: &'static str,
    /// Its inputs.
    pub rows: Vec<Row>,
}

impl Finding {
    /// Whether every answer of ours is near enough, and some careless one is not.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.rows.iter().all(Row::passes) && self.rows.iter().any(Row::shows_carelessness)
    }

    /// The largest error of ours in a unit, if a row has it.
    #[must_use]
    pub fn worst(&self, unit: &str) -> Option<f64> {
        self.rows.iter().filter(|row| row.unit == unit).map(Row::error).reduce(f64::max)
    }

    /// Everything, for stress.json; infinities and what is not a number become words.
    #[must_use]
    pub fn json(&self) -> Value {
        let number = |value: f64| if value.is_finite() { json!(value) } else { json!(value.to_string()) };
        let row = |row: &Row| {
            json!({
                "input": row.input, "unit": row.unit, "careless": number(row.careless), "ours": number(row.ours),
                "ideal": number(row.ideal), "careless_error": number(row.careless_error()), "error": number(row.error()),
                "allowed": number(row.allowed), "passes": row.passes(),
            })
        };
        let rows: Vec<Value> = self.rows.iter().map(row).collect();
        json!({
            "case": self.name, "title": self.title, "wrong": self.wrong, "passes": self.passes(),
            "worst_lsb": self.worst(LSB).map(number), "worst_level": self.worst(LEVEL).map(number), "rows": rows,
        })
    }
}

impl Case {
    /// Tries it.
    ///
    /// # Errors
    /// A texture or machine that cannot be built: a fault of the case.
    pub fn run(&self, options: &Options) -> Result<Finding> {
        let Self { name, title, wrong, run } = *self;
        Ok(Finding { name, title, wrong, rows: run(options)? })
    }
}

/// Every case, by number.
///
/// ```
/// use texunit::stress::{CASES, Options};
/// let wrap = CASES.iter().find(|case| case.name == "X9").unwrap().run(&Options::default())?;
/// assert!(wrap.passes());
/// # Ok::<(), texunit::error::Error>(())
/// ```
pub const CASES: [Case; 23] = [
    horizon::RECIPROCAL,
    horizon::BEHIND,
    horizon::RATE,
    differencing::PERSPECTIVE,
    differencing::AFFINE,
    anisotropy::MILLION,
    coordinates::FAR,
    coordinates::FLOATS,
    coordinates::NEGATIVE,
    widths::FILTER_BITS,
    shapes::ROWS,
    shapes::ONE_TEXEL,
    shapes::ODD,
    shapes::HUGE,
    levels::WHOLE,
    levels::SPECIAL,
    alpha::CLIP_EDGE,
    pipeline::DEADLOCK,
    pyramids::DRIFT,
    pyramids::SUMS,
    levels::OVERFLOW,
    levels::BEYOND,
    levels::BIAS,
];

/// A summary to go beside the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Summary {
    /// Cases tried.
    pub cases: usize,
    /// Those that failed.
    pub failed: usize,
}

impl Summary {
    /// Of some findings.
    #[must_use]
    pub fn of(findings: &[Finding]) -> Self {
        Self { cases: findings.len(), failed: findings.iter().filter(|finding| !finding.passes()).count() }
    }
}

/// An answer in a table: four digits that count, or all of a whole number.
///
/// ```
/// use texunit::stress::shown;
/// assert_eq!([0.585_94, 0.0, 4_294_967_296.0, 1.5e-9].map(shown), ["0.5859", "0", "4294967296", "1.50e-9"]);
/// ```
#[must_use]
pub fn shown(value: f64) -> String {
    let magnitude = value.abs();
    if !value.is_finite() || value == 0.0 {
        value.to_string()
    } else if value.fract() == 0.0 && magnitude < 1e15 {
        format!("{value:.0}")
    } else if !(1e-3..1e6).contains(&magnitude) {
        format!("{value:.2e}")
    } else {
        let digits = (3 - libm::floor(libm::log10(magnitude)) as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    }
}
