//! The jitter of FAST (docs/numerics.md, section 5.2; E25): from a hash of the pixel, so that it depends on nothing else.
//!
//! Shifts and wrapping products are what the page defines it by, so they are used here too.

/// How far sample `sample` of a pixel is moved at a level, in parts of a sample's share of the pixel: x and y, each in
/// `[0, 1)`.
#[must_use]
pub fn jitter(pixel: [u16; 2], sample: u32, level: u32) -> [f64; 2] {
    let place = u32::from(pixel[0]) + 65_536 * u32::from(pixel[1]);
    let which = sample.wrapping_mul(0x9E37_79B9).wrapping_add(level.wrapping_mul(0x85EB_CA6B));
    let h = place ^ which;
    let h = (h ^ (h >> 16)).wrapping_mul(0x85EB_CA6B);
    let h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE35);
    let [x, y, ..] = (h ^ (h >> 16)).to_le_bytes();
    [x, y].map(|byte| f64::from(byte) / 256.0)
}
