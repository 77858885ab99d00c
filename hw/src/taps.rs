//! Tap programs: a filter is a LOD policy and a list of weighted taps (docs/numerics.md, section 5).

use crate::{
    address::{AddressUnit, Footprint},
    lod::{LevelRange, raw_level},
    request::{LodSource, Request},
    sampler::{Filter, Sampler},
    surface::Surface,
};

/// What a tap program reads: the state of the unit that stays the same from request to request.
#[derive(Clone, Debug)]
pub struct TapUnit {
    sampler: Sampler,
    /// Level ranges: of a Mipmap's chain, then of the u and of the v axis.
    pub(crate) chain: LevelRange,
    pub(crate) axes: [LevelRange; 2],
    /// Storage index of plane (0, lv) is this plus lv, for lv above zero.
    pub(crate) row_planes: usize,
    address: AddressUnit,
}

/// A filter's taps, known at compile time so that the inner loop holds nothing another filter needs.
pub(crate) trait Program {
    /// Weights of a request sum to two to this power.
    const WEIGHT_BITS: u32;
    /// Most taps of a request: each level of each axis, or one a probe and level.
    const MOST_TAPS: usize;
    /// Whether every request has that many.
    const ALWAYS: bool = true;
    /// Texels of a tap.
    const TEXELS: usize = 4;

    /// Writes the taps of a request; returns how many, and the levels used.
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]);
}

/// Runs `$call` with the program type of a filter: the one place where a filter becomes code.
macro_rules! with_program {
    ($filter:expr, $program:ident => $call:expr) => {
        match $filter {
            $crate::sampler::Filter::Point => {
                type $program = $crate::taps::Point;
                $call
            }
            $crate::sampler::Filter::Bilinear => {
                type $program = $crate::taps::Bilinear;
                $call
            }
            $crate::sampler::Filter::NearestMip => {
                type $program = $crate::taps::NearestMip;
                $call
            }
            $crate::sampler::Filter::Trilinear => {
                type $program = $crate::taps::Trilinear;
                $call
            }
            $crate::sampler::Filter::Brilinear => {
                type $program = $crate::taps::Brilinear;
                $call
            }
            $crate::sampler::Filter::MipDouble => {
                type $program = $crate::taps::MipDouble;
                $call
            }
            $crate::sampler::Filter::Dipmap => {
                type $program = $crate::taps::Dipmap;
                $call
            }
            $crate::sampler::Filter::DipmapTrilinear => {
                type $program = $crate::taps::DipmapTrilinear;
                $call
            }
            $crate::sampler::Filter::Ripmap => {
                type $program = $crate::taps::Ripmap;
                $call
            }
            $crate::sampler::Filter::Texram => {
                type $program = $crate::probes::Texram;
                $call
            }
            $crate::sampler::Filter::Feline => {
                type $program = $crate::probes::Feline;
                $call
            }
            $crate::sampler::Filter::Fast => {
                type $program = $crate::probes::Fast;
                $call
            }
            $crate::sampler::Filter::Sat => {
                type $program = $crate::sat::Sat;
                $call
            }
        }
    };
}
pub(crate) use with_program;

impl TapUnit {
    /// The unit for one sampler and one surface.
    #[must_use]
    pub fn new(sampler: &Sampler, surface: &Surface) -> Self {
        Self {
            sampler: *sampler,
            chain: LevelRange::new(sampler, surface.last_level()),
            axes: surface.last_levels.map(|last| LevelRange::new(sampler, last)),
            row_planes: surface.last_levels[0].into(),
            address: AddressUnit::new(surface, sampler.address, sampler.filter_bits),
        }
    }

    /// State of the sampler it was made for.
    pub(crate) const fn sampler(&self) -> &Sampler {
        &self.sampler
    }

    /// Where texels lie.
    pub(crate) const fn address(&self) -> &AddressUnit {
        &self.address
    }

    /// The LOD unit's reading of one of the scales, before bias and clamp.
    #[inline]
    pub(crate) fn raw(&self, scale: u32) -> i32 {
        match self.sampler.lod_source {
            LodSource::Explicit => scale.cast_signed(),
            LodSource::Gradient => raw_level(scale, self.sampler.log2),
        }
    }

    /// Level, fraction and the level used on a Mipmap's chain.
    #[inline]
    pub(crate) fn chain_level(&self, raw: i32) -> Split {
        Split::of(self.chain.fractional(raw), self.chain.last)
    }

    /// Level and fraction of one axis.
    #[inline]
    fn axis_level(&self, axis: usize, request: &Request) -> Split {
        Split::of(self.axes[axis].fractional(self.raw(request.scale[axis])), self.axes[axis].last)
    }

    /// Storage index of plane (0, lv) of a Dipmap.
    #[inline]
    const fn row_plane(&self, lv: usize) -> usize {
        if lv == 0 { 0 } else { self.row_planes + lv }
    }

    /// A bilinear tap.
    #[inline]
    pub(crate) fn tap(&self, plane: usize, [u, v]: [i64; 2], weight: u32) -> Footprint {
        self.address.bilinear(plane, u, v, weight)
    }
}

/// A level split into the two it lies between.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Split {
    /// The sharper level.
    pub(crate) level: usize,
    /// The blurrier one, or the same at the end of the chain.
    pub(crate) coarser: usize,
    /// Weight of the blurrier one, of 256.
    pub(crate) t: u32,
    /// Both together, 8.8.
    pub(crate) lod: u16,
}

impl Split {
    #[inline]
    fn of(lod: i32, last: u8) -> Self {
        let level = (lod >> 8) as usize;
        Self { level, coarser: (level + 1).min(last.into()), t: (lod & 255) as u32, lod: lod as u16 }
    }

