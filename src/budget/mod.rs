//! The error budget: how much of a sample's error comes from the coordinate, the fraction, the level, the texels and the rounding.
//!
//! One quantisation is turned on after the other, from the ideal filter on unrounded planes to the chip itself. The steps of a sample
//! add up to its error exactly, whatever their order; what a step is worth depends on the order a little, and how much is said by
//! each quantisation alone beside it.

mod unrounded;

use rayon::prelude::*;
use serde::Serialize;
use texunit_hw::{AddressMode, FILTERS, Filter, LodSource, Response, Sampler, Unit};

use crate::{
    error::{Error, Result},
    experiment::Pyramids,
    front_end::FrontEnd,
    machine::Machine,
    names::Named,
    pyramid::Pyramid,
    reference::partial::{Partial, Place, Widths},
    scene::{Fragment, Scene},
};
use unrounded::Unrounded;

/// The quantisations, in the order they are turned on.
pub const PARTS: [&str; 5] = ["coordinate", "fraction", "lod", "texel", "rounding"];

/// The filters whose error has these parts: all that read texels.
pub fn filters() -> impl Iterator<Item = Filter> {
    FILTERS.into_iter().filter(|filter| *filter != Filter::Sat)
}

/// Red, green and blue are counted.
const CHANNELS: usize = 3;

/// One channel of one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steps {
    /// The ideal, then with each quantisation more; the last is the chip's answer.
    pub values: [f64; 6],
    /// What each quantisation does to the ideal alone.
    pub alone: [f64; 5],
}

impl Steps {
    /// What each quantisation did, in order.
    #[must_use]
    pub fn parts(&self) -> [f64; 5] {
        std::array::from_fn(|part| self.values[part + 1] - self.values[part])
    }

    /// The whole error.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.values[5] - self.values[0]
    }
}

/// Statistics of an error, in LSB.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Its mean: how much brighter.
    pub mean: f64,
    /// Root of its mean square.
    pub rms: f64,
    /// Its largest magnitude.
    pub worst: f64,
}

/// One quantisation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Part {
    /// Which.
    pub name: &'static str,
    /// Its part of the RMS error: mean of (part x total) / RMS of the total. These add up to the RMS; one that undoes others is negative.
    pub share: f64,
    /// Turned on after those before it.
    pub in_order: Spread,
    /// Turned on alone.
    pub alone: Spread,
}

/// The budget of a filter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Budget {
    /// The filter.
    pub filter: &'static str,
    /// Samples, three channels each.
    pub samples: usize,
    /// The chip against the ideal.
    pub total: Spread,
    /// Where it comes from.
    pub parts: [Part; 5],
    /// What the quantisations alone do not explain: the total less the sum of all five alone.
    pub interaction: Spread,
    /// The largest difference between the total of a sample and the sum of its parts in order: that of f64 additions.
    pub residue: f64,
}

/// A scene with what its budget needs.
#[derive(Debug)]
pub struct Ledger<'m> {
    machine: &'m Machine,
    pyramids: Pyramids,
    unrounded: Vec<Unrounded>,
    fragments: Vec<Fragment>,
    address: [AddressMode; 2],
    size: [u32; 2],
    polygon_level: Option<u8>,
}

impl<'m> Ledger<'m> {
    /// Takes `samples` fragments of a scene, evenly, and makes the pyramids of some filters, rounded and not.
    ///
    /// # Errors
    /// A filter or texture whose error has no such parts, a pyramid that cannot be made.
    pub fn new(machine: &'m Machine, scene: &Scene, filters: &[Filter], samples: usize) -> Result<Self> {
        if filters.contains(&Filter::Sat) {
            let problem =
                "a summed-area table has neither fractions nor levels to turn on: its boxes end at texel borders";
            return Err(Error::setting("--filters", "sat", problem, "leave it out; `texunit run` shows its error"));
        }
        if machine.texture.srgb {
            let problem = "planes of sRGB codes are averaged as codes, so there are no unrounded ones to compare with";
            return Err(Error::setting("texture.srgb", true, problem, "use --set texture.srgb=false"));
        }
        let texture = scene.texture.texture_image();
        let pyramids = Pyramids::for_filters(machine, &texture, filters)?;
        let mut unrounded: Vec<Unrounded> = Vec::new();
        for kind in filters.iter().map(|filter| filter.pyramid()) {
            if unrounded.iter().all(|known| known.kind() != kind) {
                unrounded.push(Unrounded::new(&machine.texture.pyramid, kind, &texture.top)?);
            }
        }
        let all: Vec<Fragment> = scene.fragments().collect();
        let count = samples.min(all.len());
        let fragments = (0..count).map(|number| all[number * all.len() / count]).collect();
        let (address, size) = (scene.texture.wrap, scene.texture.size());
        // All pixels count for a level they share, not only the samples.
        let shape = FrontEnd::new(machine, Filter::Trilinear, address, size).of_shape(machine, |seen| seen.add(&all));
        Ok(Self { machine, pyramids, unrounded, fragments, address, size, polygon_level: shape.polygon_level })
    }

