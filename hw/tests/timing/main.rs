//! The max-plus model against a simulator that ticks: the same clock for every item, the same value of every counter.

mod draw;
mod memory;
mod simulator;

use draw::{Draw, READS, machine, stream};
use proptest::prelude::*;
use simulator::{Machine, MissClocks, Tap, TapClocks, simulate};
use texunit_hw::{
    Batch, Footprint, Format, Geometry, Layout, Policy, PyramidKind, Requests, Sink, Surface,
    cache::{Detail, TexelCache},
    timing::{
        FillTimes, Histograms, MainMemory, MemoryParameters, Parameters, RequestTimes, StoredFetch, TapTimes, Timing,
        TimingCounters, TimingObserver,
    },
};

#[derive(Default)]
struct Recorder {
    requests: Vec<[u64; 3]>,
    taps: Vec<TapClocks>,
    misses: Vec<MissClocks>,
    /// What was asked of memory for a decompressor: clock, address, bytes.
    requested: Vec<(u64, u64, u64)>,
}

impl TimingObserver for &mut Recorder {
    fn fill(&mut self, fill: FillTimes, stored: &[StoredFetch]) {
        assert_eq!(fill.tap, self.taps.len() as u64);
        self.requested.extend(stored.iter().map(|one| (one.fetch.taken, one.address, one.bytes.into())));
        self.misses.push(MissClocks {
            address: fill.address,
            access: fill.access,
            taken: fill.fetch.taken,
            filled: fill.fetch.filled,
        });
    }
    fn tap(&mut self, tap: TapTimes) {
        assert_eq!((tap.tap, tap.request), (self.taps.len() as u64, self.requests.len() as u64));
        self.taps.push(TapClocks {
            issue: tap.issue,
            tag: tap.tag,
            tag_done: tap.tag_done,
            data: tap.data,
            data_done: tap.data_done,
            datapath: tap.datapath,
            misses: tap.misses.into(),
        });
    }
    fn request(&mut self, request: RequestTimes) {
        self.requests.push([request.entry, request.lod, request.result]);
    }
}

fn cache(machine: &Machine) -> TexelCache {
    let geometry = Geometry { sets: machine.sets, ways: machine.ways, line: machine.line };
    let cache = TexelCache::new(geometry, Policy::Lru, 4, Detail::default()).unwrap();
    match machine.stored {
        Some(stored) => cache.with_decompressor(stored.lines[(machine.line / 16).ilog2() as usize].clone()),
        None => cache,
    }
}

fn agree(machine: &Machine, requests: &[Vec<Tap>]) -> TimingCounters {
    let mut recorder = Recorder::default();
    let mut timing = Timing::new(&machine.pipeline, &machine.memory, cache(machine), READS, &mut recorder).unwrap();
    let mut untimed = cache(machine);
    for request in requests {
        timing.request(request.iter().map(|tap| (tap.plane, &tap.addresses[..])));
        request.iter().for_each(|tap| untimed.read_all(tap.plane, &tap.addresses));
    }
    let counters = timing.counters();
    assert_eq!(timing.cache().counters(), untimed.counters(), "time changes no hit");
    assert_eq!(timing.cache().planes(), untimed.planes());
    let planes = timing.planes();
    let sum = |field: fn(&texunit_hw::timing::PlaneTiming) -> u64| planes.iter().map(field).sum::<u64>();
    assert_eq!(sum(|plane| plane.taps), counters.taps);
    assert_eq!(sum(|plane| plane.bytes_filled), counters.bytes_filled);
    assert_eq!(sum(|plane| plane.bytes_fetched), counters.bytes_fetched);
    assert_eq!(sum(|plane| plane.stall_wait_read), counters.stall_wait_read);
    assert_eq!(sum(|plane| plane.fill_latency_sum), counters.fill_latency_sum);
    assert_eq!(sum(|plane| plane.row_hits), counters.row_hits);
    assert_eq!(sum(|plane| plane.row_misses), counters.row_misses);
    assert_eq!(sum(|plane| plane.row_conflicts), counters.row_conflicts);
    assert_eq!(sum(|plane| plane.second_level_hits), counters.second_level_hits);
    assert_eq!(*timing.histograms(), histograms(requests));
    conserve(&counters, &untimed, machine);
    drop(timing);

    let log = simulate(machine, requests);
    let (mut batched, mut alike) = (Recorder::default(), Recorder::default());
    in_batches(machine, requests, false, &counters, &mut batched);
    in_batches(machine, requests, true, &counters, &mut alike);
    in_batches(machine, requests, true, &counters, ());
    for recorder in [recorder, batched, alike] {
        assert_eq!(recorder.taps, log.taps, "taps");
        assert_eq!(recorder.misses, log.misses, "misses");
        assert_eq!(recorder.requests, log.requests, "requests");
        let requested = if machine.stored.is_some() { &log.requested[..] } else { &[] };
        assert_eq!(recorder.requested, requested, "requests to memory");
    }
    for ((name, _), value) in TimingCounters::FIELDS.iter().zip(counters.values()) {
        assert_eq!(value, log.counters.get(*name).copied().unwrap_or(0), "{name}");
    }
    counters
}

