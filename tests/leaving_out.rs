//! Leaving out: the same bits from less (docs/leaving-out.md).

use proptest::prelude::*;
use texunit::{
    machine::{Machine, Texture},
    names::Named,
    needs::{Fit, ImageNeeds, LeftOut, Loss, Needs, PixelNeeds, Plan, PpmFile, TileMemory},
    pyramid::{Build, From, Kernel, PlaneImage},
    scene::{Pattern, Procedural, Scene},
    texture_file::TextureImage,
};
use texunit_hw::{
    AddressMode, Filter, Format, I12F20, Layout, LevelRounding, LodSource, Request, Response, Rounding, Sampler, Unit,
};

fn any_of<T: Named + std::fmt::Debug>() -> impl Strategy<Value = T> {
    proptest::sample::select(T::ALL.iter().map(|(_, choice)| *choice).collect::<Vec<_>>())
}

/// Levels in which whole ones, those of one axis only and those below zero are common.
fn level() -> impl Strategy<Value = i32> {
    prop_oneof![Just(0), -700..=0_i32, (0..=5_i32).prop_map(|level| level << 8), 0..=1400_i32]
}

fn place() -> impl Strategy<Value = i32> {
    prop_oneof![0..=0xF_FFFF_i32, 0x4_0000..=0xC_0000_i32, any::<i32>()]
}

fn request() -> impl Strategy<Value = Request> {
    let vector = || prop_oneof![Just([0; 2]), [-0x8000..=0x8000_i32, -0x8000..=0x8000_i32]];
    ([place(), place()], [level(), level()], [vector(), vector()], any::<[u16; 2]>()).prop_map(
        |(at, levels, axes, pixel)| Request {
            scale: levels.map(|level| level as u32),
            axes: axes.map(|axis| axis.map(I12F20::from_bits)),
            pixel,
            ..Request::at(I12F20::from_bits(at[0]), I12F20::from_bits(at[1]))
        },
    )
}

/// A whole scene is often magnified, or lies within the texture: one request alone must not decide.
fn requests() -> impl Strategy<Value = Vec<Request>> {
    (proptest::collection::vec(request(), 0..24), any::<[bool; 3]>()).prop_map(
        |(mut requests, [flat, inside, plain])| {
            for request in &mut requests {
                if flat {
                    request.scale = [(-300_i32) as u32, (-300_i32) as u32];
                    request.axes = [[I12F20::ZERO; 2]; 2];
                }
                if inside {
                    let within = |c: I12F20| I12F20::from_bits(0x7_0000 + (c.to_bits() & 0x1_FFFF));
                    (request.u, request.v) = (within(request.u), within(request.v));
                }
                if plain {
                    request.axes = [[I12F20::ZERO; 2]; 2];
                }
            }
            requests
        },
    )
}

fn sampler() -> impl Strategy<Value = Sampler> {
    (
        any_of::<Filter>(),
        [any_of::<AddressMode>(), any_of::<AddressMode>()],
        (1..=12_u8, 0..=8_u8, 1..=8_u8, 0..=127_u8),
        (any_of::<Rounding>(), any_of::<LevelRounding>()),
        prop_oneof![3 => Just((0_i16, 0, 32 << 8)), 1 => (-600..=600_i16, 0..=300, 0..=1500)],
        any::<bool>(),
    )
        .prop_map(|(filter, address, widths, (rounding, level_rounding), levels, packed)| Sampler {
            filter,
            address,
            filter_bits: if packed { 8 } else { widths.0 },
            lod_bits: widths.1,
            max_anisotropy: widths.2,
            brilinear_threshold: widths.3,
            rounding: if packed { Rounding::Once } else { rounding },
            level_rounding,
            lod_source: LodSource::Explicit,
            bias: levels.0,
            min_lod: levels.1,
            max_lod: levels.2,
            ..Sampler::default()
        })
}

