//! Integer taps along one axis: what each texel of a smaller axis takes from which texel of the larger one.

use texunit_hw::AddressMode;

use super::kernel::Kernel;

/// A source texel and its integer weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisTap {
    /// Index along the source axis.
    pub texel: u32,
    /// Weight out of [`AxisTaps::total`]; negative in the lobes of a sinc.
    pub weight: i32,
}

/// The taps of every texel of an axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AxisTaps {
    /// What the weights of one texel sum to (less where the edge rule is clip and taps fall outside).
    pub total: i64,
    /// Texel `i` owns `taps[starts[i]..starts[i + 1]]`.
    starts: Vec<usize>,
    taps: Vec<AxisTap>,
}

/// Bits of a designed tap at 2:1, and the most bits any has: one more per further halving keeps the taps of a kernel that
/// doubles its width from vanishing, up to where 255 * total still fits the 32-bit column sums.
const TAP_BITS: (u32, u32) = (14, 21);

impl AxisTaps {
    /// Taps from `source` texels to `target` texels, `target <= source`. `width` is the kernel's width in source texels at
    /// 2:1; it grows with `source / target`.
    #[must_use]
    pub fn new(kernel: Kernel, width: Option<u8>, edge: AddressMode, source: u32, target: u32) -> Self {
        if source == target {
            return Self::collect(1, target, |i, taps| taps.push(AxisTap { texel: i, weight: 1 }));
        }
        match (kernel, width) {
            (Kernel::Point, _) => Self::point(source, target),
            (Kernel::Box, _) | (_, None) => Self::area(source, target),
            (_, Some(width)) => Self::designed(kernel, width, edge, source, target),
        }
    }

    /// Number of texels of the smaller axis.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Never: an axis has at least one texel.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The taps of texel `i`, by rising source index.
    #[must_use]
    pub fn of(&self, i: usize) -> &[AxisTap] {
        &self.taps[self.starts[i]..self.starts[i + 1]]
    }

    fn collect(total: i64, target: u32, mut each: impl FnMut(u32, &mut Vec<AxisTap>)) -> Self {
        let (mut starts, mut taps) = (vec![0], Vec::new());
        for i in 0..target {
            each(i, &mut taps);
            starts.push(taps.len());
        }
        Self { total, starts, taps }
    }

    /// The texel a point sampler finds at the centre of the new one.
    fn point(source: u32, target: u32) -> Self {
        let (source, target64) = (u64::from(source), u64::from(target));
        Self::collect(1, target, |i, taps| {
            let texel = (2 * u64::from(i) + 1) * source / (2 * target64);
            taps.push(AxisTap { texel: texel as u32, weight: 1 });
        })
    }

    /// Lengths of overlap times `target`, over their common divisor: ones for even halving, so that a power of two is
    /// divided by with a shift.
    fn area(source: u32, target: u32) -> Self {
        let (wide, narrow) = (u64::from(source), u64::from(target));
        let common = gcd(wide, narrow);
        Self::collect((wide / common) as i64, target, |i, taps| {
            // In units of 1/target of a source texel: the new texel covers [low, high), source texel s [s, s + 1) * narrow.
            let (low, high) = (u64::from(i) * wide, (u64::from(i) + 1) * wide);
            for texel in low / narrow..high.div_ceil(narrow) {
                let overlap = high.min((texel + 1) * narrow) - low.max(texel * narrow);
                taps.push(AxisTap { texel: texel as u32, weight: (overlap / common) as i32 });
            }
        })
    }

    /// Taps of a kernel designed in f64, forced to sum to a power of two: left alone they have a gain that repeats on every
    /// level and axis (E18).
    fn designed(kernel: Kernel, width: u8, edge: AddressMode, source: u32, target: u32) -> Self {
        let (wide, narrow, width) = (i64::from(source), i64::from(target), i64::from(width));
        let bits = (TAP_BITS.0 + (wide as u64).div_ceil(narrow as u64).next_power_of_two().ilog2() - 1).min(TAP_BITS.1);
        let common = gcd(wide as u64, narrow as u64) as i64;
        let (period, stride) = (narrow / common, wide / common);
        // Texel i + period has the taps of texel i, moved by `stride`.
        let phases: Vec<_> = (0..period).map(|i| phase(kernel, width, i, wide, narrow, 1 << bits)).collect();
        Self::collect(1 << bits, target, |i, taps| {
            let (first, weights) = &phases[(i64::from(i) % period) as usize];
            let shift = i64::from(i) / period * stride;
            let begin = taps.len();
            taps.extend(weights.iter().zip(first + shift..).filter_map(|(&weight, index)| {
                (weight != 0).then_some(AxisTap { texel: fold(edge, index, wide)?, weight })
            }));
            merge(taps, begin);
        })
    }
}

/// First source index and weights of texel `i` before the edge rule; they sum to `total`.
fn phase(kernel: Kernel, width: i64, i: i64, wide: i64, narrow: i64, total: i32) -> (i64, Vec<i32>) {
    // Distance of the centre of source texel k from that of texel i, in units of 1 / (2 narrow) source texels, an integer:
    // so mirrored taps have bit for bit the same height. The half width is width / 4 new texels = width wide / (4 narrow)
    // source texels.
    let distance = |k: i64| (2 * k + 1) * narrow - (2 * i + 1) * wide;
    let inside = |k: i64| 2 * distance(k).abs() < width * wide;
    let middle = (2 * i + 1) * wide / (2 * narrow);
    let (mut first, mut last) = (middle, middle);
    while inside(first - 1) {
        first -= 1;
    }
    while inside(last + 1) {
        last += 1;
    }
    let heights: Vec<f64> = (first..=last)
        .map(|k| {
            let distance = distance(k) as f64;
            kernel.height(distance / (2 * wide) as f64, 2.0 * distance / (width * wide) as f64)
        })
        .collect();
    let gain = f64::from(total) / heights.iter().sum::<f64>();
    let mut weights: Vec<i32> = heights.iter().map(|height| (height * gain + 0.5).floor() as i32).collect();
    // What rounding left over goes to the taps nearest the centre, one each and round again: symmetric kernels stay so.
    let mut nearest: Vec<usize> = (0..weights.len()).collect();
    nearest.sort_by_key(|&tap| (distance(first + tap as i64).abs(), tap));
    let mut left_over = total - weights.iter().sum::<i32>();
    for &tap in nearest.iter().cycle() {
        if left_over == 0 {
            break;
        }
        weights[tap] += left_over.signum();
        left_over -= left_over.signum();
    }
    (first, weights)
}

/// The edge rule: the sampler's (docs/numerics.md, section 3). `None` is outside: transparent black.
fn fold(edge: AddressMode, index: i64, size: i64) -> Option<u32> {
    let inside = match edge {
        AddressMode::Wrap => index.rem_euclid(size),
        AddressMode::Clamp => index.clamp(0, size - 1),
        AddressMode::Mirror => {
            let turn = index.rem_euclid(2 * size);
            turn.min(2 * size - 1 - turn)
        }
        AddressMode::Clip if (0..size).contains(&index) => index,
        AddressMode::Clip => return None,
    };
    Some(inside as u32)
}

/// Adds up the taps from `begin` on that the edge rule led to one texel.
fn merge(taps: &mut Vec<AxisTap>, begin: usize) {
    taps[begin..].sort_by_key(|tap| tap.texel);
    let mut end = begin;
    for next in begin..taps.len() {
        if end > begin && taps[end - 1].texel == taps[next].texel {
            taps[end - 1].weight += taps[next].weight;
        } else {
            taps[end] = taps[next];
            end += 1;
        }
    }
    taps.truncate(end);
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}
