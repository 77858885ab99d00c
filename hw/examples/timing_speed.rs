//! What does time cost? Texels and cache alone against the same with the timing model, a trilinear floor.
//! `cargo run --release -p texunit-hw --example timing_speed -- [ROWS [ROUNDS]]`

use std::{hint::black_box, time::Instant};

use texunit_hw::{
    Filter, Format, Geometry, I12F20, Layout, Policy, PyramidKind, Request, Response, Sampler, Surface, Unit,
    cache::{Detail, TexelCache},
    timing::{DramParameters, MainMemory, MemoryParameters, Parameters, Timing},
};

/// The floor of numerics-input 1.10 at 1920 x 1080: u = (x - 959.5) * 960 / d, v = 960 * 960 / d of a texture of 1024.
fn requests(rows: i64) -> Vec<Request> {
    let mut requests = Vec::new();
    for y in 1080 - rows..1080 {
        let d = 2 * y + 17; // twice the distance below the horizon
        for x in 0..1920i64 {
            let u = (((2 * x - 1919) * 960) << 10) / d;
            let v = ((2 * 960 * 960) << 10) / d;
            // Texels a pixel: along x, or along y, where they are more.
            let per_pixel = (2 * 960 / d).max(4 * 960 * 960 / (d * d)).max(1);
            let scale = (127 + u32::try_from(per_pixel * per_pixel).unwrap().ilog2()) << 23;
            let at = |c: i64| I12F20::from_bits((c & 0xFFFFF) as i32);
            requests.push(Request { scale: [scale, 0], ..Request::at(at(u), at(v)) });
        }
    }
    requests
}

fn main() {
    let argument = |number| std::env::args().nth(number).and_then(|text| text.parse().ok());
    let (rows, rounds) = (argument(1).unwrap_or(1080), argument(2).unwrap_or(5));
    let requests = requests(rows);
    let surface = Surface::new(PyramidKind::Mipmap, Layout::default(), Format::Rgba8, 1024, 1024).unwrap();
    let bytes = vec![7; surface.bytes as usize];
    let sampler = Sampler { filter: Filter::Trilinear, ..Sampler::default() };
    let mut responses = vec![Response::default(); requests.len()];
    let geometry = Geometry { sets: 64, ways: 4, line: 64 };
    let dram = MemoryParameters { main: MainMemory::Dram(DramParameters::default()), second_level: None };
    for (name, detail) in [
        ("plain cache", Detail { classes: false, line_use: false }),
        ("cache with classes and line use", Detail::default()),
    ] {
        let cache = || TexelCache::new(geometry, Policy::Lru, 4, detail).unwrap();
        let (mut untimed, mut timed, mut dram_timed, mut cycles) = (f64::MAX, f64::MAX, f64::MAX, 0);
        for _ in 0..rounds {
            let begin = Instant::now();
            let mut sink = cache();
            let mut unit = Unit::new(&sampler, &surface, &bytes).unwrap();
            unit.run(&requests, &mut responses, &mut sink);
            black_box(sink.counters());
            untimed = untimed.min(begin.elapsed().as_secs_f64());

            for (memory, best) in [(MemoryParameters::default(), &mut timed), (dram, &mut dram_timed)] {
                let begin = Instant::now();
                let mut sink = Timing::new(&Parameters::default(), &memory, cache(), 4, ()).unwrap();
                unit.run(&requests, &mut responses, &mut sink);
                cycles = black_box(sink.counters()).cycles;
                *best = best.min(begin.elapsed().as_secs_f64());
            }
        }
        let rate = |seconds: f64| requests.len() as f64 / seconds / 1e6;
        println!(
            "{name}: untimed {:.1} M requests/s; timed {:.1} ({:.2} x the time); with DRAM {:.1} ({:.2} x); {} cycles",
            rate(untimed),
            rate(timed),
            timed / untimed,
            rate(dram_timed),
            dram_timed / untimed,
            cycles
        );
    }
}
