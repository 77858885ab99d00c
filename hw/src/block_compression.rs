//! BC1 and BC3: one texel of a block of 4 x 4 (docs/numerics.md, section 10.3).

use crate::datapath::Texel;

/// `sum / full` as 8 bits, to nearest: `floor(255 sum / full + 1/2)`.
#[inline]
const fn nearest(sum: u32, full: u32) -> u8 {
    ((2 * 255 * sum + full) / (2 * full)) as u8
}

/// Red, green, blue of a 5:6:5 code, not expanded: what lies between two codes is rounded once, to 8 bits.
#[inline]
const fn channels(code: u32) -> [u32; 3] {
    [code >> 11 & 31, code >> 5 & 63, code & 31]
}

/// The texel at a position of an 8-byte colour block; `punch_through` is BC1's mode with a transparent fourth colour.
#[inline]
fn colour(block: &[u8], position: u32, punch_through: bool) -> Texel {
    let codes = [0, 2].map(|at| u32::from(u16::from_le_bytes([block[at], block[at + 1]])));
    let index = block[4 + (position / 4) as usize] >> (2 * (position % 4)) & 3;
    // Parts of the first and of the second colour.
    let parts = match (index, punch_through && codes[0] <= codes[1]) {
        (0, _) => [1, 0],
        (1, _) => [0, 1],
        (2, false) => [2, 1],
        (_, false) => [1, 2],
        (2, true) => [1, 1],
        (_, true) => return [0; 4],
    };
    let [first, second] = codes.map(channels);
    let channel =
        |at: usize, most: u32| nearest(parts[0] * first[at] + parts[1] * second[at], most * (parts[0] + parts[1]));
    [channel(0, 31), channel(1, 63), channel(2, 31), 255]
}

/// The texel at a position of a BC1 block of 8 bytes.
#[inline]
pub fn bc1(block: &[u8], position: u32) -> Texel {
    colour(block, position, true)
}

/// The texel at a position of a BC3 block of 16 bytes.
#[inline]
pub fn bc3(block: &[u8], position: u32) -> Texel {
    let [red, green, blue, _] = colour(&block[8..], position, false);
    let [first, second] = [block[0], block[1]].map(u32::from);
    let mut indices = [0; 8];
    indices[..6].copy_from_slice(&block[2..8]);
    let index = (u64::from_le_bytes(indices) >> (3 * position) & 7) as u32;
    let alpha = match (index, first > second) {
        (0, _) => first,
        (1, _) => second,
        (_, true) => ((8 - index) * first + (index - 1) * second + 1) / 7,
        (6, false) => 0,
        (7, false) => 255,
        (_, false) => ((6 - index) * first + (index - 1) * second + 1) / 5,
    };
    [red, green, blue, alpha as u8]
}
