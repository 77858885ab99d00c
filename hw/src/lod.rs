//! The LOD unit: from the bits of a squared scaling ratio to a level (docs/numerics.md, section 4).
//!
//! In: 32 bits of an f32, or an 8.8 level. Out: 8.8. Herf's four routines come first, exactly as printed in his memo
//! (Herf 1999, part 4); each names the inputs it answers wrongly. The unit below is built on the same idea, the exponent
//! field read as an integer logarithm, with the traps closed.

use crate::{
    log2_table::CELLS,
    sampler::{LevelRounding, Log2, Sampler},
};

/// Fraction bits of a level.
pub const LOD_BITS: u32 = 8;

/// `ilog2` as printed: integer log2 of a float, -127 for zero *and every denormal*, 128 for infinity and NaN. The sign is ignored.
///
/// ```
/// assert_eq!(texunit_hw::lod::ilog2(8.5f32.to_bits()), 3);
/// ```
#[must_use]
pub const fn ilog2(x: u32) -> i32 {
    ((x >> 23) & 0xFF) as i32 - 127
}

/// `ilog2clamp` as printed: `ilog2` clamped below at zero, for inputs without a sign bit.
///
/// The memo forgets to mask the sign (E5): -0.0 gives 129, -0.5 gives 255, -2.0 gives 0. Infinity and NaN give 128.
///
/// ```
/// use texunit_hw::lod::ilog2clamp;
/// assert_eq!(ilog2clamp(0.25f32.to_bits()), 0);
/// assert_eq!(ilog2clamp((-0.0f32).to_bits()), 129); // the trap
/// ```
#[must_use]
pub const fn ilog2clamp(x: u32) -> u32 {
    let exponent = (x >> 23).wrapping_sub(127);
    (!exponent >> 8) & exponent & 0xFF
}

/// `trival` as printed: the way to the next power of two in 1/256, for a ratio that is not squared; truncated mantissa.
///
/// Below 1.0 it still returns a fraction, though `ilog2clamp` says level 0 (E6).
///
/// ```
/// assert_eq!(texunit_hw::lod::trival(3.0f32.to_bits()), 128); // half way from 2 to 4
/// ```
#[must_use]
pub const fn trival(x: u32) -> u32 {
    (x >> 15) & 0xFF
}

/// `trivalsq` as printed: the way to the next level in 1/256 for a *squared* ratio, which spans two exponents a level; the
/// lowest exponent bit is the top bit of the fraction, inverted because the bias 127 is odd.
///
/// Below 1.0 it still returns a fraction: 0.0 gives 128, half a level of blur on a constant coordinate (E6).
///
/// ```
/// assert_eq!(texunit_hw::lod::trivalsq(2.0f32.to_bits()), 128); // ratio sqrt(2), half a level
/// assert_eq!(texunit_hw::lod::trivalsq(0.0f32.to_bits()), 128); // the trap
/// ```
#[must_use]
pub const fn trivalsq(x: u32) -> u32 {
    ((x >> 16) & 0xFF) ^ 0x80
}

/// The level of a squared ratio before bias and clamp, 8.8: section 4.1.
///
/// ```
/// use texunit_hw::{Log2, lod::raw_level};
/// assert_eq!(raw_level(16.0f32.to_bits(), Log2::Exact), 2 << 8); // 4 texels a pixel: level 2
/// assert_eq!(raw_level(f32::NAN.to_bits(), Log2::Exact), 64 << 8); // the coarsest there is
/// ```
#[inline]
#[must_use]
pub const fn raw_level(squared_ratio: u32, log2: Log2) -> i32 {
    let magnitude = squared_ratio & 0x7FFF_FFFF;
    let exponent = (magnitude >> 23) as i32;
    let mantissa = magnitude & 0x7F_FFFF;
    if exponent == 0xFF {
        return 128 << 7;
    }
    if exponent == 0 {
        return -127 << 7;
    }
    let octaves = exponent - 127;
    let start = octaves << 7;
    match log2 {
        Log2::Exact => start + exact_log2(mantissa),
        Log2::Table128 => start + exact_log2(middle_of_cell(mantissa, 7)),
        Log2::Table64 => start + exact_log2(middle_of_cell(mantissa, 6)),
        Log2::Table16 => start + exact_log2(middle_of_cell(mantissa, 4)),
        Log2::Quadratic => start + quadratic_log2(mantissa),
        Log2::Fourth => start + fourth_power_log2(mantissa),
        // The same bits as `ilog2clamp(x) / 2` and `trivalsq(x)` side by side: exponent and top 7 mantissa bits are one number.
        Log2::Herf => (magnitude >> 16) as i32 - (127 << 7),
        Log2::HerfPlain => plain_level(octaves, mantissa),
        Log2::Ilog2 => (octaves >> 1) << LOD_BITS,
    }
}

