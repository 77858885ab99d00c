//! How the cost of a piece of work grows with the work: `cargo run --release --bin growth`. Writes a plot each into docs/performance/
//! and all numbers into growth.csv.
//!
//! All are ratios: beside each piece, before and after it, a plain loop runs over a fixed piece of its own, so that a host that changes its pace changes
//! both.

use std::{fmt::Write, fs, hint::black_box, path::Path};

use texunit::{
    front_end::FrontEnd,
    machine::Machine,
    report::plot::{Axis, Plot, Series, Style},
    scene::{Fragment, Gradient},
};
use texunit_benches::{
    contest::seconds,
    workload::{Addresses, Case, Perspective},
    yardstick,
};
use texunit_hw::{
    AddressMode, Filter, Format, Geometry, Layout, Policy, PyramidKind, Request, Response, Sampler, Surface, Unit,
    cache::{Cache, Detail, TexelCache},
    sweep::{Grid, LruSweep},
    timing::{MemoryParameters, Parameters, Timing},
};

/// Rounds; their median counts.
const ROUNDS: usize = 5;

/// Requests made and answered at a time.
const BLOCK: usize = 1 << 16;

/// The cost of a piece of work, in pieces of the plain loop, by the amount of work.
type Points = Vec<(f64, f64)>;

/// A plain loop over so many pieces, always the same.
struct Gauge<F> {
    pieces: usize,
    run: F,
}

impl<F: FnMut()> Gauge<F> {
    /// Seconds a piece.
    fn seconds(&mut self) -> f64 {
        seconds(&mut self.run) / self.pieces as f64
    }

