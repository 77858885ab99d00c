//! The filters themselves: real coordinates, real levels, real weights, no rounding anywhere. What a chip with unlimited
//! widths would answer, so that the cost of every width can be measured against it.

use texunit_hw::{AddressMode, Filter, LevelRounding, Sampler};

use super::{
    datapath,
    footprint::Footprint,
    lod::{self, Limits},
    planes::Reading,
    probes::Aim,
    sat::Sat,
    taps::{Program, Settings},
};
use crate::{error::Result, pyramid::Pyramid};

/// Sampler state without widths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdealSampler {
    /// The tap program.
    pub filter: Filter,
    /// Address mode of the u and of the v axis.
    pub address: [AddressMode; 2],
    /// How filters of one whole level round it.
    pub level_rounding: LevelRounding,
    /// Most probes of an anisotropic filter a level, at least 1.
    pub max_anisotropy: u8,
    /// Brilinear takes one level where the fraction is this close to it, in levels, less than one half.
    pub brilinear_threshold: f64,
    /// Added to the level before clamping, in levels.
    pub bias: f64,
    /// Smallest level.
    pub min_lod: f64,
    /// Largest level; wins over the smallest.
    pub max_lod: f64,
}

impl From<&Sampler> for IdealSampler {
    fn from(sampler: &Sampler) -> Self {
        Self {
            filter: sampler.filter,
            address: sampler.address,
            level_rounding: sampler.level_rounding,
            max_anisotropy: sampler.max_anisotropy,
            brilinear_threshold: lod::from_8_8(sampler.brilinear_threshold.into()),
            bias: lod::from_8_8(i32::from(sampler.bias)),
            min_lod: lod::from_8_8(sampler.min_lod),
            max_lod: lod::from_8_8(sampler.max_lod),
        }
    }
}

/// What selects the level: of the only scale or of the u axis, and of the v axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Detail {
    /// Levels, 0 the texture itself. Not a number means the finest.
    Level([f64; 2]),
    /// Texels of level 0 per pixel, squared; signs are ignored. Not a number means the coarsest, as on the chip.
    SquaredRatio([f64; 2]),
    /// The same with directions, which anisotropic filters look along; given one of the others, all their probes fall on
    /// one place.
    Footprint(Footprint),
}

impl Detail {
    pub(super) fn level(self, axis: usize) -> f64 {
        match self {
            Self::Level(levels) => levels[axis],
            Self::SquaredRatio(squared) | Self::Footprint(Footprint { squared, .. }) if squared[axis].is_nan() => {
                f64::INFINITY
            }
            Self::SquaredRatio(squared) | Self::Footprint(Footprint { squared, .. }) => {
                libm::log2(squared[axis].abs()) / 2.0
            }
        }
    }

    pub(super) fn aim(self) -> Aim {
        match self {
            Self::Level(_) | Self::SquaredRatio(_) => Aim::default(),
            Self::Footprint(Footprint { axes, pixel, .. }) => Aim {
                axes: axes.map(|axis| axis.map(|c| if c.is_nan() { 0.0 } else { c.clamp(-FURTHEST, FURTHEST) })),
                pixel,
            },
        }
    }
}

/// A filtered texel before anything is rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdealResponse {
    /// Red, green, blue, alpha, each 0.0 to 255.0.
    pub texel: [f64; 4],
    /// Levels used: of the u axis (or the only one), and of the v axis (or the same).
    pub lod: [f64; 2],
}

/// A texture unit without quantisation.
///
/// ```
/// use texunit::{pyramid::{PlaneImage, Pyramid}, reference::ideal::{Detail, Ideal, IdealSampler}};
/// use texunit_hw::{Filter, PyramidKind, Sampler};
/// let plane = PlaneImage { lu: 0, lv: 0, width: 2, height: 1, texels: vec![[0; 4], [90; 4]] };
/// let pyramid = Pyramid { kind: PyramidKind::Mipmap, width: 2, height: 1, planes: vec![plane] };
/// let sampler = Sampler { filter: Filter::Bilinear, ..Sampler::default() };
/// let ideal = Ideal::new(&pyramid, IdealSampler::from(&sampler))?;
/// // A third of the way from the first texel centre (0.25) to the second (0.75).
/// let response = ideal.sample([0.25 + 0.5 / 3.0, 0.5], Detail::Level([0.0; 2]));
/// assert!((response.texel[0] - 30.0).abs() < 1e-9);
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ideal<'a> {
    model: Model<'a>,
    address: [AddressMode; 2],
}

#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "one of them a sampler; a box would cost every sample a load")]
enum Model<'a> {
    Taps(Program<'a>),
    SummedArea(Sat<'a>),
}

impl<'a> Ideal<'a> {
    /// A unit that reads `pyramid` as `sampler` says.
    ///
    /// # Errors
    /// A pyramid without the planes the filter reads.
    pub fn new(pyramid: &'a Pyramid, sampler: IdealSampler) -> Result<Self> {
        if sampler.filter == Filter::Sat {
            let model = Model::SummedArea(Sat::unlimited(pyramid, sampler.address)?);
            return Ok(Self { model, address: sampler.address });
        }
        let limits = Limits::new(sampler.bias, sampler.min_lod, sampler.max_lod, None);
        let reading = Reading { address: sampler.address, fractions: None };
        let settings = Settings {
            filter: sampler.filter,
            level_rounding: sampler.level_rounding,
            max_anisotropy: sampler.max_anisotropy,
            brilinear_threshold: sampler.brilinear_threshold,
            limits,
            reading,
            weights: None,
            places: None,
        };
        Ok(Self { model: Model::Taps(Program::new(pyramid, settings)?), address: sampler.address })
    }

    /// Samples at normalised (u, v). Values that are no coordinate are read as the chip reads them (section 1.1).
    #[must_use]
    pub fn sample(&self, at: [f64; 2], detail: Detail) -> IdealResponse {
        let at = [0, 1].map(|axis| defined(at[axis], self.address[axis]));
        let program = match &self.model {
            Model::Taps(program) => program,
            Model::SummedArea(sat) => {
                return IdealResponse { texel: sat.ideal(at, detail.aim().axes), lod: [0.0; 2] };
            }
        };
        let (texel, lod) = program.run(at, |axis| detail.level(axis), || detail.aim(), datapath::sum);
        IdealResponse { texel, lod }
    }
}

/// The range of a 12.20 coordinate: beyond it clamp and clip give the same answer as at its end.
pub(super) const FURTHEST: f64 = 2048.0;

/// A coordinate that every mode has texels for.
pub(super) fn defined(c: f64, mode: AddressMode) -> f64 {
    match mode {
        _ if c.is_nan() => 0.0,
        AddressMode::Wrap | AddressMode::Mirror if c.is_infinite() => 0.0,
        AddressMode::Wrap | AddressMode::Mirror => libm::fmod(c, 2.0), // exact, and a period of both
        AddressMode::Clamp | AddressMode::Clip => c.clamp(-FURTHEST, FURTHEST),
    }
}
