//! `cargo bench` in this folder: the whole path beside its yardstick, under divan.

use divan::{Bencher, counter::ItemsCount};
use texunit_benches::{workload::Case, yardstick};
use texunit_hw::{
    Filter, Geometry, Policy, Response, Sampler, Unit,
    cache::{Detail, TexelCache},
};

fn main() {
    divan::main();
}

#[divan::bench(sample_count = 10)]
fn model(bencher: Bencher) {
    let case = Case::new(Filter::Trilinear);
    let mut responses = vec![Response::default(); case.requests.len()];
    let geometry = Geometry { sets: 64, ways: 4, line: 64 };
    bencher.counter(ItemsCount::new(case.requests.len())).bench_local(|| {
        let mut unit = Unit::new(&Sampler::default(), &case.memory.surface, &case.memory.bytes).expect("sound");
        let mut cache = TexelCache::new(geometry, Policy::Lru, 4, Detail::default()).expect("64 x 4 x 64");
        unit.run(&case.requests, &mut responses, &mut cache);
        cache.counters()
    });
}

#[divan::bench(sample_count = 10)]
fn by_hand(bencher: Bencher) {
    let case = Case::new(Filter::Trilinear);
    let mut texels = vec![0; case.requests.len()];
    bencher
        .counter(ItemsCount::new(case.requests.len()))
        .bench_local(|| yardstick::whole_path(&case.requests, &case.memory.bytes, &mut texels));
}