    /// The steps of every sample, channel by channel.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn steps(&self, filter: Filter) -> Result<Vec<Steps>> {
        let (pyramid, memory) = self.pyramids.of(filter);
        let sampler = self.machine.sampler(filter, self.address, LodSource::Gradient);
        let front_end = FrontEnd {
            polygon_level: self.polygon_level,
            ..FrontEnd::new(self.machine, filter, self.address, self.size)
        };
        let (requests, _) = front_end.requests(&self.fragments);
        let mut responses = vec![Response::default(); requests.len()];
        Unit::new(&sampler, &memory.surface, &memory.bytes)
            .map_err(|error| Error::setting("machine", &self.machine.name, error.to_string(), "change the machine"))?
            .run(&requests, &mut responses, &mut ());
        let unrounded =
            self.unrounded.iter().find(|known| known.kind() == filter.pyramid()).expect("made for this filter");
        let models = Models::new(pyramid, unrounded, &sampler)?;
        let samples = self.fragments.par_iter().zip(&requests).zip(&responses);
        let steps: Vec<[Steps; CHANNELS]> = samples
            .map(|((fragment, request), response)| {
                let at = [fragment.u, fragment.v];
                models.steps(Place { at, detail: front_end.ideal_detail(fragment), request }, response)
            })
            .collect();
        Ok(steps.into_flattened())
    }

    /// The budget of a filter.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn budget(&self, filter: Filter) -> Result<Budget> {
        let steps = self.steps(filter)?;
        let total = spread(steps.iter().map(Steps::total));
        let part = |part: usize| {
            let along = steps.iter().map(|steps| steps.parts()[part] * steps.total()).sum::<f64>();
            Part {
                name: PARTS[part],
                share: if total.rms > 0.0 { along / steps.len() as f64 / total.rms } else { 0.0 },
                in_order: spread(steps.iter().map(|steps| steps.parts()[part])),
                alone: spread(steps.iter().map(|steps| steps.alone[part])),
            }
        };
        let residue = |steps: &Steps| (steps.total() - steps.parts().iter().sum::<f64>()).abs();
        Ok(Budget {
            filter: filter.name(),
            samples: self.fragments.len(),
            total,
            parts: [0, 1, 2, 3, 4].map(part),
            interaction: spread(steps.iter().map(|steps| steps.total() - steps.alone.iter().sum::<f64>())),
            residue: steps.iter().map(residue).fold(0.0, f64::max),
        })
    }
}

fn spread(errors: impl Iterator<Item = f64>) -> Spread {
    let (mut count, mut sum, mut squares, mut worst) = (0.0, 0.0, 0.0, 0.0f64);
    for error in errors {
        count += 1.0;
        sum += error;
        squares += error * error;
        worst = worst.max(error.abs());
    }
    let count = f64::max(count, 1.0);
    Spread { mean: sum / count, rms: libm::sqrt(squares / count), worst }
}

/// The float models between the ideal and the chip.
struct Models<'p> {
    /// On unrounded planes: nothing; coordinate; and fraction; and level. Four models each, one a channel.
    in_order: [Vec<Partial<'p>>; 4],
    /// On unrounded planes: the fraction, the level alone.
    fraction: Vec<Partial<'p>>,
    level: Vec<Partial<'p>>,
    /// On the planes as they are stored: all three, none.
    stored: Partial<'p>,
    stored_alone: Partial<'p>,
}

impl<'p> Models<'p> {
    fn new(pyramid: &'p Pyramid, unrounded: &'p Unrounded, sampler: &Sampler) -> Result<Self> {
        let [none, all] = [false, true].map(|on| Widths { coordinate: on, fraction: on, level: on });
        let coordinate = Widths { coordinate: true, ..none };
        let of = |widths| {
            unrounded.channels().map(|channel| Partial::new(channel, sampler, widths)).collect::<Result<Vec<_>>>()
        };
        Ok(Self {
            in_order: [of(none)?, of(coordinate)?, of(Widths { fraction: true, ..coordinate })?, of(all)?],
            fraction: of(Widths { fraction: true, ..none })?,
            level: of(Widths { level: true, ..none })?,
            stored: Partial::new(pyramid, sampler, all)?,
            stored_alone: Partial::new(pyramid, sampler, none)?,
        })
    }

    fn steps(&self, place: Place<'_>, chip: &Response) -> [Steps; CHANNELS] {
        let exact = |models: &[Partial<'p>], channel: usize| unrounded::value(models[channel].sum(place));
        let (stored, stored_alone) = (self.stored.sum(place), self.stored_alone.sum(place));
        let rounded_alone = self.stored_alone.rounded(place);
        std::array::from_fn(|channel| {
            let [ideal, one, two, three] = [0, 1, 2, 3].map(|step| exact(&self.in_order[step], channel));
            Steps {
                values: [ideal, one, two, three, stored[channel], f64::from(chip.texel[channel])],
                alone: [
                    one - ideal,
                    exact(&self.fraction, channel) - ideal,
                    exact(&self.level, channel) - ideal,
                    stored_alone[channel] - ideal,
                    // Roundings in stages are of stored texels: alone means without the other widths.
                    f64::from(rounded_alone[channel]) - stored_alone[channel],
                ],
            }
        })
    }
}
