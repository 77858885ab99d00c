//! Every texel format: what its codes mean, what is asked and fetched, and that the chip reads what the reference reads.
#![allow(clippy::unusual_byte_groupings, reason = "digits are grouped as the fields of a texel are")]

use proptest::prelude::*;
use texunit::{
    experiment::verify::SplitMix,
    machine::Machine,
    pyramid::{Build, PlaneImage, Pyramid},
    reference::Reference,
    texel_format::{Stored, StoredPlane, palette, plane_bytes, srgb},
    texture_file::TextureImage,
    texture_memory::{Decompress, Held, Storage},
};
use texunit_hw::{
    AddressMode, Filter, Format, I12F20, Layout, LodSource, PyramidKind, Request, Response, Rounding, Sampler, Unit,
    cache::{Counters, Detail, Geometry, Policy, TexelCache},
};

const FORMATS: [Format; 11] = [
    Format::Rgba8,
    Format::Rgb565,
    Format::Argb1555,
    Format::Argb4444,
    Format::L8,
    Format::A8,
    Format::La8,
    Format::Palette8,
    Format::Bc1,
    Format::Bc3,
    Format::Bc7,
];

const LAYOUTS: [Layout; 5] = [
    Layout::Tiled { log2_width: 2, log2_height: 2 },
    Layout::RowMajor,
    Layout::Morton,
    Layout::Tiled { log2_width: 1, log2_height: 3 },
    Layout::Blocked { block: [1, 1], superblock: [3, 2] },
];

const NO_PALETTE: [[u8; 4]; 256] = [[0; 4]; 256];

/// One plane of given elements.
fn one_plane(format: Format, width: u32, height: u32, elements: Vec<u8>) -> Stored {
    let planes = vec![StoredPlane { lu: 0, lv: 0, width, height, elements }];
    Stored { kind: PyramidKind::Mipmap, width, height, format, palette: None, planes }
}

#[test]
fn codes_of_16_bits_mean_the_same_to_chip_and_reference_and_survive_a_round_trip() {
    for format in [Format::Rgb565, Format::Argb1555, Format::Argb4444, Format::La8] {
        let elements: Vec<u8> = (0..=u16::MAX).flat_map(u16::to_le_bytes).collect();
        let stored = one_plane(format, 256, 256, elements.clone());
        let decoded = stored.decode();
        for (element, texel) in elements.chunks_exact(2).zip(&decoded.planes[0].texels) {
            assert_eq!(format.decode(element, 0, &NO_PALETTE), *texel, "{format:?} {element:?}");
        }
        assert_eq!(Stored::encode(&decoded, format).planes[0].elements, elements, "{format:?}");
    }
}

#[test]
fn codes_of_8_bits_mean_the_same_to_chip_and_reference_and_survive_a_round_trip() {
    for format in [Format::L8, Format::A8] {
        let elements: Vec<u8> = (0..=255).collect();
        let decoded = one_plane(format, 256, 1, elements.clone()).decode();
        for (element, texel) in elements.iter().zip(&decoded.planes[0].texels) {
            assert_eq!(format.decode(&[*element], 0, &NO_PALETTE), *texel, "{format:?} {element}");
        }
        assert_eq!(Stored::encode(&decoded, format).planes[0].elements, elements, "{format:?}");
    }
}

#[test]
fn channels_expand_by_repeating_their_bits() {
    let decode = |format: Format, word: u16| format.decode(&word.to_le_bytes(), 0, &NO_PALETTE);
    assert_eq!(decode(Format::Rgb565, 0b00011_000011_10000), [0b00011000, 0b00001100, 0b10000100, 255]);
    assert_eq!(decode(Format::Argb1555, 0b1_11111_00001_10000), [255, 0b00001000, 0b10000100, 255]);
    assert_eq!(decode(Format::Argb1555, 0), [0; 4]);
    assert_eq!(decode(Format::Argb4444, 0x1234), [0x22, 0x33, 0x44, 0x11]);
    assert_eq!(decode(Format::La8, 0x80FF), [255, 255, 255, 128]);
}

