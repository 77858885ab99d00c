//! The arithmetic of other machines: one small datapath, and a table of what each of them puts into it.
//!
//! The unit of this crate has one coordinate format and a handful of roundings. Its peers differ in more: where the fraction is cut, whether
//! there is a half texel, what a weight of all ones means, where they round, and what they take for a logarithm. [`MACHINES`] says it of each,
//! as peers.md (b1) of the design input read it from their sources; [`Arithmetic::sample`] does it. It is no unit of the chip (no layout, no
//! cache, no clock), but it is integers only, and this is the crate that holds code to that: docs/decisions/0006-peers-in-the-integer-crate.md.
//!
//! What no source says is an assumption, and [`Arithmetic::assumed`] says so.

mod level;
mod machines;
mod weigh;

pub use self::{
    level::{LevelUnit, Logarithm},
    machines::MACHINES,
    weigh::{Rounding, Weights},
};
use crate::coordinate::{AddressMode, resolve};

/// Fraction bits of a coordinate handed to [`Arithmetic::sample`]; 1.0 is one repeat of the texture.
pub const COORDINATE_BITS: u32 = 40;
/// Fraction bits of a level: those of an f32, so that what is linear in its significand loses nothing.
pub const LEVEL_BITS: u32 = 23;

/// Of what a coordinate register counts its fractions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Of one repeat of the texture; the product with the size keeps them all.
    Normalised,
    /// Of one texel of the level that is read.
    Texels,
}

/// The register a coordinate arrives in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coordinate {
    /// What 1.0 is.
    pub space: Space,
    /// Fraction bits.
    pub bits: u32,
    /// Whether what is below them is rounded to nearest (half up) instead of cut off.
    pub nearest: bool,
    /// Whether half a texel is taken off, so that texels have their colour at the centre and not at the corner.
    pub half_texel: bool,
}

/// Which texels a tap weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// The four around it.
    Square,
    /// Three of them: the triangle it lies in (Nintendo 64).
    Triangle,
}

/// How two levels become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// They do not: one level is read, the floor of the level.
    None,
    /// A lerp of the two filtered colours, at so many bits of the level's fraction.
    Lerp {
        /// Bits of the weight.
        bits: u32,
        /// What the weights are.
        weights: Weights,
        /// How it is rounded.
        rounding: Rounding,
    },
    /// The exact sum over both levels, rounded once (half up), at so many bits of the level's fraction.
    Once {
        /// Bits of the weight.
        bits: u32,
    },
}

/// The arithmetic of one machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arithmetic {
    /// What it is called.
    pub name: &'static str,
    /// Where this was read.
    pub source: &'static str,
    /// What no source says, or what is left out; empty if nothing.
    pub assumed: &'static str,
    /// The coordinate register.
    pub coordinate: Coordinate,
    /// Bits of the fraction that weighs, the highest of the register's.
    pub fraction: u32,
    /// The texels of a tap.
    pub shape: Shape,
    /// The weights of a lerp.
    pub weights: Weights,
    /// Where and how a tap is rounded.
    pub rounding: Rounding,
    /// Highest value of a channel within the datapath: 255, or 65535 where it is widened (times 257).
    pub full_scale: u32,
    /// The level of detail; none where there are no mipmaps.
    pub level: Option<LevelUnit>,
    /// How levels are blended.
    pub blend: Blend,
}

/// Where a machine reads its texels: a mipmap of 8-bit channels.
pub trait Texels {
    /// Width and height of a level.
    fn size(&self, level: u32) -> [u32; 2];
    /// The last level.
    fn last(&self) -> u32;
    /// A texel inside.
    fn texel(&self, level: u32, at: [u32; 2]) -> [u8; 4];
}

/// A colour, each channel of 0 to [`Arithmetic::full_scale`].
pub type Colour = [u32; 4];

