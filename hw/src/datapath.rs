//! The datapath: weighted sums of 8-bit channels (docs/numerics.md, section 6).

use crate::{
    address::{Footprint, is_outside},
    sampler::Rounding,
};

/// Red, green, blue, alpha.
pub type Texel = [u8; 4];

/// Where the datapath gets its texels: the bytes of the data banks, in the layout and format of the surface.
pub trait TexelSource {
    /// The texel at an address inside the texture; `plane` is its storage index, `position` its place in its block.
    fn texel(&self, address: u64, plane: u16, position: u32) -> Texel;

    /// One of the four texels of a tap, transparent black outside.
    #[inline]
    fn texel_or_outside(&self, tap: &Footprint, number: usize) -> Texel {
        let address = tap.address[number];
        if is_outside(address) { [0; 4] } else { self.texel(address, tap.plane, tap.position(number)) }
    }
}

/// `a` to `b` at `fraction / 2^bits`, `half` added before the shift.
///
/// ```
/// use texunit_hw::datapath::lerp;
/// assert_eq!(lerp(10, 21, 128, 8, 128), 16); // half way, half up
/// ```
#[inline]
#[must_use]
pub const fn lerp(a: u64, b: u64, fraction: u64, bits: u32, half: u64) -> u64 {
    (a * ((1 << bits) - fraction) + b * fraction + half) >> bits
}

/// Half of the last bit that a shift keeps.
#[inline]
const fn half_of(shift: u32) -> u64 {
    (1 << shift) >> 1
}

/// Filters one request at any width and rounding: `texels` is 1 or 4 a tap.
#[inline]
pub(crate) fn filter(
    source: &impl TexelSource,
    taps: &[Footprint],
    texels: usize,
    filter_bits: u32,
    weight_bits: u32,
    rounding: Rounding,
) -> Texel {
    let fraction_bits = if texels == 1 { 0 } else { filter_bits };
    let mut sums = [0u64; 4];
    for tap in taps {
        let [f, g] = tap.fraction.map(u64::from);
        let mut corners = [[0u8; 4]; 4];
        for (number, corner) in corners[..texels].iter_mut().enumerate() {
            *corner = source.texel_or_outside(tap, number);
        }
        for (channel, sum) in sums.iter_mut().enumerate() {
            let [c00, c10, c01, c11] = corners.map(|corner| u64::from(corner[channel]));
            let one = 1u64 << fraction_bits;
            let value = match (texels, rounding) {
                (1, _) => c00,
                (_, Rounding::Once) => (c00 * (one - f) + c10 * f) * (one - g) + (c01 * (one - f) + c11 * f) * g,
                (_, staged) => {
                    let half = if staged == Rounding::StagedRound { half_of(fraction_bits) } else { 0 };
                    let top = lerp(c00, c10, f, fraction_bits, half);
                    let bottom = lerp(c01, c11, f, fraction_bits, half);
                    lerp(top, bottom, g, fraction_bits, half)
                }
            };
            *sum += value * u64::from(tap.weight);
        }
    }
    let shift = if rounding == Rounding::Once { 2 * fraction_bits + weight_bits } else { weight_bits };
    let half = if rounding == Rounding::StagedTruncate { 0 } else { half_of(shift) };
    sums.map(|sum| ((sum + half) >> shift) as u8)
}

/// Filters one request at the default width, 8 fraction bits and one rounding, two channels in each 64-bit sum.
///
/// A lane holds at most `255 * 2^24 + 2^23`, so weights of up to 8 bits beside the 16 of the fractions never carry into the next lane.
#[inline]
pub(crate) fn filter_packed(source: &impl TexelSource, taps: &[Footprint], texels: usize, weight_bits: u32) -> Texel {
    let mut red_blue = 0u64;
    let mut green_alpha = 0u64;
    for tap in taps {
        let mut add = |number: usize, weight: u64| {
            let packed = u32::from_le_bytes(source.texel_or_outside(tap, number));
            red_blue += (u64::from(packed & 0xFF) | u64::from(packed & 0x00FF_0000) << 16) * weight;
            green_alpha += (u64::from(packed >> 8 & 0xFF) | u64::from(packed >> 24) << 32) * weight;
        };
        let weight = u64::from(tap.weight);
        if texels == 1 {
            add(0, weight);
            continue;
        }
        let [f, g] = tap.fraction.map(u64::from);
        let [top, bottom] = [(256 - g) * weight, g * weight];
        add(0, (256 - f) * top);
        add(1, f * top);
        add(2, (256 - f) * bottom);
        add(3, f * bottom);
    }
    let shift = if texels == 1 { weight_bits } else { 16 + weight_bits };
    let half = half_of(shift) * 0x1_0000_0001;
    let [red_blue, green_alpha] = [red_blue + half, green_alpha + half].map(|lanes| lanes >> shift);
    [red_blue as u8, green_alpha as u8, (red_blue >> 32) as u8, (green_alpha >> 32) as u8]
}
