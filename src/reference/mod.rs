//! The unit of docs/numerics.md in real numbers: what the chip must answer, bit for bit.
//!
//! Written from that page and not from `hw/`, and in another language of thought: coordinates are turns, levels are levels
//! and weights sum to one, all held in f64 and quantised by `floor` where the page says so. Every number here is a dyadic
//! fraction of at most 53 bits, so f64 is exact throughout (the exceptions, logarithms and a Gaussian, are argued in `lod.rs`
//! and `probes.rs`). [`ideal`] is the same filters with nothing quantised; [`ewa`] the filter they are measured against;
//! [`sat`] the summed-area table, by adding texels up; [`front_end`] the conversion of floats to requests.

mod coordinate;
mod datapath;
pub mod ewa;
pub mod footprint;
pub mod front_end;
pub mod ideal;
mod jitter;
mod lod;
pub mod partial;
mod planes;
mod probes;
pub mod sat;
mod taps;
pub mod weights;

use texunit_hw::{Filter, I12F20, Request, Response, Rounding, Sampler};

use crate::{
    error::{Error, Result},
    pyramid::Pyramid,
};
pub use coordinate::Grid;
use lod::Limits;
use planes::Reading;
use probes::Aim;
use sat::Sat;
use taps::{Program, Settings};

/// The float model of one texture unit: a pyramid and a sampler.
///
/// ```
/// use texunit::{pyramid::{PlaneImage, Pyramid}, reference::Reference};
/// use texunit_hw::{I12F20, PyramidKind, Request, Sampler};
/// let plane = |lu, width, texels| PlaneImage { lu, lv: 0, width, height: 1, texels };
/// let pyramid = Pyramid {
///     kind: PyramidKind::Mipmap,
///     width: 2,
///     height: 1,
///     planes: vec![plane(0, 2, vec![[0; 4], [200; 4]]), plane(1, 1, vec![[100; 4]])],
/// };
/// let reference = Reference::new(&pyramid, &Sampler::default())?;
/// // A ratio of 1 texel per pixel, squared, is level 0; u = 0.75 is the centre of the second texel.
/// let request = Request { scale: [1.0_f32.to_bits(); 2], ..Request::at(I12F20::from_num(0.75), I12F20::ZERO) };
/// assert_eq!(reference.sample(&request).texel, [200; 4]);
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Reference<'a> {
    model: Model<'a>,
    sampler: Sampler,
}

#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "one of them a sampler; a box would cost every sample a load")]
enum Model<'a> {
    Taps(Program<'a>),
    SummedArea(Sat<'a>),
}

impl<'a> Reference<'a> {
    /// A unit that reads `pyramid` as `sampler` says.
    ///
    /// # Errors
    /// A setting out of range, or a pyramid without the planes the filter reads.
    pub fn new(pyramid: &'a Pyramid, sampler: &Sampler) -> Result<Self> {
        checked(sampler)?;
        if sampler.filter == Filter::Sat {
            return Ok(Self { model: Model::SummedArea(Sat::new(pyramid, sampler)?), sampler: *sampler });
        }
        let limits = Limits::new(
            lod::from_8_8(i32::from(sampler.bias)),
            lod::from_8_8(sampler.min_lod),
            lod::from_8_8(sampler.max_lod),
            Some(Grid::new(sampler.lod_bits)),
        );
        let reading = Reading { address: sampler.address, fractions: Some(Grid::new(sampler.filter_bits)) };
        let settings = Settings {
            filter: sampler.filter,
            level_rounding: sampler.level_rounding,
            max_anisotropy: sampler.max_anisotropy,
            brilinear_threshold: lod::from_8_8(sampler.brilinear_threshold.into()),
            limits,
            reading,
            weights: Some(Grid::new(8)),
            places: Some(Grid::new(20)),
        };
        Ok(Self { model: Model::Taps(Program::new(pyramid, settings)?), sampler: *sampler })
    }

    /// The answer to one request.
    #[must_use]
    pub fn sample(&self, request: &Request) -> Response {
        let program = match &self.model {
            Model::Taps(program) => program,
            Model::SummedArea(sat) => return sat.sample(request),
        };
        let at = [turns(request.u), turns(request.v)];
        let raw = |axis: usize| lod::raw(request.scale[axis], self.sampler.lod_source, self.sampler.log2);
        let aim = || Aim { axes: request.axes.map(|axis| axis.map(turns)), pixel: request.pixel };
        let (texel, levels) = program.run(at, raw, aim, |taps| match self.sampler.rounding {
            Rounding::Once => datapath::once(taps),
            Rounding::StagedRound => datapath::staged(taps, 0.5),
            Rounding::StagedTruncate => datapath::staged(taps, 0.0),
        });
        let reported = |level: f64| (level * lod::LEVEL) as u16;
        Response { texel, lod: [reported(levels[0]), reported(levels[1])] }
    }
}

/// A coordinate of a request.
fn turns(c: I12F20) -> f64 {
    f64::from(c.to_bits()) / coordinate::TURN
}

/// Refuses a sampler that no unit can be built for.
fn checked(sampler: &Sampler) -> Result<()> {
    sampler.check().map_err(|wrong| {
        Error::setting(
            wrong.key,
            wrong.value,
            "the unit has no wires for it",
            format!("give {} to {}", wrong.range.0, wrong.range.1),
        )
    })
}
