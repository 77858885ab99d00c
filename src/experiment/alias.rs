//! Alias energy: what is left, after filtering, of detail that a pixel cannot show.
//!
//! White noise should become the flatter the larger the footprint; stripes two texels wide should vanish altogether. Both are
//! sampled at random places with the same minification along both axes, a whole level, so that no rounding of levels is in
//! the numbers.

use texunit_hw::{AddressMode, Filter, LodSource, Response, Unit};

use super::verify::SplitMix;
use crate::{
    error::{Error, Result},
    front_end::FrontEnd,
    machine::Machine,
    pyramid::PlaneImage,
    scene::{Fragment, Gradient},
    texture_memory::Held,
};

/// Side of the textures, texels.
const SIDE: u32 = 512;
/// Places sampled.
const SAMPLES: usize = 1 << 14;

/// Mean square of what a filter leaves around the middle grey, in squared units of an 8-bit channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residue {
    /// Of white noise.
    pub noise: f64,
    /// Of columns alternately black and white.
    pub stripes: f64,
    /// Largest deviation the stripes leave.
    pub stripes_worst: f64,
}

/// The residue of a filter at a minification of `scale` along both axes.
///
/// # Errors
/// A machine that cannot be built.
pub fn residue(machine: &Machine, filter: Filter, scale: f64) -> Result<Residue> {
    let mut random = SplitMix(1);
    let grey = |value: u8| [value, value, value, 255];
    let noise = (0..SIDE * SIDE).map(|_| grey(random.draw() as u8)).collect();
    let stripes = (0..SIDE * SIDE).map(|texel| grey(if texel % 2 == 0 { 0 } else { 255 })).collect();
    let noise = deviations(machine, filter, scale, noise)?;
    let stripes = deviations(machine, filter, scale, stripes)?;
    let mean_square = |deviations: &[f64]| deviations.iter().map(|d| d * d).sum::<f64>() / deviations.len() as f64;
    let mean = noise.iter().sum::<f64>() / noise.len() as f64;
    Ok(Residue {
        noise: mean_square(&noise.iter().map(|deviation| deviation - mean).collect::<Vec<_>>()),
        stripes: mean_square(&stripes),
        stripes_worst: stripes.iter().fold(0.0, |worst, deviation| worst.max(deviation.abs())),
    })
}

/// How far each answer is from the middle grey.
fn deviations(machine: &Machine, filter: Filter, scale: f64, texels: Vec<[u8; 4]>) -> Result<Vec<f64>> {
    let texture = PlaneImage::top(SIDE, SIDE, texels).into();
    let Held { memory, .. } = machine.texture.hold(filter.pyramid(), &texture)?;
    let address = [AddressMode::Wrap; 2];
    let front_end = FrontEnd::new(machine, filter, address, [SIDE; 2]);
    let step = scale / f64::from(SIDE);
    let gradient = Gradient { ux: step, vy: step, ..Gradient::default() };
    let mut random = SplitMix(2);
    let requests: Vec<_> = (0..SAMPLES)
        .map(|number| {
            let [u, v] = [0, 0].map(|_: u8| (random.draw() >> 11) as f64 / (1u64 << 53) as f64);
            front_end.request(&Fragment { x: (number % 128) as u16, y: (number / 128) as u16, u, v, gradient }).0
        })
        .collect();
    let sampler = machine.sampler(filter, address, LodSource::Gradient);
    let mut unit = Unit::new(&sampler, &memory.surface, &memory.bytes)
        .map_err(|error| Error::setting("machine", &machine.name, error.to_string(), "change the machine"))?;
    let mut responses = vec![Response::default(); requests.len()];
    unit.run(&requests, &mut responses, &mut ());
    Ok(responses.iter().map(|response| f64::from(response.texel[0]) - 127.5).collect())
}