#[derive(Clone, Copy, Debug)]
enum Look {
    Any,
    Opaque,
    Grey,
    OpaqueGrey,
    FewColours,
}

fn texture() -> impl Strategy<Value = TextureImage> {
    let looks = [Look::Any, Look::Opaque, Look::Grey, Look::OpaqueGrey, Look::FewColours];
    let side = || prop_oneof![(0..=5_u32).prop_map(|log2| 1 << log2), 1..=40_u32];
    ([side(), side()], proptest::sample::select(looks.to_vec()), any::<u32>()).prop_map(
        |([width, height], look, seed)| {
            let mut state = seed | 1;
            let texels = (0..width * height).map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let [r, g, b, a] = (state ^ (state >> 15)).to_le_bytes();
                match look {
                    Look::Any => [r, g, b, a],
                    Look::Opaque => [r, g, b, 255],
                    Look::Grey => [g, g, g, a],
                    Look::OpaqueGrey => [g, g, g, 255],
                    Look::FewColours => [b & 0xC0, 30, 90, 255],
                }
            });
            TextureImage { top: PlaneImage::top(width, height, texels.collect()), own: None }
        },
    )
}

fn stored() -> impl Strategy<Value = Texture> {
    let layouts = vec![
        Layout::RowMajor,
        Layout::Morton,
        Layout::default(),
        Layout::Blocked { block: [2, 2], superblock: [3, 3] },
    ];
    let format = prop_oneof![3 => Just(Format::Rgba8), 2 => any_of::<Format>()];
    let kernels = vec![(Kernel::Box, None), (Kernel::Tent, None), (Kernel::Lanczos, Some(6)), (Kernel::Point, None)];
    (proptest::sample::select(layouts), format, any::<[bool; 2]>(), proptest::sample::select(kernels)).prop_map(
        |(layout, format, [above, srgb], (kernel, width))| Texture {
            layout,
            format,
            srgb,
            pyramid: Build { kernel, width, from: if above { From::Above } else { From::Top }, ..Build::default() },
            ..Texture::default()
        },
    )
}

fn answers(sampler: &Sampler, memory: &texunit::texture_memory::TextureMemory, requests: &[Request]) -> Vec<Response> {
    let mut responses = vec![Response::default(); requests.len()];
    Unit::new(sampler, &memory.surface, &memory.bytes).unwrap().run(requests, &mut responses, &mut ());
    responses
}

fn bits(coordinate: I12F20, bits: texunit::needs::CoordinateBits) -> I12F20 {
    let kept = coordinate.to_bits() >> (20 - bits.fraction) << (20 - bits.fraction);
    let width = 20 + u32::from(bits.integer);
    I12F20::from_bits(if bits.integer == 0 { kept & 0xF_FFFF } else { kept << (32 - width) >> (32 - width) })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn every_answer_is_the_same_to_the_bit_with_and_without_what_is_not_needed(
        sampler in sampler(),
        requests in requests(),
        texture in texture(),
        stored in stored(),
    ) {
        let whole = stored.hold(sampler.filter.pyramid(), &texture).unwrap();
        let expected = answers(&sampler, &whole.memory, &requests);
        let size = [texture.top.width, texture.top.height];
        let needs = Needs::of(&requests, &sampler, size).unwrap();
        let plan = Plan::new(&needs, &sampler);
        let memory = plan.hold(&stored, &texture).unwrap();
        prop_assert_eq!(&answers(&plan.sampler, &memory, &requests), &expected, "{:?} {:?}", plan, memory.channels);
        prop_assert!(memory.stored_bytes() <= whole.memory.stored_bytes());
        prop_assert!(needs.needed_taps <= needs.taps);

        // The bits that are said not to matter do not.
        let fewer: Vec<Request> = requests
            .iter()
            .map(|request| Request {
                u: bits(request.u, needs.coordinate_bits[0]),
                v: bits(request.v, needs.coordinate_bits[1]),
                ..*request
            })
            .collect();
        prop_assert_eq!(&answers(&sampler, &whole.memory, &fewer), &expected, "{:?}", needs.coordinate_bits);

        // Tiles of planes made from the top give the same texels as planes.
        let plain = Texture { format: Format::Rgba8, srgb: false, ..stored };
        let opaque = texture.top.texels.iter().all(|texel| texel[3] == 255);
        if sampler.filter != Filter::Sat && plain.pyramid.from == From::Top && opaque {
            let whole = plain.hold(sampler.filter.pyramid(), &texture).unwrap();
            let tiles = TileMemory::new(&needs, &plain.pyramid, &texture.top).unwrap();
            let expected = answers(&sampler, &whole.memory, &requests);
            prop_assert_eq!(&tiles.run(&sampler, size, &requests).unwrap(), &expected);
        }
    }
}

