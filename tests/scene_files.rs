//! Scenes as files: the built-in ones, the orders, what is said of bad ones, and the ground truth.

use std::{collections::BTreeSet, fs, path::Path};

use image::{Rgba, RgbaImage};
use proptest::prelude::*;
use texunit::scene::{GroundTruth, PixelOrder, Scene, Spans};
use texunit_hw::AddressMode;

const GOOD: &str = r#"name = "mine"
description = "A test"
width = 64
height = 48

[rectangle]
size = [2.0, 2.0]
translation = [0.0, 0.0, -3.0]

[texture]
pattern = "checkerboard"
size = [64, 32]
"#;

fn parse(source: &str) -> Result<Scene, String> {
    Scene::parse(Path::new("scenes/mine.toml"), source).map_err(|error| error.to_string())
}

#[test]
fn every_built_in_scene_loads_under_its_own_name_and_covers_pixels() {
    assert_eq!(Scene::builtin_names().count(), 12);
    for name in Scene::builtin_names() {
        let scene = Scene::find(name).unwrap();
        assert_eq!(scene.name, name);
        assert!(!scene.description.is_empty() && !scene.description.contains('\n'));
        let coverage = scene.coverage();
        let [width, height] = scene.size;
        assert_eq!(coverage.pixels, u64::from(width) * u64::from(height));
        // What all are run with is quick: scenes of many frames, and those that only show what can be left out, are smaller.
        assert!((256 * 256..=640 * 480).contains(&coverage.pixels), "{name}");
        assert!(coverage.covered > coverage.pixels / 8, "{name}: {coverage:?}");
        assert_eq!(<[u32; 2]>::from(scene.texture.image().dimensions()), scene.texture.size());
    }
}

#[test]
fn fragments_are_the_same_bits_every_time() {
    let bits = |scene: &Scene| -> Vec<[u64; 6]> {
        let bits_of = |value: f64| value.to_bits();
        scene
            .fragments()
            .map(|fragment| {
                let gradient = fragment.gradient;
                [fragment.u, fragment.v, gradient.ux, gradient.uy, gradient.vx, gradient.vy].map(bits_of)
            })
            .collect()
    };
    for name in Scene::builtin_names() {
        assert_eq!(bits(&Scene::builtin(name).unwrap()), bits(&Scene::builtin(name).unwrap()), "{name}");
    }
}

/// FNV-1a, over what a machine or a compiler could change: pinned, so that a difference between machines shows.
fn fingerprint(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
}

#[test]
fn textures_and_fragments_are_the_same_on_every_machine() {
    let textures = fingerprint(
        ["rectangle-pane", "ellipsoid-natural"]
            .into_iter()
            .flat_map(|name| Scene::builtin(name).unwrap().texture.image().as_raw().clone()),
    );
    let fragments = fingerprint(["rectangle-natural", "ellipsoid-natural"].into_iter().flat_map(|name| {
        let fragments = Scene::builtin(name).unwrap().fragments();
        fragments
            .flat_map(|fragment| [fragment.u, fragment.gradient.vy].map(f64::to_le_bytes))
            .flatten()
            .collect::<Vec<_>>()
    }));
    assert_eq!(
        (textures, fragments),
        (0x7019_450F_4E60_7808, 0xC8F9_FF65_A122_A7C7),
        "textures {textures:#x}, fragments {fragments:#x}"
    );
}

#[test]
fn defaults_are_those_of_the_documentation() {
    let scene = parse(&GOOD.replace("width = 64\nheight = 48\n", "")).unwrap();
    assert_eq!((scene.size, scene.tile, scene.order), ([640, 480], 8, PixelOrder::Scanline));
    assert_eq!(scene.texture.wrap, [AddressMode::Wrap; 2]);
    assert_eq!(scene.camera.field_of_view, 45.0);
    assert_eq!(scene.ground_truth.samples, 8);
}

