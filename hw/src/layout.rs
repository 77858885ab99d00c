//! Layouts: where the texels of one plane lie. Every layout here is separable, `address(x, y) = base + X(x) + Y(y)`
//! (docs/layouts.md), so a layout is two small functions and an address unit is one adder.

/// How the texels of a plane are arranged in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layout {
    /// Rows one after the other.
    RowMajor,
    /// Blocks of `2^log2_width x 2^log2_height` texels, each row-major, the blocks row by row.
    Tiled {
        /// log2 of the block's width.
        log2_width: u8,
        /// log2 of the block's height.
        log2_height: u8,
    },
    /// Bits of x and y interleaved, x lowest; what the longer axis has left over lies above. Planes are padded to powers of two.
    Morton,
    /// Williams' arrangement of 1983: red, green and blue of each level in three quadrants, the next level in the fourth.
    Williams,
    /// Morton inside blocks, Morton of blocks inside superblocks, superblocks row by row: Hakura's 6D blocking, with the block
    /// meant to be a cache line and the superblock a cache.
    Blocked {
        /// log2 of block width and height in texels.
        block: [u8; 2],
        /// log2 of superblock width and height in texels, at least those of the block.
        superblock: [u8; 2],
    },
}

impl Default for Layout {
    fn default() -> Self {
        Self::Tiled { log2_width: 2, log2_height: 2 }
    }
}

/// One plane's arrangement: tiles row by row, with a table of offsets inside a tile for each axis.
///
/// Row-major is the tile of one element, Morton the tile as large as the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Arrangement {
    /// log2 of the tile in elements.
    tile: [u32; 2],
    /// The lower bits of an element's place in its tile are interleaved up to here, the rest above.
    block: [u32; 2],
    /// Interleaved, or row-major inside a block.
    interleaved: bool,
    /// Elements from one row of tiles to the next.
    tile_row: u64,
    /// Elements in all, padding included.
    pub(crate) elements: u64,
}

/// Bits above `log2 n` needed to number `n` things.
fn ceiling_log2(n: u32) -> u32 {
    n.next_power_of_two().trailing_zeros()
}

impl Arrangement {
    /// For a plane of `size` elements. (Williams' planes share one square: see `Surface`.)
    pub(crate) fn new(layout: Layout, size: [u32; 2]) -> Self {
        let (tile, block, interleaved) = match layout {
            Layout::RowMajor | Layout::Williams => ([0; 2], [0; 2], false),
            Layout::Tiled { log2_width, log2_height } => {
                let tile = [log2_width.into(), log2_height.into()];
                (tile, tile, false)
            }
            Layout::Morton => {
                let tile = size.map(ceiling_log2);
                (tile, tile, true)
            }
            Layout::Blocked { block, superblock } => (superblock.map(u32::from), block.map(u32::from), true),
        };
        let tiles = [0, 1].map(|axis| u64::from(size[axis].div_ceil(1 << tile[axis])));
        let tile_row = tiles[0] << (tile[0] + tile[1]);
        Self { tile, block, interleaved, tile_row, elements: tile_row * tiles[1] }
    }

    /// Rows of elements, `pitch` from one to the next.
    pub(crate) fn rows(pitch: u64, rows: u32) -> Self {
        let tile = [0; 2];
        Self { tile, block: tile, interleaved: false, tile_row: pitch, elements: pitch * u64::from(rows) }
    }

    /// Elements before the one at `index` of an axis (0 for x, 1 for y), of those that share its other index.
    pub(crate) fn offset(&self, axis: usize, index: u32) -> u64 {
        let within = u64::from(index) & ((1 << self.tile[axis]) - 1);
        let tile = u64::from(index) >> self.tile[axis];
        let between = if axis == 0 { tile << (self.tile[0] + self.tile[1]) } else { tile * self.tile_row };
        between + self.place_in_tile(axis, within)
    }

    fn place_in_tile(&self, axis: usize, within: u64) -> u64 {
        if !self.interleaved {
            return if axis == 0 { within } else { within << self.tile[0] };
        }
        let in_block = within & ((1 << self.block[axis]) - 1);
        let of_block = within >> self.block[axis];
        let above = [self.tile[0] - self.block[0], self.tile[1] - self.block[1]];
        interleave(in_block, axis, self.block) | interleave(of_block, axis, above) << (self.block[0] + self.block[1])
    }
}

/// Spreads `value` to the bit positions its axis has in an interleaving of `bits[0]` x and `bits[1]` y bits.
fn interleave(value: u64, axis: usize, bits: [u32; 2]) -> u64 {
    let shared = bits[0].min(bits[1]);
    let mut spread = 0;
    for bit in 0..bits[axis] {
        let position = if bit < shared { 2 * bit + axis as u32 } else { bit + shared };
        spread |= (value >> bit & 1) << position;
    }
    spread
}