/// Requests of a built-in scene at a small size.
fn small(name: &str, size: [u32; 2]) -> (Scene, TextureImage) {
    let mut scene = Scene::builtin(name).unwrap();
    scene.size = size;
    let texture = scene.texture.texture_image();
    (scene, texture)
}

#[test]
fn a_magnified_scene_costs_what_bilinear_costs_whichever_filter_was_asked_for() {
    let machine = Machine::default();
    let (scene, texture) = small("magnified", [256, 192]);
    let measure = |filter| {
        let requests = texunit::needs::requests(&scene, &machine, filter);
        let sampler = machine.sampler(filter, scene.texture.wrap, LodSource::Gradient);
        LeftOut::measure(&machine, &texture, &sampler, &requests).unwrap()
    };
    let bilinear = measure(Filter::Bilinear);
    for (name, filter) in Filter::ALL {
        let LeftOut { without, with, differing, plan, .. } = measure(*filter);
        assert_eq!(differing, 0, "{name}");
        assert_eq!(plan.planes, [(0, 0)], "{name}");
        let expected = if matches!(filter, Filter::Point | Filter::Sat) { Filter::Point } else { Filter::Bilinear };
        assert_eq!(plan.sampler.filter, expected, "{name}");
        assert!(with.memory_bytes < without.memory_bytes, "{name}: the other planes are left out");
        // Not more than bilinear as the machine runs it, and exactly what bilinear costs with everything left out.
        assert!(with.memory_bytes <= bilinear.without.memory_bytes, "{name}");
        assert!(with.bytes_requested <= bilinear.without.bytes_requested, "{name}");
        assert!(with.bytes_fetched <= bilinear.without.bytes_fetched, "{name}");
        assert!(with.cycles.unwrap() <= bilinear.without.cycles.unwrap(), "{name}");
        if expected == Filter::Bilinear {
            let costs = |cost: texunit::needs::Cost| {
                (cost.memory_bytes, cost.bytes_requested, cost.bytes_fetched, cost.cycles, cost.energy_pj)
            };
            assert_eq!(costs(with), costs(bilinear.with), "{name}");
        }
        if *filter == Filter::Trilinear {
            assert_eq!((without.reads, without.bytes_requested), (2 * with.reads, 2 * with.bytes_requested));
            assert!(without.cycles > with.cycles, "the second taps cost clocks");
        }
    }
}

#[test]
fn a_grey_opaque_texture_is_stored_in_one_channel_and_moves_a_quarter_of_the_bytes() {
    let machine = Machine::default();
    let (scene, texture) = small("rectangle-checkerboard", [64, 48]);
    let requests = texunit::needs::requests(&scene, &machine, Filter::Trilinear);
    let sampler = machine.sampler(Filter::Trilinear, scene.texture.wrap, LodSource::Gradient);
    let measured = LeftOut::measure(&machine, &texture, &sampler, &requests).unwrap();
    assert_eq!((measured.differing, measured.channels), (0, 1));
    let needed = measured.needs.needed_taps;
    assert_eq!(measured.without.bytes_requested, measured.needs.taps * 16);
    assert_eq!(measured.with.bytes_requested, needed * 4);
    assert!(measured.with.bytes_fetched < measured.without.bytes_fetched);
    // Clip fades what is outside: alpha is needed where anything is.
    let clipped = Sampler { address: [AddressMode::Clip; 2], ..sampler };
    let measured = LeftOut::measure(&machine, &texture, &clipped, &requests).unwrap();
    assert_eq!((measured.differing, measured.channels, measured.needs.address_logic), (0, 4, [true; 2]));
}

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

