//! `cargo run --release` in this folder: every ratio of docs/performance.md, taken in one run, as a table and as JSON.

use std::{hint::black_box, time::Instant};

use texunit_benches::{workload::Case, yardstick};
use texunit_hw::{
    Batch, Filter, Geometry, Policy, Request, Response, Sampler, Sink, Unit,
    cache::{Cache, Detail, TexelCache},
};

/// Rounds; each measures every subject once, so that a slow moment hits all alike.
const ROUNDS: usize = 9;

/// Requests of a block.
const BLOCK: usize = 4096;
/// Times a block is answered.
const TIMES: usize = 256;

/// The median of the ratios yardstick / subject, round by round: above 1, the model is the faster.
struct Ratio {
    name: &'static str,
    goal: Option<f64>,
    times: Vec<[f64; 2]>,
    work: usize,
}

impl Ratio {
    fn median(&self, pick: impl Fn(&[f64; 2]) -> f64) -> f64 {
        let mut values: Vec<f64> = self.times.iter().map(pick).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    }
}

fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let begin = Instant::now();
    black_box(work());
    begin.elapsed().as_secs_f64()
}

/// Collects the address stream.
struct Addresses(Vec<u64>);

impl Sink for Addresses {
    fn take(&mut self, batch: Batch<'_>) {
        batch.for_each_read(|_, address| self.0.push(address));
    }
}

fn main() {
    let case = Case::new(Filter::Trilinear);
    let sampler = Sampler::default();
    let geometry = Geometry { sets: 64, ways: 4, line: 64 };
    let (requests, bytes) = (&case.requests[..], &case.memory.bytes[..]);
    let unit = || Unit::new(&sampler, &case.memory.surface, bytes).expect("the case is sound");
    let mut responses = vec![Response::default(); requests.len()];
    let mut texels = vec![0u32; requests.len()];
    let mut addresses = Addresses(Vec::with_capacity(8 * requests.len()));
    unit().addresses(requests, &mut addresses);
    let addresses = addresses.0;

    // As many requests as a front end hands on at a time: they and their answers stay in the host's first-level caches, where the whole
    // frame's 44 bytes each come from memory.
    let middle = &requests[requests.len() / 2..][..BLOCK];
    let bilinear_case = Sampler { filter: Filter::Bilinear, ..sampler };
    let texels_only = |sampler: &Sampler, requests: &[Request], responses: &mut [Response], times: usize| {
        let mut unit = Unit::new(sampler, &case.memory.surface, bytes).expect("the case is sound");
        seconds(|| (0..times).for_each(|_| unit.run(requests, &mut responses[..requests.len()], &mut ())))
    };

    let row = |name, goal, work| Ratio { name, goal, times: Vec::new(), work };
    let n = requests.len();
    let mut whole = row("texels and cache, all counters", Some(1.5), n);
    let mut plain = row("texels and cache, hits and line use only", None, n);
    let mut sampling = row("texels only", Some(4.0), n);
    let mut bilinear = row("bilinear texels only", Some(4.0), n);
    let mut sampling_block = row("texels only, a block at a time", Some(4.0), TIMES * BLOCK);
    let mut bilinear_block = row("bilinear texels only, a block at a time", Some(4.0), TIMES * BLOCK);
    let mut eight = row("texels only, a block, in eight lanes", None, TIMES * BLOCK);
    let mut scalar = row("texels only, without lanes", None, n);
    let mut caching = row("addresses and plain cache", None, n);
    let mut alone = row("cache alone, from addresses", Some(0.9), addresses.len());
    for _ in 0..ROUNDS {
        let by_hand = seconds(|| yardstick::whole_path(requests, bytes, &mut texels));
        let full = seconds(|| {
            let mut cache = TexelCache::new(geometry, Policy::Lru, 4, Detail::default()).expect("64 x 4 x 64");
            unit().run(requests, &mut responses, &mut cache);
            cache.counters()
        });
        whole.times.push([by_hand, full]);
        let few = seconds(|| {
            let detail = Detail { classes: false, line_use: true };
            let mut cache = TexelCache::new(geometry, Policy::Lru, 4, detail).expect("64 x 4 x 64");
            unit().run(requests, &mut responses, &mut cache);
            cache.counters()
        });
        plain.times.push([by_hand, few]);
        let by_hand = seconds(|| yardstick::sampling(requests, bytes, &mut texels));
        sampling.times.push([by_hand, texels_only(&sampler, requests, &mut responses, 1)]);
        scalar.times.push([by_hand, seconds(|| unit().scalar().run(requests, &mut responses, &mut ()))]);
        bilinear.times.push([
            seconds(|| yardstick::bilinear(requests, bytes, &mut texels)),
            texels_only(&bilinear_case, requests, &mut responses, 1),
        ]);
        let by_hand = seconds(|| (0..TIMES).for_each(|_| yardstick::sampling(middle, bytes, &mut texels[..BLOCK])));
        sampling_block.times.push([by_hand, texels_only(&sampler, middle, &mut responses, TIMES)]);
        eight.times.push([
            by_hand,
            seconds(|| {
                let mut unit = unit().eight_lanes();
                (0..TIMES).for_each(|_| unit.run(middle, &mut responses[..BLOCK], &mut ()));
            }),
        ]);
        bilinear_block.times.push([
            seconds(|| (0..TIMES).for_each(|_| yardstick::bilinear(middle, bytes, &mut texels[..BLOCK]))),
            texels_only(&bilinear_case, middle, &mut responses, TIMES),
        ]);
        caching.times.push([
            seconds(|| yardstick::caching(requests)),
            seconds(|| {
                let detail = Detail { classes: false, line_use: false };
                let mut cache = TexelCache::new(geometry, Policy::Lru, 4, detail).expect("64 x 4 x 64");
                unit().addresses(requests, &mut cache);
                cache.counters()
            }),
        ]);
        alone.times.push([
            seconds(|| yardstick::cache_alone(&addresses)),
            seconds(|| {
                let mut cache = Cache::new(geometry, Policy::Lru).expect("64 x 4 x 64");
                cache.access_all(&addresses, &mut ());
                cache.misses()
            }),
        ]);
    }
    let rows = [whole, plain, sampling, bilinear, sampling_block, bilinear_block, eight, scalar, caching, alone];
    println!(
        "{:<44} {:>7} {:>6} {:>14} {:>14}",
        "model / hand-written loop", "ratio", "goal", "model M/s", "by hand M/s"
    );
    for row in &rows {
        let speed = |which: usize| row.work as f64 / row.median(|times| times[which]) / 1e6;
        let goal = row.goal.map_or_else(String::new, |goal| format!("{goal:.2}"));
        println!(
            "{:<44} {:>7.2} {goal:>6} {:>14.1} {:>14.1}",
            row.name,
            row.median(|[by_hand, model]| by_hand / model),
            speed(1),
            speed(0)
        );
    }
    let json: Vec<_> = rows
        .iter()
        .map(|row| {
            serde_json::json!({
                "name": row.name, "goal": row.goal, "ratio": row.median(|[by_hand, model]| by_hand / model),
                "rounds": row.times.iter().map(|[by_hand, model]| by_hand / model).collect::<Vec<_>>(),
            })
        })
        .collect();
    let path = "ratios.json";
    std::fs::write(path, format!("{:#}\n", serde_json::json!({ "schema": 1, "ratios": json }))).expect("ratios.json");
    println!("written to {path}");
}
