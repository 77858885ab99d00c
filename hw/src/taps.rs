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
    chain: LevelRange,
    axes: [LevelRange; 2],
    /// Storage index of plane (0, lv) is this plus lv, for lv above zero.
    row_planes: usize,
    address: AddressUnit,
}

/// A filter's taps, known at compile time so that the inner loop holds nothing another filter needs.
pub(crate) trait Program {
    /// Weights of a request sum to two to this power.
    const WEIGHT_BITS: u32;
    /// Taps of a request, where every request has the same number.
    const TAPS: usize;
    /// Texels of a tap.
    const TEXELS: usize = 4;

    /// Writes the taps of a request and returns the levels used.
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> [u16; 2];
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
            $crate::sampler::Filter::Dipmap => {
                type $program = $crate::taps::Dipmap;
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

    #[inline]
    fn raw(&self, scale: u32) -> i32 {
        match self.sampler.lod_source {
            LodSource::Explicit => scale.cast_signed(),
            LodSource::Gradient => raw_level(scale, self.sampler.log2),
        }
    }
}

#[inline]
fn coordinates(request: &Request) -> (i64, i64) {
    (request.u.to_bits().into(), request.v.to_bits().into())
}

pub(crate) struct Point;

impl Program for Point {
    const WEIGHT_BITS: u32 = 0;
    const TAPS: usize = 1;
    const TEXELS: usize = 1;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> [u16; 2] {
        let (u, v) = coordinates(request);
        taps[0] = unit.address.point(0, u, v, 1);
        [0; 2]
    }
}

pub(crate) struct Bilinear;

impl Program for Bilinear {
    const WEIGHT_BITS: u32 = 0;
    const TAPS: usize = 1;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> [u16; 2] {
        let (u, v) = coordinates(request);
        taps[0] = unit.address.bilinear(0, u, v, 1);
        [0; 2]
    }
}

pub(crate) struct NearestMip;

impl Program for NearestMip {
    const WEIGHT_BITS: u32 = 0;
    const TAPS: usize = 1;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> [u16; 2] {
        let (u, v) = coordinates(request);
        let level = unit.chain.whole(unit.raw(request.scale[0]), unit.sampler.level_rounding);
        taps[0] = unit.address.bilinear(level as usize, u, v, 1);
        [(level << 8) as u16; 2]
    }
}

pub(crate) struct Trilinear;

impl Program for Trilinear {
    const WEIGHT_BITS: u32 = 8;
    const TAPS: usize = 2;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> [u16; 2] {
        let (u, v) = coordinates(request);
        let lod = unit.chain.fractional(unit.raw(request.scale[0]));
        let (level, t) = ((lod >> 8) as usize, (lod & 255) as u16);
        let coarser = (level + 1).min(unit.chain.last.into());
        taps[0] = unit.address.bilinear(level, u, v, 256 - t);
        taps[1] = unit.address.bilinear(coarser, u, v, t);
        [lod as u16; 2]
    }
}

pub(crate) struct Dipmap;

impl Program for Dipmap {
    const WEIGHT_BITS: u32 = 1;
    const TAPS: usize = 2;

    #[inline]
    fn expand(unit: &TapUnit, request: &Request, taps: &mut [Footprint]) -> [u16; 2] {
        let (u, v) = coordinates(request);
        let [lu, lv] = [0, 1].map(|axis| unit.axes[axis].clamp(unit.raw(request.scale[axis])) >> 8);
        let row = if lv == 0 { 0 } else { unit.row_planes + lv as usize };
        taps[0] = unit.address.bilinear(lu as usize, u, v, 1);
        taps[1] = unit.address.bilinear(row, u, v, 1);
        [(lu << 8) as u16, (lv << 8) as u16]
    }
}

/// Sum of a filter's weights is two to this power.
#[must_use]
pub fn weight_bits(filter: Filter) -> u32 {
    with_program!(filter, P => <P as Program>::WEIGHT_BITS)
}
