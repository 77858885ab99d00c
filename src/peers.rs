//! How far the arithmetic of other machines is from exact: what peers.md (b3) of the design input measured, measured here with the
//! integer datapath of [`texunit_hw::peers`].

use rayon::prelude::*;
use serde::Serialize;
use texunit_hw::peers::{
    Arithmetic, COORDINATE_BITS, Colour, LEVEL_BITS, LevelUnit, Logarithm, MACHINES, Shape, Texels, Weights,
};

use crate::{
    experiment::verify::SplitMix,
    pyramid::{PlaneImage, Pyramid},
};

/// Samples and points of a measurement, as many as peers.md took.
const COUNT: u32 = 1 << 21;
/// Those a task takes; sums are merged in their order, so the result does not depend on the number of threads.
const TASK: u32 = 1 << 14;

/// Least, greatest and mean error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// The most it falls short.
    pub least: f64,
    /// The most it is too much.
    pub greatest: f64,
    /// The drift.
    pub mean: f64,
}

impl Spread {
    const NONE: Self = Self { least: f64::INFINITY, greatest: f64::NEG_INFINITY, mean: 0.0 };

    /// With `mean` the sum until [`Self::of`].
    fn add(&mut self, error: f64) {
        self.merge(Self { least: error, greatest: error, mean: error });
    }

    fn merge(&mut self, other: Self) {
        self.least = self.least.min(other.least);
        self.greatest = self.greatest.max(other.greatest);
        self.mean += other.mean;
    }

    fn of(self, count: u32) -> Self {
        Self { mean: self.mean / f64::from(count), ..self }
    }
}

/// What a bilinear tap of random texels at random places is off, in units of the last of 8 bits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TapError {
    /// From the exact answer at the place.
    pub exact: Spread,
    /// From the exact answer at the fraction the machine has left of it: what its weights and roundings lose.
    pub own: Spread,
    /// How often it is that answer, rightly rounded.
    pub right: f64,
}

/// Measures the tap of a machine over 2 million random quadruples of texels and places, fractions cut off as b3 has them unless the
/// machine says otherwise. A triangle is held to the exact answer of its own three texels.
#[must_use]
pub fn tap_error(machine: &Arithmetic) -> TapError {
    let none = || (Spread::NONE, Spread::NONE, 0_u32);
    let tasks: Vec<_> = (0..COUNT / TASK)
        .into_par_iter()
        .map(|task| {
            let mut random = SplitMix(u64::from(task) << 32);
            let (mut exact, mut own, mut right) = none();
            for _ in 0..TASK {
                let (error, own_error) = one_tap(machine, &mut random);
                exact.add(error);
                own.add(own_error.off);
                right += u32::from(own_error.right);
            }
            (exact, own, right)
        })
        .collect();
    let (mut exact, mut own, mut right) = none();
    for task in tasks {
        exact.merge(task.0);
        own.merge(task.1);
        right += task.2;
    }
    TapError { exact: exact.of(COUNT), own: own.of(COUNT), right: f64::from(right) / f64::from(COUNT) }
}

struct Own {
    off: f64,
    right: bool,
}

fn one_tap(machine: &Arithmetic, random: &mut SplitMix) -> (f64, Own) {
    let texels = random.draw().to_le_bytes();
    let [c00, c10, c01, c11] = [texels[0], texels[1], texels[2], texels[3]];
    let places = [0, 1].map(|_| (random.draw() >> (64 - COORDINATE_BITS)).cast_signed());
    let one = libm::exp2(f64::from(COORDINATE_BITS));
    let half = if machine.coordinate.half_texel { 0.5 } else { 0.0 };
    // On an axis of one texel the fraction has all the bits of the register.
    let mut corners = [c00, c10, c01, c11];
    let mut fractions = [0; 2];
    let mut exact = [0.0; 2];
    for axis in [0, 1] {
        let place = places[axis] as f64 / one - half;
        let (lower, fraction) = machine.texels(places[axis], 1);
        exact[axis] = place - place.floor();
        fractions[axis] = fraction;
        if lower as f64 > place.floor() {
            // Rounded up to the next texel.
            let [_, b, c, d] = corners;
            corners = if axis == 0 { [b, b, d, d] } else { [c, d, c, d] };
        }
    }
    let scale = f64::from(machine.full_scale) / 255.0;
    let answer = f64::from(machine.tap(corners.map(|texel| [texel; 4]), fractions)[0]) / scale;
    let all = libm::exp2(f64::from(machine.fraction));
    let steps = if machine.weights == Weights::OfOnes { all - 1.0 } else { all };
    let own = between(machine.shape, corners, fractions.map(|fraction| f64::from(fraction) / steps));
    let nearest = ((own * scale + 0.5).floor() / scale - answer).abs() < 1e-9;
    let truth = between(machine.shape, [c00, c10, c01, c11], exact);
    (answer - truth, Own { off: answer - own, right: nearest })
}