/// The same requests as a unit hands them over: batches of footprints, the texels that are not read outside the texture.
/// Of requests with as many taps each where they are to be alike, else of any.
fn in_batches<O: TimingObserver>(
    machine: &Machine,
    requests: &[Vec<Tap>],
    alike: bool,
    expected: &TimingCounters,
    observer: O,
) {
    // Of one plane; the streams name three, as those of several textures in one memory do, which are numbered on.
    let surface = Surface::new(PyramidKind::Mipmap, Layout::RowMajor, Format::Rgba8, 1, 1).unwrap();
    let cache = cache(machine).with_planes(3);
    let mut timing = Timing::new(&machine.pipeline, &machine.memory, cache, READS, observer).unwrap();
    // Eight taps at a time are looked at together, and what is left of a batch one by one.
    let most = if machine.sets > 3 { 7 } else { 24 };
    let together = |a: &Vec<Tap>, b: &Vec<Tap>| !alike || a.len() == b.len();
    for requests in requests.chunk_by(together).flat_map(|requests| requests.chunks(most)) {
        let mut ends = Vec::new();
        let mut taps = Vec::new();
        for (number, request) in requests.iter().enumerate() {
            // Requests without taps, at the front and between others, are in nobody's way.
            if !alike && number % 3 == 0 {
                ends.push(taps.len() as u32);
            }
            taps.extend(request.iter().map(|tap| {
                let mut address = [1 << 62; 4];
                address[..tap.addresses.len()].copy_from_slice(&tap.addresses);
                Footprint { address, plane: tap.plane as u16, ..Footprint::default() }
            }));
            ends.push(taps.len() as u32);
        }
        let each = requests[0].len();
        let requests = if alike && each > 0 { Requests::Each(each) } else { Requests::Ends(&ends) };
        timing.take(Batch { taps: &taps, requests, texels_per_tap: 4, surface: &surface }.into());
    }
    assert_eq!(timing.counters(), *expected, "batches");
    assert_eq!(*timing.histograms(), histograms(requests), "batches");
}

/// Requests with taps, by taps, by different planes, and by taps a plane.
fn histograms(requests: &[Vec<Tap>]) -> Histograms {
    let mut histograms = Histograms::default();
    for request in requests.iter().filter(|request| !request.is_empty()) {
        let planes = request.iter().map(|tap| tap.plane).collect::<std::collections::BTreeSet<_>>().len();
        histograms.taps[request.len()] += 1;
        histograms.planes[planes] += 1;
        histograms.anisotropy[request.len() / planes] += 1;
    }
    histograms
}

/// What must add up, whatever the machine.
fn conserve(c: &TimingCounters, cache: &TexelCache, machine: &Machine) {
    let cached = cache.counters();
    assert_eq!(c.reads, cached.lookups);
    assert_eq!(c.fills, cached.misses);
    assert_eq!((c.bytes_filled, c.bytes_fetched), (cached.bytes_filled, cached.bytes_fetched));
    assert_eq!(c.bytes_filled, c.fills * u64::from(machine.line));
    assert!(machine.stored.is_some() || c.bytes_fetched == c.bytes_filled);
    assert_eq!(c.fetches_ok + c.fetches_failed + c.fetches_skipped, c.reads);
    assert!(c.fetches_merged <= c.fetches_ok);
    assert_eq!(c.entry_busy + c.entry_idle + c.entry_stall_request_fifo, c.cycles);
    assert_eq!(c.lod_busy + c.lod_idle + c.lod_stall_lod_fifo, c.cycles);
    assert_eq!(c.sequencer_busy + c.sequencer_idle + c.sequencer_stall_tap_fifo, c.cycles);
    assert_eq!(c.tag_busy + c.tag_idle + c.tag_stall_fragment_fifo + c.stall_fetch, c.cycles);
    assert_eq!(c.miss_port_busy + c.miss_port_idle + c.miss_port_stall_memory, c.cycles);
    assert!(if machine.stored.is_some() { c.miss_port_busy >= c.fills } else { c.miss_port_busy == c.fills });
    assert_eq!(c.decompressor_busy + c.decompressor_idle, c.cycles);
    let work = (machine.line / 4).div_ceil(machine.pipeline.decompress_texels_per_clock);
    assert_eq!(c.decompressor_busy, machine.stored.map_or(0, |_| c.fills * u64::from(work)));
    assert_eq!(c.data_busy + c.data_idle + c.data_stall_fill + c.data_stall_result_fifo, c.cycles);
    assert_eq!(c.datapath_busy + c.datapath_idle, c.cycles);
    assert_eq!(c.result_busy + c.result_idle, c.cycles);
    if c.second_level_lookups > 0 {
        assert_eq!(c.second_level_lookups, c.miss_port_busy);
        assert_eq!(c.second_level_misses, c.memory_requests);
    } else {
        assert_eq!(c.memory_requests, c.miss_port_busy);
        assert_eq!(c.memory_bytes, c.bytes_fetched);
    }
    if c.row_hits + c.row_misses + c.row_conflicts > 0 {
        assert_eq!(c.row_hits + c.row_misses + c.row_conflicts, c.memory_requests);
    }
}