    /// How many pieces take as long as each of these works, whose seconds `work` measures.
    fn pieces<const WORKS: usize>(&mut self, work: impl FnOnce() -> [f64; WORKS]) -> [f64; WORKS] {
        let before = self.seconds();
        let times = work();
        let after = self.seconds();
        times.map(|time| time * 2.0 / (before + after))
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

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

/// A frame of a texture, so many times through one machine.
#[derive(Clone, Copy, Debug)]
struct Frame {
    size: [usize; 2],
    side: u32,
    times: usize,
}

/// What a fragment of a frame costs: texels, texels and cache, and the same with time.
fn frame(Frame { size, side, times }: Frame, gauge: &mut Gauge<impl FnMut()>) -> [f64; 3] {
    let surface = Surface::new(PyramidKind::Mipmap, Layout::default(), Format::Rgba8, side, side).expect("a surface");
    let bytes = vec![7; surface.bytes as usize];
    let mut unit = Unit::new(&Sampler::default(), &surface, &bytes).expect("a unit");
    let mut responses = vec![Response::default(); BLOCK];
    let pixels = size[0] * size[1];
    let mut rounds = [const { Vec::new() }; 3];
    for _ in 0..if pixels * times > 1 << 24 { 1 } else { ROUNDS } {
        let mut cache = texel_cache(GEOMETRY);
        let mut timing =
            Timing::new(&Parameters::default(), &MemoryParameters::default(), texel_cache(GEOMETRY), 4, ())
                .expect("a machine that runs");
        let mut sums = [0.0; 3];
        for first in (0..times).flat_map(|_| (0..pixels).step_by(BLOCK)) {
            let requests = requests(size, side, first, BLOCK.min(pixels - first));
            let responses = &mut responses[..requests.len()];
            let block = gauge.pieces(|| {
                [
                    seconds(|| unit.run(&requests, responses, &mut ())),
                    seconds(|| unit.run(&requests, responses, &mut cache)),
                    seconds(|| unit.run(&requests, responses, &mut timing)),
                ]
            });
            sums.iter_mut().zip(block).for_each(|(sum, pieces)| *sum += pieces);
        }
        rounds.iter_mut().zip(sums).for_each(|(rounds, sum)| rounds.push(sum / (pixels * times) as f64));
    }
    rounds.map(median)
}

/// Three series of [`frame`].
fn frames(gauge: &mut Gauge<impl FnMut()>, amounts: impl Iterator<Item = (f64, Frame)>) -> Vec<(&'static str, Points)> {
    let mut series = ["texels", "texels and cache", "with time"].map(|name| (name, Points::new()));
    for (amount, of_amount) in amounts {
        let costs = frame(of_amount, gauge);
        eprintln!("{of_amount:?}: {costs:.3?}");
        for ((_, points), cost) in series.iter_mut().zip(costs) {
            points.push((amount, cost));
        }
    }
    series.into()
}

/// What a lookup costs, from an address stream.
fn lookups(gauge: &mut Gauge<impl FnMut()>, addresses: &[u64], mut run: impl FnMut() -> u64) -> f64 {
    let round = |_| gauge.pieces(|| [seconds(|| black_box(run()))])[0] / addresses.len() as f64;
    median((0..ROUNDS).map(round).collect())
}

fn main() {
    let folder = Path::new("../docs/performance");
    fs::create_dir_all(folder).expect("docs/performance");
    let mut csv = String::from("plot,series,x,plain_loops\n");
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

    let case = Case::rows(Filter::Trilinear, 500..510);
    let mut texels = vec![0; case.requests.len()];
    let mut fragments = Gauge {
        pieces: case.requests.len(),
        run: || {
            black_box(yardstick::whole_path_with_counters(&case.requests, &case.memory.bytes, &mut texels));
        },
    };
    // 0.25 to 64 M fragments: one frame again and again, and frames whose sides double, which see ever less of the texture a fragment.
    let millions = |Frame { size, times, .. }: &Frame| (size[0] * size[1] * times) as f64 / 1e6;
    let labels = ["millions of fragments", "a fragment, plain loop = 1"];
    let again = (0..5).map(|doublings| Frame { size: [512; 2], side: 1024, times: 1 << (2 * doublings) });
    draw(
        "fragments",
        "One frame again and again",
        labels,
        frames(&mut fragments, again.map(|frame| (millions(&frame), frame))),
    );
    let finer = (0..5).map(|doublings| Frame { size: [512 << doublings; 2], side: 1024, times: 1 });
    draw("frames", "Ever finer frames", labels, frames(&mut fragments, finer.map(|frame| (millions(&frame), frame))));
    let sides = (6..=14).map(|log2| (f64::from(1u32 << log2), Frame { size: [1920, 1080], side: 1 << log2, times: 1 }));
    draw("textures", "Textures", ["texels on a side", "a fragment, plain loop = 1"], frames(&mut fragments, sides));

    let surface = Surface::new(PyramidKind::Mipmap, Layout::default(), Format::Rgba8, 1024, 1024).expect("a surface");
    let mut addresses = Addresses(Vec::new());
    Unit::without_memory(&Sampler::default(), &surface)
        .expect("a unit")
        .addresses(&requests([1920, 1080], 1024, 0, 1920 * 1080), &mut addresses);
    let addresses = addresses.0;
    let mut plain = Gauge {
        pieces: addresses.len() / 8,
        run: || {
            black_box(yardstick::cache_alone(&addresses[..addresses.len() / 8]));
        },
    };
    let policies = [("LRU", Policy::Lru), ("FIFO", Policy::Fifo), ("PLRU", Policy::Plru)];
    let mut of_policy = |policy| {
        let ways = |log2| {
            let run = || {
                let mut cache = Cache::new(Geometry { ways: 1u32 << log2, ..GEOMETRY }, policy).expect("a cache");
                cache.access_all(&addresses, &mut ());
                cache.misses()
            };
            (f64::from(1u32 << log2), lookups(&mut plain, &addresses, run))
        };
        (0..=6).map(ways).collect::<Points>()
    };
    let series = policies.map(|(name, policy)| (name, of_policy(policy))).into();
    draw("ways", "Ways of 64 sets", ["ways", "a lookup, plain loop of 4 ways = 1"], series);

    let mut of_ways = |ways: u32| {
        let grid = |log2_sets| {
            let run = || {
                let mut sweep = LruSweep::new(Grid { log2_sets, ways, line: 64 }).expect("a grid");
                sweep.access_all(&addresses);
                sweep.misses(0, 1)
            };
            (f64::from((log2_sets + 1) * ways), lookups(&mut plain, &addresses, run))
        };
        (0..=10).step_by(2).map(grid).collect::<Points>()
    };
    let series = vec![("up to 4 ways", of_ways(4)), ("up to 16 ways", of_ways(16))];
    draw("sweep", "LRU geometries in one pass", ["geometries", "a lookup, plain loop of 4 ways = 1"], series);
    fs::write("growth.csv", csv).expect("growth.csv");
}
