//! Every layout is a bijection from texels into bytes, and the arrangement its name says.

use std::collections::BTreeSet;

use texunit_hw::{Format, Layout, PyramidKind, Surface, SurfaceError};

const LAYOUTS: [Layout; 7] = [
    Layout::RowMajor,
    Layout::Tiled { log2_width: 2, log2_height: 2 },
    Layout::Tiled { log2_width: 3, log2_height: 1 },
    Layout::Tiled { log2_width: 0, log2_height: 4 },
    Layout::Morton,
    Layout::Blocked { block: [2, 2], superblock: [4, 4] },
    Layout::Blocked { block: [1, 3], superblock: [5, 3] },
];

fn addresses_are_distinct(surface: &Surface) {
    let mut seen = BTreeSet::new();
    for (number, plane) in surface.planes.iter().enumerate() {
        for y in 0..plane.height {
            for x in 0..plane.width {
                let reads = surface.texel_addresses(number, x, y);
                for &address in &reads[..surface.reads_per_texel() as usize] {
                    for byte in address..address + u64::from(surface.bytes_per_read()) {
                        assert!(byte < surface.bytes, "{:?}: byte {byte} of {}", surface.layout, surface.bytes);
                        assert!(
                            seen.insert(byte),
                            "{:?}: byte {byte} twice, plane {number} ({x}, {y})",
                            surface.layout
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn no_two_texels_share_a_byte_in_any_layout_of_any_small_size() {
    for (width, height) in (1..=20).flat_map(|width| (1..=20).map(move |height| (width, height))) {
        for kind in [PyramidKind::Mipmap, PyramidKind::Dipmap, PyramidKind::Ripmap] {
            for layout in LAYOUTS {
                addresses_are_distinct(&Surface::new(kind, layout, Format::Rgba8, width, height).unwrap());
            }
        }
        let williams = Surface::new(PyramidKind::Mipmap, Layout::Williams, Format::Rgba8, width, height);
        match williams {
            Ok(surface) => addresses_are_distinct(&surface),
            Err(error) => assert!(width != height, "{error}"),
        }
    }
}

#[test]
fn tiles_hold_their_texels_row_by_row_and_follow_row_by_row() {
    let layout = Layout::Tiled { log2_width: 2, log2_height: 2 };
    let surface = Surface::new(PyramidKind::Mipmap, layout, Format::Rgba8, 16, 8).unwrap();
    let plane = &surface.planes[0];
    assert_eq!(plane.address(3, 2), 4 * (2 * 4 + 3)); // inside the first tile
    assert_eq!(plane.address(4, 0), 64); // the next tile, the next line
    assert_eq!(plane.address(0, 4), 4 * 64); // the next row of four tiles
}

#[test]
fn morton_interleaves_x_lowest_and_puts_the_longer_axis_above() {
    let surface = Surface::new(PyramidKind::Mipmap, Layout::Morton, Format::Rgba8, 16, 4).unwrap();
    let place = |x, y| surface.planes[0].address(x, y) / 4;
    assert_eq!([place(1, 0), place(0, 1), place(2, 0), place(0, 2), place(4, 0), place(8, 0)], [1, 2, 4, 8, 16, 32]);
}

#[test]
fn blocks_are_morton_inside_and_among_each_other() {
    let layout = Layout::Blocked { block: [2, 2], superblock: [4, 4] };
    let surface = Surface::new(PyramidKind::Mipmap, layout, Format::Rgba8, 64, 32).unwrap();
    let place = |x, y| surface.planes[0].address(x, y) / 4;
    assert_eq!([place(1, 0), place(0, 1), place(4, 0), place(0, 4), place(8, 0)], [1, 2, 16, 32, 64]);
    assert_eq!([place(16, 0), place(0, 16)], [256, 4 * 256]); // superblocks row by row, four in a row
}

#[test]
fn williams_quadrants_nest_towards_the_origin() {
    let surface = Surface::new(PyramidKind::Mipmap, Layout::Williams, Format::Rgba8, 8, 8).unwrap();
    assert_eq!(surface.bytes, 16 * 16);
    assert_eq!(surface.texel_addresses(0, 0, 0), [8, 8 * 16, 8 * 16 + 8]);
    assert_eq!(surface.texel_addresses(1, 3, 2), [4 + 3 + 2 * 16, 3 + (4 + 2) * 16, 4 + 3 + (4 + 2) * 16]);
    assert_eq!(surface.texel_addresses(3, 0, 0), [1, 16, 17]);
}

#[test]
fn a_dipmap_shares_its_base_plane() {
    let surface = Surface::new(PyramidKind::Dipmap, Layout::RowMajor, Format::Rgba8, 256, 256).unwrap();
    let texels: u64 = surface.planes.iter().map(|plane| u64::from(plane.width) * u64::from(plane.height)).sum();
    assert_eq!(texels, 3 * 256 * 256 - 2 * 256); // E11
    assert_eq!(surface.index(0, 0), 0);
    assert_eq!((surface.planes[surface.index(5, 0)].width, surface.planes[surface.index(0, 5)].height), (8, 8));
}

#[test]
fn addresses_go_beyond_32_bits() {
    let surface = Surface::new(PyramidKind::Mipmap, Layout::default(), Format::Rgba8, 65536, 65536).unwrap();
    assert_eq!(surface.planes[0].address(65535, 65535), 4 * 65536 * 65536 - 4); // X14
}

#[test]
fn impossible_surfaces_are_refused_with_the_reason() {
    let size = Surface::new(PyramidKind::Mipmap, Layout::RowMajor, Format::Rgba8, 0, 4).unwrap_err();
    assert!(size.to_string().contains("0 x 4"), "{size}");
    let block = Layout::Blocked { block: [4, 4], superblock: [3, 4] };
    assert_eq!(Surface::new(PyramidKind::Mipmap, block, Format::Rgba8, 4, 4).unwrap_err(), SurfaceError::Block(block));
}