fn numbers(count: usize) -> impl Strategy<Value = Vec<u32>> {
    prop::collection::vec(any::<u32>(), count)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6000, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn every_item_passes_every_unit_at_the_clock_a_ticking_machine_says(numbers in numbers(600)) {
        let mut draw = Draw(numbers.iter());
        let machine = machine(&mut draw);
        agree(&machine, &stream(&mut draw, 24));
    }

    #[test]
    fn short_streams_of_any_machine_agree_too(numbers in numbers(160)) {
        let mut draw = Draw(numbers.iter());
        let machine = machine(&mut draw);
        agree(&machine, &stream(&mut draw, 5));
    }
}

/// A stream that the tag unit takes without a pause: whatever is too shallow in front of it or behind shows at once.
#[test]
fn fifos_just_deep_enough_or_just_too_shallow_agree_where_nothing_else_holds_taps_up() {
    let hits = |taps: usize| {
        let tap =
            |number: usize| Tap { plane: 0, addresses: [0, 4, 8, 12].map(|at| at + 16 * (number as u64 % 4)).to_vec() };
        vec![(0..taps).map(tap).collect::<Vec<_>>(); 24]
    };
    let streams = [hits(1), hits(2)];
    let mut machine = Machine {
        pipeline: Parameters { fragment_fifo: 100, ..Parameters::default() },
        memory: MemoryParameters { main: MainMemory::Fixed { latency: 0, bytes_per_clock: 64 }, second_level: None },
        sets: 4,
        ways: 2,
        line: 64,
        stored: None,
    };
    for number in 0..3u32.pow(7) * 2 {
        let digit = |place: u32| number / 3u32.pow(place) % 3;
        let latency = |place: u32| 1 + digit(place);
        // One place too few, as many as needed, one more; the data unit and the datapath count together.
        let depth = |place: u32, latency: u32| (latency + digit(place)).max(1);
        let p = &mut machine.pipeline;
        (p.lod_latency, p.address_latency, p.filter_latency) = (latency(0), latency(1), latency(2));
        p.lod_fifo = depth(3, p.lod_latency);
        p.tap_fifo = depth(4, p.address_latency);
        p.result_fifo = depth(5, p.data_latency + p.filter_latency);
        p.request_fifo = 1 + digit(6);
        agree(&machine, &streams[(number / 3u32.pow(7)) as usize]);
    }
}

#[test]
fn the_random_machines_meet_every_stall_and_every_counter() {
    let mut seed = 1u32;
    let mut sums = vec![0u64; TimingCounters::FIELDS.len()];
    for _ in 0..400 {
        let numbers: Vec<u32> = std::iter::repeat_with(|| {
            // Marsaglia's xorshift.
            seed ^= seed << 13;
            seed ^= seed >> 17;
            seed ^= seed << 5;
            seed
        })
        .take(600)
        .collect();
        let mut draw = Draw(numbers.iter());
        let machine = machine(&mut draw);
        let counters = agree(&machine, &stream(&mut draw, 24));
        sums.iter_mut().zip(counters.values()).for_each(|(sum, value)| *sum += value);
    }
    for ((name, _), sum) in TimingCounters::FIELDS.iter().zip(sums) {
        assert!(sum > 0, "{name} is never above 0");
    }
}
