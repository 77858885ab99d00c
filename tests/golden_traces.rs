//! The traces in traces/: replayed through chip and reference, and recorded anew.

use std::{collections::BTreeSet, fs, path::PathBuf};

use texunit::{
    machine::Machine,
    names::Named,
    scene::Scene,
    texture_file::TextureImage,
    trace::{Player, Profile, Selection, Trace, record},
};
use texunit_hw::{AddressMode, Filter};

/// The kinds of scene, each with the one that stands for it.
const KINDS: [(&str, &str); 3] =
    [("rectangle", "rectangle-pane"), ("ellipsoid", "ellipsoid-natural"), ("floor", "floor")];

const REQUESTS: u64 = 64;

/// What is not as in the default machine and scene: filter, kind, address modes, settings.
const VARIATIONS: &[(Filter, &str, [AddressMode; 2], &[&str])] = {
    use AddressMode::{Clamp, Clip, Mirror, Wrap};
    &[
        (Filter::Point, "ellipsoid", [Mirror, Mirror], &["cache.policy=fifo"]),
        (Filter::Point, "floor", [Clip, Wrap], &[]),
        (Filter::Bilinear, "rectangle", [Mirror, Clamp], &["filter.bits=4", "filter.rounding=staged-truncate"]),
        (Filter::Bilinear, "ellipsoid", [Clamp, Clip], &["texture.layout=row-major", "cache.ways=1"]),
        (Filter::NearestMip, "rectangle", [Clip, Clip], &["lod.rounding=gl", "lod.bias=0.5"]),
        (Filter::NearestMip, "floor", [Mirror, Wrap], &["lod.rounding=floor", "lod.log2=ilog2"]),
        (Filter::Trilinear, "rectangle", [Clamp, Clamp], &["filter.rounding=staged-round"]),
        (Filter::Trilinear, "ellipsoid", [Clip, Mirror], &["filter.rounding=staged-truncate", "lod.bits=4"]),
        (Filter::Trilinear, "floor", [Wrap, Wrap], &["texture.layout=williams", "cache.line=16"]),
        (Filter::Brilinear, "ellipsoid", [Mirror, Clamp], &["filter.brilinear-threshold=100"]),
        (Filter::MipDouble, "rectangle", [Clip, Wrap], &["filter.bits=12"]),
        (Filter::Dipmap, "rectangle", [Clip, Clip], &["lod.dipmap-rule=paper-step3"]),
        (Filter::Dipmap, "ellipsoid", [Mirror, Mirror], &["filter.rounding=staged-round", "texture.layout=morton"]),
        (Filter::DipmapTrilinear, "ellipsoid", [Clamp, Clip], &["filter.rounding=staged-truncate"]),
        (Filter::Ripmap, "floor", [Mirror, Clip], &["texture.layout=blocked-4x4-16x16", "cache.policy=plru"]),
        (Filter::Texram, "rectangle", [Clamp, Clip], &["filter.max-anisotropy=8"]),
        (Filter::Feline, "ellipsoid", [Clip, Clip], &["filter.rounding=staged-round"]),
        (Filter::Fast, "rectangle", [Mirror, Mirror], &["lod.norm=max", "cache.policy=random", "cache.seed=7"]),
    ]
};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("traces")
}

fn name(kind: &str, filter: Filter) -> String {
    format!("{kind}.{}.trace", filter.name())
}

/// What a file must hold.
fn recorded(kind: &str, scene: &Scene, texture: &TextureImage, filter: Filter) -> Trace {
    let default = (scene.texture.wrap, [].as_slice());
    let (wrap, settings) = VARIATIONS
        .iter()
        .find(|(varied, of_kind, ..)| (*varied, *of_kind) == (filter, kind))
        .map_or(default, |(_, _, wrap, settings)| (*wrap, *settings));
    let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
    let machine = Machine::load("herf-12.20", &settings).unwrap();
    let profile = Profile::of_scene(scene, texture, &machine, filter, wrap, &folder()).unwrap();
    record(scene, texture, profile, Selection::Count(REQUESTS), 1).unwrap()
}

#[test]
fn every_filter_and_kind_of_scene_has_a_golden_trace_that_chip_reference_and_cache_agree_with() {
    let bless = std::env::var_os("TEXUNIT_BLESS").is_some();
    let mut names = BTreeSet::new();
    for (kind, scene) in KINDS {
        let scene = Scene::builtin(scene).unwrap();
        let texture = scene.texture.texture_image();
        for (_, filter) in Filter::ALL {
            let name = name(kind, *filter);
            let path = folder().join(&name);
            let expected = recorded(kind, &scene, &texture, *filter);
            if bless {
                let mut text = Vec::new();
                expected.write(&mut text).unwrap();
                fs::write(&path, text).unwrap();
            }
            let golden = Trace::load(&path).unwrap_or_else(|error| panic!("{error}"));
            assert!(golden == expected, "{name} is not what the machine records: texunit trace verify {name}");
            assert_eq!(golden.records.len() as u64, REQUESTS);
            let player = Player::with_texture(&golden.profile, &texture).unwrap();
            assert_eq!(golden.verify(&player).unwrap(), None, "{name}");
            names.insert(name);
        }
    }
    // The units' own traces lie in a folder below.
    let found: BTreeSet<String> = fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.file_type().unwrap().is_file())
        .map(|entry| entry.file_name().into_string().unwrap())
        .collect();
    names.insert("README.md".to_owned());
    assert_eq!(found, names);
}

#[test]
fn golden_traces_vary_address_modes_and_roundings_and_are_small() {
    let mut bytes = 0;
    let mut textures = Vec::new();
    let mut modes = BTreeSet::new();
    let mut roundings = BTreeSet::new();
    for entry in fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "trace") {
            bytes += fs::metadata(&path).unwrap().len();
            let trace = Trace::load(&path).unwrap();
            modes.extend(trace.profile.wrap.map(Named::name));
            roundings.insert(trace.profile.machine.filter.rounding.name());
            // The texture is made from the head, and is the one recorded.
            let texture = trace.profile.texture;
            if !textures.contains(&texture) {
                assert_eq!(texture.load(&path).unwrap().top.width, texture.size[0]);
                textures.push(texture);
            }
            let answers: BTreeSet<_> = trace.records.iter().map(|record| record.response.texel).collect();
            assert!(answers.len() > 2, "{} says too little", path.display());
        }
    }
    assert_eq!(modes.len(), AddressMode::ALL.len());
    assert_eq!(roundings.len(), 3);
    assert!(bytes < 1 << 20, "{bytes} bytes of traces");
}
