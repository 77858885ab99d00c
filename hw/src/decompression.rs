//! A decompressor between memory and cache: the cache holds RGBA8, a fill fetches the stored elements behind it
//! (docs/numerics.md, section 10.5).

use alloc::{vec, vec::Vec};

use crate::{
    datapath::TexelSource,
    format::Format,
    memory::{Stored, store_plane},
    surface::{Surface, SurfaceError},
};

/// What the cache sees of a stored texture: the same planes in the same layout as RGBA8, and their bytes. sRGB codes stay codes;
/// they are made linear behind the cache.
///
/// # Errors
/// What [`Surface::new`] refuses.
///
/// # Panics
/// If `bytes` are not those of the surface.
pub fn decompress(stored: &Surface, bytes: &[u8]) -> Result<(Surface, Vec<u8>), SurfaceError> {
    let [width, height] = stored.planes[0].size();
    let mut held = Surface::new(stored.kind, stored.layout, Format::Rgba8, width, height)?;
    held.srgb = stored.srgb;
    let codes = Surface { srgb: false, ..stored.clone() };
    let source = Stored { bytes, surface: &codes };
    let mut held_bytes = vec![0; held.bytes as usize];
    for (number, plane) in codes.planes.iter().enumerate() {
        let mut texels = Vec::with_capacity(plane.width as usize * plane.height as usize * 4);
        for y in 0..plane.height {
            for x in 0..plane.width {
                let position = plane.position(0, x) + plane.position(1, y);
                texels.extend(source.texel(plane.address(x, y), number as u16, position));
            }
        }
        store_plane(&held, number, &texels, &mut held_bytes).expect("a layout of one read a texel holds every texel");
    }
    Ok((held, held_bytes))
}

/// Bytes of memory behind each line of `line` bytes of what [`decompress`] makes, by line number: every stored element with a
/// texel in the line, whole and once. A block whose texels lie in two lines is fetched for each of them.
#[must_use]
pub fn fill_bytes(stored: &Surface, held: &Surface, line: u32) -> Vec<u32> {
    let shift = line.trailing_zeros();
    let mut fills = vec![0; (held.bytes >> shift) as usize + 1];
    let side = 1 << stored.format.log2_block();
    let mut lines = Vec::with_capacity(16);
    for (from, to) in stored.planes.iter().zip(&held.planes) {
        let [columns, rows] = from.elements();
        for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
            lines.clear();
            for y in (row * side..(row + 1) * side).take_while(|&y| y < to.height) {
                for x in (column * side..(column + 1) * side).take_while(|&x| x < to.width) {
                    lines.push(to.address(x, y) >> shift);
                }
            }
            lines.sort_unstable();
            lines.dedup();
            for &line in &lines {
                fills[line as usize] += stored.format.element_bytes();
            }
        }
    }
    fills
}