fn texunit(arguments: &[&str]) -> (i32, String) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_texunit")).args(arguments).output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stdout).unwrap())
}

fn json(arguments: &[&str]) -> serde_json::Value {
    let (status, text) = texunit(arguments);
    assert_eq!(status, 0, "{arguments:?}");
    serde_json::from_str(&text).unwrap()
}

#[test]
fn the_scenes_show_each_kind_of_saving() {
    let machine = Machine::default();
    let pixels = |name| PixelNeeds::of(&Scene::builtin(name).unwrap(), &machine);
    let magnified = pixels("magnified");
    assert_eq!((magnified.magnified, magnified.minified[0]), (magnified.pixels, magnified.pixels));
    let one_to_one = pixels("one-to-one");
    assert_eq!(one_to_one.one_to_one, one_to_one.pixels);
    assert_eq!(one_to_one.levels, [one_to_one.pixels], "no level above 0");
    let one_axis = pixels("one-axis");
    assert_eq!(one_axis.minified, [0, one_axis.pixels, 0, 0], "u only");
    assert!(one_axis.magnified == 0 && one_axis.anisotropy.len() > 2);
    let mixed = pixels("mixed");
    assert!(8 * mixed.magnified > mixed.pixels && 8 * mixed.minified[3] > mixed.pixels, "{mixed:?}");
    assert_eq!(mixed.levels.iter().sum::<u64>(), mixed.pixels);
}

#[test]
fn what_is_known_of_a_pattern_is_what_its_texels_show() {
    for (name, _) in Pattern::ALL {
        let scene = format!("rectangle-{name}");
        let texture = Scene::builtin(&scene).unwrap().texture;
        assert_eq!(texture.image_needs(), ImageNeeds::of([&texture.texture_image().top]), "{name}");
    }
}

#[test]
fn a_texture_that_is_only_read_from_level_two_on_may_be_a_quarter_as_long() {
    let requests: Vec<Request> = (0..64)
        .map(|number| Request {
            scale: [512 + 8 * number, 0],
            ..Request::at(I12F20::from_bits(77_777 * number as i32), I12F20::ZERO)
        })
        .collect();
    let sampler = Sampler { lod_source: LodSource::Explicit, ..Sampler::default() };
    let needs = Needs::of(&requests, &sampler, [256, 128]).unwrap();
    assert_eq!(needs.smallest_texture(), [64, 32]);
    assert_eq!(needs.levels, Some([512, 512 + 8 * 63]));
    assert_eq!(needs.lod_bits, [2, 5], "levels 2 and 3, in steps of 8/256");
    // The level's fraction needs no more bits than that.
    let texture = TextureImage {
        top: PlaneImage::top(
            256,
            128,
            (0..256 * 128_u32).map(|i| i.wrapping_mul(2_654_435_761).to_le_bytes()).collect(),
        ),
        own: None,
    };
    let memory = Texture::default().hold(sampler.filter.pyramid(), &texture).unwrap().memory;
    let narrow = Sampler { lod_bits: 5, ..sampler };
    assert_eq!(answers(&narrow, &memory, &requests), answers(&sampler, &memory, &requests));
    let narrower = Sampler { lod_bits: 4, ..sampler };
    assert_ne!(answers(&narrower, &memory, &requests), answers(&sampler, &memory, &requests));
}

