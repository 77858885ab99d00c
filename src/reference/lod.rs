//! Level of detail (docs/numerics.md, section 4), in levels: 0.0 is the texture itself, one more halves it.
//!
//! # Why the exact logarithm is safe in f64
//!
//! The page defines `g(m) = floor(128 log2(1 + m/2^23) + 1/2)`, and `128 (e - 127)` is an integer, so the raw level of a
//! squared ratio `s` is `floor(128 log2 s + 1/2)` in 1/256 level. The floor is decided wrongly only if `s` lies nearer to a
//! boundary `2^((2k-1)/256)` than the error of the logarithm. The boundaries are irrational, so no f32 lies on one. Neighbouring
//! mantissas are 1.1e-5 or more apart on the scale of `128 log2`, and of all 2^23 of them the nearest to a boundary is 4.27e-8
//! away (the test `no_mantissa_is_near_a_boundary_of_the_logarithm` measures it). `libm::log2` (FreeBSD's `e_log2.c`) errs by
//! less than one unit in the last place, which for `|log2 s| <= 128` is 2^-46; times 128, and with the rounding of the
//! addition of 1/2, that is under 2^-37 = 7.3e-12: more than three orders of magnitude less.

use texunit_hw::{LevelRounding, LodSource, Log2};

use super::coordinate::{Grid, floor};

/// Units of an 8.8 level in one level.
pub const LEVEL: f64 = 256.0;

/// The raw level of an infinite or undefined ratio: coarser than any plane whatever the bias.
const COARSEST: f64 = 64.0;
/// The raw level of a ratio of zero: finer than any plane whatever the bias.
const FINEST: f64 = -63.5;

/// A level from its 8.8 integer.
#[must_use]
pub fn from_8_8(fixed: i32) -> f64 {
    f64::from(fixed) / LEVEL
}

/// What a request asks for, before bias and limits: section 4.1.
#[inline]
#[must_use]
pub fn raw(scale: u32, source: LodSource, log2: Log2) -> f64 {
    match source {
        LodSource::Explicit => from_8_8(scale as i32),
        LodSource::Gradient => of_squared_ratio(f32::from_bits(scale), log2),
    }
}

#[inline]
fn of_squared_ratio(squared: f32, log2: Log2) -> f64 {
    if !squared.is_finite() {
        return COARSEST;
    }
    if squared.abs() < f32::MIN_POSITIVE {
        return FINEST;
    }
    let squared = f64::from(squared.abs());
    let (octave, significand) = octave_and_mantissa(squared);
    let x = significand - 1.0;
    let beyond_octave = match log2 {
        Log2::Exact => return floor(128.0 * libm::log2(squared) + 0.5) / LEVEL,
        Log2::Table128 => table(x, 128.0),
        Log2::Table64 => table(x, 64.0),
        Log2::Table16 => table(x, 16.0),
        Log2::Quadratic => {
            let y = floor(x * 4096.0) / 4096.0;
            floor(128.0 * (y + 89.0 / 256.0 * y * (1.0 - y)) + 0.5)
        }
        Log2::Fourth => {
            let p = significand * significand;
            if p < 2.0 { floor(64.0 * (p - 1.0)) } else { 64.0 + floor(64.0 * (p / 2.0 - 1.0)) }
        }
        Log2::Herf => floor(128.0 * x),
        // The square root is exact or, 24 bits being few, farther from any 1/256 than its rounding.
        Log2::HerfPlain => {
            let level = floor(octave / 2.0);
            let ratio = libm::sqrt(squared) / libm::exp2(level);
            return level + floor(LEVEL * (ratio - 1.0)) / LEVEL;
        }
        Log2::Ilog2 => return floor(octave / 2.0),
    };
    (128.0 * octave + beyond_octave) / LEVEL
}

/// The entry of a table of the logarithm. The middles of cells are mantissas, so what the module says of all those holds.
fn table(x: f64, entries: f64) -> f64 {
    let middle = (2.0 * floor(entries * x) + 1.0) / (2.0 * entries);
    floor(128.0 * libm::log2(1.0 + middle) + 0.5)
}

/// `x = mantissa * 2^octave` with the mantissa in `[1, 2)`.
fn octave_and_mantissa(x: f64) -> (f64, f64) {
    let (half_mantissa, exponent) = libm::frexp(x);
    (f64::from(exponent) - 1.0, 2.0 * half_mantissa)
}

/// What keeps a level within the pyramid and the sampler's range: section 4.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Added first, in levels.
    pub bias: f64,
    /// Smallest level.
    pub min_lod: f64,
    /// Largest level; wins over the smallest.
    pub max_lod: f64,
    /// The coarsest plane there is, a whole number.
    pub coarsest: f64,
    /// The fractions there are between two levels; none for the real numbers.
    pub fractions: Option<Grid>,
}

impl Limits {
    /// The range a sampler allows, of a pyramid without end.
    #[must_use]
    pub fn new(bias: f64, min_lod: f64, max_lod: f64, fractions: Option<Grid>) -> Self {
        Self { bias, min_lod, max_lod, coarsest: f64::INFINITY, fractions }
    }

    /// Steps 1 and 2: a level that the pyramid has.
    #[must_use]
    pub fn clamp(&self, raw: f64) -> f64 {
        (raw + self.bias).max(self.min_lod.max(0.0)).min(self.max_lod.min(self.coarsest))
    }

    /// Steps 1 to 3: rounded, half up, to what the level fraction can hold.
    #[must_use]
    pub fn fractional(&self, raw: f64) -> f64 {
        let level = self.clamp(raw);
        self.fractions.map_or(level, |grid| grid.nearest(level).min(self.coarsest))
    }

    /// The whole level of filters that read one.
    #[must_use]
    pub fn whole_level(&self, raw: f64, rounding: LevelRounding) -> f64 {
        let level = self.clamp(raw);
        let whole = match rounding {
            LevelRounding::Floor => floor(level),
            LevelRounding::Nearest => floor(level + 0.5),
            LevelRounding::Gl => -floor(-level - 0.5) - 1.0, // ceil(level + 1/2) - 1
        };
        whole.min(self.coarsest)
    }
}