#[test]
fn no_code_is_nearer_to_any_value_than_the_one_it_gets() {
    let texels: Vec<[u8; 4]> = (0..=255).map(|value| [value; 4]).collect();
    let pyramid = one_pyramid(256, 1, texels);
    for (format, bits) in [(Format::Rgb565, [5, 6, 5]), (Format::Argb1555, [5; 3]), (Format::Argb4444, [4; 3])] {
        let decoded = Stored::encode(&pyramid, format).decode();
        for (value, texel) in (0..=255i32).zip(&decoded.planes[0].texels) {
            for (channel, bits) in bits.into_iter().enumerate() {
                let best =
                    (0..1i32 << bits).map(|code| (repeated(code, bits) - value).abs()).min().expect("there is a code");
                assert_eq!((i32::from(texel[channel]) - value).abs(), best, "{format:?} {value} channel {channel}");
            }
        }
    }
}

/// Bits of a code repeated to 8, bit by bit.
fn repeated(code: i32, bits: i32) -> i32 {
    (0..8).fold(0, |eight, place| eight << 1 | code >> (bits - 1 - place % bits) & 1)
}

fn one_pyramid(width: u32, height: u32, texels: Vec<[u8; 4]>) -> Pyramid {
    Pyramid { kind: PyramidKind::Mipmap, width, height, planes: vec![PlaneImage::top(width, height, texels)] }
}

#[test]
fn random_blocks_mean_the_same_to_chip_and_reference() {
    type Decoder = fn(&[u8], &mut [u8], usize);
    let decoders: [(Format, Decoder); 3] =
        [(Format::Bc1, bcdec_rs::bc1), (Format::Bc3, bcdec_rs::bc3), (Format::Bc7, bcdec_rs::bc7)];
    for (format, decoder) in decoders {
        let mut random = SplitMix(format.element_bytes().into());
        for number in 0..100_000u32 {
            let mut block = [0; 16];
            block[..8].copy_from_slice(&random.draw().to_le_bytes());
            block[8..].copy_from_slice(&random.draw().to_le_bytes());
            if format == Format::Bc7 {
                // All modes alike, the reserved one too.
                let mode = number % 9;
                block[0] = if mode == 8 { 0 } else { (block[0] | 1) << mode };
            }
            if number % 5 == 0 {
                // Equal end colours and alphas, which choose the other mode.
                block.copy_within(0..1, 1);
                block.copy_within(8..10, 10);
            }
            let mut texels = [[0u8; 4]; 16];
            decoder(&block, texels.as_flattened_mut(), 16);
            for (position, texel) in (0..).zip(texels) {
                assert_eq!(format.decode(&block, position, &NO_PALETTE), texel, "{format:?} {block:?} {position}");
            }
        }
    }
}

#[test]
fn every_pair_of_block_end_colours_of_a_channel_has_the_nearest_steps_between() {
    // BC1 with both red codes free: the nearest to the exact mixture, which has no tie.
    for (first, second) in (0..32u16).flat_map(|first| (0..32u16).map(move |second| (first, second))) {
        let mut block = [0u8; 8];
        block[..2].copy_from_slice(&(first << 11 | 32).to_le_bytes());
        block[2..4].copy_from_slice(&(second << 11).to_le_bytes());
        block[4] = 0b11_10_01_00;
        let red = |position| f64::from(Format::Bc1.decode(&block, position, &NO_PALETTE)[0]);
        let full = |part: f64| 255.0 * part / 31.0;
        let (a, b) = (f64::from(first), f64::from(second));
        let expected =
            if first >= second { [a, b, (2.0 * a + b) / 3.0, (a + 2.0 * b) / 3.0] } else { [a, b, (a + b) / 2.0, 0.0] };
        for (position, expected) in (0..).zip(expected) {
            assert!((red(position) - full(expected)).abs() <= 0.5, "{first} {second} {position}");
        }
    }
}

