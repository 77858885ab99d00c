//! The whole unit: what the order of requests may change and what not, and a trace of it played again.

use std::path::Path;

use proptest::prelude::*;
use texunit::{
    experiment,
    front_end::FrontEnd,
    machine::Machine,
    names::Named,
    pyramid::PlaneImage,
    scene::{Fragment, PixelOrder, Scene},
    texture_file::TextureImage,
    trace::{Player, Profile, Selection, Trace, record},
};
use texunit_hw::{AddressMode, Filter, LodSource, Response, Unit, cache::Counters};

fn any_of<T: Named + std::fmt::Debug>() -> impl Strategy<Value = T> {
    prop::sample::select(T::ALL.iter().map(|(_, choice)| *choice).collect::<Vec<_>>())
}

/// Settings that answers and misses depend on.
fn settings() -> impl Strategy<Value = Vec<String>> {
    (
        prop::sample::select(vec!["lru", "fifo", "plru", "random"]),
        prop::sample::select(vec!["1", "3", "16"]),
        prop::sample::select(vec!["1", "2", "5"]),
        prop::sample::select(vec!["once", "staged-round", "staged-truncate"]),
        1..9_u8,
    )
        .prop_map(|(policy, sets, ways, rounding, bits)| {
            vec![
                format!("cache.policy={policy}"),
                format!("cache.sets={sets}"),
                format!("cache.ways={ways}"),
                format!("filter.rounding={rounding}"),
                format!("filter.bits={bits}"),
            ]
        })
}

/// Scenes of each shape, small: none has a texture of its own that takes long to make.
fn scene() -> impl Strategy<Value = Scene> {
    let name = prop::sample::select(vec!["floor", "rectangle-pane", "ellipsoid-checkerboard"]);
    (name, 8..40_u32, 8..40_u32).prop_map(|(name, width, height)| {
        let scene = Scene::builtin(name).unwrap();
        Scene { size: [width, height], ..scene }
    })
}

/// A texture of noise.
fn noise() -> TextureImage {
    let mut seed = 7_u32;
    let mut draw = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        seed.to_be_bytes()
    };
    PlaneImage::top(64, 32, (0..64 * 32).map(|_| draw()).collect()).into()
}

/// One run through unit and cache.
struct Run {
    /// Answers by place on the screen, from the top left.
    picture: Vec<([u16; 2], Response)>,
    counters: Counters,
}

impl Run {
    fn new(machine: &Machine, filter: Filter, wrap: [AddressMode; 2], fragments: &[Fragment]) -> Self {
        let held = machine.texture.hold(filter.pyramid(), &noise()).unwrap();
        let surface = &held.memory.surface;
        let (requests, _) = FrontEnd::new(machine, filter, wrap, [64, 32]).requests(fragments);
        let sampler = machine.sampler(filter, wrap, LodSource::Gradient);
        let mut responses = vec![Response::default(); requests.len()];
        let mut cache = held.memory.behind(experiment::cache(machine, surface.bytes_per_read()).unwrap());
        Unit::new(&sampler, surface, &held.memory.bytes).unwrap().run(&requests, &mut responses, &mut cache);
        let places = fragments.iter().map(|fragment| [fragment.y, fragment.x]);
        let mut picture: Vec<_> = places.zip(responses).collect();
        picture.sort_by_key(|(place, _)| *place);
        Self { picture, counters: cache.counters() }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_stream_in_any_order_of_tiles_gives_the_same_pixels_from_as_many_lookups(
        scene in scene(), filter in any_of::<Filter>(), wrap in any_of::<AddressMode>(), settings in settings(),
        order in any_of::<PixelOrder>(), tile in 1..20_u32, seed in any::<u64>(),
    ) {
        let machine = Machine::load("herf-12.20", &settings).unwrap();
        let fragments = |scene: &Scene| -> Vec<Fragment> { scene.fragments().collect() };
        let run = |fragments: &[Fragment]| Run::new(&machine, filter, [wrap; 2], fragments);
        let scanline = run(&fragments(&scene));
        let in_order = fragments(&Scene { order, tile, ..scene.clone() });
        // And in no order at all.
        let mut shuffled = in_order.clone();
        shuffled.sort_by_key(|fragment| (u64::from(fragment.x) << 16 | u64::from(fragment.y)).wrapping_add(seed).wrapping_mul(0x9E37_79B9_7F4A_7C15));
        for fragments in [in_order, shuffled] {
            let other = run(&fragments);
            prop_assert!(other.picture == scanline.picture, "{:?} of {} in tiles of {}", order, scene.name, tile);
            let Counters { lookups, hits, misses, .. } = other.counters;
            prop_assert_eq!(hits + misses, lookups);
            prop_assert_eq!(lookups, scanline.counters.lookups);
        }
        prop_assert_eq!(scanline.counters.hits + scanline.counters.misses, scanline.counters.lookups);
    }

    #[test]
    fn a_trace_written_read_and_replayed_is_the_run_it_was_recorded_from(
        scene in scene(), filter in any_of::<Filter>(), wrap in any_of::<AddressMode>(), settings in settings(),
    ) {
        let machine = Machine::load("herf-12.20", &settings).unwrap();
        let texture = noise();
        let wrap = [wrap; 2];
        let profile = Profile::of_scene(&scene, &texture, &machine, filter, wrap, Path::new(".")).unwrap();
        let recorded = record(&scene, &texture, profile, Selection::All, 1).unwrap();
        let mut text = Vec::new();
        recorded.write(&mut text).unwrap();
        let read = Trace::parse("a.trace", text.as_slice()).unwrap();
        let requests: Vec<_> = read.records.iter().map(|record| record.request).collect();
        let replayed = Player::with_texture(&read.profile, &texture).unwrap().chip(&requests).unwrap();
        prop_assert!(replayed == recorded.records, "{} of {}", filter.name(), scene.name);

        let fragments: Vec<Fragment> = scene.fragments().collect();
        let run = Run::new(&machine, filter, wrap, &fragments);
        let mut answers: Vec<_> = replayed
            .iter()
            .map(|record| (record.request.pixel, record.response))
            .map(|([x, y], response)| ([y, x], response))
            .collect();
        answers.sort_by_key(|(place, _)| *place);
        prop_assert!(answers == run.picture, "{} of {}", filter.name(), scene.name);
        let sum = |of: fn(&texunit::trace::Record) -> u16| replayed.iter().map(|record| u64::from(of(record))).sum::<u64>();
        prop_assert_eq!(sum(|record| record.reads), run.counters.lookups);
        prop_assert_eq!(sum(|record| record.misses), run.counters.misses);
    }
}
