//! `cargo run --release` in this folder: every ratio of docs/performance.md, taken in one run, as a table and as JSON.

use texunit_benches::{
    contest::{Goal, Row, seconds},
    workload::{Addresses, Case},
    yardstick::{self, Counted},
};
use texunit_hw::{
    Filter, Geometry, Policy, Request, Response, Sampler, Unit,
    cache::{Cache, Counters, Detail, MissClassifier, PlaneCounters, TexelCache},
    sweep::{FifoSweep, Grid, LruSweep},
    timing::{DramParameters, MainMemory, MemoryParameters, Parameters, Timing},
};

/// Rounds; each measures every subject once, so that a slow moment hits all alike.
const ROUNDS: usize = 9;

/// Requests of a block.
const BLOCK: usize = 4096;
/// The command, built beside the benches.
const TEXUNIT: &str = "../target/release/texunit";

/// Times a block is answered.
const TIMES: usize = 256;

/// The counters of the model as the yardstick has them.
fn counted(counters: Counters, planes: &[PlaneCounters]) -> Counted {
    let mut counted = Counted { used: counters.bytes_used / 4, ..Counted::default() };
    for (level, plane) in planes.iter().enumerate() {
        counted.lookups[level] = plane.lookups;
        counted.misses[level] = [plane.classes.compulsory, plane.classes.capacity, plane.classes.conflict];
    }
    counted
}