#[test]
fn blocks_of_one_colour_are_encoded_close_to_it() {
    for format in [Format::Bc1, Format::Bc3, Format::Bc7] {
        let mut random = SplitMix(7);
        for _ in 0..200 {
            let [r, g, b, _] = (random.draw() as u32).to_le_bytes();
            let decoded = Stored::encode(&one_pyramid(5, 3, vec![[r, g, b, 255]; 15]), format).decode();
            for texel in &decoded.planes[0].texels {
                let apart = texel.iter().zip([r, g, b, 255]).map(|(a, b)| a.abs_diff(b)).max().expect("4 channels");
                assert!(apart <= 4, "{format:?} {r} {g} {b}: {texel:?}");
            }
        }
    }
}

#[test]
fn a_bc7_block_of_two_colours_keeps_both_within_one() {
    let texels: Vec<[u8; 4]> =
        (0..16).map(|texel| if texel % 3 == 1 { [250, 10, 99, 30] } else { [3, 77, 180, 255] }).collect();
    let decoded = Stored::encode(&one_pyramid(4, 4, texels.clone()), Format::Bc7).decode();
    for (texel, wanted) in decoded.planes[0].texels.iter().zip(texels) {
        assert!(texel.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= 1), "{texel:?} for {wanted:?}");
    }
}

#[test]
fn a_texture_of_few_colours_keeps_them_and_its_averages_find_the_nearest_the_lowest_of_two() {
    let (black, grey, white) = ([0, 0, 0, 255], [100, 100, 100, 255], [200, 200, 200, 255]);
    let mut palette = NO_PALETTE;
    palette[3..6].copy_from_slice(&[black, white, white]);
    assert_eq!(palette::nearest(&palette, white), 4);
    assert_eq!(palette::nearest(&palette, grey), 3); // as far from black as from white
    assert_eq!(palette::nearest(&palette, [101, 100, 100, 255]), 4);

    // Averages are made of colours, and have room in the palette: the grey of the smaller plane is there (E17).
    let top = PlaneImage::top(2, 1, vec![black, white]);
    let pyramid = Build::default().pyramid(PyramidKind::Mipmap, &top).unwrap();
    let stored = Stored::encode(&pyramid, Format::Palette8);
    assert_eq!(stored.decode(), pyramid);
    assert_eq!(stored.planes[0].elements, [0, 1]);
}

#[test]
fn a_palette_of_a_texture_of_many_colours_has_256_of_them_and_comes_close() {
    let texels: Vec<[u8; 4]> = (0..64 * 64).map(|n: i32| [(n % 64 * 4) as u8, (n / 64 * 4) as u8, 128, 255]).collect();
    let stored = Stored::encode(&one_pyramid(64, 64, texels.clone()), Format::Palette8);
    let mut entries = stored.palette.as_deref().expect("a palette").to_vec();
    entries.sort_unstable();
    entries.dedup();
    assert_eq!(entries.len(), 256);
    for (texel, wanted) in stored.decode().planes[0].texels.iter().zip(texels) {
        // 256 boxes of 16 x 16 levels each: no texel is farther than a box and a half from its colour.
        assert!(texel.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= 24), "{texel:?} for {wanted:?}");
    }
}

#[test]
fn linear_light_is_the_curve_of_the_standard_in_8_bits() {
    for code in 0..=255u8 {
        let texel = [code, 255 - code, code, code];
        assert_eq!(texunit_hw::srgb::linear(texel), srgb::linear_texel(texel), "{code}");
    }
    let linear: Vec<u8> = (0..=255).map(|code| srgb::linear_texel([code; 4])[0]).collect();
    assert!(linear.windows(2).all(|pair| pair[0] <= pair[1]));
    assert_eq!((linear[0], linear[188], linear[255]), (0, 128, 255));
    let mut distinct = linear;
    distinct.dedup();
    assert_eq!(distinct.len(), 183); // docs/numerics.md, section 10.4: what 8 bits of light keep apart
}

