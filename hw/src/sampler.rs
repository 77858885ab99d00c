//! The state of the unit that stays the same from request to request: what an API calls a sampler.

use crate::{coordinate::AddressMode, request::LodSource};

/// Which program of taps answers a request (docs/numerics.md, section 5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Filter {
    /// The texel under the coordinate, level 0.
    Point,
    /// Four texels of level 0.
    Bilinear,
    /// Four texels of one whole level.
    NearestMip,
    /// Four texels of each of two levels (Williams 1983).
    #[default]
    Trilinear,
    /// Trilinear near the middle between two levels, bilinear elsewhere (peers' "brilinear").
    Brilinear,
    /// Two levels of a Mipmap, one an axis (Du & Wan, II-A: double sampling).
    MipDouble,
    /// Four texels of the column pyramid and four of the row pyramid (Du & Wan).
    Dipmap,
    /// The same with two levels of each.
    DipmapTrilinear,
    /// Two levels of each axis, four planes.
    Ripmap,
    /// A power of two of trilinear probes along the longer side of the footprint (Schilling 1996).
    Texram,
    /// Trilinear probes along the major axis, weighted by a Gaussian (McCormack 1999).
    Feline,
    /// Jittered samples over the footprint, as many as each level needs (Chen 2004).
    Fast,
    /// The mean over the footprint's bounding box, from a summed-area table (Crow 1984).
    Sat,
}

/// Every filter, in the order of [`Filter`].
pub const FILTERS: [Filter; 13] = [
    Filter::Point,
    Filter::Bilinear,
    Filter::NearestMip,
    Filter::Trilinear,
    Filter::Brilinear,
    Filter::MipDouble,
    Filter::Dipmap,
    Filter::DipmapTrilinear,
    Filter::Ripmap,
    Filter::Texram,
    Filter::Feline,
    Filter::Fast,
    Filter::Sat,
];

/// Which planes a pyramid holds (docs/numerics.md, section 2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PyramidKind {
    /// Both axes halved together: the diagonal.
    #[default]
    Mipmap,
    /// One axis halved at a time: the two edges, base shared.
    Dipmap,
    /// Each axis halved as often as the other or not: the whole grid.
    Ripmap,
    /// No halvings: level 0 as a summed-area table, 16 bytes an entry (docs/numerics.md, section 5.3).
    Sat,
}

impl Filter {
    /// The pyramid this filter reads.
    #[must_use]
    pub const fn pyramid(self) -> PyramidKind {
        match self {
            Self::Dipmap | Self::DipmapTrilinear => PyramidKind::Dipmap,
            Self::Ripmap => PyramidKind::Ripmap,
            Self::Sat => PyramidKind::Sat,
            _ => PyramidKind::Mipmap,
        }
    }

    /// Whether each axis selects a level of its own.
    #[must_use]
    pub const fn level_per_axis(self) -> bool {
        matches!(self, Self::MipDouble | Self::Dipmap | Self::DipmapTrilinear | Self::Ripmap)
    }

    /// Whether `scale` holds the major and the minor axis of the footprint, and `axes` are read (docs/numerics.md, section 5.2).
    #[must_use]
    pub const fn is_anisotropic(self) -> bool {
        matches!(self, Self::Texram | Self::Feline | Self::Fast)
    }

    /// Whether the level of a request matters at all.
    #[must_use]
    pub const fn uses_level(self) -> bool {
        !matches!(self, Self::Point | Self::Bilinear | Self::Sat)
    }
}

/// The log2 unit (docs/numerics.md, section 4.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Log2 {
    /// Rounded to nearest, error at most 1/512 level.
    #[default]
    Exact,
    /// A table of 128 entries, each right in the middle of its cell: error +-0.0047.
    Table128,
    /// The same with 64 entries: error +-0.0074.
    Table64,
    /// The same with 16 entries: error +-0.0238.
    Table16,
    /// The mantissa bent by a parabola: error +-0.0058.
    Quadratic,
    /// Exponent and mantissa of the fourth power, one multiply more than Herf: error -0.0254 to 0.
    Fourth,
    /// Exponent and mantissa of the square, Herf's `trivalsq`: error -0.0469 to 0.
    Herf,
    /// Exponent and mantissa of the ratio itself, Herf's `trival`, behind a square root: error -0.0900 to 0.
    HerfPlain,
    /// Whole levels only, Herf's `ilog2`.
    Ilog2,
}