impl Arithmetic {
    /// The machine of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        MACHINES.iter().find(|machine| machine.name == name)
    }

    /// Lower texel and the weight of the next one, on an axis of `size` texels; `coordinate` has [`COORDINATE_BITS`].
    ///
    /// ```
    /// use texunit_hw::peers::{Arithmetic, COORDINATE_BITS};
    /// let vortex = Arithmetic::named("vortex").unwrap();
    /// // A quarter of 16 texels: half a texel before texel 4, so half way from 3 to 4.
    /// assert_eq!(vortex.texels(1 << (COORDINATE_BITS - 2), 16), (3, 128));
    /// ```
    #[must_use]
    pub const fn texels(&self, coordinate: i64, size: u32) -> (i64, u32) {
        let Coordinate { space, bits, nearest, half_texel } = self.coordinate;
        let drop = COORDINATE_BITS - bits;
        let half = if nearest { (1_i128 << drop) >> 1 } else { 0 };
        let scaled = match space {
            Space::Normalised => ((coordinate as i128 + half) >> drop) * size as i128,
            Space::Texels => (coordinate as i128 * size as i128 + half) >> drop,
        };
        let position = if half_texel { scaled - (1 << (bits - 1)) } else { scaled };
        let fraction = (position >> (bits - self.fraction)) & ((1 << self.fraction) - 1);
        ((position >> bits) as i64, fraction as u32)
    }

    /// The colour of one tap between four texels: (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1).
    #[must_use]
    pub fn tap(&self, corners: [[u8; 4]; 4], fractions: [u32; 2]) -> Colour {
        let widen = self.full_scale / 255;
        core::array::from_fn(|channel| {
            let corners = corners.map(|corner| u64::from(corner[channel]) * u64::from(widen));
            match self.shape {
                Shape::Square => weigh::square(corners, fractions, self.fraction, self.weights, self.rounding) as u32,
                Shape::Triangle => weigh::triangle(corners, fractions, self.fraction) as u32,
            }
        })
    }

    /// A sample at normalised coordinates of [`COORDINATE_BITS`]; `ratio` is the f32 pattern of the texels of level 0 in a pixel.
    ///
    /// Machines without mipmaps read level 0.
    #[must_use]
    pub fn sample(&self, texels: &impl Texels, at: [i64; 2], ratio: u32, address: [AddressMode; 2]) -> Colour {
        let level = self.level.map_or(0, |unit| unit.level(ratio).clamp(0, i64::from(texels.last()) << LEVEL_BITS));
        let whole = (level >> LEVEL_BITS) as u32;
        let next = (whole + 1).min(texels.last());
        let fraction = |bits: u32| (level >> (LEVEL_BITS - bits)) as u32 & ((1 << bits) - 1);
        match self.blend {
            Blend::None => self.bilinear(texels, at, whole, address),
            Blend::Lerp { bits, weights, rounding } => {
                let [a, b] = [whole, next].map(|level| self.bilinear(texels, at, level, address));
                core::array::from_fn(|channel| {
                    weigh::lerp(u64::from(a[channel]), u64::from(b[channel]), fraction(bits), bits, weights, rounding)
                        as u32
                })
            }
            Blend::Once { bits } => {
                let [a, b] = [whole, next].map(|level| self.exact(texels, at, level, address));
                let shift = 2 * self.fraction + bits;
                let weight = u64::from(fraction(bits));
                core::array::from_fn(|channel| {
                    let sum = a[channel] * ((1 << bits) - weight) + b[channel] * weight;
                    ((sum + ((1 << shift) >> 1)) >> shift) as u32
                })
            }
        }
    }

    fn bilinear(&self, texels: &impl Texels, at: [i64; 2], level: u32, address: [AddressMode; 2]) -> Colour {
        let (corners, fractions) = self.corners(texels, at, level, address);
        self.tap(corners, fractions)
    }

    /// The weighted sum, nothing rounded.
    fn exact(&self, texels: &impl Texels, at: [i64; 2], level: u32, address: [AddressMode; 2]) -> [u64; 4] {
        let (corners, fractions) = self.corners(texels, at, level, address);
        let [f, g] = fractions.map(u64::from);
        let one = 1_u64 << self.fraction;
        core::array::from_fn(|channel| {
            let [c00, c10, c01, c11] = corners.map(|corner| u64::from(corner[channel]));
            (c00 * (one - f) + c10 * f) * (one - g) + (c01 * (one - f) + c11 * f) * g
        })
    }

    fn corners(
        &self,
        texels: &impl Texels,
        at: [i64; 2],
        level: u32,
        address: [AddressMode; 2],
    ) -> ([[u8; 4]; 4], [u32; 2]) {
        let size = texels.size(level);
        let [(i, f), (j, g)] = [0, 1].map(|axis| self.texels(at[axis], size[axis]));
        let texel = |i: i64, j: i64| match (resolve(i, size[0], address[0]), resolve(j, size[1], address[1])) {
            (Some(i), Some(j)) => texels.texel(level, [i, j]),
            _ => [0; 4],
        };
        ([texel(i, j), texel(i + 1, j), texel(i, j + 1), texel(i + 1, j + 1)], [f, g])
    }
}