fn main() {
    let case = Case::new(Filter::Trilinear);
    let sampler = Sampler::default();
    let geometry = Geometry { sets: 64, ways: 4, line: 64 };
    let (requests, bytes) = (&case.requests[..], &case.memory.bytes[..]);
    let unit = || Unit::new(&sampler, &case.memory.surface, bytes).expect("the case is sound");
    let texel_cache = |classes, line_use| {
        TexelCache::new(geometry, Policy::Lru, 4, Detail { classes, line_use }).expect("64 x 4 x 64")
    };
    let cache = |policy| Cache::new(geometry, policy).expect("64 x 4 x 64");
    let fixed = MemoryParameters::default();
    let dram = MemoryParameters { main: MainMemory::Dram(DramParameters::default()), second_level: None };
    let timing = |memory: &MemoryParameters| {
        Timing::new(&Parameters::default(), memory, texel_cache(true, true), 4, ()).expect("a machine that runs")
    };
    let mut responses = vec![Response::default(); requests.len()];
    let mut texels = vec![0u32; requests.len()];
    let mut addresses = Addresses(Vec::with_capacity(8 * requests.len()));
    unit().addresses(requests, &mut addresses);
    let addresses = addresses.0;

    // Yardsticks that count must count what the model counts, but for levels: theirs are of a logarithm without a table, which is
    // another one in a request of a thousand.
    let mut once = texel_cache(true, true);
    unit().run(requests, &mut responses, &mut once);
    let by_hand = yardstick::whole_path_with_counters(requests, bytes, &mut texels);
    let alike = |by_hand: u64, model: u64| assert!(by_hand.abs_diff(model) * 100 <= model, "{by_hand}, not {model}");
    let counted = counted(once.counters(), &once.planes());
    alike(by_hand.used, counted.used);
    for class in 0..3 {
        let of_all = |counted: &Counted| counted.misses.iter().map(|level| level[class]).sum();
        alike(of_all(&by_hand), of_all(&counted));
    }
    alike(yardstick::whole_path(requests, bytes, &mut texels), once.counters().misses);
    assert_eq!(yardstick::cache_alone(&addresses), once.counters().misses);

    // As many requests as a front end hands on at a time: they and their answers stay in the host's first-level caches, where the whole
    // frame's 44 bytes each come from memory.
    let middle = &requests[requests.len() / 2..][..BLOCK];
    let bilinear_case = Sampler { filter: Filter::Bilinear, ..sampler };
    let texels_only = |sampler: &Sampler, requests: &[Request], responses: &mut [Response], times: usize| {
        let mut unit = Unit::new(sampler, &case.memory.surface, bytes).expect("the case is sound");
        seconds(|| (0..times).for_each(|_| unit.run(requests, &mut responses[..requests.len()], &mut ())))
    };
    let grid = Grid { log2_sets: 10, ways: 16, line: 64 };

    // A scene with every filter, as the command does it, in one thread and in two.
    let command = |threads: &str| {
        let folder = std::env::temp_dir().join("texunit-benches");
        let status = std::process::Command::new(TEXUNIT)
            .args(["run", "floor", "--size", "320x240", "--output"])
            .arg(&folder)
            .env("RAYON_NUM_THREADS", threads)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .status();
        assert!(status.is_ok_and(|status| status.success()), "{TEXUNIT}: build it with cargo build --release");
    };

    let n = requests.len();
    let mut rows: Vec<Row<'_>> = Vec::new();
    for round in 0..ROUNDS {
        let mut next = 0;
        let mut enter = |name, against, goal, work, times| {
            if round == 0 {
                rows.push(Row { name, against, goal, work, times: Vec::new() });
            }
            rows[next].times.push(times);
            next += 1;
        };
        let hand = "plain loop";
        let hits_by_hand = seconds(|| yardstick::whole_path(requests, bytes, &mut texels));
        let all_by_hand = seconds(|| yardstick::whole_path_with_counters(requests, bytes, &mut texels));
        let mut run = |mut sink: TexelCache| {
            seconds(|| {
                unit().run(requests, &mut responses, &mut sink);
                sink.counters()
            })
        };
        let (full, plain) = (run(texel_cache(true, true)), run(texel_cache(false, false)));
        enter("texels and cache, every counter", "plain loop, every counter", Goal::Speed(1.5), n, [all_by_hand, full]);
        enter("texels and cache, every counter", "plain loop, misses only", Goal::None, n, [hits_by_hand, full]);
        enter("texels and cache, misses only", "plain loop, misses only", Goal::Speed(1.5), n, [hits_by_hand, plain]);
        let mut run = |memory| {
            let mut sink = timing(memory);
            seconds(|| {
                unit().run(requests, &mut responses, &mut sink);
                sink.counters()
            })
        };
        let (timed, dram_timed) = (run(&fixed), run(&dram));
        enter("the same with time", "plain loop, every counter", Goal::Speed(0.75), n, [all_by_hand, timed]);
        enter("the same with time", "plain loop, misses only", Goal::None, n, [hits_by_hand, timed]);
        enter("the same with time", "without time", Goal::Cost(2.0), n, [full, timed]);
        enter("the same with time, DRAM", "without time", Goal::None, n, [full, dram_timed]);

        let by_hand = seconds(|| yardstick::sampling(requests, bytes, &mut texels));
        let model = texels_only(&sampler, requests, &mut responses, 1);
        enter("trilinear texels", hand, Goal::Speed(4.0), n, [by_hand, model]);
        let model = seconds(|| unit().scalar().run(requests, &mut responses, &mut ()));
        enter("trilinear texels, without lanes", hand, Goal::None, n, [by_hand, model]);
        let by_hand = seconds(|| yardstick::bilinear(requests, bytes, &mut texels));
        let model = texels_only(&bilinear_case, requests, &mut responses, 1);
        enter("bilinear texels", hand, Goal::Speed(4.0), n, [by_hand, model]);
        let by_hand = seconds(|| (0..TIMES).for_each(|_| yardstick::sampling(middle, bytes, &mut texels[..BLOCK])));
        let model = texels_only(&sampler, middle, &mut responses, TIMES);
        enter("trilinear texels, a block", hand, Goal::Speed(4.0), TIMES * BLOCK, [by_hand, model]);
        let model = seconds(|| {
            let mut unit = unit().eight_lanes();
            (0..TIMES).for_each(|_| unit.run(middle, &mut responses[..BLOCK], &mut ()));
        });
        enter("trilinear texels, a block, eight lanes", hand, Goal::None, TIMES * BLOCK, [by_hand, model]);
        let by_hand = seconds(|| (0..TIMES).for_each(|_| yardstick::bilinear(middle, bytes, &mut texels[..BLOCK])));
        let model = texels_only(&bilinear_case, middle, &mut responses, TIMES);
        enter("bilinear texels, a block", hand, Goal::Speed(4.0), TIMES * BLOCK, [by_hand, model]);

        let by_hand = seconds(|| yardstick::caching(requests));
        let model = seconds(|| {
            let mut cache = texel_cache(false, false);
            unit().addresses(requests, &mut cache);
            cache.counters()
        });
        enter("addresses and plain cache", hand, Goal::None, n, [by_hand, model]);
        let lookups = addresses.len();
        let by_hand = seconds(|| yardstick::cache_alone(&addresses));
        let one = |policy| {
            seconds(|| {
                let mut cache = cache(policy);
                cache.access_all(&addresses, &mut ());
                cache.misses()
            })
        };
        let (lru, fifo) = (one(Policy::Lru), one(Policy::Fifo));
        enter("cache alone, LRU", hand, Goal::Speed(0.9), lookups, [by_hand, lru]);
        enter("cache alone, FIFO", hand, Goal::None, lookups, [by_hand, fifo]);
        let classes = seconds(|| {
            let mut classifier = MissClassifier::new(geometry).expect("64 x 4 x 64");
            cache(Policy::Lru).access_all(&addresses, &mut classifier);
            classifier.classes()
        });
        enter("three classes of misses", "one LRU run", Goal::Cost(4.0), lookups, [lru, classes]);
        let sweep = seconds(|| {
            let mut sweep = LruSweep::new(grid).expect("176 geometries");
            sweep.access_all(&addresses);
            sweep.misses(6, 4)
        });
        enter("176 LRU geometries in one pass", "one LRU run", Goal::Cost(9.0), lookups, [lru, sweep]);
        let sweep = seconds(|| {
            let mut sweep = FifoSweep::new(grid).expect("176 geometries");
            sweep.access_all(&addresses);
            sweep.misses(6, 4)
        });
        enter("176 FIFO geometries in one pass", "one LRU run", Goal::Cost(45.0), lookups, [lru, sweep]);

        let [one, two] = ["1", "2"].map(|threads| seconds(|| command(threads)));
        enter("a scene with every filter, two threads", "one thread", Goal::Speed(1.8), 1, [one, two]);
        let start = seconds(|| {
            std::process::Command::new(TEXUNIT).arg("--version").stdout(std::process::Stdio::null()).status()
        });
        enter("start-up", "20 ms", Goal::Cost(1.0), 1, [0.02, start]);
    }
    println!("{:<52} {:<34} {:>7} {:>8} {:<8} {:>9}", "model", "measured against", "figure", "goal", "", "model M/s");
    rows.iter().for_each(|row| println!("{}", row.line()));
    let json: Vec<_> = rows.iter().map(Row::json).collect();
    let path = "ratios.json";
    std::fs::write(path, format!("{:#}\n", serde_json::json!({ "schema": 2, "ratios": json }))).expect("ratios.json");
    println!("written to {path}");
}
