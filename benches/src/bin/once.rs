//! One subject, once, over 64 rows: for `count-instructions`, which runs it under callgrind.

use std::hint::black_box;

use texunit_benches::{workload::Case, yardstick};
use texunit_hw::{
    Batch, Filter, Geometry, Policy, Response, Sampler, Sink, Unit,
    cache::{Cache, Detail, TexelCache},
};

struct Addresses(Vec<u64>);

impl Sink for Addresses {
    fn take(&mut self, batch: Batch<'_>) {
        batch.for_each_read(|_, address| self.0.push(address));
    }
}

/// Everything below this frame is counted.
#[inline(never)]
fn counted<T>(work: impl FnOnce() -> T) {
    black_box(work());
}

fn main() {
    let subject = std::env::args().nth(1).unwrap_or_default();
    let case = Case::rows(Filter::Trilinear, 500..564);
    let (requests, bytes) = (&case.requests[..], &case.memory.bytes[..]);
    let mut texels = vec![0u32; requests.len()];
    let mut responses = vec![Response::default(); requests.len()];
    let geometry = Geometry { sets: 64, ways: 4, line: 64 };
    let detail = |classes, line_use| Detail { classes, line_use };
    let texel_cache = |detail| TexelCache::new(geometry, Policy::Lru, 4, detail).expect("64 x 4 x 64");
    let mut unit = Unit::new(&Sampler::default(), &case.memory.surface, bytes).expect("sound");
    let mut addresses = Addresses(Vec::new());
    unit.addresses(requests, &mut addresses);
    println!("{} requests", requests.len());
    match subject.as_str() {
        "hand-whole" => counted(|| yardstick::whole_path(requests, bytes, &mut texels)),
        "hand-sampling" => counted(|| yardstick::sampling(requests, bytes, &mut texels)),
        "hand-caching" => counted(|| yardstick::caching(requests)),
        "hand-cache" => counted(|| yardstick::cache_alone(&addresses.0)),
        "whole" => {
            let mut cache = texel_cache(detail(true, true));
            counted(|| unit.run(requests, &mut responses, &mut cache));
        }
        "whole-plain" => {
            let mut cache = texel_cache(detail(false, false));
            counted(|| unit.run(requests, &mut responses, &mut cache));
        }
        "sampling" => counted(|| unit.run(requests, &mut responses, &mut ())),
        "addresses" => counted(|| unit.addresses(requests, &mut ())),
        "cache" => {
            let mut cache = Cache::new(geometry, Policy::Lru).expect("64 x 4 x 64");
            counted(|| cache.access_all(&addresses.0, &mut ()));
        }
        _ => panic!("name a subject: hand-whole hand-sampling hand-caching hand-cache whole whole-plain sampling addresses cache"),
    }
}
