//! Planes and how a tap reads one (docs/numerics.md, sections 2, 3 and 5).

use texunit_hw::{AddressMode, Filter, PyramidKind};

use super::{
    coordinate::{self, Grid, floored},
    datapath::Tap,
};
use crate::{
    error::{Error, Result},
    pyramid::{PlaneImage, Pyramid},
};

/// A texel outside the texture, in clip mode.
const OUTSIDE: [u8; 4] = [0; 4];

/// The planes a filter can select, by level.
#[derive(Clone, Debug)]
pub struct Planes<'a> {
    /// By the level of the only scale, or by that of the u axis. Level 0 is always there.
    pub along_u: Vec<Plane<'a>>,
    /// By the level of the v axis; empty for filters with one level.
    pub along_v: Vec<Plane<'a>>,
    /// By both, a row for each level of the v axis; empty for filters that never read a plane halved both ways apart.
    grid: Vec<Plane<'a>>,
}

impl<'a> Planes<'a> {
    /// # Errors
    /// A pyramid without the planes the filter reads.
    pub fn new(pyramid: &'a Pyramid, filter: Filter) -> Result<Self> {
        let [last_u, last_v] = [halvings(pyramid.width)?, halvings(pyramid.height)?];
        let find = |lu, lv| Plane::find(pyramid, lu, lv);
        let chain = |last: u8| (0..=last).map(|l| find(l.min(last_u), l.min(last_v))).collect::<Result<Vec<_>>>();
        if !filter.uses_level() {
            return Ok(Self { along_u: chain(0)?, along_v: Vec::new(), grid: Vec::new() });
        }
        match filter.pyramid() {
            PyramidKind::Mipmap | PyramidKind::Sat => {
                let along_u = chain(last_u.max(last_v))?;
                let along_v = if filter.level_per_axis() { along_u.clone() } else { Vec::new() };
                Ok(Self { along_u, along_v, grid: Vec::new() })
            }
            kind => {
                let along_u = (0..=last_u).map(|l| find(l, 0)).collect::<Result<_>>()?;
                let along_v = (0..=last_v).map(|l| find(0, l)).collect::<Result<_>>()?;
                let cells = (0..=last_v).flat_map(|lv| (0..=last_u).map(move |lu| (lu, lv)));
                let grid = match kind {
                    PyramidKind::Ripmap => cells.map(|(lu, lv)| find(lu, lv)).collect::<Result<_>>()?,
                    _ => Vec::new(),
                };
                Ok(Self { along_u, along_v, grid })
            }
        }
    }

    /// The coarsest level of an axis.
    #[must_use]
    pub fn coarsest(&self, axis: usize) -> f64 {
        [&self.along_u, &self.along_v][axis].len().saturating_sub(1) as f64
    }

    /// A plane of a ripmap, by its levels.
    #[must_use]
    pub fn cell(&self, lu: f64, lv: f64) -> &Plane<'a> {
        &self.grid[lv as usize * self.along_u.len() + lu as usize]
    }
}

/// `floor(log2 size)`.
fn halvings(size: u32) -> Result<u8> {
    if size == 0 {
        return Err(Error::setting("texture", "0 texels wide or high", "there is nothing to sample", "give 1 or more"));
    }
    Ok((libm::frexp(f64::from(size)).1 - 1) as u8)
}

/// How a plane is read.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Address mode of each axis.
    pub address: [AddressMode; 2],
    /// The fractions there are between two texels; none for the real numbers.
    pub fractions: Option<Grid>,
}

/// One plane, ready to be read.
#[derive(Clone, Copy, Debug)]
pub struct Plane<'a> {
    /// Texels along u and along v.
    pub size: [f64; 2],
    width: usize,
    texels: &'a [[u8; 4]],
}

impl<'a> Plane<'a> {
    /// # Errors
    /// A pyramid without this plane.
    pub fn find(pyramid: &'a Pyramid, lu: u8, lv: u8) -> Result<Self> {
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

    /// The tap of one texel.
    #[inline]
    #[must_use]
    pub fn point(&self, at: [f64; 2], reading: &Reading) -> Tap {
        let i = coordinate::point(at[0], self.size[0], reading.address[0]);
        let j = coordinate::point(at[1], self.size[1], reading.address[1]);
        // Four times the same texel with fractions of zero: both lerps, and their roundings, then change nothing.
        Tap { texels: [self.texel(i, j); 4], fraction: [0.0; 2], weight: 1.0 }
    }

    /// The tap of the four texels around a coordinate.
    #[inline]
    #[must_use]
    pub fn bilinear(&self, at: [f64; 2], reading: &Reading, weight: f64) -> Tap {
        let ([i0, i1], f) = coordinate::bilinear(at[0], self.size[0], reading.address[0]);
        let ([j0, j1], g) = coordinate::bilinear(at[1], self.size[1], reading.address[1]);
        let texels = [self.texel(i0, j0), self.texel(i1, j0), self.texel(i0, j1), self.texel(i1, j1)];
        let truncated = |fraction| floored(reading.fractions, fraction);
        Tap { texels, fraction: [truncated(f), truncated(g)], weight }
    }

    /// A texel by its addressed indices.
    #[inline]
    #[must_use]
    pub fn texel(&self, i: Option<usize>, j: Option<usize>) -> [u8; 4] {
        match (i, j) {
            (Some(i), Some(j)) => self.texels[j * self.width + i],
            _ => OUTSIDE,
        }
    }
}
