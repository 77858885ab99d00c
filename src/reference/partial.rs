//! The unit with some of its widths and not the others: between [`Ideal`](super::ideal::Ideal), which has none, and
//! [`Reference`](super::Reference), which has all. For the error budget.

use texunit_hw::{Request, Rounding, Sampler};

use super::{
    checked,
    coordinate::Grid,
    datapath::{self, Tap},
    ideal::{Detail, IdealSampler, defined},
    lod::{self, Limits},
    planes::Reading,
    probes::Aim,
    taps::{Program, Settings},
    turns,
};
use crate::{error::Result, pyramid::Pyramid};

/// Which widths there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Widths {
    /// Coordinates, footprint axes and places of probes in 12.20.
    pub coordinate: bool,
    /// Fractions between texels of the filter's bits, weights of probes (and brilinear's) of 8.
    pub fraction: bool,
    /// The log2 unit, and level fractions of the machine's bits.
    pub level: bool,
}

/// A unit with some widths.
#[derive(Clone, Debug)]
pub struct Partial<'a> {
    program: Program<'a>,
    sampler: Sampler,
    widths: Widths,
}

/// What is sampled, in floats and as the request the front end made of it.
#[derive(Clone, Copy, Debug)]
pub struct Place<'r> {
    /// Normalised (u, v).
    pub at: [f64; 2],
    /// What selects the level.
    pub detail: Detail,
    /// The same as integers.
    pub request: &'r Request,
}

impl<'a> Partial<'a> {
    /// A unit that reads `pyramid` as `sampler` says; not a summed-area table.
    ///
    /// # Errors
    /// A setting out of range, or a pyramid without the planes the filter reads.
    pub fn new(pyramid: &'a Pyramid, sampler: &Sampler, widths: Widths) -> Result<Self> {
        checked(sampler)?;
        let grid = |wanted: bool, bits: u8| wanted.then(|| Grid::new(bits));
        let ideal = IdealSampler::from(sampler);
        let limits = Limits::new(ideal.bias, ideal.min_lod, ideal.max_lod, grid(widths.level, sampler.lod_bits));
        let settings = Settings {
            filter: sampler.filter,
            level_rounding: sampler.level_rounding,
            max_anisotropy: sampler.max_anisotropy,
            brilinear_threshold: ideal.brilinear_threshold,
            limits,
            reading: Reading { address: sampler.address, fractions: grid(widths.fraction, sampler.filter_bits) },
            weights: grid(widths.fraction, 8),
            places: grid(widths.coordinate, 20),
        };
        Ok(Self { program: Program::new(pyramid, settings)?, sampler: *sampler, widths })
    }

    /// The weighted sum, not rounded.
    #[must_use]
    pub fn sum(&self, place: Place<'_>) -> [f64; 4] {
        self.run(place, datapath::sum)
    }

    /// The answer as the datapath rounds it.
    #[must_use]
    pub fn rounded(&self, place: Place<'_>) -> [u8; 4] {
        self.run(place, |taps| match self.sampler.rounding {
            Rounding::Once => datapath::once(taps),
            Rounding::StagedRound => datapath::staged(taps, 0.5),
            Rounding::StagedTruncate => datapath::staged(taps, 0.0),
        })
    }

    fn run<T>(&self, Place { at, detail, request }: Place<'_>, weigh: impl Fn(&[Tap]) -> T) -> T {
        let Sampler { address, lod_source, log2, .. } = self.sampler;
        let (at, aim) = if self.widths.coordinate {
            let axes = request.axes.map(|axis| axis.map(turns));
            ([turns(request.u), turns(request.v)], Aim { axes, pixel: request.pixel })
        } else {
            ([0, 1].map(|axis| defined(at[axis], address[axis])), detail.aim())
        };
        let raw = |axis: usize| {
            if self.widths.level { lod::raw(request.scale[axis], lod_source, log2) } else { detail.level(axis) }
        };
        self.program.run(at, raw, || aim, weigh).0
    }
}
