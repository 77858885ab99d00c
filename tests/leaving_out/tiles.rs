//! Textures by tiles.

use texunit::{
    machine::Machine,
    needs::{Needs, PpmFile, TileMemory},
    pyramid::{Build, From, PlaneImage},
    scene::{Pattern, Procedural},
};
use texunit_hw::{Filter, I12F20, LodSource, Request, Sampler};

use crate::small;

#[test]
fn a_texture_of_four_gigabytes_is_sampled_from_the_tiles_a_scene_reads() {
    let size = [32768; 2];
    let texture = Procedural { pattern: Pattern::Checkerboard, size, cell: 100, line: 4, seed: 1 };
    // A window of an eighth by an eighth of the texture, a texel a pixel in the distance and many pixels a texel nearby.
    let requests: Vec<Request> = (0..96 * 96)
        .map(|pixel: i32| {
            let [x, y] = [pixel % 96, pixel / 96];
            let place = |at: i32| I12F20::from_bits(0x4_0000 + at * 0x2_0000 / 96 + 3 * at);
            Request { scale: [(1 << (2 * (y / 32))) as f32, 0.0].map(f32::to_bits), ..Request::at(place(x), place(y)) }
        })
        .collect();
    let sampler = Sampler::default();
    let needs = Needs::of(&requests, &sampler, size).unwrap();
    let [read, all] = needs.tiles();
    assert!(50 * read < all, "{read} of {all} tiles: less than 2 %");
    let tiles = TileMemory::new(&needs, &Build::default(), &texture).unwrap();
    assert_eq!(tiles.tiles() as u64, read);
    // All planes would take 5.7 GB; the tables of the planes that are read take 4 bytes a tile.
    assert!(tiles.bytes() < 4096 * read + 4 * all + 1, "{}", tiles.bytes());
    assert!(tiles.source_texels < 1 << 20, "texels in memory at a time");
    let responses = tiles.run(&sampler, size, &requests).unwrap();
    // Magnified or a texel a pixel: bilinear in a checkerboard, computed here from the coordinate alone.
    for (request, response) in
        requests.iter().zip(&responses).filter(|(request, _)| request.scale[0] == 1.0f32.to_bits())
    {
        let position = [request.u, request.v].map(|c| i64::from(c.to_bits()) * 32768 - (1 << 19));
        let [(i, f), (j, g)] = position.map(|p| (p >> 20, (p >> 12) & 255));
        let white = |x: i64, y: i64| if (x / 100 + y / 100) % 2 == 0 { 255 } else { 0 };
        let top = white(i, j) * (256 - f) + white(i + 1, j) * f;
        let bottom = white(i, j + 1) * (256 - f) + white(i + 1, j + 1) * f;
        let grey = (top * (256 - g) + bottom * g + (1 << 15)) >> 16;
        assert_eq!(i64::from(response.texel[0]), grey, "{request:?}");
    }
}

#[test]
fn tiles_of_a_file_are_those_of_its_image() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("texture.ppm");
    let texels: Vec<[u8; 4]> =
        (0..100 * 70_u32).map(|i| (i.wrapping_mul(2_654_435_761) | 255 << 24).to_le_bytes()).collect();
    let mut bytes = b"P6 # a comment\n100 70\n255\n".to_vec();
    bytes.extend(texels.iter().flat_map(|texel| &texel[..3]));
    std::fs::write(&path, &bytes).unwrap();
    let file = PpmFile::open(&path).unwrap();
    let image = PlaneImage::top(100, 70, texels);
    let (scene, _) = small("mixed", [64, 48]);
    let machine = Machine::default();
    let requests = texunit::needs::requests_of_size(&scene, &machine, Filter::Ripmap, [100, 70]);
    let sampler = machine.sampler(Filter::Ripmap, scene.texture.wrap, LodSource::Gradient);
    let needs = Needs::of(&requests, &sampler, [100, 70]).unwrap();
    let run = |memory: TileMemory| memory.run(&sampler, [100, 70], &requests).unwrap();
    let build = Build::default();
    assert_eq!(
        run(TileMemory::new(&needs, &build, &file).unwrap()),
        run(TileMemory::new(&needs, &build, &image).unwrap())
    );

    std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    let message = PpmFile::open(&path).unwrap_err().to_string();
    assert!(message.contains("texture.ppm") && message.contains("fewer texels"), "{message}");
    let above = Build { from: From::Above, ..build };
    assert!(TileMemory::new(&needs, &above, &image).unwrap_err().to_string().contains("use top"));
}