fn between(shape: Shape, corners: [u8; 4], [f, g]: [f64; 2]) -> f64 {
    let [c00, c10, c01, c11] = corners.map(f64::from);
    match shape {
        Shape::Square => (c00 * (1.0 - f) + c10 * f) * (1.0 - g) + (c01 * (1.0 - f) + c11 * f) * g,
        Shape::Triangle if f + g < 1.0 => c00 + f * (c10 - c00) + g * (c01 - c00),
        Shape::Triangle => c11 + (1.0 - f) * (c01 - c11) + (1.0 - g) * (c10 - c11),
    }
}

/// Whether a field of one colour keeps it, whatever the place: all colours, all pairs of the extreme fractions and some between.
#[must_use]
pub fn keeps_flat_fields(machine: &Arithmetic) -> bool {
    let last = (1_u32 << machine.fraction) - 1;
    let fractions = [0, 1, last / 3, last / 2, last / 2 + 1, last - 1, last];
    (0..=255_u8).all(|colour| {
        fractions.iter().all(|&f| {
            fractions
                .iter()
                .all(|&g| machine.tap([[colour; 4]; 4], [f, g]) == [u32::from(colour) * (machine.full_scale / 255); 4])
        })
    })
}

/// The error of a level over 2 million ratios of 1 to 4096, uniform in their logarithm; negative is too sharp.
#[must_use]
pub fn level_error(unit: &LevelUnit) -> Spread {
    let tasks: Vec<Spread> = (0..COUNT / TASK)
        .into_par_iter()
        .map(|task| {
            let mut spread = Spread::NONE;
            for point in task * TASK..(task + 1) * TASK {
                let ratio = libm::exp2(12.0 * (f64::from(point) + 0.5) / f64::from(COUNT)) as f32;
                let level = unit.level(ratio.to_bits()) as f64 / f64::from(1 << LEVEL_BITS);
                spread.add(level - libm::log2(f64::from(ratio)));
            }
            spread
        })
        .collect();
    let mut spread = Spread::NONE;
    for task in tasks {
        spread.merge(task);
    }
    spread.of(COUNT)
}

/// A row of b3 about taps: machine, least, greatest, mean, share of right roundings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PublishedTap {
    /// Whose tap it is.
    pub machine: &'static str,
    /// Least error.
    pub least: f64,
    /// Greatest error.
    pub greatest: f64,
    /// Mean error.
    pub mean: f64,
    /// Share of answers that are the exact one at the machine's own fraction, rounded; where it was given.
    pub right: Option<f64>,
}

const fn tap(machine: &'static str, [least, greatest, mean]: [f64; 3], right: Option<f64>) -> PublishedTap {
    PublishedTap { machine, least, greatest, mean, right }
}

/// peers.md (b3), the table of bilinear conventions. Extremes are of 2 million random samples, another draw of which differs by some per
/// cent. llvmpipe was modelled there with fractions cut off; as its sources have it they are rounded to nearest, and it is nearer.
pub const PUBLISHED_TAPS: [PublishedTap; 7] = [
    tap("vortex", [-2.20, 2.11, 0.0], Some(0.805)),
    tap("llvmpipe", [-2.09, 2.25, 0.016], Some(0.803)),
    tap("gplgpu", [-1.91, 0.91, -0.493], Some(0.501)),
    tap("gamecube", [-4.05, 2.95, -0.500], Some(0.500)),
    tap("voodoo-1", [-26.1, 26.9, -0.486], Some(0.502)),
    tap("swiftshader", [-0.032, -0.001, -0.016], None),
    tap("herf-12.20", [-2.09, 2.04, 0.0], Some(1.0)),
];

