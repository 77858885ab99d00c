//! How the cost of a piece of work grows with the work: `cargo run --release --bin growth`. Writes a plot each into docs/performance/
//! and all numbers into growth.csv.

use std::{fmt::Write, fs, hint::black_box, path::Path};

use texunit::{
    front_end::FrontEnd,
    machine::Machine,
    report::plot::{Axis, Plot, Series, Style},
    scene::{Fragment, Gradient},
};
use texunit_benches::{
    contest::seconds,
    workload::{Addresses, Perspective},
};
use texunit_hw::{
    AddressMode, Filter, Format, Geometry, Layout, Policy, PyramidKind, Request, Response, Sampler, Surface, Unit,
    cache::{Cache, Detail, TexelCache},
    sweep::{Grid, LruSweep},
    timing::{MemoryParameters, Parameters, Timing},
};

/// Rounds; the least time of each counts, for whatever else the machine does only adds.
const ROUNDS: usize = 5;

/// Requests made and answered at a time.
const BLOCK: usize = 1 << 16;

/// Nanoseconds a piece of work, by the amount of work.
type Points = Vec<(f64, f64)>;

/// The floor seen in `width` by `height` pixels, some of them from the one numbered `first` on.
fn requests(size: [usize; 2], side: u32, first: usize, count: usize) -> Vec<Request> {
    let front_end = FrontEnd::new(&Machine::default(), Filter::Trilinear, [AddressMode::Wrap; 2], [side; 2]);
    let [across, down] = [1920.0 / size[0] as f64, 1080.0 / size[1] as f64];
    let scale = 1.0 / f64::from(side);
    let fragments: Vec<Fragment> = (first..first + count)
        .map(|number| {
            let (x, y) = (number % size[0], number / size[0]);
            let ([u, v], [ux, uy, vx, vy]) = Perspective::FLOOR.at((x as f64 + 0.5) * across, (y as f64 + 0.5) * down);
            let gradient = Gradient {
                ux: ux * across * scale,
                uy: uy * down * scale,
                vx: vx * across * scale,
                vy: vy * down * scale,
            };
            Fragment { x: x as u16, y: y as u16, u: u * scale, v: v * scale, gradient }
        })
        .collect();
    front_end.requests(&fragments).0
}

fn texel_cache(geometry: Geometry) -> TexelCache {
    TexelCache::new(geometry, Policy::Lru, 4, Detail::default()).expect("a cache")
}

const GEOMETRY: Geometry = Geometry { sets: 64, ways: 4, line: 64 };

/// Nanoseconds a fragment of a frame: texels, texels and cache, and the same with time.
fn frame(size: [usize; 2], side: u32) -> [f64; 3] {
    let surface = Surface::new(PyramidKind::Mipmap, Layout::default(), Format::Rgba8, side, side).expect("a surface");
    let bytes = vec![7; surface.bytes as usize];
    let mut unit = Unit::new(&Sampler::default(), &surface, &bytes).expect("a unit");
    let mut responses = vec![Response::default(); BLOCK];
    let pixels = size[0] * size[1];
    let mut least = [f64::MAX; 3];
    for _ in 0..if pixels > 1 << 24 { 1 } else { ROUNDS } {
        let mut cache = texel_cache(GEOMETRY);
        let mut timing =
            Timing::new(&Parameters::default(), &MemoryParameters::default(), texel_cache(GEOMETRY), 4, ())
                .expect("a machine that runs");
        let mut sums = [0.0; 3];
        for first in (0..pixels).step_by(BLOCK) {
            let requests = requests(size, side, first, BLOCK.min(pixels - first));
            let responses = &mut responses[..requests.len()];
            sums[0] += seconds(|| unit.run(&requests, responses, &mut ()));
            sums[1] += seconds(|| unit.run(&requests, responses, &mut cache));
            sums[2] += seconds(|| unit.run(&requests, responses, &mut timing));
        }
        for (least, sum) in least.iter_mut().zip(sums) {
            *least = least.min(sum * 1e9 / pixels as f64);
        }
    }
    least
}