/// How a filter of one whole level rounds (docs/numerics.md, section 4.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LevelRounding {
    /// The sharper level.
    Floor,
    /// Half goes to the blurrier level.
    #[default]
    Nearest,
    /// OpenGL's rule: half goes to the sharper level.
    Gl,
}

/// Where the datapath rounds (docs/numerics.md, section 6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Rounding {
    /// The exact weighted sum, half up, one shift.
    #[default]
    Once,
    /// Every lerp to 8 bits, half up.
    StagedRound,
    /// Every lerp to 8 bits, truncated.
    StagedTruncate,
}

/// Sampler state. The fields are public and checked by [`Sampler::check`] when a unit is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    /// The tap program.
    pub filter: Filter,
    /// Address mode of the u and of the v axis.
    pub address: [AddressMode; 2],
    /// Bits of the bilinear fraction, 1 to 12.
    pub filter_bits: u8,
    /// Bits of the level fraction, 0 to 8.
    pub lod_bits: u8,
    /// Where the datapath rounds.
    pub rounding: Rounding,
    /// How [`crate::Request::scale`] is read.
    pub lod_source: LodSource,
    /// The log2 unit.
    pub log2: Log2,
    /// How filters of one whole level round it.
    pub level_rounding: LevelRounding,
    /// Most probes of an anisotropic filter a level, 1 to 64.
    pub max_anisotropy: u8,
    /// Brilinear takes one level where the fraction is this close to it, in 1/256 level, 0 to 127.
    pub brilinear_threshold: u8,
    /// Added to the level before clamping, 8.8, within +-16.0.
    pub bias: i16,
    /// Smallest level, 8.8.
    pub min_lod: i32,
    /// Largest level, 8.8.
    pub max_lod: i32,
    /// Whether taps of weight zero are left out, and taps of one request that read the same texels are made one: the same answers
    /// from fewer reads (docs/numerics.md, section 5).
    pub skip_empty_taps: bool,
}

impl Default for Sampler {
    fn default() -> Self {
        Self {
            filter: Filter::default(),
            address: [AddressMode::Wrap; 2],
            filter_bits: 8,
            lod_bits: 8,
            rounding: Rounding::default(),
            lod_source: LodSource::default(),
            log2: Log2::default(),
            level_rounding: LevelRounding::default(),
            max_anisotropy: 16,
            brilinear_threshold: 64,
            bias: 0,
            min_lod: 0,
            max_lod: 32 << 8,
            skip_empty_taps: false,
        }
    }
}

/// A sampler setting that no unit can be built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplerError {
    /// The setting.
    pub key: &'static str,
    /// Its value.
    pub value: i64,
    /// Smallest and largest value that would do.
    pub range: (i64, i64),
}

impl core::fmt::Display for SamplerError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} = {} is outside {}..={}", self.key, self.value, self.range.0, self.range.1)
    }
}

impl core::error::Error for SamplerError {}

impl Sampler {
    /// Refuses widths and levels the unit has no wires for.
    ///
    /// # Errors
    /// The first setting out of range.
    pub fn check(&self) -> Result<(), SamplerError> {
        let rows = [
            ("filter_bits", i64::from(self.filter_bits), (1, 12)),
            ("lod_bits", i64::from(self.lod_bits), (0, 8)),
            ("max_anisotropy", i64::from(self.max_anisotropy), (1, 64)),
            ("brilinear_threshold", i64::from(self.brilinear_threshold), (0, 127)),
            ("bias", i64::from(self.bias), (-16 << 8, 16 << 8)),
            ("min_lod", i64::from(self.min_lod), (0, 32 << 8)),
            ("max_lod", i64::from(self.max_lod), (0, 32 << 8)),
        ];
        match rows.into_iter().find(|&(_, value, (low, high))| !(low..=high).contains(&value)) {
            Some((key, value, range)) => Err(SamplerError { key, value, range }),
            None => Ok(()),
        }
    }
}
