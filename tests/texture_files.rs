//! KTX2 and DDS files as textures with levels of their own.

use std::path::{Path, PathBuf};

use ddsfile::{
    AlphaMode, Caps2, D3D10ResourceDimension, D3DFormat, Dds, DxgiFormat, NewD3dParams, NewDxgiParams, PixelFormatFlags,
};
use ktx2::{Format as Vulkan, Header, Index, LevelIndex, SupercompressionScheme};
use texunit::{
    experiment::verify::SplitMix,
    machine::Machine,
    texture_file::{TextureImage, load},
};
use texunit_hw::{Format, PyramidKind};

fn random_bytes(count: usize) -> Vec<u8> {
    let mut random = SplitMix(count as u64);
    (0..count).map(|_| random.draw() as u8).collect()
}

/// A KTX2 file of levels, largest first, with no descriptor blocks and at most one key.
fn ktx2_bytes(header: Header, levels: &[Vec<u8>], swizzle: Option<&str>) -> Vec<u8> {
    let start = Header::LENGTH + LevelIndex::LENGTH * levels.len();
    let mut keys = Vec::new();
    if let Some(swizzle) = swizzle {
        let pair = [b"KTXswizzle\0", swizzle.as_bytes(), b"\0"].concat();
        keys.extend((pair.len() as u32).to_le_bytes());
        keys.extend(pair);
        keys.resize(keys.len().next_multiple_of(4), 0);
    }
    let index = Index {
        dfd_byte_offset: start as u32,
        dfd_byte_length: 4,
        kvd_byte_offset: start as u32 + 4,
        kvd_byte_length: keys.len() as u32,
        sgd_byte_offset: 0,
        sgd_byte_length: 0,
    };
    let mut bytes = Header { index, ..header }.as_bytes().to_vec();
    let mut offset = start + 4 + keys.len();
    for level in levels {
        let entry = LevelIndex {
            byte_offset: offset as u64,
            byte_length: level.len() as u64,
            uncompressed_byte_length: level.len() as u64,
        };
        bytes.extend(entry.as_bytes());
        offset += level.len();
    }
    bytes.extend(4u32.to_le_bytes());
    bytes.extend(keys);
    bytes.extend(levels.concat());
    bytes
}

