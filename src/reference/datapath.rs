//! Weighing the texels (docs/numerics.md, section 6). Fractions and weights are real numbers here, so one texel is worth
//! the same at every stage and no stage shifts.

use super::coordinate::floor;

/// Four texels in the order of section 5, the fractions between them and what the tap counts for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// (i0, j0), (i1, j0), (i0, j1), (i1, j1).
    pub texels: [[u8; 4]; 4],
    /// How far from i0 to i1 and from j0 to j1, in `[0, 1)`.
    pub fraction: [f64; 2],
    /// The weights of one request sum to 1.
    pub weight: f64,
}

impl Tap {
    #[inline]
    fn values(&self) -> [[f64; 4]; 4] {
        let mut values = [[0.0; 4]; 4];
        for (value, texel) in values.as_flattened_mut().iter_mut().zip(self.texels.as_flattened()) {
            *value = f64::from(*texel);
        }
        values
    }
}

/// The weighted sum, not rounded.
#[inline]
#[must_use]
pub fn sum(taps: &[Tap]) -> [f64; 4] {
    let mut total = [0.0; 4];
    for tap in taps {
        let [f, g] = tap.fraction;
        let [c00, c10, c01, c11] = tap.values();
        let [w00, w10, w01, w11] = [(1.0 - f) * (1.0 - g), f * (1.0 - g), (1.0 - f) * g, f * g];
        for channel in 0..4 {
            let value = c00[channel] * w00 + c10[channel] * w10 + c01[channel] * w01 + c11[channel] * w11;
            total[channel] += tap.weight * value;
        }
    }
    total
}

/// One rounding at the very end, half up. Exact: a sum has 8 integer and at most 2 * 12 + 8 fraction bits.
#[inline]
#[must_use]
pub fn once(taps: &[Tap]) -> [u8; 4] {
    sum(taps).map(|value| whole(value + 0.5))
}

/// A rounding after every lerp and after the sum of the taps: `half` is 0.5 to round half up, 0.0 to truncate.
#[inline]
#[must_use]
pub fn staged(taps: &[Tap], half: f64) -> [u8; 4] {
    let lerp = |a: [f64; 4], b: [f64; 4], f: f64| -> [f64; 4] {
        let mut value = [0.0; 4];
        for channel in 0..4 {
            value[channel] = floor(a[channel] * (1.0 - f) + b[channel] * f + half);
        }
        value
    };
    let mut total = [half; 4];
    for tap in taps {
        let [c00, c10, c01, c11] = tap.values();
        let [f, g] = tap.fraction;
        let value = lerp(lerp(c00, c10, f), lerp(c01, c11, f), g);
        for channel in 0..4 {
            total[channel] += tap.weight * value[channel];
        }
    }
    // Where the weights are whole the sum is whole already, and the half changes nothing.
    total.map(whole)
}

/// The 8 bits of a value of 0 to 255 and a fraction.
fn whole(value: f64) -> u8 {
    value as i32 as u8
}
