//! Textures too large to hold: only the tiles that a scene reads are computed and stored.
//!
//! Addresses stay those of the whole texture, so hits, misses and clocks are the same; between them and the bytes stands a table of
//! tiles, as for the sparse textures of graphics interfaces.

use std::{
    fs::File,
    io::{BufReader, Read, Seek, SeekFrom},
    ops::Range,
    path::{Path, PathBuf},
    sync::Mutex,
};

use rayon::prelude::*;
use texunit_hw::{
    Filter, Request, Response, Sampler, Surface, Unit,
    datapath::{Texel, TexelSource},
    surface::place_on_map,
};

use super::Needs;
use crate::{
    error::{Error, Result},
    pyramid::{Build, From, PlaneImage, axis::AxisTaps, halved},
    scene::{Pattern, Procedural},
};

/// Texels on a side of a tile: 4 KiB of RGBA8.
pub const TILE: u32 = 32;

/// A set of tiles of one plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileSet {
    columns: u32,
    all: u64,
    marks: Vec<u64>,
}

impl TileSet {
    /// None of the tiles of a plane of this size.
    #[must_use]
    pub fn new(size: [u32; 2]) -> Self {
        let [columns, rows] = size.map(|texels| texels.div_ceil(TILE));
        let all = u64::from(columns) * u64::from(rows);
        Self { columns, all, marks: vec![0; all.div_ceil(64) as usize] }
    }

    fn number(&self, [x, y]: [u32; 2]) -> u64 {
        u64::from(y / TILE) * u64::from(self.columns) + u64::from(x / TILE)
    }

    /// Adds the tile of a texel.
    #[inline]
    pub fn add(&mut self, texel: [u32; 2]) {
        let number = self.number(texel);
        self.marks[(number / 64) as usize] |= 1 << (number % 64);
    }

    /// Tiles in the set.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.marks.iter().map(|marks| u64::from(marks.count_ones())).sum()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Tiles of the plane.
    #[must_use]
    pub const fn all(&self) -> u64 {
        self.all
    }

    /// Their numbers, rising: row after row of tiles.
    fn numbers(&self) -> impl Iterator<Item = u64> + '_ {
        (0..self.all).filter(|number| self.marks[(number / 64) as usize] >> (number % 64) & 1 == 1)
    }
}

/// A texture whose texels are made or read when they are asked for.
pub trait LazyTexture: Sync {
    /// Width and height.
    fn size(&self) -> [u32; 2];
    /// Whether alpha is 255 everywhere.
    fn is_opaque(&self) -> bool;
    /// Writes the texels of a part of one row.
    ///
    /// # Errors
    /// A file that cannot be read.
    fn row(&self, y: u32, columns: Range<u32>, texels: &mut [Texel]) -> Result<()>;
}

impl LazyTexture for Procedural {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn is_opaque(&self) -> bool {
        true
    }

    fn row(&self, y: u32, columns: Range<u32>, texels: &mut [Texel]) -> Result<()> {
        if self.pattern == Pattern::Natural {
            let problem = "hairs run through the whole image: its texels cannot be had one by one";
            return Err(Error::setting(
                "texture.pattern",
                "natural",
                problem,
                "use checkerboard or pane, or a PPM file",
            ));
        }
        for (x, texel) in columns.zip(texels) {
            *texel = self.texel(x, y);
        }
        Ok(())
    }
}

impl LazyTexture for PlaneImage {
    fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    fn is_opaque(&self) -> bool {
        self.texels.iter().all(|texel| texel[3] == 255)
    }

    fn row(&self, y: u32, columns: Range<u32>, texels: &mut [Texel]) -> Result<()> {
        let begin = y as usize * self.width as usize;
        texels.copy_from_slice(&self.texels[begin + columns.start as usize..begin + columns.end as usize]);
        Ok(())
    }
}

/// A binary PPM file (P6, 8 bits) read in pieces.
#[derive(Debug)]
pub struct PpmFile {
    path: PathBuf,
    file: Mutex<File>,
    begin: u64,
    size: [u32; 2],
}

