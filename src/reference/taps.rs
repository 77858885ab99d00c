//! Planes and the taps read from them (docs/numerics.md, sections 2 and 5).

use texunit_hw::{AddressMode, Filter, LevelRounding};

use super::{
    coordinate::{self, Grid, floor},
    datapath::Tap,
    lod::Limits,
};
use crate::{
    error::{Error, Result},
    pyramid::{PlaneImage, Pyramid},
};

/// A texel outside the texture, in clip mode.
const OUTSIDE: [u8; 4] = [0; 4];

/// The planes a filter can select, by level.
#[derive(Clone, Debug)]
struct Planes<'a> {
    /// By the level of the only scale, or by that of the u axis. Level 0 is always there.
    along_u: Vec<Plane<'a>>,
    /// By the level of the v axis; empty for filters with one level.
    along_v: Vec<Plane<'a>>,
}

impl<'a> Planes<'a> {
    fn new(pyramid: &'a Pyramid, filter: Filter) -> Result<Self> {
        let [halvings_u, halvings_v] = [halvings(pyramid.width)?, halvings(pyramid.height)?];
        let find = |lu, lv| Plane::find(pyramid, lu, lv);
        let (along_u, along_v): (Result<Vec<_>>, Result<Vec<_>>) = if filter.level_per_axis() {
            ((0..=halvings_u).map(|l| find(l, 0)).collect(), (0..=halvings_v).map(|l| find(0, l)).collect())
        } else {
            let last = if filter.uses_level() { halvings_u.max(halvings_v) } else { 0 };
            ((0..=last).map(|l| find(l.min(halvings_u), l.min(halvings_v))).collect(), Ok(Vec::new()))
        };
        Ok(Self { along_u: along_u?, along_v: along_v? })
    }

    /// The coarsest level of an axis.
    fn coarsest(&self, axis: usize) -> f64 {
        [&self.along_u, &self.along_v][axis].len().saturating_sub(1) as f64
    }
}

/// `floor(log2 size)`.
fn halvings(size: u32) -> Result<u8> {
    if size == 0 {
        return Err(Error::setting("texture", "0 texels wide or high", "there is nothing to sample", "give 1 or more"));
    }
    Ok((libm::frexp(f64::from(size)).1 - 1) as u8)
}

/// The tap programs of section 5, for a pyramid and the settings that choose among its planes.
#[derive(Clone, Debug)]
pub struct Program<'a> {
    planes: Planes<'a>,
    filter: Filter,
    level_rounding: LevelRounding,
    limits: [Limits; 2],
    reading: Reading,
}

impl<'a> Program<'a> {
    /// `limits` comes without the coarsest level, which is that of the pyramid.
    ///
    /// # Errors
    /// A pyramid without the planes the filter reads.
    pub fn new(
        pyramid: &'a Pyramid,
        filter: Filter,
        level_rounding: LevelRounding,
        limits: Limits,
        reading: Reading,
    ) -> Result<Self> {
        let planes = Planes::new(pyramid, filter)?;
        let limits = [0, 1].map(|axis| Limits { coarsest: planes.coarsest(axis), ..limits });
        Ok(Self { planes, filter, level_rounding, limits, reading })
    }