fn random_stored(kind: PyramidKind, format: Format, [width, height]: [u32; 2], seed: u64) -> Stored {
    let mut random = SplitMix(seed);
    let palette =
        (format == Format::Palette8).then(|| Box::new(std::array::from_fn(|_| (random.draw() as u32).to_le_bytes())));
    let planes = texunit_hw::surface::planes_of(kind, width, height)
        .into_iter()
        .map(|(lu, lv)| {
            let [width, height] = [(width >> lu).max(1), (height >> lv).max(1)];
            let elements = (0..plane_bytes(format, width, height)).map(|_| random.draw() as u8).collect();
            StoredPlane { lu, lv, width, height, elements }
        })
        .collect();
    Stored { kind, width, height, format, palette, planes }
}

/// Filters of both pyramids, with texels of 1 and 4 a tap.
const FILTERS: [Filter; 5] = [Filter::Point, Filter::Bilinear, Filter::NearestMip, Filter::Trilinear, Filter::Dipmap];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn chip_and_reference_agree_on_random_elements(
        format in 0..FORMATS.len(), layout in 0..LAYOUTS.len(), filter in 0..FILTERS.len(), mode in 0..4usize,
        size in [1..40u32, 1..40u32], before_cache: bool, srgb: bool, staged: bool, seed: u64,
    ) {
        let (format, filter) = (FORMATS[format], FILTERS[filter]);
        let modes = [AddressMode::Wrap, AddressMode::Clamp, AddressMode::Clip, AddressMode::Mirror];
        let decompress = if before_cache { Decompress::BeforeCache } else { Decompress::AfterCache };
        let storage = Storage { layout: LAYOUTS[layout], format, decompress, srgb };
        let held = Held::new(&random_stored(filter.pyramid(), format, size, seed), &storage).unwrap();
        let sampler = Sampler {
            filter,
            address: [modes[mode]; 2],
            lod_source: LodSource::Explicit,
            rounding: if staged { Rounding::StagedRound } else { Rounding::Once },
            ..Sampler::default()
        };
        let mut random = SplitMix(!seed);
        let requests: Vec<Request> = (0..40)
            .map(|_| {
                let [u, v] = [0, 1].map(|_| I12F20::from_bits((random.draw() as i32) >> 9));
                Request { scale: [0, 1].map(|_| random.draw() as u32 % (6 << 8)), ..Request::at(u, v) }
            })
            .collect();
        let reference = Reference::new(&held.pyramid, &sampler).unwrap();
        let mut unit = Unit::new(&sampler, &held.memory.surface, &held.memory.bytes).unwrap();
        let mut responses = vec![Response::default(); requests.len()];
        unit.run(&requests, &mut responses, &mut ());
        for (request, response) in requests.iter().zip(&responses) {
            prop_assert_eq!(reference.sample(request), *response, "{:?}", request);
        }
    }
}

/// Every texel of a 64 x 64 texture read once, row by row, through a cache that holds all of it.
fn counters_of_a_sweep(format: Format, decompress: Decompress) -> Counters {
    let layout = Layout::Tiled { log2_width: 2, log2_height: 2 };
    let storage = Storage { layout, format, decompress, srgb: false };
    let held = Held::new(&random_stored(PyramidKind::Mipmap, format, [64, 64], 1), &storage).unwrap();
    let geometry = Geometry { sets: 1024, ways: 4, line: 64 };
    let bytes = held.memory.surface.bytes_per_read();
    let cache = TexelCache::new(geometry, Policy::Lru, bytes, Detail::default()).unwrap();
    let mut cache = held.memory.behind(cache);
    let sampler = Sampler { filter: Filter::Point, ..Sampler::default() };
    let mut unit = Unit::new(&sampler, &held.memory.surface, &held.memory.bytes).unwrap();
    let place = |texel: i32| I12F20::from_bits((texel << 14) + (1 << 13));
    let requests: Vec<Request> = (0..64).flat_map(|y| (0..64).map(move |x| Request::at(place(x), place(y)))).collect();
    unit.addresses(&requests, &mut cache);
    cache.counters()
}

