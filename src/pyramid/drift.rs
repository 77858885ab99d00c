//! How rounding darkens or brightens a recursive pyramid, level by level (Flavell 1998; E16, X19).
//!
//! Works on square single-channel images of any depth, because Flavell's listings average 5- and 6-bit channels, where one
//! step is 8 or 4 times as visible as in 8 bits.

use serde::Serialize;

use super::{PlaneImage, halved};

/// How four neighbours become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Averaging {
    /// `sum >> 2`: Flavell's and Blow's listings.
    Truncate,
    /// `(sum + 2) >> 2`.
    HalfUp,
    /// To nearest, ties to even.
    HalfEven,
    /// `(a + b + 1) >> 1` along u, then along v: what a byte-average instruction does.
    TwoPassUp,
    /// Truncated, then Flavell's compensation as he words it, "a small amount to each color component at each LOD": one
    /// step, the smallest amount there is.
    TruncatePlusOne,
    /// Truncated, then one step at three levels of eight: 3/8 a level, the expected loss, as an integer adder can pay it.
    TruncatePlusExpected,
    /// Every level from the texture itself, one rounding, ties to even.
    FromTop,
}

impl Averaging {
    /// All rules, in the order tables show them.
    pub const ALL: [Self; 7] = [
        Self::Truncate,
        Self::HalfUp,
        Self::HalfEven,
        Self::TwoPassUp,
        Self::TruncatePlusOne,
        Self::TruncatePlusExpected,
        Self::FromTop,
    ];

    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Truncate => "truncate",
            Self::HalfUp => "half-up",
            Self::HalfEven => "half-even",
            Self::TwoPassUp => "two-pass half-up",
            Self::TruncatePlusOne => "truncate, +1 each level",
            Self::TruncatePlusExpected => "truncate, +3 in 8 levels",
            Self::FromTop => "from top, half-even",
        }
    }

    /// Four neighbours (two of one row, two of the next) into one, before clamping to the depth. `level` is that of the
    /// result, from 1. [`Self::FromTop`] is half-even here, one level being all this sees.
    #[must_use]
    pub const fn of(self, [a, b, c, d]: [u32; 4], level: u8) -> u32 {
        let sum = a + b + c + d;
        match self {
            Self::Truncate => sum >> 2,
            Self::HalfUp => (sum + 2) >> 2,
            Self::HalfEven | Self::FromTop => (sum + 1 + ((sum >> 2) & 1)) >> 2,
            Self::TwoPassUp => (((a + b + 1) >> 1) + ((c + d + 1) >> 1) + 1) >> 1,
            Self::TruncatePlusOne => (sum >> 2) + 1,
            Self::TruncatePlusExpected => {
                let owed = (3 * level as u32 + 4) / 8 - (3 * (level as u32 - 1) + 4) / 8;
                (sum >> 2) + owed
            }
        }
    }

    /// Mean error of one level in steps of the channel when the low bits of the four are uniform: exact, over all of them.
    /// For the compensation with a schedule, its mean over the eight levels of the schedule.
    #[must_use]
    pub fn expected_drift(self) -> f64 {
        if self == Self::FromTop {
            return 0.0;
        }
        let levels = if self == Self::TruncatePlusExpected { 8 } else { 1 };
        let mut error_in_quarters: i64 = 0;
        // Three low bits of the first, two of the others: a tie to even asks whether the sum is 2 or 6 modulo 8.
        for low in 0..512u32 {
            let four = [low & 7, low >> 3 & 3, low >> 5 & 3, low >> 7];
            for level in 1..=levels {
                error_in_quarters += 4 * i64::from(self.of(four, level)) - i64::from(four.iter().sum::<u32>());
            }
        }
        error_in_quarters as f64 / (4.0 * 512.0 * f64::from(levels))
    }
}

/// One channel of a square image whose side is a power of two.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Bits of a value, 1 to 8.
    pub bits: u8,
    side: usize,
    values: Vec<u32>,
}

impl Channel {
    /// Uniform noise from a fixed generator (xorshift, Marsaglia 2003).
    #[must_use]
    pub fn random(side: usize, bits: u8, seed: u64) -> Self {
        let mut state = seed | 1;
        let values = std::iter::repeat_with(|| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 40) as u32 & ((1 << bits) - 1)
        });
        Self { bits, side, values: values.take(side * side).collect() }
    }

    /// The green channel of a picture, its largest square with a power-of-two side from the upper left, cut to `bits`.
    #[must_use]
    pub fn of_image(image: &PlaneImage, bits: u8) -> Self {
        let side = 1usize << image.width.min(image.height).ilog2();
        let rows = image.texels.chunks_exact(image.width as usize).take(side);
        let values = rows.flat_map(|row| row[..side].iter().map(|texel| u32::from(texel[1] >> (8 - bits)))).collect();
        Self { bits, side, values }
    }

    /// Levels below this one, down to a single value.
    #[must_use]
    pub const fn last_level(&self) -> u8 {
        self.side.ilog2() as u8
    }

    /// Mean value, in steps of the channel.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|&value| u64::from(value)).sum::<u64>() as f64 / self.values.len() as f64
    }

    /// Mean of each level less the mean of this image, in steps, for levels 1 to `levels`.
    #[must_use]
    pub fn drift(&self, averaging: Averaging, levels: u8) -> Vec<f64> {
        let most = (1 << self.bits) - 1;
        let mean = self.mean();
        let mut above = self.clone();
        (1..=levels.min(self.last_level()))
            .map(|level| {
                let side = halved(self.side as u32, level) as usize;
                let values = if averaging == Averaging::FromTop {
                    self.averages(side)
                } else {
                    let four = |i: usize| {
                        let corner = 2 * (i / side) * above.side + 2 * (i % side);
                        [corner, corner + 1, corner + above.side, corner + above.side + 1].map(|at| above.values[at])
                    };
                    (0..side * side).map(|i| averaging.of(four(i), level).min(most)).collect()
                };
                above = Self { bits: self.bits, side, values };
                above.mean() - mean
            })
            .collect()
    }

    /// Averages over equal squares, half to even.
    fn averages(&self, side: usize) -> Vec<u32> {
        let run = self.side / side;
        let mut sums = vec![0u64; side * side];
        for (index, &value) in self.values.iter().enumerate() {
            sums[index / self.side / run * side + index % self.side / run] += u64::from(value);
        }
        let shift = 2 * run.ilog2();
        let half = (1u64 << shift) / 2;
        sums.iter().map(|&sum| ((sum + half - 1 + (sum >> shift & 1)) >> shift) as u32).collect()
    }
}