/// `log2(1.mantissa)` in 1/128, rounded to nearest.
#[inline]
const fn exact_log2(mantissa: u32) -> i32 {
    let cell = CELLS[(mantissa >> 15) as usize];
    (cell >> 24) as i32 + (mantissa >= (cell & 0xFF_FFFF)) as i32
}

/// The mantissa in the middle of its cell, of `2^log2_cells` cells. A table with one entry a cell holds the logarithms of
/// these; there is no need to store them a second time.
#[inline]
const fn middle_of_cell(mantissa: u32, log2_cells: u32) -> u32 {
    let half = (1 << 22) >> log2_cells;
    mantissa & !(2 * half - 1) | half
}

/// `y + 89/256 y (1 - y)` in 1/128, half up, of the top 12 mantissa bits.
#[inline]
const fn quadratic_log2(mantissa: u32) -> i32 {
    let y = (mantissa >> 11) as u64;
    (((y << 20) + 89 * y * (4096 - y) + (1 << 24)) >> 25) as i32
}

/// Exponent and mantissa of the square of 1.mantissa, in 1/64 octave of that square.
#[inline]
const fn fourth_power_log2(mantissa: u32) -> i32 {
    let significand = (1 << 23 | mantissa) as u64;
    let square = significand * significand;
    let carry = (square >> 47) as i32;
    (carry << 6) + (square >> (40 + carry)) as i32 - 64
}

/// What `ilog2` and `trival` say of the ratio, from its square: eight fraction bits of an integer square root.
#[inline]
const fn plain_level(octaves: i32, mantissa: u32) -> i32 {
    let significand = (1 << 23 | mantissa) << (octaves & 1);
    let root = (significand >> 7).isqrt() as i32;
    ((octaves >> 1) << LOD_BITS) + root - 256
}

/// What the clamp of the LOD unit is wired to, for one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelRange {
    pub(crate) bias: i32,
    pub(crate) low: i32,
    pub(crate) high: i32,
    /// The last level.
    pub last: u8,
    /// Half of the last fraction bit that is kept, and the bits that are kept.
    pub(crate) half: i32,
    pub(crate) mask: i32,
}

impl LevelRange {
    /// For a sampler and the last level of the chain.
    #[must_use]
    pub const fn new(sampler: &Sampler, last: u8) -> Self {
        let end = (last as i32) << LOD_BITS;
        let high = if sampler.max_lod < end { sampler.max_lod } else { end };
        let low = if sampler.min_lod > 0 { sampler.min_lod } else { 0 };
        let dropped = LOD_BITS - sampler.lod_bits as u32;
        Self { bias: sampler.bias as i32, low, high, last, half: (1 << dropped) >> 1, mask: !((1 << dropped) - 1) }
    }

    /// Bias and clamp: section 4.2, steps 1 and 2.
    #[inline]
    #[must_use]
    pub const fn clamp(&self, raw: i32) -> i32 {
        let level = raw.saturating_add(self.bias);
        let level = if level < self.low { self.low } else { level };
        if level > self.high { self.high } else { level }
    }

    /// The clamped level at the machine's fraction width: step 3.
    #[inline]
    #[must_use]
    pub const fn fractional(&self, raw: i32) -> i32 {
        let rounded = (self.clamp(raw) + self.half) & self.mask;
        let end = (self.last as i32) << LOD_BITS;
        if rounded > end { end } else { rounded }
    }

    /// One whole level.
    #[inline]
    #[must_use]
    pub const fn whole(&self, raw: i32, rounding: LevelRounding) -> i32 {
        let added = match rounding {
            LevelRounding::Floor => 0,
            LevelRounding::Nearest => 128,
            LevelRounding::Gl => 127,
        };
        let level = (self.clamp(raw) + added) >> LOD_BITS;
        if level > self.last as i32 { self.last as i32 } else { level }
    }
}