#[test]
fn traffic_follows_the_stored_format() {
    let texels = 64 * 64;
    for (format, bytes_a_read, stored) in [
        (Format::Rgba8, 4, 4 * texels),
        (Format::Rgb565, 2, 2 * texels),
        (Format::Argb1555, 2, 2 * texels),
        (Format::Argb4444, 2, 2 * texels),
        (Format::L8, 1, texels),
        (Format::A8, 1, texels),
        (Format::La8, 2, 2 * texels),
        (Format::Palette8, 1, texels),
        (Format::Bc1, 8, texels / 2),
        (Format::Bc3, 16, texels),
        (Format::Bc7, 16, texels),
    ] {
        let after = counters_of_a_sweep(format, Decompress::AfterCache);
        assert_eq!((after.lookups, after.bytes_requested), (texels, bytes_a_read * texels), "{format:?}");
        assert_eq!((after.bytes_fetched, after.bytes_filled, after.bytes_used), (stored, stored, stored), "{format:?}");
        let before = counters_of_a_sweep(format, Decompress::BeforeCache);
        assert_eq!((before.lookups, before.bytes_requested), (texels, 4 * texels), "{format:?}");
        assert_eq!(
            (before.bytes_fetched, before.bytes_filled, before.bytes_used),
            (stored, 4 * texels, 4 * texels),
            "{format:?}"
        );
    }
}

#[test]
fn a_line_that_holds_parts_of_four_blocks_fetches_four_blocks() {
    let storage =
        Storage { layout: Layout::RowMajor, format: Format::Bc1, decompress: Decompress::BeforeCache, srgb: false };
    let held = Held::new(&random_stored(PyramidKind::Mipmap, Format::Bc1, [64, 64], 1), &storage).unwrap();
    let geometry = Geometry { sets: 1024, ways: 4, line: 64 };
    let mut cache = held.memory.behind(TexelCache::new(geometry, Policy::Lru, 4, Detail::default()).unwrap());
    cache.read(0, held.memory.surface.planes[0].address(16, 3));
    assert_eq!(cache.counters().bytes_fetched, 4 * 8);
    assert_eq!(held.memory.stored_bytes(), held.memory.compressed.as_ref().unwrap().bytes);
}

#[test]
fn a_machine_holds_a_texture_in_its_format_and_refuses_what_has_no_place() {
    let texture = TextureImage::from(PlaneImage::top(8, 8, vec![[250, 100, 50, 255]; 64]));
    let machine = |settings: &[&str]| {
        let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
        Machine::load("herf-12.20", &settings).unwrap()
    };
    let held = machine(&["texture.format=rgb565"]).texture.hold(PyramidKind::Dipmap, &texture).unwrap();
    assert_eq!(held.memory.surface.bytes_per_read(), 2);
    assert!(held.pyramid.planes.iter().flat_map(|plane| &plane.texels).all(|texel| *texel == [247, 101, 49, 255]));
    let linear = machine(&["texture.srgb=true"]).texture.hold(PyramidKind::Mipmap, &texture).unwrap();
    assert_eq!(linear.pyramid.planes[0].texels[0], srgb::linear_texel([250, 100, 50, 255]));

    let error = machine(&["texture.format=bc1", "texture.layout=williams"])
        .texture
        .hold(PyramidKind::Mipmap, &texture)
        .unwrap_err()
        .to_string();
    assert!(error.contains("williams (bc1)") && error.contains("tiled-4x4"), "{error}");
    let error = Machine::load("herf-12.20", &["texture.format=rgb888".into()]).unwrap_err().to_string();
    assert!(error.contains("rgb888") && error.contains("palette8"), "{error}");
}