impl PpmFile {
    /// Reads the header.
    ///
    /// # Errors
    /// A file that cannot be read, is no P6 of 8 bits, or is too short.
    pub fn open(path: &Path) -> Result<Self> {
        let wrong = |problem: &str| {
            Error::file(path, "the header", problem, "write a binary PPM of 8 bits a channel: P6, width, height, 255")
        };
        let file = File::open(path).map_err(Error::io(path))?;
        let length = file.metadata().map_err(Error::io(path))?.len();
        let mut header = BufReader::new(&file).take(1 << 12);
        let (mut begin, mut words, mut word, mut comment) = (0, Vec::new(), String::new(), false);
        while words.len() < 4 {
            let mut byte = [0];
            header.read_exact(&mut byte).map_err(|_| wrong("it ends too soon"))?;
            begin += 1;
            match byte[0] {
                b'#' => comment = true,
                b'\n' if comment => comment = false,
                _ if comment => {}
                b' ' | b'\t' | b'\r' | b'\n' if word.is_empty() => {}
                b' ' | b'\t' | b'\r' | b'\n' => words.push(std::mem::take(&mut word)),
                byte => word.push(byte.into()),
            }
        }
        let number = |word: &String| word.parse::<u32>().ok().filter(|size| (1..=1 << 20).contains(size));
        let (Some(width), Some(height)) = (number(&words[1]), number(&words[2])) else {
            return Err(wrong("width and height are not from 1 to 1048576"));
        };
        if words[0] != "P6" || words[3] != "255" {
            return Err(wrong("it does not begin with P6 and 255"));
        }
        if length < begin + 3 * u64::from(width) * u64::from(height) {
            return Err(wrong("there are fewer texels than width x height"));
        }
        Ok(Self { path: path.into(), file: Mutex::new(file), begin, size: [width, height] })
    }
}

impl LazyTexture for PpmFile {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn is_opaque(&self) -> bool {
        true
    }

    fn row(&self, y: u32, columns: Range<u32>, texels: &mut [Texel]) -> Result<()> {
        let mut bytes = vec![0; 3 * columns.len()];
        let place = u64::from(y) * u64::from(self.size[0]) + u64::from(columns.start);
        {
            let mut file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            file.seek(SeekFrom::Start(self.begin + 3 * place))
                .and_then(|_| file.read_exact(&mut bytes))
                .map_err(Error::io(&self.path))?;
        }
        for (texel, rgb) in texels.iter_mut().zip(bytes.chunks_exact(3)) {
            *texel = [rgb[0], rgb[1], rgb[2], 255];
        }
        Ok(())
    }
}

/// The tiles that some requests read, and nothing else of the pyramid.
#[derive(Debug)]
pub struct TileMemory {
    /// For each plane: tiles in a row of tiles, and for each tile its place among those held.
    planes: Vec<(u32, Vec<u32>)>,
    /// Tiles, each [`TILE`] x [`TILE`] texels row after row.
    tiles: Vec<[Texel; (TILE * TILE) as usize]>,
    /// Most texels of the texture that were in memory at a time for making tiles.
    pub source_texels: u64,
}

/// No tile.
const NOT_HELD: u32 = u32::MAX;

impl TileMemory {
    /// Computes the tiles that `needs` names, each from the piece of the texture below it.
    ///
    /// Texels are bit for bit those of the whole pyramid ([`Build::pyramid`]): the same taps along both axes, summed exactly, and one
    /// rounding. That asks for planes made from the top.
    ///
    /// # Errors
    /// Planes made from each other, a kernel that cannot be built, texels that cannot be had.
    pub fn new(needs: &Needs, build: &Build, texture: &impl LazyTexture) -> Result<Self> {
        if build.from != From::Top {
            let problem = "a tile comes from the texture, not from a plane that is not there";
            return Err(Error::setting("texture.pyramid.from", "above", problem, "use top"));
        }
        if !texture.is_opaque() {
            let problem = "whether colours must stay below alpha depends on all texels";
            return Err(Error::setting("texture", "with alpha", problem, "use an opaque texture"));
        }
        let size = texture.size();
        let width = build.kernel.width(build.width)?;
        let (mut planes, mut jobs) = (Vec::new(), Vec::new());
        for plane in &needs.planes {
            let columns = plane.size[0].div_ceil(TILE);
            if plane.tiles.is_empty() {
                planes.push((columns, Vec::new()));
                continue;
            }
            let (lu, lv) = plane.halvings;
            let axis = |axis: usize, halvings| {
                AxisTaps::new(build.kernel, width, build.edge, size[axis], halved(size[axis], halvings))
            };
            let axes = std::sync::Arc::new([axis(0, lu), axis(1, lv)]);
            let mut places = vec![NOT_HELD; plane.tiles.all() as usize];
            for number in plane.tiles.numbers() {
                places[number as usize] = jobs.len() as u32;
                let tile = [(number % u64::from(columns)) as u32, (number / u64::from(columns)) as u32];
                jobs.push((axes.clone(), tile));
            }
            planes.push((columns, places));
        }
        let mut tiles = vec![[[0; 4]; (TILE * TILE) as usize]; jobs.len()];
        let longest = tiles
            .par_iter_mut()
            .zip(&jobs)
            .map(|(made, (axes, tile))| make_tile(build, texture, axes, *tile, made))
            .try_reduce(|| 0, |one, other| Ok(one.max(other)))?;
        // A row of texels and a row of sums for each thread at work.
        let source_texels = longest * rayon::current_num_threads() as u64;
        Ok(Self { planes, tiles, source_texels })
    }

