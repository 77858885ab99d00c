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

/// Where a position lies on one axis of a lattice: between which two points, and the weight of the second.
type Between = (u32, u32, f64);

/// A sum of octaves of smooth noise in [0, 1], each over a lattice twice as fine and 0.55 times as strong, mean about 1/2. Lattices repeat
/// after as many points as they have. Made for the columns of an image, and read row by row, so that a point is hashed once for a row.
#[derive(Clone, Debug)]
pub struct Octaves {
    cells: [u32; 2],
    seed: u32,
    /// By octave and column.
    columns: Vec<Vec<Between>>,
}

/// One row of it: by octave, the weight of the lower points, and the noise at the upper and lower ones.
#[derive(Clone, Debug)]
pub struct OctavesOfRow<'a> {
    of: &'a Octaves,
    rows: Vec<(f64, [Vec<f64>; 2])>,
}

impl Octaves {
    /// `cells` points along and down in the coarsest of `count` octaves; `positions` are those of columns, in [0, 1].
    #[must_use]
    pub fn new(positions: &[f64], cells: [u32; 2], count: u32, seed: u32) -> Self {
        let columns = (0..count).map(|octave| positions.iter().map(|&s| between(s, cells[0] << octave)).collect());
        Self { cells, seed, columns: columns.collect() }
    }

    /// The row at `t`, in [0, 1].
    #[must_use]
    pub fn row(&self, t: f64) -> OctavesOfRow<'_> {
        let of_octave = |octave: u32| {
            let [across, down] = self.cells.map(|axis| axis << octave);
            let (upper, lower, weight) = between(t, down);
            let points = |y: u32| {
                let hash = SeededHash::new(y, self.seed + octave);
                (0..across).map(|x| hash.unit(x)).collect()
            };
            (weight, [points(upper), points(lower)])
        };
        OctavesOfRow { of: self, rows: (0..self.columns.len() as u32).map(of_octave).collect() }
    }
}

impl OctavesOfRow<'_> {
    /// The noise at a column.
    #[must_use]
    pub fn at(&self, column: usize) -> f64 {
        let (mut sum, mut total, mut strength) = (0.0, 0.0, 1.0);
        for ((down, [upper, lower]), columns) in self.rows.iter().zip(&self.of.columns) {
            let (first, second, across) = columns[column];
            let [top, bottom] =
                [upper, lower].map(|points| points[first as usize] * (1.0 - across) + points[second as usize] * across);
            sum += strength * (top * (1.0 - down) + bottom * down);
            total += strength;
            strength *= 0.55;
        }
        sum / total
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "reduced to the lattice before the cast")]
fn between(position: f64, points: u32) -> Between {
    let size = f64::from(points);
    let position = position * size;
    let reduced = position - size * whole(position / size);
    let first = (reduced as u32).min(points - 1);
    let fraction = reduced - f64::from(first);
    // Quintic: first and second derivatives vanish at the lattice.
    let weight = fraction * fraction * fraction * (fraction * (fraction * 6.0 - 15.0) + 10.0);
    (first, (first + 1) % points, weight)
}
