//! Coordinates: from float bits to 12.20, and from 12.20 to texel indices (docs/numerics.md, sections 1.1 and 3).

use fixed::types::I12F20;

/// Fraction bits of a coordinate.
pub const COORDINATE_BITS: u32 = 20;
const HALF_TEXEL: i64 = 1 << (COORDINATE_BITS - 1);

/// What happens to a coordinate outside the texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum AddressMode {
    /// Repeat: exact modulo 1 at any value.
    #[default]
    Wrap,
    /// The edge texel.
    Clamp,
    /// Transparent black outside (Herf's Clip; right for premultiplied alpha).
    Clip,
    /// Repeat, every second time mirrored.
    Mirror,
}

/// A coordinate made from a float, and whether the float had no defined place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Converted {
    /// The coordinate.
    pub value: I12F20,
    /// NaN, or an infinity under a periodic mode: the value is 0 and the front end counts it.
    pub undefined: bool,
}

/// The 12.20 coordinate of an f32 given by its bits; see [`from_f64_bits`].
#[must_use]
pub const fn from_f32_bits(bits: u32, mode: AddressMode) -> Converted {
    let exponent = (bits >> 23 & 0xFF) as i32;
    let fraction = (bits & 0x7F_FFFF) as u64;
    let negative = bits >> 31 == 1;
    match exponent {
        0xFF => special(fraction != 0, negative, mode),
        0 => place(fraction, -149, negative, mode),
        _ => place(fraction | 1 << 23, exponent - 150, negative, mode),
    }
}

/// The 12.20 coordinate of an f64 given by its bits: floor, exact modulo 4096 for periodic modes, saturating for the others.
///
/// Round-to-nearest would turn 1 - 2^-24 into a full turn, a known seam bug of a published standard (X9).
///
/// ```
/// use texunit_hw::{AddressMode, coordinate::from_f64_bits};
/// assert_eq!(from_f64_bits(0.75f64.to_bits(), AddressMode::Wrap).value.to_bits(), 0xC0000);
/// assert_eq!(from_f64_bits((-1e-9f64).to_bits(), AddressMode::Wrap).value.to_bits(), -1);
/// assert_eq!(from_f64_bits(2048.25f64.to_bits(), AddressMode::Clamp).value.to_bits(), i32::MAX);
/// ```
#[must_use]
pub const fn from_f64_bits(bits: u64, mode: AddressMode) -> Converted {
    let exponent = (bits >> 52 & 0x7FF) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let negative = bits >> 63 == 1;
    match exponent {
        0x7FF => special(fraction != 0, negative, mode),
        0 => place(fraction, -1074, negative, mode),
        _ => place(fraction | 1 << 52, exponent - 1075, negative, mode),
    }
}

const fn special(nan: bool, negative: bool, mode: AddressMode) -> Converted {
    let periodic = matches!(mode, AddressMode::Wrap | AddressMode::Mirror);
    let undefined = nan || periodic;
    let bits = match (undefined, negative) {
        (true, _) => 0,
        (false, false) => i32::MAX,
        (false, true) => i32::MIN,
    };
    Converted { value: I12F20::from_bits(bits), undefined }
}

/// `floor(+-significand * 2^(exponent + 20))`, reduced or saturated to 32 bits.
const fn place(significand: u64, exponent: i32, negative: bool, mode: AddressMode) -> Converted {
    let shift = exponent + COORDINATE_BITS as i32;
    // Floor of a negative value is minus the ceiling of its magnitude: add one whenever bits are lost.
    let (low, exceeds) = if shift >= 0 {
        let low = if shift < 64 { significand << shift } else { 0 };
        let exceeds =
            significand != 0 && (shift >= 64 || significand.leading_zeros() < shift as u32 || low > i32::MAX as u64);
        (low, exceeds)
    } else if shift > -64 {
        let kept = significand >> -shift;
        let lost = significand != kept << -shift;
        let magnitude = kept + (negative && lost) as u64;
        (magnitude, magnitude > i32::MAX as u64)
    } else {
        ((negative && significand != 0) as u64, false)
    };
    let bits = match mode {
        AddressMode::Wrap | AddressMode::Mirror => {
            if negative {
                (low as u32).wrapping_neg() as i32
            } else {
                low as i32
            }
        }
        AddressMode::Clamp | AddressMode::Clip => match (exceeds, negative) {
            (true, false) => i32::MAX,
            (true, true) => i32::MIN,
            (false, false) => low as i32,
            (false, true) => -(low as i32),
        },
    };
    Converted { value: I12F20::from_bits(bits), undefined: false }
}

/// The two texels under a bilinear tap on one axis: the lower index, before the address mode, and the fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexelPair {
    /// Index of the left or upper texel; -1 is usual (E21). The other is one more.
    pub lower: i64,
    /// Weight of the other texel, in units of `2^-filter_bits`.
    pub fraction: u32,
}

/// The bits of a coordinate that the address mode keeps: one period, or all of them.
#[inline]
#[must_use]
pub const fn period_mask(mode: AddressMode) -> i64 {
    match mode {
        AddressMode::Wrap => (1 << COORDINATE_BITS) - 1,
        AddressMode::Mirror => (1 << (COORDINATE_BITS + 1)) - 1,
        AddressMode::Clamp | AddressMode::Clip => -1,
    }
}

/// Texel index of a point tap: no half texel (E21). `coordinate` is 12.20 in any integer range, already reduced to its period.
#[inline]
#[must_use]
pub const fn texel_under(coordinate: i64, size: u32) -> i64 {
    (coordinate * size as i64) >> COORDINATE_BITS
}

/// Texel pair of a bilinear tap, `filter_bits` of fraction truncated from the same register as the index.
///
/// ```
/// use texunit_hw::coordinate::texel_pair;
/// let pair = texel_pair(0, 16, 8); // the left border lies half way between texel -1 and texel 0
/// assert_eq!((pair.lower, pair.fraction), (-1, 128));
/// ```
#[inline]
#[must_use]
pub const fn texel_pair(coordinate: i64, size: u32, filter_bits: u32) -> TexelPair {
    let position = coordinate * size as i64 - HALF_TEXEL;
    TexelPair {
        lower: position >> COORDINATE_BITS,
        fraction: (position >> (COORDINATE_BITS - filter_bits)) as u32 & ((1 << filter_bits) - 1),
    }
}

/// The address mode applied to one texel index; `None` is outside (clip only).
#[inline]
#[must_use]
pub const fn resolve(index: i64, size: u32, mode: AddressMode) -> Option<u32> {
    let size = size as i64;
    match mode {
        AddressMode::Wrap => Some(index.rem_euclid(size) as u32),
        AddressMode::Mirror => {
            let folded = index.rem_euclid(2 * size);
            Some(if folded < size { folded } else { 2 * size - 1 - folded } as u32)
        }
        AddressMode::Clamp => Some(if index < 0 {
            0
        } else if index >= size {
            (size - 1) as u32
        } else {
            index as u32
        }),
        AddressMode::Clip => {
            if index < 0 || index >= size {
                None
            } else {
                Some(index as u32)
            }
        }
    }
}
