//! Leaving out: the same bits from less (docs/leaving-out.md).

mod command_line;
mod same_bits;
mod tiles;

use texunit::{
    machine::{Machine, Texture},
    names::Named,
    needs::{Fit, ImageNeeds, LeftOut, Loss, Needs, PixelNeeds},
    pyramid::PlaneImage,
    scene::{Pattern, Scene},
    texture_file::TextureImage,
};
use texunit_hw::{AddressMode, Filter, I12F20, LodSource, Request, Response, Sampler, Unit};

fn answers(sampler: &Sampler, memory: &texunit::texture_memory::TextureMemory, requests: &[Request]) -> Vec<Response> {
    let mut responses = vec![Response::default(); requests.len()];
    Unit::new(sampler, &memory.surface, &memory.bytes).unwrap().run(requests, &mut responses, &mut ());
    responses
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
        assert!(with.cycles <= bilinear.without.cycles, "{name}");
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
        LeftOut::measure(machine, &texture, &sampler, &requests).unwrap().with.cycles
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
fn a_machine_with_a_decompressor_before_its_cache_is_fitted_and_left_out_in_clocks_like_any_other() {
    let settings = ["texture.format=bc1", "texture.decompress=before-cache"].map(String::from);
    let machine = Machine::default().with_settings(&settings).unwrap();
    let (scene, texture) = small("magnified", [96, 72]);
    let requests = texunit::needs::requests(&scene, &machine, Filter::Trilinear);
    let sampler = machine.sampler(Filter::Trilinear, scene.texture.wrap, LodSource::Gradient);
    let measured = LeftOut::measure(&machine, &texture, &sampler, &requests).unwrap();
    assert_eq!(measured.differing, 0);
    assert!(measured.with.cycles >= requests.len() as u64 && measured.with.cycles < measured.without.cycles);
    assert!(measured.with.energy_pj < measured.without.energy_pj);
    let fit = Fit::find(&scene, &machine, Filter::Trilinear, Loss { time: 0.02, rmse: 0.0 }).unwrap();
    assert_eq!(fit.cycles, measured.with.cycles);
}
