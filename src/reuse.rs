//! How soon lines are read again: reuse distances, working sets, and what levels and frames share.

use std::collections::HashSet;

use serde_json::{Value, json};
use texunit_hw::{
    Filter,
    address_stream::{AddressBatch, Sink},
    sweep::{Distances, LineTable, ReuseDistances},
};

use crate::{error::Result, experiment::AddressBench, machine::Machine, names::Named, scene::Scene};

/// Edges of the screen tiles whose working sets are told, pixels.
pub const TILES: [u16; 4] = [8, 16, 32, 64];

/// Lookups of one plane.
#[derive(Clone, Debug, Default)]
pub struct PlaneReuse {
    /// Distances in lines of any plane, of the lookups of this one.
    pub distances: Distances,
    /// Different lines read.
    pub lines: u64,
    /// Lookups whose line was last read as another level: as the finer of two, and now as the coarser, or the reverse.
    pub across_levels: u64,
}

/// Lines that the pixels of one screen tile read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TileWorkingSet {
    /// Edge of the tile, pixels.
    pub tile: u16,
    /// Tiles with a pixel.
    pub tiles: u64,
    /// Mean of their lines.
    pub mean: f64,
    /// Lines that nine in ten of them do not exceed.
    pub ninth_decile: u64,
    /// Most lines of any.
    pub most: u64,
}

/// What a frame shares with the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameReuse {
    /// Lookups.
    pub lookups: u64,
    /// Different lines.
    pub lines: u64,
    /// Of those, lines that the frame before read too.
    pub lines_of_previous: u64,
}

/// Everything about one filter on one scene.
#[derive(Clone, Debug)]
pub struct Reuse {
    /// The filter.
    pub filter: Filter,
    /// Bytes of a line.
    pub line: u32,
    /// Distances of all lookups.
    pub all: Distances,
    /// Of those, of the first lookups of a line in a frame that an earlier frame read: what must be kept between frames.
    pub between_frames: Distances,
    /// Different lines.
    pub lines: u64,
    /// By plane, in storage order: how often each axis is halved, and what was read.
    pub planes: Vec<((u8, u8), PlaneReuse)>,
    /// Working sets of screen tiles, over all frames.
    pub tiles: Vec<TileWorkingSet>,
    /// By frame.
    pub frames: Vec<FrameReuse>,
}

/// What is remembered of a line.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Frame that read it last.
    frame: u32,
    /// Whether it was the first plane of its request.
    finer: bool,
    last_tile: [u32; TILES.len()],
}

/// Watches the address stream.
#[derive(Debug)]
struct Watch {
    shift: u32,
    lines: LineTable,
    known: Vec<Line>,
    reuse: ReuseDistances,
    all: Distances,
    between_frames: Distances,
    planes: Vec<PlaneReuse>,
    frames: Vec<FrameReuse>,
    /// Pixels of the requests to come, and how many have been.
    pixels: Vec<[u16; 2]>,
    next: usize,
    /// Tile and line, met before.
    met: [HashSet<(u32, u32)>; TILES.len()],
    /// Lines by tile, of the current frame.
    tile_lines: [Vec<u64>; TILES.len()],
    /// The same of earlier frames.
    tile_counts: [Vec<u64>; TILES.len()],
    columns: [u32; TILES.len()],
}

/// No tile.
const NO_TILE: u32 = u32::MAX;

impl Watch {
    fn new(line: u32, planes: usize, size: [u32; 2]) -> Self {
        let columns = TILES.map(|tile| size[0].div_ceil(tile.into()));
        let rows = TILES.map(|tile| size[1].div_ceil(tile.into()));
        let tiles = [0, 1, 2, 3].map(|at| vec![0; columns[at] as usize * rows[at] as usize]);
        Self {
            shift: line.trailing_zeros(),
            lines: LineTable::default(),
            known: Vec::new(),
            reuse: ReuseDistances::default(),
            all: Distances::default(),
            between_frames: Distances::default(),
            planes: vec![PlaneReuse::default(); planes],
            frames: Vec::new(),
            pixels: Vec::new(),
            next: 0,
            met: Default::default(),
            tile_lines: tiles,
            tile_counts: Default::default(),
            columns,
        }
    }

    /// Ends the tiles of a frame and begins the next.
    fn begin_frame(&mut self) {
        self.frames.push(FrameReuse::default());
        for at in 0..TILES.len() {
            self.met[at].clear();
            let counts = self.tile_lines[at].iter_mut().map(std::mem::take).filter(|&lines| lines > 0);
            self.tile_counts[at].extend(counts);
        }
        for line in &mut self.known {
            line.last_tile = [NO_TILE; TILES.len()];
        }
    }

