//! Requests from elsewhere: files of requests and meshes, against scenes and caches told one by one.

#[cfg(feature = "gltf")]
mod gltf;
mod mesh;
mod requests;

use std::{path::Path, process::Command};

use image::{Rgba, RgbaImage};
use texunit::{
    experiment::{self, BATCH, Bench, Pyramids, Stage},
    machine::Machine,
    scene::Scene,
    stream::{NamedTexture, Stream, StreamRequest, StreamRun},
    texture_file::TextureImage,
    timed_run::time_requests,
};
use texunit_hw::{AddressMode, Filter, LodSource, Response};

/// A scene's fragments as a stream of its texture.
fn stream_of(stage: &Stage) -> Stream {
    let requests = stage.scene.fragments().map(|fragment| StreamRequest { fragment, texture: 0, filter: None });
    Stream {
        textures: vec![NamedTexture { name: "it".into(), image: stage.texture.clone() }],
        requests: requests.collect(),
        size: Some(stage.scene.size),
    }
}

fn small(name: &str) -> Stage {
    Stage::new(Scene { size: [96, 72], ..Scene::builtin(name).unwrap() })
}

#[test]
fn the_stream_of_a_scene_is_the_scene() {
    let before_cache = ["texture.format=bc1", "texture.decompress=before-cache"].map(String::from);
    let compressed = Machine::default().with_settings(&before_cache).unwrap();
    let stage = small("floor");
    let stream = stream_of(&stage);
    let whole =
        [Filter::Trilinear, Filter::Dipmap, Filter::Feline, Filter::Sat].map(|filter| (Machine::default(), filter));
    for (machine, filter) in whole.iter().chain(&[(compressed, Filter::Trilinear)]) {
        let filter = *filter;
        let pyramids = Pyramids::for_filters(machine, &stage.texture, &[filter]).unwrap();
        let (pyramid, memory) = pyramids.of(filter);
        let mut responses = Vec::new();
        let bench = Bench::new(&stage, machine, filter, pyramid, memory);
        let scene = bench.measure_watched(machine, |batch| responses.extend_from_slice(batch)).unwrap();
        let run = StreamRun::new(&stream, machine, filter, stage.scene.texture.wrap).unwrap();
        let outcome = run.measure().unwrap();
        assert_eq!(outcome.responses, responses, "{filter:?}");
        assert_eq!(outcome.counters, scene.counters, "{filter:?}");
        assert_eq!(outcome.timing, scene.timed.counters, "{filter:?}");
        assert_eq!((outcome.mismatches, outcome.parts.len()), (0, 1));
        assert_eq!(outcome.parts[0].traffic.misses, outcome.counters.misses);
    }
}

#[test]
fn a_frame_answered_batch_by_batch_is_the_frame_answered_at_once() {
    let machine = Machine::default();
    let stage = Stage::new(Scene { size: [480, 360], ..Scene::builtin("floor").unwrap() });
    assert!(stage.coverage.covered > BATCH as u64 + 1000, "more than one batch");
    let filter = Filter::Trilinear;
    let pyramids = Pyramids::for_filters(&machine, &stage.texture, &[filter]).unwrap();
    let (pyramid, memory) = pyramids.of(filter);
    let bench = Bench::new(&stage, &machine, filter, pyramid, memory);
    let mut in_batches = Vec::new();
    let outcome = bench.measure_watched(&machine, |batch| in_batches.extend_from_slice(batch)).unwrap();

    let requests = bench.requests();
    let mut at_once = vec![Response::default(); requests.len()];
    let mut cache = experiment::cache(&machine, memory.surface.bytes_per_read()).unwrap();
    bench.unit().unwrap().run(&requests, &mut at_once, &mut cache);
    assert_eq!((outcome.pixels, in_batches), (at_once.len() as u64, at_once.clone()));
    assert_eq!((outcome.counters, outcome.mismatches), (cache.counters(), 0));
    let sampler = machine.sampler(filter, stage.scene.texture.wrap, LodSource::Gradient);
    let timed = time_requests(&machine, &sampler, memory, &requests).unwrap();
    assert_eq!(outcome.timed.counters, timed.counters);
    let mut picture = stage.empty_picture();
    for (fragment, response) in stage.scene.fragments().zip(&at_once) {
        picture.put_pixel(fragment.x.into(), fragment.y.into(), Rgba(response.texel));
    }
    assert_eq!(outcome.picture, picture);
}

