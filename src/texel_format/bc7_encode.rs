//! BC7 in its mode 6 alone: one pair of RGBA colours a block and 16 steps between them. Integers, so the same everywhere; other
//! encoders use all eight modes and reach closer (their files can be read: `crate::texture_file`).

use rayon::prelude::*;

use crate::pyramid::PlaneImage;

type Colour = [i32; 4];

/// Weight of the second colour, of 64, by index.
const WEIGHTS: [i32; 16] = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64];

/// The blocks of a plane, row after row. Blocks that reach over the edge repeat its texels.
pub fn plane(plane: &PlaneImage) -> Vec<u8> {
    let (width, height) = (plane.width as usize, plane.height as usize);
    let columns = width.div_ceil(4);
    (0..columns * height.div_ceil(4))
        .into_par_iter()
        .flat_map_iter(|number| {
            let (left, top) = (number % columns * 4, number / columns * 4);
            let texels = std::array::from_fn(|texel| {
                let (x, y) = ((left + texel % 4).min(width - 1), (top + texel / 4).min(height - 1));
                plane.texels[y * width + x].map(i32::from)
            });
            block(&texels)
        })
        .collect()
}

fn distance(a: Colour, b: Colour) -> i32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// The two texels farthest apart, the first such pair.
fn extremes(texels: &[Colour; 16]) -> [Colour; 2] {
    let mut farthest = (0, [texels[0]; 2]);
    for (number, &a) in texels.iter().enumerate() {
        for &b in &texels[number + 1..] {
            let apart = distance(a, b);
            if apart > farthest.0 {
                farthest = (apart, [a, b]);
            }
        }
    }
    farthest.1
}

/// A pair of end colours as stored, and which step between them each texel takes.
#[derive(Clone, Copy)]
struct Fit {
    codes: [Colour; 2],
    lowest: [i32; 2],
    indices: [u8; 16],
    error: i32,
}

/// 16 bytes for 16 texels.
fn block(texels: &[Colour; 16]) -> [u8; 16] {
    let ends = extremes(texels);
    let mut best: Option<Fit> = None;
    for lowest in [[0, 0], [0, 1], [1, 0], [1, 1]] {
        let fit = fit(texels, ends, lowest);
        if best.is_none_or(|best| fit.error < best.error) {
            best = Some(fit);
        }
    }
    pack(best.expect("there were four"))
}

fn fit(texels: &[Colour; 16], ends: [Colour; 2], lowest: [i32; 2]) -> Fit {
    let code = |end: usize| ends[end].map(|channel| ((channel - lowest[end] + 1) >> 1).clamp(0, 127));
    let codes = [code(0), code(1)];
    let [low, high] = [0, 1].map(|end| codes[end].map(|code| code << 1 | lowest[end]));
    let steps: [Colour; 16] = WEIGHTS
        .map(|weight| std::array::from_fn(|channel| ((64 - weight) * low[channel] + weight * high[channel] + 32) >> 6));
    let mut error = 0;
    let indices = texels.map(|texel| {
        let nearest = steps.iter().map(|&step| distance(texel, step)).enumerate().min_by_key(|&(_, apart)| apart);
        let (index, apart) = nearest.unwrap_or_default();
        error += apart;
        index as u8
    });
    Fit { codes, lowest, indices, error }
}

fn pack(mut fit: Fit) -> [u8; 16] {
    // The first index is stored without its top bit: turn the pair round where that bit is set.
    if fit.indices[0] >= 8 {
        fit.codes.swap(0, 1);
        fit.lowest.swap(0, 1);
        fit.indices = fit.indices.map(|index| 15 - index);
    }
    let mut bits = 1u128 << 6;
    let mut next = 7;
    let mut put = |value: u128, count: u32| {
        bits |= value << next;
        next += count;
    };
    for channel in 0..4 {
        for end in fit.codes {
            put(end[channel] as u128, 7);
        }
    }
    for lowest in fit.lowest {
        put(lowest as u128, 1);
    }
    for (texel, index) in fit.indices.into_iter().enumerate() {
        put(index.into(), if texel == 0 { 3 } else { 4 });
    }
    bits.to_le_bytes()
}