fn ktx2_header(format: Option<Vulkan>, width: u32, height: u32, levels: u32) -> Header {
    Header {
        format,
        type_size: 1,
        pixel_width: width,
        pixel_height: height,
        pixel_depth: 0,
        layer_count: 0,
        face_count: 1,
        level_count: levels,
        supercompression_scheme: None,
        index: Index {
            dfd_byte_offset: 0,
            dfd_byte_length: 0,
            kvd_byte_offset: 0,
            kvd_byte_length: 0,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    }
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn refusal(folder: &Path, bytes: &[u8]) -> String {
    load(&write(folder, "refused", bytes)).unwrap_err().to_string()
}

fn hold(texture: &TextureImage, kind: PyramidKind, format: &str) -> texunit::texture_memory::Held {
    Machine::load("herf-12.20", &[format!("texture.format={format}"), "texture.layout=row-major".into()])
        .unwrap()
        .texture
        .hold(kind, texture)
        .unwrap()
}

#[test]
fn levels_of_a_bc7_ktx2_file_are_the_planes_of_the_mipmap_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    // 12 x 8: levels of 12 x 8, 6 x 4, 3 x 2, 1 x 1.
    let levels: Vec<Vec<u8>> = [6, 2, 1, 1].map(|blocks| random_bytes(16 * blocks)).into();
    let header = ktx2_header(Some(Vulkan::BC7_SRGB_BLOCK), 12, 8, 4);
    let texture = load(&write(folder.path(), "a.ktx2", &ktx2_bytes(header, &levels, None))).unwrap();
    assert_eq!((texture.top.width, texture.top.height), (12, 8));

    let held = hold(&texture, PyramidKind::Mipmap, "bc7");
    for (plane, level) in held.memory.surface.planes.iter().zip(&levels) {
        let base = plane.base as usize;
        assert_eq!(&held.memory.bytes[base..base + level.len()], level);
    }
    let mut block = [[0u8; 4]; 16];
    bcdec_rs::bc7(&levels[3], block.as_flattened_mut(), 16);
    assert_eq!(held.pyramid.planes[3].texels, [block[0]]);

    // Another format: the same planes, encoded anew.
    let as_rgba8 = hold(&texture, PyramidKind::Mipmap, "rgba8");
    assert_eq!(as_rgba8.pyramid, held.pyramid);
    // Another pyramid: level 0 as it was, the rest made from it.
    let dipmap = hold(&texture, PyramidKind::Dipmap, "bc7");
    assert_eq!(dipmap.pyramid.planes[0], held.pyramid.planes[0]);
    assert_eq!(dipmap.memory.bytes[..levels[0].len()], levels[0]);
}

#[test]
fn levels_a_file_has_not_are_made_from_its_largest() {
    let folder = tempfile::tempdir().unwrap();
    let levels = [random_bytes(4 * 16), vec![7; 4 * 4]];
    let header = ktx2_header(Some(Vulkan::R8G8B8A8_UNORM), 4, 4, 2);
    let texture = load(&write(folder.path(), "a.ktx2", &ktx2_bytes(header, &levels, None))).unwrap();
    let held = hold(&texture, PyramidKind::Mipmap, "rgba8");
    assert_eq!(held.pyramid.planes[1].texels, [[7; 4]; 4]);
    let mean = |channel: usize| {
        let sum: u32 = levels[0].iter().skip(channel).step_by(4).map(|&value| u32::from(value)).sum();
        f64::from(sum) / 16.0
    };
    for channel in 0..4 {
        assert!((f64::from(held.pyramid.planes[2].texels[0][channel]) - mean(channel)).abs() <= 0.5);
    }
}

#[test]
fn every_element_of_a_ktx2_file_reads_as_its_format_says() {
    let folder = tempfile::tempdir().unwrap();
    type Case = (Vulkan, Option<&'static str>, Vec<u8>, [u8; 4]);
    let cases: [Case; 12] = [
        (Vulkan::R8G8B8A8_SRGB, None, vec![1, 2, 3, 4], [1, 2, 3, 4]),
        (Vulkan::R8G8B8A8_UNORM, Some("rgb1"), vec![1, 2, 3, 4], [1, 2, 3, 255]),
        (Vulkan::B8G8R8A8_UNORM, Some("rgba"), vec![1, 2, 3, 4], [3, 2, 1, 4]),
        (Vulkan::R8G8B8_UNORM, None, vec![1, 2, 3], [1, 2, 3, 255]),
        (Vulkan::R5G6B5_UNORM_PACK16, None, 0xF800u16.to_le_bytes().into(), [255, 0, 0, 255]),
        (Vulkan::A1R5G5B5_UNORM_PACK16, None, 0x801Fu16.to_le_bytes().into(), [0, 0, 255, 255]),
        (Vulkan::A4R4G4B4_UNORM_PACK16, None, 0x1234u16.to_le_bytes().into(), [0x22, 0x33, 0x44, 0x11]),
        (Vulkan::R8_UNORM, Some("rrr1"), vec![9], [9, 9, 9, 255]),
        (Vulkan::R8G8_UNORM, Some("rrrg"), vec![9, 8], [9, 9, 9, 8]),
        (Vulkan::BC1_RGBA_UNORM_BLOCK, None, vec![0, 0, 0, 0, 255, 255, 255, 255], [0, 0, 0, 0]),
        (Vulkan::BC1_RGB_UNORM_BLOCK, None, vec![0, 0, 0, 0, 255, 255, 255, 255], [0, 0, 0, 255]),
        (
            Vulkan::BC3_UNORM_BLOCK,
            None,
            [[77, 0, 0, 0, 0, 0, 0, 0], [0xE0, 0x07, 0, 0, 0, 0, 0, 0]].concat(),
            [0, 255, 0, 77],
        ),
    ];
    for (format, swizzle, element, texel) in cases {
        let bytes = ktx2_bytes(ktx2_header(Some(format), 1, 1, 1), &[element], swizzle);
        let texture = load(&write(folder.path(), "a.ktx2", &bytes)).unwrap();
        assert_eq!(texture.top.texels, [texel], "{format:?}");
    }
}

#[test]
fn levels_of_dds_files_of_both_headers_follow_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let d3d =
        |format, mipmap_levels| NewD3dParams { height: 2, width: 4, depth: None, format, mipmap_levels, caps2: None };
    let mut dds = Dds::new_d3d(d3d(D3DFormat::R5G6B5, Some(3))).unwrap();
    dds.data = random_bytes(2 * (8 + 2 + 1));
    let mut bytes = Vec::new();
    dds.write(&mut bytes).unwrap();
    let texture = load(&write(folder.path(), "a.dds", &bytes)).unwrap();
    let held = hold(&texture, PyramidKind::Mipmap, "rgb565");
    let bases: Vec<usize> = held.memory.surface.planes.iter().map(|plane| plane.base as usize).collect();
    for (base, level) in bases.iter().zip([0..16, 16..20, 20..22]) {
        assert_eq!(held.memory.bytes[*base..*base + level.len()], dds.data[level]);
    }

    let mut dds = Dds::new_dxgi(NewDxgiParams {
        height: 4,
        width: 4,
        depth: None,
        format: DxgiFormat::BC7_UNorm,
        mipmap_levels: Some(3),
        array_layers: None,
        caps2: None,
        is_cubemap: false,
        resource_dimension: D3D10ResourceDimension::Texture2D,
        alpha_mode: AlphaMode::Straight,
    })
    .unwrap();
    dds.data = random_bytes(3 * 16);
    let mut bytes = Vec::new();
    dds.write(&mut bytes).unwrap();
    let texture = load(&write(folder.path(), "b.dds", &bytes)).unwrap();
    assert_eq!(texture.own.as_ref().map(|own| (own.format, own.planes.len())), Some((Format::Bc7, 3)));
    let mut block = [[0u8; 4]; 16];
    bcdec_rs::bc7(&dds.data[..16], block.as_flattened_mut(), 16);
    assert_eq!(texture.top.texels, block);
}

#[test]
fn every_element_of_a_dds_file_reads_as_its_format_says() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(D3DFormat, Vec<u8>, [u8; 4]); 10] = [
        (D3DFormat::A8R8G8B8, vec![1, 2, 3, 4], [3, 2, 1, 4]),
        (D3DFormat::X8R8G8B8, vec![1, 2, 3, 4], [3, 2, 1, 255]),
        (D3DFormat::A8B8G8R8, vec![1, 2, 3, 4], [1, 2, 3, 4]),
        (D3DFormat::R8G8B8, vec![1, 2, 3], [3, 2, 1, 255]),
        (D3DFormat::A1R5G5B5, 0x801Fu16.to_le_bytes().into(), [0, 0, 255, 255]),
        (D3DFormat::A4R4G4B4, 0x1234u16.to_le_bytes().into(), [0x22, 0x33, 0x44, 0x11]),
        (D3DFormat::L8, vec![9], [9, 9, 9, 255]),
        (D3DFormat::A8, vec![9], [0, 0, 0, 9]),
        (D3DFormat::A8L8, vec![9, 8], [9, 9, 9, 8]),
        (D3DFormat::DXT1, vec![0, 0, 0, 0, 255, 255, 255, 255], [0, 0, 0, 0]),
    ];
    for (format, element, texel) in cases {
        let params = NewD3dParams { height: 1, width: 1, depth: None, format, mipmap_levels: None, caps2: None };
        let mut dds = Dds::new_d3d(params).unwrap();
        // The crate writes these three as RGB, but reads them as others write them.
        match format {
            D3DFormat::L8 => dds.header.spf.flags = PixelFormatFlags::LUMINANCE,
            D3DFormat::A8L8 => dds.header.spf.flags = PixelFormatFlags::LUMINANCE | PixelFormatFlags::ALPHA_PIXELS,
            D3DFormat::A8 => dds.header.spf.flags = PixelFormatFlags::ALPHA,
            _ => (),
        }
        dds.data = element;
        let mut bytes = Vec::new();
        dds.write(&mut bytes).unwrap();
        let texture =
            load(&write(folder.path(), "a.dds", &bytes)).unwrap_or_else(|error| panic!("{format:?}: {error}"));
        assert_eq!(texture.top.texels, [texel], "{format:?}");
    }
}

