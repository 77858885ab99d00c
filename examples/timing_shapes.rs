//! The shapes that published texture caches show, from this model: tables on standard output, plots as SVG.
//! `cargo run --release --example timing_shapes -- docs/timing-shapes`
//!
//! The scene is a floor of 256 x 256 pixels: u = (x - 127.5) * 256 / d and v = 65536 / d texels, d = y + 8.5, on a texture of 1024 x
//! 1024 RGBA8, trilinear, the level from Heckbert's norm of the exact derivatives.

use std::{error::Error, fs, path::PathBuf};

use plotters::prelude::*;
use texunit_hw::{
    Filter, Format, Geometry, I12F20, Layout, Policy, PyramidKind, Request, Sampler, Surface, Unit,
    cache::{Counters, Detail, TexelCache},
    timing::{MainMemory, MemoryParameters, Parameters, Timing, TimingCounters},
};

const SIDE: u32 = 256;
const TEXTURE: f64 = 1024.0;

#[derive(Clone, Copy, Debug)]
enum Order {
    Rows,
    Columns,
    Tiles,
}

/// Pixels in an order.
fn pixels(order: Order) -> Vec<(u32, u32)> {
    let all = 0..SIDE * SIDE;
    match order {
        Order::Rows => all.map(|n| (n % SIDE, n / SIDE)).collect(),
        Order::Columns => all.map(|n| (n / SIDE, n % SIDE)).collect(),
        Order::Tiles => all
            .map(|n| {
                let (tile, inside) = (n / 64, n % 64);
                let tiles = SIDE / 8;
                (tile % tiles * 8 + inside % 8, tile / tiles * 8 + inside / 8)
            })
            .collect(),
    }
}

fn requests(order: Order, turned: bool) -> Vec<Request> {
    let fixed = |texels: f64| {
        let bits = (texels / TEXTURE * f64::from(1 << 20)).floor() as i64;
        I12F20::from_bits(bits as i32)
    };
    pixels(order)
        .into_iter()
        .map(|(x, y)| {
            let d = f64::from(y) + 8.5;
            let across = f64::from(x) - 127.5;
            let (u, v) = (across * 256.0 / d, 65536.0 / d);
            let along_x = (256.0 / d).powi(2);
            let along_y = (across * 256.0 / (d * d)).powi(2) + (65536.0 / (d * d)).powi(2);
            let scale = along_x.max(along_y) as f32;
            let (u, v) = if turned { (v, u) } else { (u, v) };
            Request { scale: [scale.to_bits(), 0], ..Request::at(fixed(u), fixed(v)) }
        })
        .collect()
}

struct Bound {
    surface: Surface,
    bytes: Vec<u8>,
}

impl Bound {
    fn new(layout: Layout) -> Self {
        let surface = Surface::new(PyramidKind::Mipmap, layout, Format::Rgba8, 1024, 1024).expect("a usual texture");
        let bytes = vec![0; surface.bytes as usize];
        Self { surface, bytes }
    }

    fn unit(&self) -> Unit<'_> {
        let sampler = Sampler { filter: Filter::Trilinear, ..Sampler::default() };
        Unit::new(&sampler, &self.surface, &self.bytes).expect("a usual sampler")
    }

    fn cache(&self, requests: &[Request], bytes: u32, ways: u32, line: u32) -> Counters {
        let mut cache = cache(bytes, ways, line);
        self.unit().addresses(requests, &mut cache);
        cache.counters()
    }

    fn time(&self, requests: &[Request], pipeline: &Parameters, latency: u32, bytes_per_clock: u32) -> TimingCounters {
        let memory = MemoryParameters { main: MainMemory::Fixed { latency, bytes_per_clock }, second_level: None };
        let mut timing = Timing::new(pipeline, &memory, cache(16 << 10, 2, 64), 4, ()).expect("a machine that runs");
        self.unit().addresses(requests, &mut timing);
        timing.counters()
    }
}

fn cache(bytes: u32, ways: u32, line: u32) -> TexelCache {
    let geometry = Geometry { sets: bytes / ways / line, ways, line };
    TexelCache::new(geometry, Policy::Lru, 4, Detail { classes: true, line_use: false }).expect("a usual cache")
}

/// Igehy's pipeline: a fragment (two taps) a clock, nothing narrow but memory, fragment FIFO and reorder buffer.
fn igehy(fragments: u32, reorder_buffer: u32) -> Parameters {
    Parameters {
        taps_per_clock: 2,
        request_fifo: 16,
        lod_fifo: 16,
        tap_fifo: 32,
        fragment_fifo: 2 * fragments,
        result_fifo: 64,
        tag_banks: 1,
        tag_ports: 64,
        miss_status: 1 << 14,
        merges: 1 << 20,
        miss_queue: 1 << 14,
        reorder_buffer,
        data_ports: 64,
        ..Parameters::default()
    }
}