/// A convention of b3 for the logarithm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convention {
    /// What it is, and whose.
    pub name: &'static str,
    /// The unit.
    pub unit: LevelUnit,
    /// Least, greatest and mean error as published.
    pub published: Spread,
}

const fn convention(
    name: &'static str,
    squarings: u32,
    logarithm: Logarithm,
    bits: u32,
    [least, greatest, mean]: [f64; 3],
) -> Convention {
    let unit = LevelUnit { squarings, logarithm, bits, nearest: false };
    Convention { name, unit, published: Spread { least, greatest, mean } }
}

/// peers.md (b3), the table of logarithms.
pub const CONVENTIONS: [Convention; 9] = [
    convention("plain (Herf; llvmpipe fast_log2)", 0, Logarithm::Linear, LEVEL_BITS, [-0.0861, 0.0, -0.0573]),
    convention("of the square (llvmpipe)", 1, Logarithm::Linear, LEVEL_BITS, [-0.0430, 0.0, -0.0287]),
    convention("of the fourth power (SwiftShader)", 2, Logarithm::Linear, LEVEL_BITS, [-0.0215, 0.0, -0.0143]),
    convention("plain, 4 bits (Dolphin)", 0, Logarithm::Linear, 4, [-0.1486, 0.0, -0.0883]),
    convention("plain, 6 bits (gplgpu)", 0, Logarithm::Linear, 6, [-0.1017, 0.0, -0.0651]),
    convention("plain, 8 bits (angrylion)", 0, Logarithm::Linear, 8, [-0.0900, 0.0, -0.0593]),
    convention(
        "128 entries of the square (MAME)",
        1,
        Logarithm::TableFloor { index: 7, entry: 8 },
        8,
        [-0.0089, 0.0, -0.0040],
    ),
    convention(
        "256 entries, nearest (softpipe)",
        0,
        Logarithm::TableNearest { index: 8 },
        LEVEL_BITS,
        [-0.0028, 0.0028, 0.0],
    ),
    convention(
        "65536 entries, nearest (softpipe)",
        0,
        Logarithm::TableNearest { index: 16 },
        LEVEL_BITS,
        [-0.00001, 0.00001, 0.0],
    ),
];

/// Every machine with its measured errors.
#[must_use]
pub fn measure() -> Vec<(&'static Arithmetic, TapError, Option<Spread>)> {
    MACHINES.iter().map(|machine| (machine, tap_error(machine), machine.level.as_ref().map(level_error))).collect()
}

/// A mipmap, as the machines read it.
#[derive(Clone, Copy, Debug)]
pub struct Mipmap<'p>(pub &'p Pyramid);

impl Mipmap<'_> {
    fn plane(&self, level: u32) -> &PlaneImage {
        &self.0.planes[level as usize]
    }
}

impl Texels for Mipmap<'_> {
    fn size(&self, level: u32) -> [u32; 2] {
        let plane = self.plane(level);
        [plane.width, plane.height]
    }

    fn last(&self) -> u32 {
        self.0.planes.len() as u32 - 1
    }

    fn texel(&self, level: u32, [i, j]: [u32; 2]) -> [u8; 4] {
        let plane = self.plane(level);
        plane.texels[(j * plane.width + i) as usize]
    }
}

/// A coordinate as the machines take it: cut off at [`COORDINATE_BITS`], saturated to +-2^20 repeats.
#[must_use]
pub fn coordinate(x: f64) -> i64 {
    (libm::scalbn(x, COORDINATE_BITS as i32)).floor().clamp(-1.152_921_504_606_847e18, 1.152_921_504_606_847e18) as i64
}

/// A colour of a machine in 8 bits, to nearest.
#[must_use]
pub fn to_8_bits(machine: &Arithmetic, colour: Colour) -> [u8; 4] {
    let widen = machine.full_scale / 255;
    colour.map(|channel| ((channel + widen / 2) / widen).min(255) as u8)
}
