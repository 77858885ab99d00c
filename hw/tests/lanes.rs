//! The lanes of the machine against the scalar units: every bit of every answer, of every address, and of what is counted of them.

use proptest::{
    prelude::*,
    strategy::ValueTree,
    test_runner::{TestRng, TestRunner},
};
use texunit_hw::{
    AddressBatch, AddressMode, FILTERS, Filter, Format, Geometry, I12F20, Layout, LevelRounding, LodSource, Log2,
    Policy, Request, Requests, Response, Rounding, Sampler, Sink, Surface, Unit,
    address::is_outside,
    cache::{Counters, Detail, PlaneCounters, TexelCache},
    timing::{MemoryParameters, Parameters, PlaneTiming, Timing, TimingCounters},
};

const MODES: [AddressMode; 4] = [AddressMode::Wrap, AddressMode::Clamp, AddressMode::Clip, AddressMode::Mirror];
const LAYOUTS: [Layout; 4] = [
    Layout::RowMajor,
    Layout::Tiled { log2_width: 2, log2_height: 2 },
    Layout::Morton,
    Layout::Blocked { block: [2, 1], superblock: [3, 4] },
];
const SIZES: [[u32; 2]; 8] = [[1, 1], [2, 1], [1, 37], [64, 64], [16, 128], [33, 7], [1000, 2], [5000, 3]];

/// Sums are not texels, and have no taps to compare.
fn of_texels() -> impl Iterator<Item = Filter> {
    FILTERS.into_iter().filter(|filter| *filter != Filter::Sat)
}

/// A tap: the number of its request, its plane, and its addresses, those outside the texture as one.
type Tap = (usize, usize, [u64; 4]);

/// All taps.
#[derive(Debug, Default, PartialEq)]
struct Taps {
    taps: Vec<Tap>,
    requests: usize,
}

impl Sink for Taps {
    fn take(&mut self, batch: AddressBatch<'_>) {
        let mut number = 0;
        batch.for_each_tap(|request, plane, reads| {
            let (of_tap, addresses) = batch.tap(number);
            assert_eq!(of_tap, plane);
            let used = &addresses[..batch.texels_per_tap];
            assert!(used.iter().filter(|&&address| !is_outside(address)).eq(reads), "{used:?} are read as {reads:?}");
            let mut addresses = addresses.map(|address| if is_outside(address) { u64::MAX } else { address });
            addresses[batch.texels_per_tap..].fill(0);
            self.taps.push((self.requests + request, plane, addresses));
            number += 1;
        });
        assert_eq!(number, batch.taps());
        self.requests += batch.len();
        if let Requests::Each(taps) = batch.requests {
            assert_eq!(batch.taps(), taps * batch.len());
        }
    }
}

/// Coordinates that mean something, coordinates at borders, any bits.
fn coordinate() -> impl Strategy<Value = i32> {
    prop_oneof![
        0..1i32 << 20,
        (-3i32..=3, -2i32..=2).prop_map(|(turns, near)| (turns << 20) + near),
        -(4i32 << 20)..4 << 20,
        Just(i32::MIN),
        Just(i32::MAX),
        any::<i32>(),
    ]
}

/// Levels that mean something to one source of levels or the other, the specials of both, any bits.
fn scale() -> impl Strategy<Value = u32> {
    prop_oneof![
        (110u32 << 23..160 << 23),
        0u32..16 << 8,
        (-600i32..0).prop_map(i32::cast_unsigned),
        prop::sample::select(vec![0, 1 << 31, 0x7F80_0000, 0xFF80_0000, 0x7FC0_0000, 0x7F7F_FFFF, 0x8000_0001]),
        (120u32 << 23..130 << 23).prop_map(|bits| bits & !0x7FFF),
        any::<u32>(),
    ]
}

fn request() -> impl Strategy<Value = Request> {
    let vector = || [-(1i32 << 18)..1 << 18, -(1i32 << 18)..1 << 18].prop_map(|vector| vector.map(I12F20::from_bits));
    (coordinate(), coordinate(), [scale(), scale()], [vector(), vector()], any::<[u16; 2]>()).prop_map(
        |(u, v, scale, axes, pixel)| Request { u: I12F20::from_bits(u), v: I12F20::from_bits(v), scale, axes, pixel },
    )
}