type Curve = (String, Vec<(f64, f64)>);

fn plot(
    path: PathBuf,
    title: &str,
    (x_name, y_name): (&str, &str),
    top: f64,
    curves: &[Curve],
) -> Result<(), Box<dyn Error>> {
    let root = SVGBackend::new(&path, (760, 460)).into_drawing_area();
    root.fill(&WHITE)?;
    let xs = || curves.iter().flat_map(|(_, points)| points.iter().map(|point| point.0));
    let (least, most) = (xs().fold(f64::MAX, f64::min), xs().fold(0.0, f64::max));
    let mut chart = ChartBuilder::on(&root)
        .caption(title, ("sans-serif", 17))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(52)
        .build_cartesian_2d((least..most).log_scale(), 0.0..top)?;
    chart.configure_mesh().x_desc(x_name).y_desc(y_name).x_label_formatter(&|x| format!("{x}")).draw()?;
    for (number, (name, points)) in curves.iter().enumerate() {
        let color = Palette99::pick(number).to_rgba();
        chart
            .draw_series(LineSeries::new(points.iter().copied(), color.stroke_width(2)).point_size(3))?
            .label(name)
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], color.stroke_width(2)));
    }
    chart.configure_series_labels().border_style(BLACK.mix(0.4)).background_style(WHITE.mix(0.85)).draw()?;
    root.present()?;
    Ok(())
}

fn misses(folder: &std::path::Path) -> Result<(), Box<dyn Error>> {
    let linear = Layout::RowMajor;
    let blocked = Layout::Tiled { log2_width: 3, log2_height: 2 };
    let rows = [
        ("row, linear", Order::Rows, linear, false, [10.34, 6.94, 3.40, 2.28, 0.56, 0.55, 0.55]),
        ("row, blocked 8x4", Order::Rows, blocked, false, [4.00, 2.84, 1.93, 3.78, 1.44, 0.77, 0.51]),
        ("column, linear", Order::Columns, linear, false, [35.96, 32.09, 26.58, 23.45, 22.29, 20.70, 0.55]),
        ("column, blocked", Order::Columns, blocked, false, [9.63, 8.58, 7.93, 9.20, 6.88, 5.72, 0.51]),
        ("8x8 tiles, blocked", Order::Tiles, blocked, false, [3.64, 2.50, 2.07, 3.93, 1.59, 0.93, 0.51]),
        ("rot 90, row, linear", Order::Rows, linear, true, [13.56, 13.39, 13.29, 13.11, 13.00, 12.52, 0.65]),
        ("rot 90, row, blocked", Order::Rows, blocked, true, [5.54, 4.52, 3.67, 3.66, 3.55, 3.47, 0.52]),
        ("rot 90, tiles, blocked", Order::Tiles, blocked, true, [5.52, 4.32, 3.42, 3.00, 3.19, 2.16, 0.52]),
    ];
    let shapes = [(2, 2), (4, 2), (8, 2), (16, 1), (16, 2), (32, 2)];
    println!("Misses a texel access, in percent: ours (section 1.10). 128-byte lines, LRU.\n");
    println!("| order / layout | 2K 2w | 4K 2w | 8K 2w | 16K 1w | 16K 2w | 32K 2w | cold |");
    println!("|---|---|---|---|---|---|---|---|");
    let (mut curves, mut direct): (Vec<Curve>, Vec<Curve>) = (Vec::new(), Vec::new());
    for (name, order, layout, turned, expected) in rows {
        let (bound, requests) = (Bound::new(layout), requests(order, turned));
        let percent = |counters: &Counters, misses: u64| 100.0 * misses as f64 / counters.lookups as f64;
        let mut cells = Vec::new();
        for (kib, ways) in shapes {
            let counters = bound.cache(&requests, kib << 10, ways, 128);
            cells.push(percent(&counters, counters.misses));
            if (kib, ways) == (32, 2) {
                cells.push(percent(&counters, counters.compulsory));
            }
        }
        let row: Vec<String> =
            cells.iter().zip(expected).map(|(ours, theirs): (&f64, f64)| format!("{ours:.2} ({theirs:.2})")).collect();
        println!("| {name} | {} |", row.join(" | "));
        let two_way = [(2.0, cells[0]), (4.0, cells[1]), (8.0, cells[2]), (16.0, cells[4]), (32.0, cells[5])];
        curves.push((name.to_owned(), two_way.to_vec()));
        if name == "row, blocked 8x4" {
            for ways in [1, 2, 4] {
                let points = [2u32, 4, 8, 16, 32, 64].map(|kib| {
                    let counters = bound.cache(&requests, kib << 10, ways, 128);
                    (f64::from(kib), percent(&counters, counters.misses))
                });
                direct.push((format!("{ways}-way"), points.to_vec()));
            }
        }
    }
    let axes = ("cache, KiB", "misses, % of accesses");
    let steady: Vec<Curve> = curves.iter().filter(|(name, _)| !name.contains("column")).cloned().collect();
    plot(folder.join("knee.svg"), "Misses and cache size, 2 ways: the knee is at 8 to 16 KiB", axes, 14.0, &steady)?;
    plot(
        folder.join("ways.svg"),
        "Direct-mapped suffers from adjacent levels (rows, blocked 8x4)",
        axes,
        9.0,
        &direct,
    )?;
    let turned: Vec<Curve> = [0, 1, 5, 6].map(|row: usize| curves[row].clone()).to_vec();
    plot(folder.join("rotation.svg"), "Turning the texture: linear collapses, blocked does not", axes, 14.0, &turned)
}