#[test]
fn a_proposal_costs_what_its_evidence_says() {
    let machine = Machine::default();
    let (scene, texture) = small("mixed", [96, 72]);
    let loss = Loss { time: 0.03, rmse: 0.7 };
    let fit = Fit::find(&scene, &machine, Filter::Trilinear, loss).unwrap();
    let chosen = fit.candidates.iter().rfind(|candidate| candidate.chosen).unwrap();
    assert!(fit.settings.len() >= 3 && chosen.cache_bytes < 16384, "{:?}", fit.settings);
    let proposed = machine.with_settings(&fit.settings).unwrap();
    let requests = texunit::needs::requests(&scene, &proposed, Filter::Trilinear);
    let cost = |machine: &Machine| {
        let sampler = machine.sampler(Filter::Trilinear, scene.texture.wrap, LodSource::Gradient);
        LeftOut::measure(machine, &texture, &sampler, &requests).unwrap().with.cycles.unwrap()
    };
    assert_eq!((cost(&machine), cost(&proposed)), (fit.cycles, chosen.cycles));
    assert!(chosen.cycles as f64 <= 1.03 * fit.cycles as f64 && chosen.rmse <= 0.7);
    // Everything smaller that was tried lost too much.
    for (number, candidate) in fit.candidates.iter().enumerate().skip(1) {
        let too_much = candidate.cycles as f64 > 1.03 * fit.cycles as f64 || candidate.rmse > 0.7;
        assert_eq!(candidate.chosen, !too_much, "{number}: {candidate:?}");
    }
    // No loss allowed: the picture stays the same.
    let exact = Fit::find(&scene, &machine, Filter::Trilinear, Loss { time: 0.0, rmse: 0.0 }).unwrap();
    assert!(exact.candidates.iter().filter(|candidate| candidate.chosen).all(|candidate| candidate.worst == 0));
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

#[test]
fn the_command_line_says_what_is_needed_and_what_leaving_out_saves() {
    let needs = json(&["needs", "one-to-one", "-f", "trilinear,sat", "--json"]);
    let filter = &needs["scenes"][0]["filters"][0];
    assert_eq!((filter["runs_as"].as_str(), filter["taps"].as_u64()), (Some("bilinear"), Some(2 * 256 * 256)));
    assert_eq!(needs["scenes"][0]["filters"][1]["runs_as"], "point");
    assert_eq!(needs["scenes"][0]["channels"]["count"], 3);

    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let run = json(&[
        "run",
        "one-to-one",
        "mixed",
        "-f",
        "trilinear,dipmap",
        "--size",
        "80x60",
        "--leave-out",
        "--json",
        "-o",
        out,
    ]);
    for scene in run["scenes"].as_array().unwrap() {
        for filter in scene["filters"].as_array().unwrap() {
            assert_eq!(filter["left_out"]["differing_pixels"], 0);
            let number = |name: &str| filter["metrics"][name]["value"].as_f64().unwrap();
            assert_eq!(number("cycles_per_pixel"), number("cycles_per_pixel_whole"));
            assert!(number("cycles_per_pixel_needed") <= number("cycles_per_pixel_whole"));
            assert!(number("memory_bytes_needed") <= number("pyramid_bytes"));
        }
    }
    let page = folder.path().join("page.html");
    assert_eq!(texunit(&["report", out, "-o", page.to_str().unwrap()]).0, 0);
    let page = std::fs::read_to_string(page).unwrap();
    assert!(
        page.contains("what it costs without what this scene does not need")
            && page.contains("differ between the two: 0")
    );

    let picture = folder.path().join("tiles.png");
    let arguments =
        ["needs", "one-to-one", "-f", "bilinear", "--texture-size", "32768x32768", "--size", "64x64", "--tiles"];
    let (status, text) = texunit(&[&arguments[..], &[picture.to_str().unwrap()]].concat());
    assert!(status == 0 && text.contains("all planes would take 5461.3 MiB"), "{text}");
    assert_eq!(image::open(picture).unwrap().to_rgba8().dimensions(), (64, 64));
}