#[test]
fn textures_and_filters_share_one_cache_and_are_counted_apart() {
    let machine = Machine::default();
    let stages = ["rectangle-natural", "rectangle-pane"].map(small);
    let filters = [Filter::Bilinear, Filter::Trilinear, Filter::Dipmap];
    let textures =
        stages.iter().map(|stage| NamedTexture { name: stage.scene.name.clone(), image: stage.texture.clone() });
    let mut stream = Stream { textures: textures.collect(), ..Stream::default() };
    // Interleaved, so that runs of equal requests are short.
    for (number, (a, b)) in stages[0].scene.fragments().zip(stages[1].scene.fragments()).enumerate() {
        let filter = Some(filters[number / 5 % 3]);
        stream.requests.push(StreamRequest { fragment: a, texture: 0, filter });
        stream.requests.push(StreamRequest { fragment: b, texture: 1, filter });
    }
    let run = StreamRun::new(&stream, &machine, Filter::Point, [AddressMode::Wrap; 2]).unwrap();
    let outcome = run.measure().unwrap();
    assert_eq!((outcome.mismatches, outcome.parts.len()), (0, 6));
    let sum = |of: fn(&texunit::stream::PartOutcome) -> u64| outcome.parts.iter().map(of).sum::<u64>();
    assert_eq!(sum(|part| part.traffic.lookups), outcome.counters.lookups);
    assert_eq!(sum(|part| part.traffic.misses), outcome.counters.misses);
    assert_eq!(sum(|part| part.requests), stream.requests.len() as u64);
    assert_eq!(outcome.timing.requests, stream.requests.len() as u64);
    // Each answer is that of the texture alone.
    for texture in [0, 1] {
        let only: Vec<_> = stream.requests.iter().copied().filter(|request| request.texture == texture).collect();
        let alone = Stream { requests: only, ..stream.clone() };
        let answers =
            StreamRun::new(&alone, &machine, Filter::Point, [AddressMode::Wrap; 2]).unwrap().measure().unwrap();
        let mixed = stream.requests.iter().zip(&outcome.responses).filter(|(request, _)| request.texture == texture);
        assert!(mixed.map(|(_, response)| response).eq(&answers.responses));
    }
}

#[test]
fn textures_behind_one_decompressor_each_bring_their_own_bytes() {
    // Caches that nothing falls out of: every line is filled once, whoever shares it.
    let settings = ["texture.format=bc1", "texture.layout=row-major", "texture.decompress=before-cache"];
    let settings = settings
        .iter()
        .chain(&["cache.sets=4096", "memory.second-level.enabled=true", "memory.second-level.sets=4096"])
        .map(|setting| (*setting).to_owned());
    let machine = Machine::default().with_settings(&settings.collect::<Vec<_>>()).unwrap();
    let stages = ["rectangle-natural", "rectangle-pane"].map(small);
    let measure = |which: &[usize]| {
        let mut stream = Stream::default();
        for (texture, &stage) in which.iter().enumerate() {
            stream.textures.extend(stream_of(&stages[stage]).textures);
            let requests = stages[stage].scene.fragments();
            stream.requests.extend(requests.map(|fragment| StreamRequest { fragment, texture, filter: None }));
        }
        StreamRun::new(&stream, &machine, Filter::Trilinear, [AddressMode::Wrap; 2]).unwrap().measure().unwrap()
    };
    let [both, first, second] = [measure(&[0, 1]), measure(&[0]), measure(&[1])];
    assert_eq!(both.mismatches, 0);
    assert_eq!(both.counters.bytes_fetched, first.counters.bytes_fetched + second.counters.bytes_fetched);
    assert_eq!(both.timing.bytes_fetched, both.counters.bytes_fetched);
    assert!(both.counters.bytes_fetched > both.counters.fills * 3 * 8, "a line of a row is four blocks");
    let twice = measure(&[0, 0]);
    assert_eq!(twice.timing.memory_bytes, 2 * first.timing.memory_bytes, "apart in memory too");
    assert!(both.timing.decompressor_busy > 0);
}

#[test]
fn a_filter_with_wider_entries_needs_a_stream_of_its_own() {
    let mut stream = stream_of(&small("magnified"));
    stream.requests[0].filter = Some(Filter::Sat);
    let error = StreamRun::new(&stream, &Machine::default(), Filter::Point, [AddressMode::Wrap; 2]).unwrap_err();
    assert!(error.to_string().contains("sat"), "{error}");
}

fn write_texture(path: &Path, colour: [u8; 4]) {
    RgbaImage::from_fn(8, 8, |x, y| if (x + y) % 2 == 0 { Rgba(colour) } else { Rgba([0, 0, 0, 255]) })
        .save(path)
        .unwrap();
}

fn texunit(folder: &Path, args: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_texunit")).current_dir(folder).args(args).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_texture_without_a_request_takes_no_memory() {
    let stage = small("magnified");
    let mut stream = stream_of(&stage);
    let machine = Machine::default();
    let alone = StreamRun::new(&stream, &machine, Filter::Bilinear, [AddressMode::Wrap; 2]).unwrap();
    let memory = alone.measure().unwrap().memory;
    stream.textures.push(NamedTexture { name: "other".into(), image: TextureImage::clone(&stage.texture) });
    let both = StreamRun::new(&stream, &machine, Filter::Bilinear, [AddressMode::Wrap; 2]).unwrap();
    assert_eq!(both.measure().unwrap().memory, memory);
}
