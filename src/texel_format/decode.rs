//! Elements into texels, the reference's way: shares nothing with the chip's decoders. Codes are real numbers here, and blocks are
//! left to the `bcdec_rs` crate.

use texunit_hw::{Format, Palette};

use super::StoredPlane;

type Block = [[u8; 4]; 16];

/// All texels of a plane, row after row.
pub fn plane(format: Format, palette: Option<&Palette>, plane: &StoredPlane) -> Vec<[u8; 4]> {
    match format {
        Format::Rgba8 => each(plane, |element: [u8; 4]| element),
        Format::Rgb565 => words(plane, |word| [field(word, 11, 5), field(word, 5, 6), field(word, 0, 5), 255]),
        Format::Argb1555 => {
            words(plane, |word| [field(word, 10, 5), field(word, 5, 5), field(word, 0, 5), field(word, 15, 1)])
        }
        Format::Argb4444 => {
            words(plane, |word| [field(word, 8, 4), field(word, 4, 4), field(word, 0, 4), field(word, 12, 4)])
        }
        Format::L8 => each(plane, |[grey]| [grey, grey, grey, 255]),
        Format::A8 => each(plane, |[alpha]| [0, 0, 0, alpha]),
        Format::La8 => each(plane, |[grey, alpha]| [grey, grey, grey, alpha]),
        Format::Palette8 => each(plane, |[index]| palette.map_or([0; 4], |colours| colours[usize::from(index)])),
        Format::Bc1 => blocks(plane, 8, bcdec_rs::bc1),
        Format::Bc3 => blocks(plane, 16, bcdec_rs::bc3),
        Format::Bc7 => blocks(plane, 16, bcdec_rs::bc7),
    }
}

fn each<const BYTES: usize>(plane: &StoredPlane, texel: impl Fn([u8; BYTES]) -> [u8; 4]) -> Vec<[u8; 4]> {
    plane.elements.as_chunks().0.iter().map(|&element| texel(element)).collect()
}

fn words(plane: &StoredPlane, texel: impl Fn(f64) -> [u8; 4]) -> Vec<[u8; 4]> {
    each(plane, |bytes| texel(f64::from(u16::from_le_bytes(bytes))))
}

/// The `bits` bits of a word above bit `from`, as 8 bits: read as a binary fraction, repeated for ever, cut after 8 places.
fn field(word: f64, from: i32, bits: i32) -> u8 {
    let shifted = (word * libm::exp2(f64::from(-from))).floor();
    let values = libm::exp2(f64::from(bits));
    let code = shifted - (shifted / values).floor() * values;
    // 0.codecodecode... = code / (2^bits - 1), all ones being 1 itself.
    let repeated = code / (values - 1.0) * 256.0;
    repeated.floor().min(255.0) as u8
}

fn blocks(plane: &StoredPlane, bytes: usize, decode: fn(&[u8], &mut [u8], usize)) -> Vec<[u8; 4]> {
    let (width, height) = (plane.width as usize, plane.height as usize);
    let mut texels = vec![[0; 4]; width * height];
    for (number, element) in plane.elements.chunks_exact(bytes).enumerate() {
        let (left, top) = (number % width.div_ceil(4) * 4, number / width.div_ceil(4) * 4);
        let mut block: Block = [[0; 4]; 16];
        decode(element, block.as_flattened_mut(), 16);
        for (row, line) in block.chunks_exact(4).enumerate().take(height - top) {
            let begin = (top + row) * width + left;
            let count = 4.min(width - left);
            texels[begin..begin + count].copy_from_slice(&line[..count]);
        }
    }
    texels
}