    /// Bytes of the tiles held and of the tables that find them.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let tables: usize = self.planes.iter().map(|(_, places)| size_of_val(places.as_slice())).sum();
        (size_of_val(self.tiles.as_slice()) + tables) as u64
    }

    /// Tiles held.
    #[must_use]
    pub const fn tiles(&self) -> usize {
        self.tiles.len()
    }

    /// Answers the requests the tiles were made for.
    ///
    /// # Errors
    /// A sampler or size no unit can be built for, among them [`Filter::Sat`]: an entry is a sum of texels of all tiles before it.
    ///
    /// # Panics
    /// On a request that reads a tile which is not held.
    pub fn run(&self, sampler: &Sampler, size: [u32; 2], requests: &[Request]) -> Result<Vec<Response>> {
        let cannot = |error: String| Error::setting("texture", "this size", error, "change the texture or the machine");
        if sampler.filter == Filter::Sat {
            return Err(cannot("a summed-area table is not made of tiles".into()));
        }
        let map =
            Surface::map(sampler.filter.pyramid(), size[0], size[1]).map_err(|error| cannot(error.to_string()))?;
        let sampler = Sampler { skip_empty_taps: true, ..*sampler };
        let mut unit = Unit::without_memory(&sampler, &map).map_err(|error| cannot(error.to_string()))?;
        let mut responses = vec![Response::default(); requests.len()];
        unit.run_from(self, requests, &mut responses, &mut ());
        Ok(responses)
    }
}

impl TexelSource for TileMemory {
    fn texel(&self, address: u64, plane: u16, _position: u32) -> Texel {
        let [x, y] = place_on_map(address);
        let (columns, places) = &self.planes[usize::from(plane)];
        let tile = places[((y / TILE) * columns + x / TILE) as usize];
        self.tiles[tile as usize][(y % TILE * TILE + x % TILE) as usize]
    }
}

/// Fills one tile; says how many columns of the texture it came from.
fn make_tile(
    build: &Build,
    texture: &impl LazyTexture,
    [u, v]: &[AxisTaps; 2],
    tile: [u32; 2],
    made: &mut [Texel; (TILE * TILE) as usize],
) -> Result<u64> {
    let span =
        |axis: &AxisTaps, tile: u32| tile as usize * TILE as usize..axis.len().min((tile + 1) as usize * TILE as usize);
    let (across, down) = (span(u, tile[0]), span(v, tile[1]));
    // The columns read: taps rise, but at an edge that wraps they may come from both ends.
    let columns = across.clone().flat_map(|i| u.of(i)).map(|tap| tap.texel);
    let (first, last) = columns.fold((u32::MAX, 0), |(first, last), texel| (first.min(texel), last.max(texel)));
    let mut row = vec![[0; 4]; (last + 1 - first) as usize];
    let mut sums = vec![[0i64; 4]; row.len()];
    for (j, line) in down.zip(made.chunks_exact_mut(TILE as usize)) {
        sums.fill([0; 4]);
        for tap in v.of(j) {
            texture.row(tap.texel, first..last + 1, &mut row)?;
            for (sum, texel) in sums.as_flattened_mut().iter_mut().zip(row.as_flattened()) {
                *sum += i64::from(tap.weight) * i64::from(*texel);
            }
        }
        for (i, texel) in across.clone().zip(line) {
            let mut total = [0i64; 4];
            for tap in u.of(i) {
                for (total, sum) in total.iter_mut().zip(sums[(tap.texel - first) as usize]) {
                    *total += i64::from(tap.weight) * sum;
                }
            }
            // An opaque texture counts as premultiplied, and where an edge fades alpha its colours fade with it.
            let [red, green, blue, alpha] = build.rounding.divide(total, u.total * v.total);
            *texel = [red.min(alpha), green.min(alpha), blue.min(alpha), alpha];
        }
    }
    Ok(row.len() as u64)
}
