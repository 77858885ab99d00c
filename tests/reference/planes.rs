//! Pyramids of given texels, for tests.

use texunit::pyramid::{PlaneImage, Pyramid};
use texunit_hw::PyramidKind;

/// The planes of docs/numerics.md, section 2, each texel given by (lu, lv, x, y).
pub fn pyramid(
    kind: PyramidKind,
    width: u32,
    height: u32,
    mut texel: impl FnMut(u8, u8, u32, u32) -> [u8; 4],
) -> Pyramid {
    let [last_u, last_v] = [width, height].map(|size| size.ilog2() as u8);
    let halvings: Vec<(u8, u8)> = match kind {
        PyramidKind::Mipmap => (0..=last_u.max(last_v)).map(|l| (l.min(last_u), l.min(last_v))).collect(),
        PyramidKind::Dipmap => (0..=last_u).map(|lu| (lu, 0)).chain((1..=last_v).map(|lv| (0, lv))).collect(),
        PyramidKind::Sat => vec![(0, 0)],
        PyramidKind::Ripmap => (0..=last_v).flat_map(|lv| (0..=last_u).map(move |lu| (lu, lv))).collect(),
    };
    let planes = halvings
        .into_iter()
        .map(|(lu, lv)| {
            let (width, height) = ((width >> lu).max(1), (height >> lv).max(1));
            let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            PlaneImage { lu, lv, width, height, texels: texels.map(|(x, y)| texel(lu, lv, x, y)).collect() }
        })
        .collect();
    Pyramid { kind, width, height, planes }
}

/// A texture one texel high with these grey columns; its smaller images are black.
pub fn columns(grey: &[u8]) -> Pyramid {
    pyramid(
        PyramidKind::Mipmap,
        grey.len() as u32,
        1,
        |lu, _, x, _| if lu == 0 { [grey[x as usize]; 4] } else { [0; 4] },
    )
}

/// Texels of noise, in every plane its own.
pub fn noise(kind: PyramidKind, size: (u32, u32), seed: u32) -> Pyramid {
    let mut state = seed;
    pyramid(kind, size.0, size.1, |_, _, _, _| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state ^ (state >> 16)).to_le_bytes()
    })
}
