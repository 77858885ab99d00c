//! What other machines take for a logarithm.

use super::LEVEL_BITS;

/// Fraction bits of an f32's significand.
const SIGNIFICAND_BITS: u32 = 23;

/// How the bits between two powers of two are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Logarithm {
    /// Not at all: whole levels.
    Whole,
    /// The significand as it is: `log2(1 + x)` is taken for `x`.
    Linear,
    /// A table of `2^index` entries of `entry` bits, `log2` at the left end of each cell, cut off.
    TableFloor {
        /// log2 of the entries.
        index: u32,
        /// Bits of an entry.
        entry: u32,
    },
    /// A table of `2^index` entries and one more, of [`LEVEL_BITS`], read at the nearest.
    TableNearest {
        /// log2 of the cells.
        index: u32,
    },
    /// The logarithm, to [`LEVEL_BITS`].
    Exact,
}

/// The unit that turns a ratio into a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelUnit {
    /// The ratio is squared so often before its logarithm is read, which is then halved as often.
    pub squarings: u32,
    /// The logarithm.
    pub logarithm: Logarithm,
    /// Fraction bits of a level, at most [`LEVEL_BITS`]; what is below is cut off.
    pub bits: u32,
    /// Whether it is rounded to nearest, half up, instead.
    pub nearest: bool,
}

impl LevelUnit {
    /// The level of a ratio, an f32 pattern: signed, with [`LEVEL_BITS`].
    ///
    /// Zero, and what squares to less than any normal number, is the finest there is; infinity and NaN are the coarsest.
    ///
    /// ```
    /// use texunit_hw::peers::{LEVEL_BITS, LevelUnit, Logarithm};
    /// let plain = LevelUnit { squarings: 0, logarithm: Logarithm::Linear, bits: LEVEL_BITS, nearest: false };
    /// assert_eq!(plain.level(6.0_f32.to_bits()), (2 << LEVEL_BITS) + (1 << (LEVEL_BITS - 1))); // 2.5 for log2(6) = 2.585
    /// ```
    #[must_use]
    pub const fn level(&self, ratio: u32) -> i64 {
        let mut power = ratio & 0x7FFF_FFFF;
        let mut squaring = 0;
        while squaring < self.squarings {
            power = squared(power);
            squaring += 1;
        }
        let level = self.of_power(power) >> self.squarings;
        let drop = LEVEL_BITS - self.bits;
        let half = if self.nearest { (1 << drop) >> 1 } else { 0 };
        ((level + half) >> drop) << drop
    }

    const fn of_power(&self, power: u32) -> i64 {
        let exponent = (power >> SIGNIFICAND_BITS) as i64;
        let significand = power & ((1 << SIGNIFICAND_BITS) - 1);
        let whole = match exponent {
            0 => return -(127 << LEVEL_BITS),
            255 => return 127 << LEVEL_BITS,
            _ => (exponent - 127) << LEVEL_BITS,
        };
        whole
            + match self.logarithm {
                Logarithm::Whole => 0,
                Logarithm::Linear => (significand >> (SIGNIFICAND_BITS - LEVEL_BITS)) as i64,
                Logarithm::TableFloor { index, entry } => {
                    let cell = significand >> (SIGNIFICAND_BITS - index) << (SIGNIFICAND_BITS - index);
                    (logarithm(cell) >> (32 - entry) << (LEVEL_BITS - entry)) as i64
                }
                Logarithm::TableNearest { index } => {
                    let drop = SIGNIFICAND_BITS - index;
                    rounded(logarithm(((significand + (1 << (drop - 1))) >> drop) << drop))
                }
                Logarithm::Exact => rounded(logarithm(significand)),
            }
    }
}

/// Of 32 bits the upper [`LEVEL_BITS`], half up.
const fn rounded(logarithm: u64) -> i64 {
    ((logarithm + (1 << (31 - LEVEL_BITS))) >> (32 - LEVEL_BITS)) as i64
}

/// `log2(1 + significand / 2^23)` with 32 fraction bits, cut off: square, note whether it passed 2, halve. 1.0 for a significand of 2^23.
const fn logarithm(significand: u32) -> u64 {
    // 1.63, so that 32 squarings err by less than the last of 32 bits.
    let mut x = ((1 << SIGNIFICAND_BITS) + significand as u64) << (63 - SIGNIFICAND_BITS);
    if significand == 1 << SIGNIFICAND_BITS {
        return 1 << 32;
    }
    let mut result = 0;
    let mut bit = 0;
    while bit < 32 {
        let square = (x as u128 * x as u128) >> 63;
        result <<= 1;
        if square >> 64 == 1 {
            result |= 1;
            x = (square >> 1) as u64;
        } else {
            x = square as u64;
        }
        bit += 1;
    }
    result
}

/// The square of a positive f32, to nearest, ties to even, in its pattern; below the normal numbers zero, above infinity.
const fn squared(power: u32) -> u32 {
    let exponent = (power >> SIGNIFICAND_BITS) as i32;
    if exponent == 0 {
        return 0;
    }
    if exponent == 255 {
        return power;
    }
    let significand = (1 << SIGNIFICAND_BITS | power & ((1 << SIGNIFICAND_BITS) - 1)) as u64;
    let product = significand * significand;
    let carry = (product >> (2 * SIGNIFICAND_BITS + 1)) as i32;
    let drop = SIGNIFICAND_BITS + carry as u32;
    let kept = product >> drop;
    let below = product & ((1 << drop) - 1);
    let half = 1 << (drop - 1);
    let up = below > half || below == half && kept & 1 == 1;
    let exponent = 2 * (exponent - 127) + carry + 127;
    if exponent < 1 {
        return 0;
    }
    if exponent > 254 {
        return 0x7F80_0000;
    }
    // A carry out of the significand goes on into the exponent, as it should.
    ((exponent as u32) << SIGNIFICAND_BITS) + (kept as u32 & ((1 << SIGNIFICAND_BITS) - 1)) + up as u32
}