#[test]
fn bad_scenes_are_refused_with_file_line_key_value_and_remedy() {
    let cases: &[(&str, &str, &[&str])] = &[
        ("width = 64", "width = 0", &["mine.toml:3:9", "`width` is 0", "from 1 to 16384"]),
        ("width = 64", "wdith = 64", &["mine.toml:3:1", "wdith", "`width`"]),
        ("width = 64", "width = \"64\"", &["mine.toml:3:9", "string \"64\"", "help"]),
        ("height = 48", "order = \"hilbert\"", &["mine.toml:4:9", "hilbert", "scanline, tiles, morton"]),
        ("height = 48", "tile = 100000", &["mine.toml:4:8", "`tile` is 100000", "1 to 4096"]),
        ("height = 48", "height = = 48", &["mine.toml:4:10"]),
        ("height = 48", "[camera]\nfield-of-view = 200", &["mine.toml:5:17", "`field-of-view` is 200", "1 to 170"]),
        ("size = [2.0, 2.0]", "size = [2.0, nan]", &["mine.toml:7:14", "`size` is NaN"]),
        ("size = [2.0, 2.0]", "size = [2.0, 2.0]\nrepeats = [0, 1]", &["mine.toml:8:12", "`repeats` is 0"]),
        (
            "size = [2.0, 2.0]",
            "size = [2.0, 2.0]\nrotation = { about = { axis = [0, 0, 0], angle = 3 } }",
            &["mine.toml:8:", "axis", "no length", "[0, 1, 0]"],
        ),
        (
            "size = [2.0, 2.0]",
            "size = [2.0, 2.0]\nrotation = { euler = [0, inf, 0] }",
            &["mine.toml:8:", "not finite", "degrees"],
        ),
        ("[rectangle]", "[ellipsoid]", &["mine.toml:7:1", "size", "radii"]),
        (
            "[texture]",
            "[ellipsoid]\nradii = [1, 1, 1]\ntranslation = [0, 0, -3]\n[texture]",
            &["mine.toml:10:", "two shapes", "keep one"],
        ),
        (
            "pattern = \"checkerboard\"",
            "pattern = \"plaid\"",
            &["mine.toml:11:11", "plaid", "checkerboard, pane, natural"],
        ),
        ("pattern = \"checkerboard\"", "", &["mine.toml:10:1", "no source", "`file`"]),
        ("size = [64, 32]", "size = [64, 0]", &["mine.toml:12:13", "`size` is 0", "1 to 8192"]),
        (
            "size = [64, 32]",
            "wrap = [\"wrap\", \"repeat\"]",
            &["mine.toml:12:8", "repeat", "wrap, clamp, clip, mirror"],
        ),
        (
            "pattern = \"checkerboard\"\nsize = [64, 32]",
            "file = \"no-such.png\"",
            &["mine.toml:11:8", "scenes/no-such.png", "relative to the scene file"],
        ),
        ("pattern = \"checkerboard\"", "file = \"no-such.png\"", &["mine.toml:12:8", "`size`", "leave `size` out"]),
        ("name = \"mine\"\n", "", &["mine.toml:", "missing field `name`"]),
    ];
    for (good, bad, said) in cases {
        assert!(GOOD.contains(good), "{good}");
        let message = parse(&GOOD.replacen(good, bad, 1)).expect_err(bad);
        for part in *said {
            assert!(message.contains(part), "{bad:?} should say {part:?}, says:\n{message}");
        }
    }
}

#[test]
fn a_file_that_is_no_image_or_has_no_texels_is_refused_and_a_good_one_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    let source = GOOD.replace("pattern = \"checkerboard\"\nsize = [64, 32]", "file = \"texture.pnm\"");
    fs::write(&path, source).unwrap();
    for content in ["this is no image", "P6\n0 4\n255\n"] {
        fs::write(folder.path().join("texture.pnm"), content).unwrap();
        let message = Scene::load(&path).unwrap_err().to_string();
        assert!(message.contains("mine.toml:11:8") && message.contains("texture.pnm"), "{message}");
    }
    fs::write(folder.path().join("texture.pnm"), b"P6\n2 1\n255\nabcdef").unwrap();
    let scene = Scene::load(&path).unwrap();
    assert_eq!(scene.texture.image().as_raw().as_slice(), b"abc\xFFdef\xFF");
    assert_eq!(scene.texture.size(), [2, 1]);
    let missing = Scene::load(&folder.path().join("absent.toml")).unwrap_err().to_string();
    assert!(missing.contains("absent.toml"), "{missing}");
}

#[test]
fn an_unknown_scene_is_answered_with_those_there_are() {
    let message = Scene::find("flor").unwrap_err().to_string();
    assert!(message.contains("flor") && message.contains("ellipsoid-natural, floor"), "{message}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_order_visits_every_pixel_once(width in 1_u32..70, height in 1_u32..70, tile in 1_u32..20) {
        let all: BTreeSet<_> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
        for order in [PixelOrder::Scanline, PixelOrder::Tiles, PixelOrder::Morton] {
            let visited: Vec<_> = Spans::new(order, [width, height], tile)
                .flat_map(|span| (span.x..span.x + span.length).map(move |x| (x, span.y)))
                .collect();
            prop_assert_eq!(visited.len(), all.len(), "{:?}", order);
            prop_assert_eq!(&visited.into_iter().collect::<BTreeSet<_>>(), &all, "{:?}", order);
        }
    }
}

