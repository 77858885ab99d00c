//! How far each log2 unit is from the logarithm: over every mantissa, and over a sweep as others have measured it.

use rayon::prelude::*;
use texunit_hw::{Log2, lod::raw_level};

use crate::names::Named;

/// Least, greatest and mean error, in levels; positive is blurrier than it should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LodError {
    /// The sharpest it ever is.
    pub least: f64,
    /// The blurriest.
    pub greatest: f64,
    /// Mean over ratios that are uniform in their logarithm.
    pub mean: f64,
}

impl LodError {
    /// The larger magnitude.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.greatest.max(-self.least)
    }
}

/// A sum of errors, each with its weight.
#[derive(Clone, Copy)]
struct Sum {
    least: f64,
    greatest: f64,
    weighted: f64,
    weights: f64,
}

impl Sum {
    const NONE: Self = Self { least: f64::INFINITY, greatest: f64::NEG_INFINITY, weighted: 0.0, weights: 0.0 };

    fn add(&mut self, error: f64, weight: f64) {
        self.least = self.least.min(error);
        self.greatest = self.greatest.max(error);
        self.weighted += weight * error;
        self.weights += weight;
    }

    fn merge(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            greatest: self.greatest.max(other.greatest),
            weighted: self.weighted + other.weighted,
            weights: self.weights + other.weights,
        }
    }

    fn error(self) -> LodError {
        LodError { least: self.least, greatest: self.greatest, mean: self.weighted / self.weights }
    }
}

/// One unit, measured.
#[derive(Clone, Copy, Debug)]
pub struct Rung {
    /// The unit.
    pub log2: Log2,
    /// As the chip does it, over all mantissas of two octaves.
    pub exhaustive: LodError,
    /// The same over a log-uniform sweep of ratios from 1 to 4096.
    pub sweep: LodError,
    /// The idea behind it, without the widths of the chip, over all mantissas.
    pub unrounded: LodError,
}

/// Mantissas of a binade.
const MANTISSAS: u32 = 1 << 23;
/// Mantissas a task takes; sums are merged in their order, so the result does not depend on the number of threads.
const TASK: u32 = 1 << 16;
/// Points of the sweep.
const SWEEP: u32 = 1 << 21;

/// Measures every unit, in the order they are listed to a user.
#[must_use]
pub fn measure() -> Vec<Rung> {
    let units: Vec<Log2> = Log2::ALL.iter().map(|(_, log2)| *log2).collect();
    let merge = |mut sums: Vec<Sum>, more: Vec<Sum>| {
        for (sum, more) in sums.iter_mut().zip(more) {
            *sum = sum.merge(more);
        }
        sums
    };
    let none = || vec![Sum::NONE; 2 * units.len()];
    let tasks: Vec<Vec<Sum>> = (0..MANTISSAS / TASK)
        .into_par_iter()
        .map(|task| of_mantissas(&units, task * TASK..(task + 1) * TASK))
        .collect();
    let sums = tasks.into_iter().fold(none(), merge);
    let tasks: Vec<Vec<Sum>> =
        (0..SWEEP / TASK).into_par_iter().map(|task| of_sweep(&units, task * TASK..(task + 1) * TASK)).collect();
    let swept = tasks.into_iter().fold(vec![Sum::NONE; units.len()], merge);
    let rung = |(number, &log2): (usize, &Log2)| Rung {
        log2,
        exhaustive: sums[2 * number].error(),
        unrounded: sums[2 * number + 1].error(),
        sweep: swept[number].error(),
    };
    units.iter().enumerate().map(rung).collect()
}