#[test]
fn containers_of_anything_else_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let level = vec![vec![0; 4 * 16]];
    let rgba8 = ktx2_header(Some(Vulkan::R8G8B8A8_UNORM), 4, 4, 1);
    let refused = |header: Header, levels: &[Vec<u8>]| refusal(folder.path(), &ktx2_bytes(header, levels, None));
    for (message, words) in [
        (
            refused(Header { supercompression_scheme: Some(SupercompressionScheme::Zstandard), ..rgba8 }, &level),
            "Zstandard",
        ),
        (refused(Header { format: None, ..rgba8 }, &level), "Basis"),
        (refused(Header { format: Some(Vulkan::R16G16B16A16_SFLOAT), ..rgba8 }, &level), "R16G16B16A16_SFLOAT"),
        (refused(Header { face_count: 6, ..rgba8 }, &level), "6 faces"),
        (refused(Header { layer_count: 3, ..rgba8 }, &level), "3 layers"),
        (refused(Header { pixel_depth: 4, ..rgba8 }, &level), "x 4 texels"),
        (refused(Header { pixel_height: 0, ..rgba8 }, &level), "two-dimensional"),
        (refused(Header { pixel_width: 8, ..rgba8 }, &level), "128 bytes"),
        (refused(Header { pixel_width: 1 << 30, ..rgba8 }, &level), "1073741824 x 4"),
        (refused(Header { level_count: 4, ..rgba8 }, &[level.clone(), vec![vec![]; 3]].concat()), "1 to 3"),
    ] {
        assert!(
            message.contains(words) && message.contains("refused") && message.contains("help"),
            "{words}: {message}"
        );
    }
    let whole = ktx2_bytes(rgba8, &level, None);
    for length in [12, 60, 100, whole.len() - 1] {
        let message = refusal(folder.path(), &whole[..length]);
        assert!(message.contains("cut short"), "{length}: {message}");
    }
    let swizzled = refusal(folder.path(), &ktx2_bytes(rgba8, &level, Some("bgra")));
    assert!(swizzled.contains("bgra"), "{swizzled}");

    let params = NewD3dParams {
        height: 4,
        width: 4,
        depth: None,
        format: D3DFormat::A8R8G8B8,
        mipmap_levels: Some(2),
        caps2: None,
    };
    let mut bytes = Vec::new();
    Dds::new_d3d(params.clone()).unwrap().write(&mut bytes).unwrap();
    assert!(refusal(folder.path(), &bytes[..bytes.len() - 1]).contains("level 1"));
    assert!(refusal(folder.path(), &bytes[..100]).contains("cut short"));
    for (changed, words) in [
        (NewD3dParams { format: D3DFormat::DXT3, ..params.clone() }, "DXT3"),
        (NewD3dParams { caps2: Some(Caps2::CUBEMAP), ..params.clone() }, "cube"),
        (NewD3dParams { caps2: Some(Caps2::VOLUME), ..params }, "volume"),
    ] {
        let mut bytes = Vec::new();
        Dds::new_d3d(changed).unwrap().write(&mut bytes).unwrap();
        let message = refusal(folder.path(), &bytes);
        assert!(message.contains(words), "{words}: {message}");
    }
}
