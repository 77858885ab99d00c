//! The order in which pixels are visited: it changes no value, only what a cache sees.

/// The order of pixels on the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelOrder {
    /// Rows from the top, each from the left.
    #[default]
    Scanline,
    /// Square tiles in rows from the top, each tile by rows.
    Tiles,
    /// Along the Morton curve: x and y interleaved, x in bit 0, as many bits as the smaller axis has.
    Morton,
}

/// A run of pixels of one row: `x`, `y` of the first, and how many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// Column of the first pixel.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Number of pixels, to the right.
    pub length: u32,
}

/// The runs of an image in order; together they visit each pixel once.
#[derive(Clone, Debug)]
pub struct Spans {
    order: PixelOrder,
    size: [u32; 2],
    tile: u32,
    /// Number of the next run, and of the one past the last.
    next: u64,
    end: u64,
}

impl Spans {
    /// All runs of a `width` x `height` image; `tile` is the edge of a tile for [`PixelOrder::Tiles`].
    #[must_use]
    pub fn new(order: PixelOrder, size: [u32; 2], tile: u32) -> Self {
        let tile = tile.max(1);
        let [width, height] = size.map(u64::from);
        let end = match order {
            PixelOrder::Scanline => height,
            PixelOrder::Tiles => width.div_ceil(u64::from(tile)) * height.div_ceil(u64::from(tile)) * u64::from(tile),
            // Two pixels of a row per run: bit 0 of the curve is bit 0 of x.
            PixelOrder::Morton => {
                let [columns, rows] = size.map(axis_bits);
                (1 << (columns + rows)) / if columns > 0 { 2 } else { 1 }
            }
        };
        Self { order, size, tile, next: 0, end: if width == 0 || height == 0 { 0 } else { end } }
    }

    fn span(&self, number: u64) -> Span {
        let [width, _] = self.size;
        match self.order {
            PixelOrder::Scanline => Span { x: 0, y: narrow(number), length: width },
            PixelOrder::Tiles => {
                let columns = u64::from(width.div_ceil(self.tile));
                let (tile, row) = (number / u64::from(self.tile), number % u64::from(self.tile));
                let x = narrow(tile % columns) * self.tile;
                let y = narrow(tile / columns) * self.tile + narrow(row);
                Span { x, y, length: self.tile.min(width - x) }
            }
            PixelOrder::Morton => {
                let [columns, rows] = self.size.map(axis_bits);
                let length = if columns > 0 { 2 } else { 1 };
                let code = number * length;
                let shared = columns.min(rows);
                let low = code & ((1 << (2 * shared)) - 1);
                let high = narrow(code >> (2 * shared)) << shared;
                let (x, y) = (every_second_bit(low), every_second_bit(low >> 1));
                let (x, y) = if columns > rows { (x | high, y) } else { (x, y | high) };
                Span { x, y, length: narrow(length).min(width.saturating_sub(x)) }
            }
        }
    }
}

impl Iterator for Spans {
    type Item = Span;

    fn next(&mut self) -> Option<Span> {
        while self.next < self.end {
            let span = self.span(self.next);
            self.next += 1;
            // The last tiles and the power-of-two frame of the Morton curve reach beyond the image.
            if span.x < self.size[0] && span.y < self.size[1] {
                return Some(span);
            }
        }
        None
    }
}

/// Bits that number the pixels of an axis.
fn axis_bits(pixels: u32) -> u32 {
    u32::BITS - pixels.saturating_sub(1).leading_zeros()
}

/// Bits 0, 2, 4... of a code, packed.
fn every_second_bit(code: u64) -> u32 {
    let mut bits = code & 0x5555_5555_5555_5555;
    for (shift, mask) in [
        (1, 0x3333_3333_3333_3333),
        (2, 0x0F0F_0F0F_0F0F_0F0F),
        (4, 0x00FF_00FF_00FF_00FF),
        (8, 0x0000_FFFF_0000_FFFF),
        (16, 0x0000_0000_FFFF_FFFF_u64),
    ] {
        bits = (bits | (bits >> shift)) & mask;
    }
    narrow(bits)
}

#[allow(clippy::cast_possible_truncation, reason = "image axes have at most 16 bits")]
fn narrow(value: u64) -> u32 {
    value as u32
}
