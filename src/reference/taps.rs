//! The tap programs (docs/numerics.md, section 5).

use texunit_hw::{Filter, LevelRounding};

use super::{
    coordinate::{Grid, floor, floored},
    datapath::Tap,
    lod::Limits,
    planes::{Plane, Planes, Reading},
    probes::{Aim, Probes},
};
use crate::{error::Result, pyramid::Pyramid};

/// What chooses among the planes of a pyramid.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The tap program.
    pub filter: Filter,
    /// How filters of one whole level round it.
    pub level_rounding: LevelRounding,
    /// Most probes a level.
    pub max_anisotropy: u8,
    /// Brilinear takes one level where the fraction is this close to it, in levels.
    pub brilinear_threshold: f64,
    /// Comes without the coarsest level, which is that of the pyramid.
    pub limits: Limits,
    /// How a plane is read.
    pub reading: Reading,
    /// The weights there are; none for the real numbers.
    pub weights: Option<Grid>,
    /// The places there are within a repeat of the texture, in turns; none for the real numbers.
    pub places: Option<Grid>,
}

/// The tap programs of section 5, for a pyramid and the settings that choose among its planes.
#[derive(Clone, Debug)]
pub struct Program<'a> {
    planes: Planes<'a>,
    settings: Settings,
    limits: [Limits; 2],
    probes: Probes,
}

impl<'a> Program<'a> {
    /// # Errors
    /// A pyramid without the planes the filter reads.
    pub fn new(pyramid: &'a Pyramid, settings: Settings) -> Result<Self> {
        let planes = Planes::new(pyramid, settings.filter)?;
        let limits = [0, 1].map(|axis| Limits { coarsest: planes.coarsest(axis), ..settings.limits });
        let probes = Probes::new(settings.filter, settings.max_anisotropy, settings.weights, settings.places);
        Ok(Self { planes, settings, limits, probes })
    }

    /// Reads the taps of a request at a coordinate in turns. `raw` is the level of an axis before bias and limits; `aim` is
    /// asked for by filters that look along it; `weigh` makes a texel of the taps. Returns that texel and the levels used.
    #[inline]
    pub fn run<T>(
        &self,
        at: [f64; 2],
        raw: impl Fn(usize) -> f64,
        aim: impl FnOnce() -> Aim,
        weigh: impl Fn(&[Tap]) -> T,
    ) -> (T, [f64; 2]) {
        let reading = &self.settings.reading;
        let base = &self.planes.along_u[0];
        let along_u = |level: f64| &self.planes.along_u[level as usize];
        let along_v = |level: f64| &self.planes.along_v[level as usize];
        let tap = |plane: &Plane<'_>, weight| plane.bilinear(at, reading, weight);
        match self.settings.filter {
            Filter::Point => (weigh(&[base.point(at, reading)]), [0.0; 2]),
            Filter::Bilinear => (weigh(&[tap(base, 1.0)]), [0.0; 2]),
            Filter::NearestMip => {
                let level = self.limits[0].whole_level(raw(0), self.settings.level_rounding);
                (weigh(&[tap(along_u(level), 1.0)]), [level; 2])
            }
            Filter::Trilinear => {
                let [level, coarser, blur] = self.pair(0, self.limits[0].fractional(raw(0)));
                (weigh(&[tap(along_u(level), 1.0 - blur), tap(along_u(coarser), blur)]), [level + blur; 2])
            }
            Filter::Brilinear => {
                let [level, blur] = self.brilinear(self.limits[0].fractional(raw(0)));
                let texel = if blur > 0.0 {
                    weigh(&[tap(along_u(level), 1.0 - blur), tap(along_u(level + 1.0), blur)])
                } else {
                    weigh(&[tap(along_u(level), 1.0)])
                };
                (texel, [level + blur; 2])
            }
            Filter::MipDouble | Filter::Dipmap => {
                let levels = [0, 1].map(|axis| floor(self.limits[axis].clamp(raw(axis))));
                (weigh(&[tap(along_u(levels[0]), 0.5), tap(along_v(levels[1]), 0.5)]), levels)
            }
            Filter::DipmapTrilinear => {
                let lods = [0, 1].map(|axis| self.limits[axis].fractional(raw(axis)));
                let [column, coarser_column, blur_u] = self.pair(0, lods[0]);
                let [row, coarser_row, blur_v] = self.pair(1, lods[1]);
                let texel = weigh(&[
                    tap(along_u(column), (1.0 - blur_u) / 2.0),
                    tap(along_u(coarser_column), blur_u / 2.0),
                    tap(along_v(row), (1.0 - blur_v) / 2.0),
                    tap(along_v(coarser_row), blur_v / 2.0),
                ]);
                (texel, lods)
            }
            Filter::Ripmap => {
                let lods = [0, 1].map(|axis| self.limits[axis].fractional(raw(axis)));
                let [lu, coarser_u, blur_u] = self.pair(0, lods[0]);
                let [lv, coarser_v, blur_v] = self.pair(1, lods[1]);
                let cell = |lu, lv, weight| tap(self.planes.cell(lu, lv), weight);
                let texel = weigh(&[
                    cell(lu, lv, (1.0 - blur_u) * (1.0 - blur_v)),
                    cell(coarser_u, lv, blur_u * (1.0 - blur_v)),
                    cell(lu, coarser_v, (1.0 - blur_u) * blur_v),
                    cell(coarser_u, coarser_v, blur_u * blur_v),
                ]);
                (texel, lods)
            }
            Filter::Sat => unreachable!("a summed-area table has no taps"),
            Filter::Texram | Filter::Feline | Filter::Fast => {
                let axes = self.probes.axes([raw(0), raw(1)]);
                let lod = self.limits[0].fractional(axes.level);
                let pair = self.pair(0, lod);
                let mut taps = Vec::with_capacity(2 * usize::from(self.settings.max_anisotropy));
                self.probes.for_each(at, axes, &aim(), pair, |probe| {
                    taps.push(along_u(probe.level).bilinear(probe.at, reading, probe.weight));
                });
                (weigh(&taps), [lod; 2])
            }
        }
    }

    /// The level, the next coarser one there is, and the way from the one to the other.
    #[inline]
    fn pair(&self, axis: usize, lod: f64) -> [f64; 3] {
        let level = floor(lod);
        [level, (level + 1.0).min(self.limits[axis].coarsest), lod - level]
    }

    /// The level and the way to the next, with the threshold cut off at both ends and the rest stretched.
    fn brilinear(&self, lod: f64) -> [f64; 2] {
        let threshold = self.settings.brilinear_threshold;
        let level = floor(lod);
        let blur = lod - level;
        if blur <= threshold {
            [level, 0.0]
        } else if blur >= 1.0 - threshold {
            [level + 1.0, 0.0]
        } else {
            [level, floored(self.settings.weights, (blur - threshold) / (1.0 - 2.0 * threshold))]
        }
    }
}