fn sampler() -> impl Strategy<Value = Sampler> {
    let log2 = prop_oneof![
        3 => Just(Log2::Exact),
        1 => prop::sample::select(vec![Log2::Table16, Log2::Quadratic, Log2::Fourth, Log2::Herf, Log2::HerfPlain, Log2::Ilog2]),
    ];
    let level_rounding = prop::sample::select(vec![LevelRounding::Floor, LevelRounding::Nearest, LevelRounding::Gl]);
    let lod_source = prop_oneof![3 => Just(LodSource::Gradient), 1 => Just(LodSource::Explicit)];
    let levels =
        (-(16i16 << 8)..=16 << 8, prop_oneof![Just(0), 0..=32i32 << 8], prop_oneof![Just(32 << 8), 0..=32i32 << 8]);
    let bias = prop_oneof![Just(true), Just(false)];
    (log2, level_rounding, lod_source, levels, bias, 0u8..=8, 0u8..=127, 1u8..=64).prop_map(
        |(log2, level_rounding, lod_source, (most, min_lod, max_lod), bias, lod_bits, threshold, probes)| Sampler {
            log2,
            level_rounding,
            lod_source,
            bias: if bias { most } else { 0 },
            min_lod,
            max_lod,
            lod_bits,
            brilinear_threshold: threshold,
            max_anisotropy: probes,
            ..Sampler::default()
        },
    )
}

/// Bytes that tell every texel from its neighbours.
fn bytes(surface: &Surface) -> Vec<u8> {
    (0..surface.bytes as u32).map(|at| (at.wrapping_mul(0x9E37_79B9) >> 24) as u8).collect()
}

fn runner() -> TestRunner {
    let config = ProptestConfig::default();
    let rng = TestRng::deterministic_rng(config.rng_algorithm);
    TestRunner::new_with_rng(config, rng)
}

fn draw<S: Strategy>(runner: &mut TestRunner, strategy: &S) -> S::Value {
    strategy.new_tree(runner).expect("nothing is rejected").current()
}

/// What a small cache, and a machine around another, make of the taps of requests.
fn counted(
    unit: &mut Unit<'_>,
    requests: &[Request],
) -> (Counters, Vec<PlaneCounters>, TimingCounters, Vec<PlaneTiming>) {
    let cache = || TexelCache::new(Geometry { sets: 8, ways: 2, line: 64 }, Policy::Lru, 4, Detail::default());
    let mut untimed = cache().expect("a cache");
    unit.addresses(requests, &mut untimed);
    let (parameters, memory) = (Parameters::default(), MemoryParameters::default());
    let mut timing = Timing::new(&parameters, &memory, cache().expect("a cache"), 4, ()).expect("a machine that runs");
    unit.run(requests, &mut vec![Response::default(); requests.len()], &mut timing);
    assert_eq!(timing.cache().counters(), untimed.counters());
    (untimed.counters(), untimed.planes(), timing.counters(), timing.planes())
}

/// Compares the two units on requests, with and without somebody to look at the taps.
fn compare(sampler: &Sampler, surface: &Surface, bytes: &[u8], requests: &[Request]) {
    let told = || format!("{sampler:?}\n{:?} {:?}", surface.layout, surface.planes[0].size());
    let lanes = Unit::new(sampler, surface, bytes).expect("a sound unit");
    let mut scalar = lanes.clone().scalar();
    assert_eq!(scalar.lanes(), 1);
    let mut right = vec![Response::default(); requests.len()];
    let mut right_taps = Taps::default();
    scalar.run(requests, &mut right, &mut right_taps);
    let right_counts = counted(&mut scalar, requests);

    for mut lanes in [lanes.clone().eight_lanes(), lanes] {
        let mut seen = (vec![Response::default(); requests.len()], Taps::default());
        lanes.run(requests, &mut seen.0, &mut seen.1);
        let mut unseen = vec![Response::default(); requests.len()];
        lanes.run(requests, &mut unseen, &mut ());
        let mut addresses = Taps::default();
        lanes.addresses(requests, &mut addresses);
        let counts = counted(&mut lanes, requests);
        let told = || format!("{} lanes, {}", lanes.lanes(), told());
        for (number, request) in requests.iter().enumerate() {
            assert_eq!(seen.0[number], right[number], "seen, request {number}: {request:?}\n{}", told());
            assert_eq!(unseen[number], right[number], "unseen, request {number}: {request:?}\n{}", told());
        }
        assert!(seen.1 == right_taps, "taps of a run\n{}", told());
        assert!(addresses == right_taps, "taps alone\n{}", told());
        assert_eq!(counts, right_counts, "counters\n{}", told());
    }
}

#[test]
fn lanes_are_the_scalar_unit_for_every_filter_address_mode_layout_and_size() {
    let mut runner = runner();
    let (sampler, request) = (sampler(), request());
    for filter in of_texels() {
        for layout in LAYOUTS {
            for [width, height] in SIZES {
                let surface = Surface::new(filter.pyramid(), layout, Format::Rgba8, width, height).expect("a surface");
                let bytes = bytes(&surface);
                for u in MODES {
                    for v in MODES {
                        let skip_empty_taps = draw(&mut runner, &any::<bool>());
                        let sampler =
                            Sampler { filter, address: [u, v], skip_empty_taps, ..draw(&mut runner, &sampler) };
                        // Sixteen lanes twice, eight once, and a rest that fills none.
                        let requests: Vec<Request> = (0..32 + 8 + 3).map(|_| draw(&mut runner, &request)).collect();
                        compare(&sampler, &surface, &bytes, &requests);
                    }
                }
            }
        }
    }
}

