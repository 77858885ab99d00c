//! From a coordinate to texel indices (docs/numerics.md, section 3), in turns: 1.0 is one repeat of the texture.

use texunit_hw::AddressMode;

/// Units of a 12.20 coordinate in one repeat of the texture.
pub const TURN: f64 = 1_048_576.0;

/// 1.5 * 2^52: adding it leaves no bits for a fraction.
const NO_FRACTION: f64 = 6_755_399_441_055_744.0;

/// The largest whole number not above `x`, for `|x| < 2^51`. Four additions the compiler can inline and run side by side;
/// `f64::floor` is a call on machines whose baseline has no rounding instruction.
#[inline]
#[must_use]
pub fn floor(x: f64) -> f64 {
    let nearest = (x + NO_FRACTION) - NO_FRACTION;
    nearest - if nearest > x { 1.0 } else { 0.0 }
}

/// Step 1: the coordinate within its period, where it has one.
#[inline]
#[must_use]
pub fn reduce(c: f64, mode: AddressMode) -> f64 {
    match mode {
        AddressMode::Wrap => c - floor(c),
        AddressMode::Mirror => c - 2.0 * floor(c / 2.0),
        AddressMode::Clamp | AddressMode::Clip => c,
    }
}

/// Section 3 of a point tap: the texel the coordinate falls into, on an axis of `size` texels.
#[inline]
#[must_use]
pub fn point(c: f64, size: f64, mode: AddressMode) -> Option<usize> {
    addressed([floor(reduce(c, mode) * size)], size, mode)[0]
}

/// Section 3 of a bilinear tap: the two texels whose centres the coordinate lies between, and how far from the first to the
/// second it lies, in `[0, 1)`, not yet truncated to the width of the filter.
#[inline]
#[must_use]
pub fn bilinear(c: f64, size: f64, mode: AddressMode) -> ([Option<usize>; 2], f64) {
    let position = reduce(c, mode) * size - 0.5;
    let first = floor(position);
    (addressed([first, first + 1.0], size, mode), position - first)
}

/// Step 4: the texels that indices of a reduced coordinate stand for, or none where the clip mode reads no texel.
#[inline]
fn addressed<const COUNT: usize>(indices: [f64; COUNT], size: f64, mode: AddressMode) -> [Option<usize>; COUNT] {
    let texel = |index: f64| Some(index as u32 as usize);
    match mode {
        AddressMode::Wrap => indices.map(|index| texel(within(index, size))),
        AddressMode::Mirror => indices.map(|index| {
            let index = within(index, 2.0 * size);
            texel(if index < size { index } else { 2.0 * size - 1.0 - index })
        }),
        AddressMode::Clamp => indices.map(|index| {
            let last = size - 1.0;
            let index = if index > last { last } else { index };
            texel(if index < 0.0 { 0.0 } else { index })
        }),
        AddressMode::Clip => indices.map(|index| if index < 0.0 || index >= size { None } else { texel(index) }),
    }
}

/// Step 4 of any index, however far outside: for filters that count texels and not taps.
#[must_use]
pub fn anywhere(index: f64, size: f64, mode: AddressMode) -> Option<usize> {
    let period = match mode {
        AddressMode::Wrap => size,
        AddressMode::Mirror => 2.0 * size,
        AddressMode::Clamp | AddressMode::Clip => return addressed([index], size, mode)[0],
    };
    addressed([index - period * floor(index / period)], size, mode)[0]
}

/// An index modulo its period. The coordinate was reduced, so a tap reaches out of the period by one texel at most.
#[inline]
fn within(index: f64, period: f64) -> f64 {
    if index < 0.0 {
        index + period
    } else if index >= period {
        index - period
    } else {
        index
    }
}

/// The numbers with so many fraction bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    steps: f64,
    step: f64,
}

impl Grid {
    /// With `bits` fraction bits.
    #[must_use]
    pub fn new(bits: u8) -> Self {
        let steps = libm::exp2(f64::from(bits));
        Self { steps, step: 1.0 / steps }
    }

    /// The nearest number of the grid not above `x`.
    #[inline]
    #[must_use]
    pub fn floor(&self, x: f64) -> f64 {
        floor(x * self.steps) * self.step
    }

    /// The nearest number of the grid not below `x`.
    #[must_use]
    pub fn ceil(&self, x: f64) -> f64 {
        -self.floor(-x)
    }

    /// The nearest number of the grid, half up.
    #[inline]
    #[must_use]
    pub fn nearest(&self, x: f64) -> f64 {
        floor(x * self.steps + 0.5) * self.step
    }
}

/// The nearest number not above `x` that there is: of a grid, or `x` itself among the real numbers.
#[inline]
#[must_use]
pub fn floored(grid: Option<Grid>, x: f64) -> f64 {
    grid.map_or(x, |grid| grid.floor(x))
}