    /// Weight of the sharper level, of 256.
    #[inline]
    pub(crate) const fn s(&self) -> u32 {
        256 - self.t
    }
}

#[inline]
pub(crate) fn coordinates(request: &Request) -> [i64; 2] {
    [request.u, request.v].map(|coordinate| coordinate.to_bits().into())
}

pub(crate) struct Point;

impl Program for Point {
    const WEIGHT_BITS: u32 = 0;
    const MOST_TAPS: usize = 1;
    const TEXELS: usize = 1;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let [u, v] = coordinates(request);
        taps[0] = unit.address.point(0, u, v, 1);
        (1, [0; 2])
    }
}

pub(crate) struct Bilinear;

impl Program for Bilinear {
    const WEIGHT_BITS: u32 = 0;
    const MOST_TAPS: usize = 1;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        taps[0] = unit.tap(0, coordinates(request), 1);
        (1, [0; 2])
    }
}

pub(crate) struct NearestMip;

impl Program for NearestMip {
    const WEIGHT_BITS: u32 = 0;
    const MOST_TAPS: usize = 1;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let level = unit.chain.whole(unit.raw(request.scale[0]), unit.sampler.level_rounding);
        taps[0] = unit.tap(level as usize, coordinates(request), 1);
        (1, [(level << 8) as u16; 2])
    }
}

pub(crate) struct Trilinear;

impl Program for Trilinear {
    const WEIGHT_BITS: u32 = 8;
    const MOST_TAPS: usize = 2;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let at = coordinates(request);
        let split = unit.chain_level(unit.raw(request.scale[0]));
        taps[0] = unit.tap(split.level, at, split.s());
        taps[1] = unit.tap(split.coarser, at, split.t);
        (2, [split.lod; 2])
    }
}

pub(crate) struct Brilinear;

impl Program for Brilinear {
    const WEIGHT_BITS: u32 = 8;
    const MOST_TAPS: usize = 2;
    const ALWAYS: bool = false;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let at = coordinates(request);
        let split = unit.chain_level(unit.raw(request.scale[0]));
        let threshold = u32::from(unit.sampler.brilinear_threshold);
        let (level, t) = if split.t <= threshold {
            (split.level, 0)
        } else if split.t >= 256 - threshold {
            (split.level + 1, 0)
        } else {
            (split.level, ((split.t - threshold) << 8) / (256 - 2 * threshold))
        };
        taps[0] = unit.tap(level, at, 256 - t);
        let lod = ((level as u32) << 8 | t) as u16;
        if t == 0 {
            return (1, [lod; 2]);
        }
        taps[1] = unit.tap(split.coarser, at, t);
        (2, [lod; 2])
    }
}

pub(crate) struct MipDouble;

impl Program for MipDouble {
    const WEIGHT_BITS: u32 = 1;
    const MOST_TAPS: usize = 2;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let at = coordinates(request);
        let levels = request.scale.map(|scale| unit.chain.clamp(unit.raw(scale)) >> 8);
        for (tap, level) in taps.iter_mut().zip(levels) {
            *tap = unit.tap(level as usize, at, 1);
        }
        (2, levels.map(|level| (level << 8) as u16))
    }
}

pub(crate) struct Dipmap;

impl Program for Dipmap {
    const WEIGHT_BITS: u32 = 1;
    const MOST_TAPS: usize = 2;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let at = coordinates(request);
        let [lu, lv] = [0, 1].map(|axis| unit.axes[axis].clamp(unit.raw(request.scale[axis])) >> 8);
        taps[0] = unit.tap(lu as usize, at, 1);
        taps[1] = unit.tap(unit.row_plane(lv as usize), at, 1);
        (2, [(lu << 8) as u16, (lv << 8) as u16])
    }
}

pub(crate) struct DipmapTrilinear;

impl Program for DipmapTrilinear {
    const WEIGHT_BITS: u32 = 9;
    const MOST_TAPS: usize = 4;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let at = coordinates(request);
        let [columns, rows] = [0, 1].map(|axis| unit.axis_level(axis, request));
        taps[0] = unit.tap(columns.level, at, columns.s());
        taps[1] = unit.tap(columns.coarser, at, columns.t);
        taps[2] = unit.tap(unit.row_plane(rows.level), at, rows.s());
        taps[3] = unit.tap(unit.row_plane(rows.coarser), at, rows.t);
        (4, [columns.lod, rows.lod])
    }
}

pub(crate) struct Ripmap;

impl Program for Ripmap {
    const WEIGHT_BITS: u32 = 16;
    const MOST_TAPS: usize = 4;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> (usize, [u16; 2]) {
        let at = coordinates(request);
        let [columns, rows] = [0, 1].map(|axis| unit.axis_level(axis, request));
        let row_of_planes = unit.row_planes + 1;
        let pairs = [(rows.level, rows.s()), (rows.coarser, rows.t)];
        for (taps, (lv, weight)) in taps.chunks_exact_mut(2).zip(pairs) {
            taps[0] = unit.tap(lv * row_of_planes + columns.level, at, weight * columns.s());
            taps[1] = unit.tap(lv * row_of_planes + columns.coarser, at, weight * columns.t);
        }
        (4, [columns.lod, rows.lod])
    }
}

/// Sum of a filter's weights is two to this power.
#[must_use]
pub fn weight_bits(filter: Filter) -> u32 {
    with_program!(filter, P => <P as Program>::WEIGHT_BITS)
}

/// Most taps of a request, and whether every request has that many.
#[must_use]
pub fn most_taps(filter: Filter) -> (usize, bool) {
    with_program!(filter, P => (<P as Program>::MOST_TAPS, <P as Program>::ALWAYS))
}