#[test]
fn neighbours_that_share_a_plane_are_answered_as_if_alone() {
    let mut runner = runner();
    let (sampler, request) = (sampler(), request());
    for filter in of_texels() {
        let surface = Surface::new(filter.pyramid(), LAYOUTS[1], Format::Rgba8, 96, 40).expect("a surface");
        let bytes = bytes(&surface);
        for mode in MODES {
            let sampler = Sampler { filter, address: [mode; 2], ..draw(&mut runner, &sampler) };
            let scale = draw(&mut runner, &request).scale;
            let requests: Vec<Request> =
                (0..256 + 5).map(|_| Request { scale, ..draw(&mut runner, &request) }).collect();
            compare(&sampler, &surface, &bytes, &requests);
        }
    }
}

#[test]
fn every_mantissa_boundary_of_the_logarithm_is_where_the_scalar_unit_has_it() {
    let surface =
        Surface::new(Filter::Trilinear.pyramid(), Layout::RowMajor, Format::Rgba8, 512, 512).expect("a surface");
    let bytes = bytes(&surface);
    let sampler = Sampler::default();
    let boundaries =
        (1..=128).map(|k| (2f64.powf(f64::from(2 * k - 1) / 256.0) * f64::from(1 << 23)) as u32 - (1 << 23));
    let requests: Vec<Request> = boundaries
        .flat_map(|mantissa| (mantissa.saturating_sub(3)..mantissa + 4).map(|mantissa| mantissa.min((1 << 23) - 1)))
        .flat_map(|mantissa| [0u32, 1, 126, 127, 128, 131, 254, 255].map(|exponent| exponent << 23 | mantissa))
        .map(|scale| Request { scale: [scale; 2], ..Request::default() })
        .collect();
    compare(&sampler, &surface, &bytes, &requests);
}

#[test]
fn lanes_serve_the_common_case_where_the_machine_has_them() {
    let surface =
        Surface::new(Filter::Trilinear.pyramid(), Layout::default(), Format::Rgba8, 64, 64).expect("a surface");
    let bytes = bytes(&surface);
    let lanes = |sampler: &Sampler| Unit::new(sampler, &surface, &bytes).expect("a unit").lanes();
    #[cfg(target_arch = "x86_64")]
    let machine = match () {
        () if std::arch::is_x86_feature_detected!("avx512bw") => 16,
        () if std::arch::is_x86_feature_detected!("avx2") => 8,
        () => 1,
    };
    #[cfg(not(target_arch = "x86_64"))]
    let machine = 1;
    assert_eq!(lanes(&Sampler::default()), machine);
    let eight = Unit::new(&Sampler::default(), &surface, &bytes).expect("a unit").eight_lanes();
    assert_eq!(eight.lanes(), machine.min(8));
    assert_eq!(lanes(&Sampler { filter_bits: 7, ..Sampler::default() }), 1);
    assert_eq!(lanes(&Sampler { rounding: Rounding::StagedRound, ..Sampler::default() }), 1);
}

#[test]
fn memories_beyond_four_gibibytes_are_read_where_they_are() {
    let surface = Surface::new(Filter::Feline.pyramid(), Layout::RowMajor, Format::Rgba8, 32_768, 32_768);
    let surface = surface.expect("a surface");
    // Pages that are neither written nor read are never there.
    let mut bytes = vec![0; surface.bytes as usize];
    let level_1 = surface.planes[1].base as usize;
    assert!(level_1 >= 1 << 32);
    bytes[level_1..level_1 + 4096].iter_mut().zip((1..=251).cycle()).for_each(|(byte, value)| *byte = value);
    // Two texels of level 0 a pixel along both axes: level 1.
    let step = I12F20::from_bits(2 << (20 - 15));
    let axes = [[step, I12F20::ZERO], [I12F20::ZERO, step]];
    let scale = [4.0_f32.to_bits(); 2];
    let request = |texel: i32| Request { axes, scale, ..Request::at(I12F20::from_bits(texel << 6), I12F20::ZERO) };
    let requests: Vec<Request> = (0..64).map(request).collect();
    let sampler = Sampler { filter: Filter::Feline, ..Sampler::default() };
    compare(&sampler, &surface, &bytes, &requests);
    let mut responses = vec![Response::default(); requests.len()];
    Unit::new(&sampler, &surface, &bytes).expect("a unit").run(&requests, &mut responses, &mut ());
    assert!(responses.iter().all(|response| response.lod[0] == 256 && response.texel != [0; 4]));
}