    /// Reads the taps of a request at a coordinate in turns. `raw` is the level of an axis before bias and limits; `weigh`
    /// makes a texel of the taps. Returns that texel and the levels used.
    #[inline]
    pub fn run<T>(&self, at: [f64; 2], raw: impl Fn(usize) -> f64, weigh: impl Fn(&[Tap]) -> T) -> (T, [f64; 2]) {
        let base = &self.planes.along_u[0];
        match self.filter {
            Filter::Point => (weigh(&[base.point(at, &self.reading)]), [0.0; 2]),
            Filter::Bilinear => (weigh(&[base.bilinear(at, &self.reading, 1.0)]), [0.0; 2]),
            Filter::NearestMip => {
                let level = self.limits[0].whole_level(raw(0), self.level_rounding);
                let plane = &self.planes.along_u[level as usize];
                (weigh(&[plane.bilinear(at, &self.reading, 1.0)]), [level; 2])
            }
            Filter::Trilinear => {
                let lod = self.limits[0].fractional(raw(0));
                let level = floor(lod);
                let blur = lod - level;
                let coarser = (level + 1.0).min(self.limits[0].coarsest);
                let [sharp, soft] = [level, coarser].map(|l| &self.planes.along_u[l as usize]);
                let taps = [sharp.bilinear(at, &self.reading, 1.0 - blur), soft.bilinear(at, &self.reading, blur)];
                (weigh(&taps), [lod; 2])
            }
            Filter::Dipmap => {
                let levels = [0, 1].map(|axis| self.limits[axis].clamp(raw(axis))).map(floor);
                let column = &self.planes.along_u[levels[0] as usize];
                let row = &self.planes.along_v[levels[1] as usize];
                let taps = [column.bilinear(at, &self.reading, 0.5), row.bilinear(at, &self.reading, 0.5)];
                (weigh(&taps), levels)
            }
            filter => unimplemented!("{filter:?}: being written from the specification"),
        }
    }
}

/// How a plane is read.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Address mode of each axis.
    pub address: [AddressMode; 2],
    /// The fractions there are between two texels; none for the real numbers.
    pub fractions: Option<Grid>,
}

impl Reading {
    #[inline]
    fn truncate(&self, fraction: f64) -> f64 {
        self.fractions.map_or(fraction, |grid| grid.floor(fraction))
    }
}

/// One plane, ready to be read.
#[derive(Clone, Copy, Debug)]
struct Plane<'a> {
    size: [f64; 2],
    width: usize,
    texels: &'a [[u8; 4]],
}

impl<'a> Plane<'a> {
    fn find(pyramid: &'a Pyramid, lu: u8, lv: u8) -> Result<Self> {
        let halved = |size: u32, times: u8| (f64::from(size) / libm::exp2(f64::from(times))).floor().max(1.0);
        let size = [halved(pyramid.width, lu), halved(pyramid.height, lv)];
        let fits = |plane: &&PlaneImage| {
            [f64::from(plane.width), f64::from(plane.height)] == size
                && plane.texels.len() as u64 == u64::from(plane.width) * u64::from(plane.height)
        };
        let plane =
            pyramid.planes.iter().find(|plane| (plane.lu, plane.lv) == (lu, lv)).filter(fits).ok_or_else(|| {
                Error::setting(
                    "pyramid",
                    format!("{:?} of {} x {}", pyramid.kind, pyramid.width, pyramid.height),
                    format!("has no plane ({lu}, {lv}) of {} x {} texels, which the filter reads", size[0], size[1]),
                    "build the pyramid this filter needs",
                )
            })?;
        Ok(Self { size, width: plane.width as usize, texels: &plane.texels })
    }

    #[inline]
    fn point(&self, at: [f64; 2], reading: &Reading) -> Tap {
        let i = coordinate::point(at[0], self.size[0], reading.address[0]);
        let j = coordinate::point(at[1], self.size[1], reading.address[1]);
        // Four times the same texel with fractions of zero: both lerps, and their roundings, then change nothing.
        Tap { texels: [self.texel(i, j); 4], fraction: [0.0; 2], weight: 1.0 }
    }

    #[inline]
    fn bilinear(&self, at: [f64; 2], reading: &Reading, weight: f64) -> Tap {
        let ([i0, i1], f) = coordinate::bilinear(at[0], self.size[0], reading.address[0]);
        let ([j0, j1], g) = coordinate::bilinear(at[1], self.size[1], reading.address[1]);
        let texels = [self.texel(i0, j0), self.texel(i1, j0), self.texel(i0, j1), self.texel(i1, j1)];
        Tap { texels, fraction: [reading.truncate(f), reading.truncate(g)], weight }
    }

    #[inline]
    fn texel(&self, i: Option<usize>, j: Option<usize>) -> [u8; 4] {
        match (i, j) {
            (Some(i), Some(j)) => self.texels[j * self.width + i],
            _ => OUTSIDE,
        }
    }
}
