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

/// A texture as the cache sees it and as memory holds it.
#[derive(Clone, Copy, Debug)]
pub struct Decompressed<'a> {
    /// What [`decompress`] makes, and the address its own 0 is at for the cache.
    pub held: (&'a Surface, u64),
    /// What memory holds, and the address its own 0 is at there.
    pub stored: (&'a Surface, u64),
}

/// Stored elements that follow each other in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Piece {
    /// Address of the first.
    pub address: u64,
    /// Bytes of all of them.
    pub bytes: u32,
}

/// What of memory is behind each line of a cache that holds decompressed texels: every stored element with a texel in the line, whole
/// and once. A block whose texels lie in two lines is behind both.
///
/// ```
/// use texunit_hw::{Format, Layout, PyramidKind, Surface};
/// use texunit_hw::decompression::{Decompressed, Piece, StoredLines};
/// let surface = |format| Surface::new(PyramidKind::Mipmap, Layout::RowMajor, format, 64, 64);
/// let (held, stored) = (surface(Format::Rgba8)?, surface(Format::Bc1)?);
/// // A line of 64 bytes is 16 texels of a row: four blocks of 8 bytes, side by side.
/// let lines = StoredLines::new(64, [Decompressed { held: (&held, 0), stored: (&stored, 0) }]);
/// assert_eq!(lines.pieces(1), [Piece { address: 32, bytes: 32 }]);
/// assert_eq!(lines.pieces(4), lines.pieces(0)); // the row below
/// # Ok::<(), texunit_hw::SurfaceError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredLines {
    /// Where the pieces of each line begin, and where those of the last end.
    begins: Vec<u32>,
    pieces: Vec<Piece>,
}

impl StoredLines {
    /// Of lines of `line` bytes, a power of two.
    #[must_use]
    pub fn new<'a>(line: u32, textures: impl IntoIterator<Item = Decompressed<'a>>) -> Self {
        let shift = line.trailing_zeros();
        let (mut of_lines, mut count) = (Vec::new(), 0);
        for texture in textures {
            let (held, at) = texture.held;
            count = count.max(((at + held.bytes) >> shift) + 1);
            add_elements(texture, shift, &mut of_lines);
        }
        of_lines.sort_unstable();
        of_lines.dedup_by(|next, last| join(last, *next));
        let mut begins = vec![0; count as usize + 1];
        for (line, _) in &of_lines {
            begins[*line as usize + 1] += 1;
        }
        for line in 0..count as usize {
            begins[line + 1] += begins[line];
        }
        Self { begins, pieces: of_lines.into_iter().map(|(_, piece)| piece).collect() }
    }

    /// What is behind a line, by its number, in order of address: nothing behind a line without texels.
    #[must_use]
    pub fn pieces(&self, line: u64) -> &[Piece] {
        match self.begins.get(line as usize..).unwrap_or_default() {
            [begin, end, ..] => &self.pieces[*begin as usize..*end as usize],
            _ => &[],
        }
    }

    /// Bytes behind a line.
    #[must_use]
    pub fn bytes(&self, line: u64) -> u64 {
        self.pieces(line).iter().map(|piece| u64::from(piece.bytes)).sum()
    }
}

/// Every element of a texture with every line it has a texel in.
fn add_elements(Decompressed { held, stored }: Decompressed<'_>, shift: u32, of_lines: &mut Vec<(u32, Piece)>) {
    let ((held, held_at), (stored, stored_at)) = (held, stored);
    let side = 1 << stored.format.log2_block();
    let bytes = stored.format.element_bytes();
    let mut lines = Vec::with_capacity(16);
    for (from, to) in stored.planes.iter().zip(&held.planes) {
        let [columns, rows] = from.elements();
        for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
            lines.clear();
            for y in (row * side..(row + 1) * side).take_while(|&y| y < to.height) {
                for x in (column * side..(column + 1) * side).take_while(|&x| x < to.width) {
                    lines.push(((held_at + to.address(x, y)) >> shift) as u32);
                }
            }
            lines.sort_unstable();
            lines.dedup();
            let piece = Piece { address: stored_at + from.address(column * side, row * side), bytes };
            for &line in &lines {
                // Most follow the one before: joined at once they take less memory.
                if !of_lines.last_mut().is_some_and(|last| join(last, (line, piece))) {
                    of_lines.push((line, piece));
                }
            }
        }
    }
}

/// Whether a piece of the same line follows the last, which then takes it in.
fn join((line, last): &mut (u32, Piece), (of, piece): (u32, Piece)) -> bool {
    let follows = *line == of && last.address + u64::from(last.bytes) == piece.address;
    last.bytes += if follows { piece.bytes } else { 0 };
    follows
}