    fn lookup(&mut self, plane: usize, finer: bool, pixel: [u16; 2], address: u64) {
        let line = address >> self.shift;
        let distance = self.reuse.lookup(line);
        self.all.count(distance);
        let row = &mut self.planes[plane];
        row.distances.count(distance);
        let now = self.frames.len() as u32;
        let frame = self.frames.last_mut().expect("a frame has begun");
        frame.lookups += 1;
        let number = self.lines.number(line);
        if number as usize == self.known.len() {
            row.lines += 1;
            frame.lines += 1;
            self.known.push(Line { frame: now, finer, last_tile: [NO_TILE; TILES.len()] });
        }
        let known = &mut self.known[number as usize];
        if known.frame != now {
            frame.lines += 1;
            frame.lines_of_previous += u64::from(known.frame + 1 == now);
            self.between_frames.count(distance);
        }
        row.across_levels += u64::from(known.finer != finer);
        (known.frame, known.finer) = (now, finer);
        for (at, &side) in TILES.iter().enumerate() {
            let tile = u32::from(pixel[1] / side) * self.columns[at] + u32::from(pixel[0] / side);
            if known.last_tile[at] != tile {
                known.last_tile[at] = tile;
                self.tile_lines[at][tile as usize] += u64::from(self.met[at].insert((tile, number)));
            }
        }
    }

    fn tiles(&self) -> Vec<TileWorkingSet> {
        let summary = |(&tile, counts): (&u16, &Vec<u64>)| {
            let mut counts = counts.clone();
            counts.sort_unstable();
            let tiles = counts.len() as u64;
            let mean = counts.iter().sum::<u64>() as f64 / (tiles.max(1) as f64);
            let ninth_decile = counts.get((counts.len() * 9).div_ceil(10).saturating_sub(1)).copied().unwrap_or(0);
            TileWorkingSet { tile, tiles, mean, ninth_decile, most: counts.last().copied().unwrap_or(0) }
        };
        TILES.iter().zip(&self.tile_counts).map(summary).collect()
    }
}

impl Sink for Watch {
    fn take(&mut self, batch: AddressBatch<'_>) {
        // The first tap of a request is of the finer plane.
        let mut first = None;
        batch.for_each_tap(|request, plane, addresses| {
            let finer_plane = match first {
                Some((of, first_plane)) if of == request => first_plane,
                _ => plane,
            };
            first = Some((request, finer_plane));
            let pixel = self.pixels[self.next + request];
            addresses.iter().for_each(|&address| self.lookup(plane, plane == finer_plane, pixel, address));
        });
        self.next += batch.len();
    }
}

impl Reuse {
    /// Follows every lookup of all frames of a scene.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn of(scene: &Scene, machine: &Machine, filter: Filter, mut frame_done: impl FnMut()) -> Result<Self> {
        let bench = AddressBench::new(scene, machine, filter)?;
        let surface = &bench.surface;
        let mut watch = Watch::new(machine.cache.line, surface.planes.len(), scene.size);
        for number in 0..scene.frame_count() {
            watch.begin_frame();
            bench.run(&scene.frame(number), &mut watch, |fragments, watch| {
                watch.pixels.clear();
                watch.pixels.extend(fragments.iter().map(|fragment| [fragment.x, fragment.y]));
                watch.next = 0;
            });
            frame_done();
        }
        watch.begin_frame();
        watch.frames.pop();
        let tiles = watch.tiles();
        Ok(Self {
            filter,
            line: machine.cache.line,
            lines: watch.reuse.lines(),
            planes: surface.planes.iter().map(|plane| (plane.lu, plane.lv)).zip(watch.planes).collect(),
            all: watch.all,
            between_frames: watch.between_frames,
            tiles,
            frames: watch.frames,
        })
    }

    /// Lookups that crossed levels, in all planes.
    #[must_use]
    pub fn across_levels(&self) -> u64 {
        self.planes.iter().map(|(_, plane)| plane.across_levels).sum()
    }

    /// As in reuse.json.
    #[must_use]
    pub fn json(&self) -> Value {
        let curve = |distances: &Distances| -> Value {
            distances.curve().map(|(lines, misses)| json!([lines, misses])).collect()
        };
        let planes: Vec<Value> = self
            .planes
            .iter()
            .filter(|(_, plane)| plane.distances.lookups() > 0)
            .map(|((lu, lv), plane)| {
                json!({
                    "lu": lu, "lv": lv, "lookups": plane.distances.lookups(), "lines": plane.lines,
                    "across_levels": plane.across_levels, "working_set_lines": plane.distances.working_set(10),
                    "curve": curve(&plane.distances),
                })
            })
            .collect();
        let tiles: Vec<Value> = self
            .tiles
            .iter()
            .map(|set| json!({ "tile": set.tile, "tiles": set.tiles, "mean": set.mean, "ninth_decile": set.ninth_decile, "most": set.most }))
            .collect();
        let frames: Vec<Value> = self
            .frames
            .iter()
            .map(|frame| json!({ "lookups": frame.lookups, "lines": frame.lines, "lines_of_previous": frame.lines_of_previous }))
            .collect();
        json!({
            "filter": self.filter.name(),
            "line": self.line,
            "lookups": self.all.lookups(),
            "lines": self.lines,
            "working_set_lines": self.all.working_set(10),
            "across_levels": self.across_levels(),
            "curve": curve(&self.all),
            "between_frames": curve(&self.between_frames),
            "planes": planes,
            "tiles": tiles,
            "frames": frames,
        })
    }
}
