//! The address unit: no two texels of a pyramid share a byte, and none lies outside the memory.

use texunit_hw::{AddressMode, Format, Layout, PyramidKind, Surface, address::AddressUnit, address::is_outside};

use super::{Chip, Proof, Tally, Work};
use crate::names::layout_name;

const LAYOUTS: [Layout; 9] = [
    Layout::RowMajor,
    Layout::Tiled { log2_width: 2, log2_height: 2 },
    Layout::Tiled { log2_width: 3, log2_height: 2 },
    Layout::Tiled { log2_width: 0, log2_height: 5 },
    Layout::Morton,
    Layout::Blocked { block: [2, 2], superblock: [4, 4] },
    Layout::Blocked { block: [2, 1], superblock: [6, 6] },
    Layout::Blocked { block: [0, 3], superblock: [5, 3] },
    Layout::Williams,
];

/// A format of each number of bytes an element, and both kinds of block.
const FORMATS: [Format; 5] = [Format::L8, Format::Rgb565, Format::Rgba8, Format::Bc1, Format::Bc3];

const KINDS: [PyramidKind; 4] = [PyramidKind::Mipmap, PyramidKind::Dipmap, PyramidKind::Ripmap, PyramidKind::Sat];

/// Every size up to this on a side.
const SMALL: u32 = 64;

/// Larger, awkward and long ones.
const LARGE: [[u32; 2]; 8] =
    [[256, 256], [1024, 16], [1000, 600], [257, 255], [7, 4096], [4096, 1], [1, 4096], [1 << 20, 1]];

pub(super) fn proofs<C: Chip>() -> Vec<Proof<C>> {
    let of_layout = |layout: Layout| {
        let name = layout_name(layout);
        let what = format!(
            "address unit, layout {name}: every texel of every plane, all sizes to 64 x 64 and {} large ones, pyramids and element sizes: own bytes, within the memory",
            LARGE.len()
        );
        Proof::new(format!("address-{name}"), what, move |chip: &C, work: &Work<'_>| bijection(chip, work, layout))
    };
    LAYOUTS.into_iter().map(of_layout).collect()
}

fn bijection<C: Chip>(chip: &C, work: &Work<'_>, layout: Layout) -> Option<Tally> {
    let williams = layout == Layout::Williams;
    let mut sizes: Vec<[u32; 2]> = Vec::new();
    for height in 1..=SMALL {
        // Williams holds squares.
        sizes.extend((1..=SMALL).map(|width| [width, height]).filter(|[width, height]| !williams || width == height));
    }
    if work.quick {
        sizes.retain(|[width, height]| (width * 5 + height * 3) % 151 == 0 || width == height && width % 9 == 1);
        sizes.extend([[1023, 9], [5, 1025]].into_iter().filter(|_| !williams));
    } else if williams {
        sizes.extend([[1024; 2], [1000; 2], [255; 2]]);
    } else {
        sizes.extend(LARGE);
    }
    // Large ones first: they take longest.
    sizes.reverse();
    work.over(sizes.len(), |number| {
        let mut tally = Tally::default();
        for kind in KINDS {
            for format in FORMATS {
                // A table holds sums, whatever the texels were stored as; Williams bytes of red, green and blue.
                let makes_sense = if williams {
                    (kind, format) == (PyramidKind::Mipmap, Format::Rgba8)
                } else {
                    kind != PyramidKind::Sat || format == Format::Rgba8
                };
                if makes_sense {
                    texels(chip, layout, kind, format, sizes[number], &mut tally);
                }
            }
        }
        tally
    })
}

/// Which bytes belong to somebody.
struct Claims {
    words: Vec<u64>,
    bytes: u64,
}

impl Claims {
    /// Whether these bytes exist and were nobody's.
    fn claim(&mut self, address: u64, length: u64) -> bool {
        if address.checked_add(length).is_none_or(|end| end > self.bytes) {
            return false;
        }
        let mut free = true;
        let (mut at, end) = (address, address + length);
        while at < end {
            // The part of it in one word.
            let (word, first) = (&mut self.words[(at / 64) as usize], at % 64);
            let count = (end - at).min(64 - first);
            let mask = (u64::MAX >> (64 - count)) << first;
            free &= *word & mask == 0;
            *word |= mask;
            at += count;
        }
        free
    }
}

fn texels<C: Chip>(chip: &C, layout: Layout, kind: PyramidKind, format: Format, size: [u32; 2], tally: &mut Tally) {
    let surface = Surface::new(kind, layout, format, size[0], size[1]).expect("a size and a layout that exist");
    let unit = AddressUnit::new(&surface, [AddressMode::Clip; 2], 8);
    let mut claims = Claims { words: vec![0; surface.bytes.div_ceil(64) as usize], bytes: surface.bytes };
    let log2_block = if kind == PyramidKind::Sat { 0 } else { format.log2_block() };
    // Of a texel's number, its place in the block.
    let within = (1 << log2_block) - 1;
    let length = u64::from(surface.bytes_per_read());
    // A texel's centre, floored: it stays within the texel.
    let centre = |index: u32, texels: u32| i64::from(2 * index + 1) * (1 << 19) / i64::from(texels);
    let several = surface.reads_per_texel() as usize > 1;
    for (number, plane) in surface.planes.iter().enumerate() {
        let mut of_row = vec![0; (plane.width >> log2_block) as usize + 1];
        let centres: Vec<i64> = (0..plane.width).map(|x| centre(x, plane.width)).collect();
        for y in 0..plane.height {
            let v = centre(y, plane.height);
            for (x, &u) in (0..plane.width).zip(&centres) {
                let footprint = chip.point(&unit, number, u, v);
                let address = footprint.address[0];
                let place = &mut of_row[(x >> log2_block) as usize];
                let right = if x & within == 0 && y & within == 0 {
                    *place = address;
                    !is_outside(address)
                        && claims.claim(address, length)
                        && (!several
                            || surface.texel_addresses(number, x, y)[1..surface.reads_per_texel() as usize]
                                .iter()
                                .all(|&other| claims.claim(other, length)))
                } else {
                    *place == address
                };
                let position = (y & within) * 4 + (x & within);
                tally.count(right && footprint.position(0) == position, || {
                    let [width, height] = size;
                    format!(
                        "{kind:?} of {width} x {height} {format:?}: texel ({x}, {y}) of plane {number} at {address:#x}, place {}, of {} bytes",
                        footprint.position(0),
                        surface.bytes
                    )
                });
            }
        }
    }
}
