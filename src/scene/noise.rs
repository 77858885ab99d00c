//! Noise that is the same on every machine: integers in, a hash, and only arithmetic after it.

use super::whole::whole;

/// Two rounds of the "lowbias32" finaliser.
#[inline]
fn mix(mut bits: u32) -> u32 {
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x7FEB_352D);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x846C_A68B);
    bits ^ (bits >> 16)
}

/// What a hash of two integers and a seed makes of the second and the seed: for one such pair and many first integers.
#[derive(Clone, Copy, Debug)]
pub struct SeededHash(u32);

impl SeededHash {
    /// For a second integer and a seed.
    #[must_use]
    #[inline]
    pub fn new(y: u32, seed: u32) -> Self {
        Self(mix(y ^ mix(seed.wrapping_add(0x9E37_79B9))))
    }

    /// 32 uniform bits.
    #[must_use]
    #[inline]
    pub fn bits(self, x: u32) -> u32 {
        mix(x ^ self.0)
    }

    /// The bits as a number in [0, 1).
    #[must_use]
    #[inline]
    pub fn unit(self, x: u32) -> f64 {
        f64::from(self.bits(x)) / 4_294_967_296.0
    }
}

/// Mixes two integers and a seed to 32 uniform bits.
#[must_use]
pub fn hash(x: u32, y: u32, seed: u32) -> u32 {
    SeededHash::new(y, seed).bits(x)
}

/// The hash as a number in [0, 1).
#[must_use]
pub fn unit_hash(x: u32, y: u32, seed: u32) -> f64 {
    SeededHash::new(y, seed).unit(x)
}

/// Smooth noise in [0, 1] over a lattice that repeats after `cells` in each axis; `s` and `t` are in lattice cells.
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "reduced to the lattice before the cast")]
pub fn smooth_noise(s: f64, t: f64, cells: [u32; 2], seed: u32) -> f64 {
    let axis = |position: f64, count: u32| {
        let size = f64::from(count);
        let reduced = position - size * whole(position / size);
        let first = (reduced as u32).min(count - 1);
        let fraction = reduced - f64::from(first);
        // Quintic: first and second derivatives vanish at the lattice.
        let weight = fraction * fraction * fraction * (fraction * (fraction * 6.0 - 15.0) + 10.0);
        (first, (first + 1) % count, weight)
    };
    let (x0, x1, across) = axis(s, cells[0]);
    let (y0, y1, down) = axis(t, cells[1]);
    let top = unit_hash(x0, y0, seed) * (1.0 - across) + unit_hash(x1, y0, seed) * across;
    let bottom = unit_hash(x0, y1, seed) * (1.0 - across) + unit_hash(x1, y1, seed) * across;
    top * (1.0 - down) + bottom * down
}

/// A sum of octaves of [`smooth_noise`], each twice as fine and 0.55 times as strong, mean about 1/2.
#[must_use]
pub fn octaves(s: f64, t: f64, cells: [u32; 2], count: u32, seed: u32) -> f64 {
    let (mut sum, mut total, mut strength) = (0.0, 0.0, 1.0);
    for octave in 0..count {
        let cells = cells.map(|axis| axis << octave);
        sum += strength * smooth_noise(s * f64::from(cells[0]), t * f64::from(cells[1]), cells, seed + octave);
        total += strength;
        strength *= 0.55;
    }
    sum / total
}
