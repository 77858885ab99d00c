//! How fast is the cache alone? Lookups per second on tiled trilinear addresses, against a hand-written loop of one
//! geometry in the same process. `cargo run --release -p texunit-hw --example cache_speed`

mod floor;

use floor::{Contest, addresses};
use texunit_hw::cache::{Cache, Detail, Geometry, MissClassifier, Policy, TexelCache};

/// The loop one writes for 64 sets of 4 ways and nothing else.
#[inline(never)]
fn by_hand(addresses: &[u64]) -> u64 {
    let mut sets = [[u64::MAX; 4]; 64];
    let mut misses = 0;
    for &address in addresses {
        let line = address >> 6;
        let set = &mut sets[(line & 63) as usize];
        if set[0] == line {
            continue;
        }
        if set[1] == line {
            *set = [line, set[0], set[2], set[3]];
        } else if set[2] == line {
            *set = [line, set[0], set[1], set[3]];
        } else {
            misses += u64::from(set[3] != line);
            *set = [line, set[0], set[1], set[2]];
        }
    }
    misses
}

fn main() {
    let addresses = addresses();
    let (lookups, geometry) = (addresses.len(), Geometry { sets: 64, ways: 4, line: 64 });
    let same = addresses.windows(2).filter(|pair| pair[0] >> 6 == pair[1] >> 6).count();
    println!("{lookups} lookups, {:.1} % of the line before", 100.0 * same as f64 / lookups as f64);
    let run = |geometry: Geometry, policy| {
        let mut cache = Cache::new(geometry, policy).unwrap();
        cache.access_all(&addresses, &mut ());
        cache.misses()
    };
    let metered = |detail| {
        let mut cache = TexelCache::new(geometry, Policy::Lru, 4, detail).unwrap();
        addresses.chunks(4).for_each(|tap| cache.read_all(0, tap));
        cache.counters().misses
    };
    let mut contest = Contest { lookups, entries: Vec::new() };
    contest.enter("by hand, 64 x 4 lru", || by_hand(&addresses));
    contest.enter("64 x 4 lru", || run(geometry, Policy::Lru));
    contest.enter("64 x 4 lru, three classes", || {
        let mut cache = Cache::new(geometry, Policy::Lru).unwrap();
        let mut classifier = MissClassifier::new(geometry).unwrap();
        cache.access_all(&addresses, &mut classifier);
        cache.misses()
    });
    contest.enter("texel cache, all counters", || metered(Detail::default()));
    contest.enter("texel cache, no classes", || metered(Detail { classes: false, line_use: true }));
    contest.enter("texel cache, plain", || metered(Detail { classes: false, line_use: false }));
    for (name, policy) in [("fifo", Policy::Fifo), ("plru", Policy::Plru), ("random", Policy::Random { seed: 1 })] {
        contest.enter(format!("64 x 4 {name}"), move || run(geometry, policy));
    }
    for (sets, ways) in [(128, 2), (32, 8), (16, 16), (4, 24), (1, 256), (85, 3)] {
        contest.enter(format!("{sets} x {ways} lru"), move || run(Geometry { sets, ways, line: 64 }, Policy::Lru));
    }
    contest.run(9);
    let [hand, plain, classes] = [0, 1, 2].map(|entry| contest.entries[entry].seconds);
    println!("plain / by hand {:.2}; three classes cost {:.2} runs", hand / plain, classes / plain);
}
