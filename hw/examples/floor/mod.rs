//! What the speed examples share: an address stream, and a fair contest over it.
#![allow(missing_docs, reason = "examples are no interface")]

use std::{hint::black_box, time::Instant};

/// Byte addresses of eight texels a fragment: a perspective floor, rotated, RGBA8, 4 x 4 tiles, scanline order.
pub fn addresses() -> Vec<u64> {
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

/// One contender.
pub struct Entry<'a> {
    name: String,
    work: Box<dyn FnMut() -> u64 + 'a>,
    /// Seconds of its best round.
    pub seconds: f64,
    misses: u64,
}

/// Contenders that take turns on the same addresses.
pub struct Contest<'a> {
    /// Lookups of each.
    pub lookups: usize,
    /// Who takes part, in order of entry.
    pub entries: Vec<Entry<'a>>,
}

impl<'a> Contest<'a> {
    /// One contender more.
    pub fn enter(&mut self, name: impl Into<String>, work: impl FnMut() -> u64 + 'a) {
        self.entries.push(Entry { name: name.into(), work: Box::new(work), seconds: f64::MAX, misses: 0 });
    }

    /// Everyone runs once a round, so that all see the same load of the machine; the best of each counts.
    pub fn run(&mut self, rounds: usize) {
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
