//! How fast is the cache alone? Lookups per second on tiled trilinear addresses, against a hand-written loop of one
//! geometry in the same process. `cargo run --release -p texunit-hw --example cache_speed`

use std::{hint::black_box, time::Instant};

use texunit_hw::cache::{Cache, Detail, Geometry, MissClassifier, Policy, TexelCache};

/// Byte addresses of eight texels a fragment: a perspective floor, rotated, RGBA8, 4 x 4 tiles, scanline order.
fn addresses() -> Vec<u64> {
    let (width, height, size) = (1920i64, 540i64, 1024i64);
    let bases: Vec<i64> = (0..11)
        .scan(0, |at, level| Some(std::mem::replace(at, *at + ((4 * size * size) >> (2 * level)).max(64))))
        .collect();
    let mut out = Vec::with_capacity((width * height * 8) as usize);
    for y in 0..height {
        let depth = (1 << 28) / (y + 8);
        let step = (depth >> 10).max(1);
        let level = (63 - (step >> 8 | 1).leading_zeros() as i64).clamp(0, 9);
        for x in 0..width {
            let (along, across) = ((x - width / 2) * step, depth);
            let (u, v) = ((along * 7 + across * 3) >> 3, (across * 7 - along * 3) >> 3);
            for level in [level, level + 1] {
                let side = size >> level;
                let texel = |i: i64, j: i64| {
                    let (i, j) = (i & (side - 1), j & (side - 1));
                    let tiles = (side / 4).max(1);
                    let address = bases[level as usize] + 64 * ((j / 4) * tiles + i / 4) + 4 * ((j % 4) * 4 + i % 4);
                    address as u64
                };
                let (i, j) = (u >> (8 + level), v >> (8 + level));
                out.extend([texel(i, j), texel(i + 1, j), texel(i, j + 1), texel(i + 1, j + 1)]);
            }
        }
    }
    out
}

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

struct Entry<'a> {
    name: String,
    work: Box<dyn FnMut() -> u64 + 'a>,
    seconds: f64,
    misses: u64,
}

struct Contest<'a> {
    lookups: usize,
    entries: Vec<Entry<'a>>,
}

impl<'a> Contest<'a> {
    fn enter(&mut self, name: impl Into<String>, work: impl FnMut() -> u64 + 'a) {
        self.entries.push(Entry { name: name.into(), work: Box::new(work), seconds: f64::MAX, misses: 0 });
    }

    /// Everyone runs once a round, so that all see the same load of the machine; the best of each counts.
    fn run(&mut self, rounds: usize) {
        for _ in 0..rounds {
            for Entry { work, seconds, misses, .. } in &mut self.entries {
                let start = Instant::now();
                *misses = black_box(work());
                *seconds = seconds.min(start.elapsed().as_secs_f64());
            }
        }
        for Entry { name, seconds, misses, .. } in &self.entries {
            println!("{name:28} {:8.1} M/s   {misses} misses", self.lookups as f64 / seconds / 1e6);
        }
    }
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