/// Three series of [`frame`].
fn frames(amounts: impl Iterator<Item = (f64, [usize; 2], u32)>) -> Vec<(&'static str, Points)> {
    let mut series = ["texels", "texels and cache", "with time"].map(|name| (name, Points::new()));
    for (amount, size, side) in amounts {
        let times = frame(size, side);
        eprintln!("{size:?} of {side}: {times:.1?}");
        for ((_, points), time) in series.iter_mut().zip(times) {
            points.push((amount, time));
        }
    }
    series.into()
}

/// Nanoseconds a lookup, from an address stream.
fn lookups(addresses: &[u64], mut run: impl FnMut() -> u64) -> f64 {
    let least = (0..ROUNDS).map(|_| seconds(|| black_box(run()))).fold(f64::MAX, f64::min);
    least * 1e9 / addresses.len() as f64
}

fn main() {
    let folder = Path::new("../docs/performance");
    fs::create_dir_all(folder).expect("docs/performance");
    let mut csv = String::from("plot,series,x,nanoseconds\n");
    let mut draw = |name: &str, title: &str, [x, y]: [&str; 2], series: Vec<(&str, Points)>| {
        for (series, points) in &series {
            for (x, y) in points {
                writeln!(csv, "{name},{series},{x},{y:.3}").expect("a string");
            }
        }
        let axis = |label: &str, logarithmic| Axis { label: label.to_owned(), logarithmic };
        let series = series.into_iter().map(|(name, points)| Series {
            name: name.to_owned(),
            style: Style::Line,
            points: points.into_iter().map(|(x, y)| (x, y, String::new())).collect(),
        });
        let plot = Plot { title: title.to_owned(), x: axis(x, true), y: axis(y, true), series: series.collect() };
        fs::write(folder.join(format!("{name}.svg")), plot.svg()).expect("docs/performance");
    };

    // 0.25 to 64 M fragments: sides double.
    let sizes = (0..5).map(|doublings| {
        let size = [512 << doublings; 2];
        ((size[0] * size[1]) as f64 / 1e6, size, 1024)
    });
    draw("fragments", "Frames", ["millions of fragments", "ns a fragment"], frames(sizes));
    let sides = (6..=14).map(|log2| (f64::from(1u32 << log2), [1920, 1080], 1u32 << log2));
    draw("textures", "Textures", ["texels on a side", "ns a fragment"], frames(sides));

    let surface = Surface::new(PyramidKind::Mipmap, Layout::default(), Format::Rgba8, 1024, 1024).expect("a surface");
    let mut addresses = Addresses(Vec::new());
    Unit::without_memory(&Sampler::default(), &surface)
        .expect("a unit")
        .addresses(&requests([1920, 1080], 1024, 0, 1920 * 1080), &mut addresses);
    let addresses = addresses.0;
    let policies = [("LRU", Policy::Lru), ("FIFO", Policy::Fifo), ("PLRU", Policy::Plru)];
    let of_policy = |policy| {
        let ways = |log2| {
            let run = || {
                let mut cache = Cache::new(Geometry { ways: 1u32 << log2, ..GEOMETRY }, policy).expect("a cache");
                cache.access_all(&addresses, &mut ());
                cache.misses()
            };
            (f64::from(1u32 << log2), lookups(&addresses, run))
        };
        (0..=6).map(ways).collect::<Points>()
    };
    let series = policies.map(|(name, policy)| (name, of_policy(policy))).into();
    draw("ways", "Ways of 64 sets", ["ways", "ns a lookup"], series);

    let of_ways = |ways: u32| {
        let grid = |log2_sets| {
            let run = || {
                let mut sweep = LruSweep::new(Grid { log2_sets, ways, line: 64 }).expect("a grid");
                sweep.access_all(&addresses);
                sweep.misses(0, 1)
            };
            (f64::from((log2_sets + 1) * ways), lookups(&addresses, run))
        };
        (0..=10).step_by(2).map(grid).collect::<Points>()
    };
    let series = vec![("up to 4 ways", of_ways(4)), ("up to 16 ways", of_ways(16))];
    draw("sweep", "LRU geometries in one pass", ["geometries", "ns a lookup"], series);
    fs::write("growth.csv", csv).expect("growth.csv");
}