/// Two sums a unit: as the chip does it, and unrounded.
fn of_mantissas(units: &[Log2], mantissas: std::ops::Range<u32>) -> Vec<Sum> {
    let mut sums = vec![Sum::NONE; 2 * units.len()];
    for mantissa in mantissas {
        let significand = 1.0 + f64::from(mantissa) / f64::from(MANTISSAS);
        let logarithm = libm::log2(significand);
        // Uniform in the logarithm is inverse to the value.
        let weight = 1.0 / significand;
        for octave in [0.0, 1.0] {
            let level = f64::midpoint(logarithm, octave);
            let bits = (127 + octave as u32) << 23 | mantissa;
            for (&log2, sums) in units.iter().zip(sums.chunks_exact_mut(2)) {
                sums[0].add(f64::from(raw_level(bits, log2)) / 256.0 - level, weight);
                sums[1].add(unrounded(log2, significand, octave, level) - level, weight);
            }
        }
    }
    sums
}

fn of_sweep(units: &[Log2], points: std::ops::Range<u32>) -> Vec<Sum> {
    let mut sums = vec![Sum::NONE; units.len()];
    for point in points {
        let squared = libm::exp2(24.0 * (f64::from(point) + 0.5) / f64::from(SWEEP)) as f32;
        let level = libm::log2(f64::from(squared)) / 2.0;
        for (&log2, sum) in units.iter().zip(&mut sums) {
            sum.add(f64::from(raw_level(squared.to_bits(), log2)) / 256.0 - level, 1.0);
        }
    }
    sums
}

/// The level of a squared ratio `significand * 2^octave`, octave 0 or 1, by the idea of each unit.
fn unrounded(log2: Log2, significand: f64, octave: f64, exact: f64) -> f64 {
    let x = significand - 1.0;
    let table = |entries: f64| libm::log2(1.0 + ((x * entries).floor() + 0.5) / entries);
    let of_octave = match log2 {
        Log2::Exact => return exact,
        Log2::Ilog2 => return 0.0,
        Log2::HerfPlain => return libm::sqrt(significand * (1.0 + octave)) - 1.0,
        Log2::Table128 => table(128.0),
        Log2::Table64 => table(64.0),
        Log2::Table16 => table(16.0),
        Log2::Quadratic => x + 0.347 * x * (1.0 - x),
        Log2::Fourth => {
            let square = significand * significand;
            (if square < 2.0 { square - 1.0 } else { square / 2.0 }) / 2.0
        }
        Log2::Herf => x,
    };
    f64::midpoint(octave, of_octave)
}

/// What was published of a unit, in levels.
#[derive(Clone, Copy, Debug)]
pub struct Published {
    /// The largest magnitude of the error.
    pub worst: f64,
    /// Its mean, where there is one.
    pub mean: Option<f64>,
    /// The same with the result truncated to 8 bits.
    pub eight_bits: Option<[f64; 2]>,
    /// Where.
    pub source: &'static str,
}

/// The numbers others give for the idea behind a unit.
#[must_use]
pub const fn published(log2: Log2) -> Option<Published> {
    let (worst, mean, eight_bits, source) = match log2 {
        Log2::HerfPlain => {
            (0.0861, Some(-0.0573), Some([0.0900, -0.0593]), "Herf's trival; llvmpipe and angrylion on the ratio")
        }
        Log2::Herf => (0.0430, Some(-0.0287), Some([0.0469, -0.0306]), "Herf's trivalsq; llvmpipe on the square"),
        Log2::Fourth => (0.0215, Some(-0.0143), None, "SwiftShader"),
        Log2::Quadratic => (0.0039, None, None, "m + 0.347 m (1 - m) of the square"),
        // Given for a ratio: half of it where the table is read with the square.
        Log2::Table16 => (0.044 / 2.0, None, None, "16 entries, read with the square"),
        Log2::Table64 => (0.013 / 2.0, None, None, "64 entries, read with the square, 8 bits"),
        Log2::Table128 => (0.007 / 2.0, None, None, "128 entries, read with the square, 8 bits"),
        Log2::Exact | Log2::Ilog2 => return None,
    };
    Some(Published { worst, mean, eight_bits, source })
}
