//! One subject, once, over 64 rows: for `count-instructions`, which runs it under callgrind.

use std::hint::black_box;

use texunit_benches::{
    workload::{Addresses, Case},
    yardstick,
};
use texunit_hw::{
    AddressBatch, FILTERS, Geometry, Policy, Response, Sampler, Sink, Unit,
    cache::{Cache, Detail, TexelCache},
    timing::{MemoryParameters, Parameters, Timing},
};

/// Has taps made, and leaves them.
struct Nothing;

impl Sink for Nothing {
    fn take(&mut self, batch: AddressBatch<'_>) {
        black_box(batch);
    }
}

const SUBJECTS: &str = "hand-whole hand-whole-counters hand-sampling hand-bilinear hand-caching hand-cache whole whole-plain timed sampling scalar-sampling \
                        taps-and-texels addresses cache";

/// Everything below this frame is counted.
#[inline(never)]
fn counted<T>(work: impl FnOnce() -> T) {
    black_box(work());
}

fn main() {
    let subject = std::env::args().nth(1).unwrap_or_default();
    // A subject that ends in `=FILTER` is that filter's; the others are trilinear.
    let (subject, filter) = subject.split_once('=').unwrap_or((&subject, "Trilinear"));
    let filter = FILTERS.into_iter().find(|known| format!("{known:?}") == filter).expect("a filter by its name");
    let case = Case::rows(filter, 500..564);
    let (requests, bytes) = (&case.requests[..], &case.memory.bytes[..]);
    let mut texels = vec![0u32; requests.len()];
    let mut responses = vec![Response::default(); requests.len()];
    let geometry = Geometry { sets: 64, ways: 4, line: 64 };
    let detail = |classes, line_use| Detail { classes, line_use };
    let texel_cache = |detail| TexelCache::new(geometry, Policy::Lru, 4, detail).expect("64 x 4 x 64");
    let mut unit = Unit::new(&Sampler { filter, ..Sampler::default() }, &case.memory.surface, bytes).expect("sound");
    let mut addresses = Addresses(Vec::new());
    unit.addresses(requests, &mut addresses);
    println!("{} requests", requests.len());
    match subject {
        "hand-whole" => counted(|| yardstick::whole_path(requests, bytes, &mut texels)),
        "hand-whole-counters" => counted(|| yardstick::whole_path_with_counters(requests, bytes, &mut texels)),
        "hand-sampling" => counted(|| yardstick::sampling(requests, bytes, &mut texels)),
        "hand-bilinear" => counted(|| yardstick::bilinear(requests, bytes, &mut texels)),
        "hand-caching" => counted(|| yardstick::caching(requests)),
        "hand-cache" => counted(|| yardstick::cache_alone(&addresses.0)),
        "whole" => {
            let mut cache = texel_cache(detail(true, true));
            counted(|| unit.run(requests, &mut responses, &mut cache));
        }
        "timed" => {
            let memory = MemoryParameters::default();
            let cache = texel_cache(detail(true, true));
            let mut timing = Timing::new(&Parameters::default(), &memory, cache, 4, ()).expect("a machine that runs");
            counted(|| unit.run(requests, &mut responses, &mut timing));
        }
        "whole-plain" => {
            let mut cache = texel_cache(detail(false, false));
            counted(|| unit.run(requests, &mut responses, &mut cache));
        }
        "sampling" => counted(|| unit.run(requests, &mut responses, &mut ())),
        "scalar-sampling" => {
            let mut unit = unit.scalar();
            counted(|| unit.run(requests, &mut responses, &mut ()));
        }
        // With somebody who looks, though at nothing.
        "taps-and-texels" => counted(|| unit.run(requests, &mut responses, &mut Nothing)),
        "addresses" => counted(|| unit.addresses(requests, &mut Nothing)),
        "cache" => {
            let mut cache = Cache::new(geometry, Policy::Lru).expect("64 x 4 x 64");
            counted(|| cache.access_all(&addresses.0, &mut ()));
        }
        _ => panic!("name a subject: {SUBJECTS}"),
    }
}
