//! Weights and roundings.

/// What a fraction `f` of `b` bits weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weights {
    /// `f` of `2^b`, the other texel the rest.
    Binary,
    /// `f` of `2^b - 1`: all ones is the next texel, and `x / (2^b - 1)` is `(x + x >> b) >> b` (Vortex; Blinn's rounding).
    OfOnes,
    /// `f` of `2^b`, the other texel the complement `2^b - 1 - f`, but `2^b` where `f` is 0 (gplgpu).
    Complement,
    /// `f` of `2^b`, the other texel always the complement: the sum is one too small (SwiftShader).
    AlwaysComplement,
}

/// Where a tap is rounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// The exact sum, half up.
    Once,
    /// The exact sum, cut off.
    OnceTruncate,
    /// Every lerp, half up: along u, then along v.
    Staged,
    /// Every lerp, cut off.
    StagedTruncate,
    /// Every product of two numbers keeps its upper half only: of two weights, and of a weight and a texel (SwiftShader's `MulHigh`).
    UpperHalves,
}

impl Weights {
    /// Of the first and of the second texel, `bits` wide.
    pub(super) const fn pair(self, f: u32, bits: u32) -> [u64; 2] {
        let f = f as u64;
        let one = 1_u64 << bits;
        match self {
            Self::Binary => [one - f, f],
            Self::Complement if f == 0 => [one, 0],
            Self::OfOnes | Self::Complement | Self::AlwaysComplement => [one - 1 - f, f],
        }
    }
}

/// From `a` to `b` at `f` of `bits`.
pub(super) const fn lerp(a: u64, b: u64, f: u32, bits: u32, weights: Weights, rounding: Rounding) -> u64 {
    let [first, second] = weights.pair(f, bits);
    if matches!(rounding, Rounding::UpperHalves) {
        return ((a * first) >> bits) + ((b * second) >> bits);
    }
    let half = if matches!(rounding, Rounding::Once | Rounding::Staged) { 1 << (bits - 1) } else { 0 };
    let sum = a * first + b * second + half;
    if matches!(weights, Weights::OfOnes) { (sum + (sum >> bits)) >> bits } else { sum >> bits }
}

/// Four texels.
pub(super) const fn square(
    corners: [u64; 4],
    [f, g]: [u32; 2],
    bits: u32,
    weights: Weights,
    rounding: Rounding,
) -> u64 {
    let [c00, c10, c01, c11] = corners;
    let [f1, f2] = weights.pair(f, bits);
    let [g1, g2] = weights.pair(g, bits);
    match rounding {
        Rounding::Staged | Rounding::StagedTruncate => {
            let top = lerp(c00, c10, f, bits, weights, rounding);
            let bottom = lerp(c01, c11, f, bits, weights, rounding);
            lerp(top, bottom, g, bits, weights, rounding)
        }
        Rounding::Once | Rounding::OnceTruncate => {
            let sum = (c00 * f1 + c10 * f2) * g1 + (c01 * f1 + c11 * f2) * g2;
            let half = if matches!(rounding, Rounding::Once) { 1 << (2 * bits - 1) } else { 0 };
            (sum + half) >> (2 * bits)
        }
        Rounding::UpperHalves => {
            let weights = [(f1 * g1) >> bits, (f2 * g1) >> bits, (f1 * g2) >> bits, (f2 * g2) >> bits];
            ((c00 * weights[0]) >> bits)
                + ((c10 * weights[1]) >> bits)
                + ((c01 * weights[2]) >> bits)
                + ((c11 * weights[3]) >> bits)
        }
    }
}

/// The three texels of the triangle the place lies in: the upper left one, or the lower right one from the diagonal on; half up.
pub(super) const fn triangle(corners: [u64; 4], [f, g]: [u32; 2], bits: u32) -> u64 {
    let [c00, c10, c01, c11] = corners;
    let [base, right, down, f, g] = if f + g < 1 << bits {
        [c00, c10, c01, f as u64, g as u64]
    } else {
        [c11, c01, c10, (1 << bits) - f as u64, (1 << bits) - g as u64]
    };
    let rise = f as i64 * (right as i64 - base as i64) + g as i64 * (down as i64 - base as i64);
    (base as i64 + ((rise + (1 << (bits - 1))) >> bits)) as u64
}