#[test]
fn tiles_and_morton_go_their_known_ways() {
    let pixels = |order, size, tile| -> Vec<(u32, u32)> {
        Spans::new(order, size, tile)
            .flat_map(|span| (span.x..span.x + span.length).map(move |x| (x, span.y)))
            .collect()
    };
    assert_eq!(pixels(PixelOrder::Tiles, [3, 2], 2), [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (2, 1)]);
    let curve = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (3, 0), (2, 1), (3, 1), (0, 2), (1, 2), (0, 3), (1, 3)];
    assert_eq!(pixels(PixelOrder::Morton, [4, 4], 1)[..12], curve);
    // A wide image: squares of the curve, one beside the other.
    assert_eq!(pixels(PixelOrder::Morton, [4, 2], 1), curve[..8]);
}

/// One pixel, sampled by hand.
#[test]
fn the_ground_truth_is_the_average_of_the_texels_under_the_pixel() {
    let mut scene = parse(&GOOD.replace("64, 32", "37, 23")).unwrap();
    let texture = RgbaImage::from_fn(37, 23, |x, y| Rgba([(x * 6) as u8, (y * 11) as u8, (x * y % 256) as u8, 200]));
    for wrap in [AddressMode::Wrap, AddressMode::Clamp, AddressMode::Clip, AddressMode::Mirror] {
        scene.texture.wrap = [wrap; 2];
        let truth = GroundTruth::render(&scene, &texture);
        let mut checked = 0;
        for fragment in scene.fragments().filter(|fragment| (fragment.x + fragment.y) % 7 == 0) {
            let mut sum = [0.0; 4];
            let mut hits = 0.0;
            for sample in 0..64 {
                let x = f64::from(fragment.x) + (f64::from(sample % 8) + 0.5) / 8.0;
                let y = f64::from(fragment.y) + (f64::from(sample / 8) + 0.5) / 8.0;
                let Some((u, v)) = scene.uv_at(x, y) else { continue };
                // The rectangle holds one repeat: every mode finds the same texel.
                let texel = texture.get_pixel((u * 37.0) as u32, (v * 23.0) as u32).0;
                sum.iter_mut().zip(texel).for_each(|(sum, channel)| *sum += f64::from(channel));
                hits += 1.0;
            }
            let expected = sum.map(|sum| (sum / hits) as f32);
            assert_eq!(truth.at(fragment.x, fragment.y), expected, "{wrap:?} at {fragment:?}");
            checked += 1;
        }
        assert!(checked > 100);
        assert_eq!(truth.at(0, 0), [0.0; 4], "no fragment, no colour");
    }
}

#[test]
fn the_ground_truth_beyond_the_texture_follows_each_axis_mode() {
    // A texture of two texels per axis on a rectangle of two repeats: u in 0..2, only the first repeat is inside.
    let source = GOOD.replace("size = [2.0, 2.0]", "size = [2.0, 2.0]\nrepeats = [2.0, 1.0]").replace("64, 32", "2, 1");
    let mut scene = parse(&source).unwrap();
    let texture = RgbaImage::from_fn(2, 1, |x, _| Rgba([100 * (x as u8 + 1); 4]));
    let along = |scene: &Scene| -> Vec<f32> {
        let truth = GroundTruth::render(scene, &texture);
        let (left, right) =
            (scene.fragments().map(|f| f.x).min().unwrap(), scene.fragments().map(|f| f.x).max().unwrap());
        (0..4).map(|part| truth.at(left + (right - left) * (2 * part + 1) / 8, 24)[0]).collect()
    };
    for (mode, expected) in [
        (AddressMode::Wrap, [100.0, 200.0, 100.0, 200.0]),
        (AddressMode::Mirror, [100.0, 200.0, 200.0, 100.0]),
        (AddressMode::Clamp, [100.0, 200.0, 200.0, 200.0]),
        (AddressMode::Clip, [100.0, 200.0, 0.0, 0.0]),
    ] {
        scene.texture.wrap = [mode, AddressMode::Wrap];
        assert_eq!(along(&scene), expected, "{mode:?}");
    }
}

#[test]
fn a_checkerboard_far_away_is_grey_in_the_ground_truth() {
    for jitter in [false, true] {
        let mut scene = Scene::builtin("floor").unwrap();
        scene.size = [160, 120];
        scene.ground_truth.jitter = jitter;
        let texture = scene.texture.image();
        let truth = GroundTruth::render(&scene, &texture);
        // Four rows below the horizon a pixel covers many squares, and the grid of samples still resolves them.
        let horizon = scene.fragments().map(|fragment| fragment.y).min().unwrap();
        let row: Vec<f32> = (0..160).map(|x| truth.at(x, horizon + 4)[0]).collect();
        let mean = row.iter().sum::<f32>() / 160.0;
        assert!((mean - 127.5).abs() < 6.0, "jitter {jitter}: {mean}");
        assert_eq!(truth, GroundTruth::render(&scene, &texture), "the same every time");
    }
}