fn latency(folder: &std::path::Path) -> Result<(), Box<dyn Error>> {
    let bound = Bound::new(Layout::Tiled { log2_width: 2, log2_height: 2 });
    let requests = requests(Order::Tiles, false);
    let depths = [8u32, 16, 32, 64, 128, 256, 512];
    let unlimited = 1 << 14;
    let expected = [
        (32, 50, [30.0, 42.0, 67.0, 97.2, 98.7, 99.9, 99.9]),
        (32, 250, [7.5, 11.0, 17.0, 29.0, 54.0, 96.5, 99.6]),
        (8, 50, [40.0, 52.0, 77.0, 98.3, 99.8, 100.0, 100.0]),
        (8, 250, [11.0, 16.0, 25.0, 43.0, 73.0, 98.3, 99.8]),
    ];
    println!(
        "\nClocks of a zero-latency memory, in percent of ours, by depth of the fragment FIFO in fragments: ours (section 1.10).\n"
    );
    println!("| memory | latency | F=8 | 16 | 32 | 64 | 128 | 256 | 512 |");
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut curves = Vec::new();
    for (width, clocks, theirs) in expected {
        let ideal = bound.time(&requests, &igehy(512, unlimited), 0, width);
        let efficiency = |fragments: u32| {
            let counters = bound.time(&requests, &igehy(fragments, unlimited), clocks, width);
            100.0 * ideal.cycles as f64 / counters.cycles as f64
        };
        let cells: Vec<String> =
            depths.iter().zip(theirs).map(|(&f, theirs)| format!("{:.1} ({theirs})", efficiency(f))).collect();
        let per = ideal.cycles as f64 / ideal.requests as f64;
        println!("| {width} B/clk ({per:.3} clk/frag) | {clocks} | {} |", cells.join(" | "));
        let points = [0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.5, 2.0]
            .map(|part: f64| (part, efficiency((part * f64::from(clocks)).round() as u32)));
        let reached = points.iter().find(|point| point.1 >= 97.0).map_or(f64::NAN, |point| point.0);
        curves.push((format!("{width} B/clk, {clocks} clocks: 97 % at {reached} latencies"), points.to_vec()));
    }
    plot(
        folder.join("latency.svg"),
        "Igehy's pipeline: 97 % once the fragment FIFO holds a latency",
        ("fragment FIFO / memory latency", "% of zero-latency speed"),
        105.0,
        &curves,
    )?;
    for (name, _) in &curves {
        println!("\n{name}");
    }
    println!("\nReorder buffer (F=512, 250 clocks, 32 B/clk), in lines:\n");
    println!("| R=4 | 8 | 16 | 32 | 64 | 128 |\n|---|---|---|---|---|---|");
    let ideal = bound.time(&requests, &igehy(512, unlimited), 0, 32);
    let cells: Vec<String> =
        [(4u32, "deadlock: per fragment"), (8, "18"), (16, "35"), (32, "62"), (64, "88"), (128, "97")]
            .into_iter()
            .map(|(lines, theirs)| {
                let counters = bound.time(&requests, &igehy(512, lines), 250, 32);
                format!("{:.1} ({theirs})", 100.0 * ideal.cycles as f64 / counters.cycles as f64)
            })
            .collect();
    println!("| {} |", cells.join(" | "));
    let counters = bound.time(&requests, &igehy(512, unlimited), 250, 32);
    println!(
        "\n{:.3} lines a fragment, {:.2} % of accesses, {:.1} B a fragment (section 1.10: 0.160, 2.0 %, 10.2 B)",
        counters.fills as f64 / counters.requests as f64,
        100.0 * counters.fills as f64 / counters.reads as f64,
        counters.bytes_filled as f64 / counters.requests as f64,
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "out".into()));
    fs::create_dir_all(&folder)?;
    misses(&folder)?;
    latency(&folder)
}
