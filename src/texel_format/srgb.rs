//! sRGB codes as linear light, from the formula (docs/numerics.md, section 10.4).

use crate::pyramid::PlaneImage;

/// The decoding curve of IEC 61966-2-1 on `[0, 1]`.
#[must_use]
pub fn to_linear(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { libm::pow((code + 0.055) / 1.055, 2.4) }
}

/// A texel's red, green and blue as linear light of 8 bits, half up; alpha as it is.
#[must_use]
pub fn linear_texel([red, green, blue, alpha]: [u8; 4]) -> [u8; 4] {
    let linear = |code: u8| (255.0 * to_linear(f64::from(code) / 255.0) + 0.5).floor() as u8;
    [linear(red), linear(green), linear(blue), alpha]
}

/// The same for every texel of a plane.
pub fn make_linear(plane: &mut PlaneImage) {
    let by_code: [u8; 256] = std::array::from_fn(|code| linear_texel([code as u8; 4])[0]);
    for [red, green, blue, _] in &mut plane.texels {
        for channel in [red, green, blue] {
            *channel = by_code[usize::from(*channel)];
        }
    }
}
