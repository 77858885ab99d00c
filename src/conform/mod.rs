//! Acceptance as a conformance suite does it: an answer is right if the promised precision allows it.
//!
//! A graphics API does not say which texel a sample must give; it promises so many bits of the sub-texel fraction and of the level
//! fraction. The lookup verifier of dEQP (VK-GL-CTS, `tcuTexLookupVerifier.cpp`) turns that into a set: the coordinate may lie anywhere
//! in an interval, so may the level, and every texel and weight these can select is a candidate. This is that idea, written from its
//! description, in f64 and sharing nothing with the chip or the reference, so that it can judge any machine: see [`Judge`].
//!
//! Where the suite steps through the intervals, this searches them: within one set of texels the filtered colour is linear in each
//! weight, so the ends of the intervals bound each channel exactly, and a descent finds a point that suits all channels at once.

mod blend;
mod interval;
pub mod largest;
pub mod scenes;
mod words;

use texunit_hw::{AddressMode, Filter, PyramidKind};

use self::{
    blend::{Blend, Miss, Patch, Search},
    interval::Interval,
};
use crate::{
    error::{Error, Result},
    pyramid::{PlaneImage, Pyramid},
};

/// What a machine promises, and how nearly its colour must be right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// Bits of the sub-texel fraction: coordinates in texels may be off by 2^-subtexel.
    pub subtexel: u8,
    /// Bits of the level fraction: levels may be off by 2^-mipmap.
    pub mipmap: u8,
    /// Bits of a normalised coordinate that count, from its highest: the suite takes 20 of the 24 a float has.
    pub coordinate: u8,
    /// How far a channel may lie from an allowed colour, in units of its last bit; one half is a right rounding.
    pub tolerance: f64,
}

impl Default for Precision {
    /// What Direct3D 11 promises: 8 and 8 bits.
    fn default() -> Self {
        Self { subtexel: 8, mipmap: 8, coordinate: 20, tolerance: 0.5 }
    }
}

/// The filters the rule is known for: what they may answer follows from coordinate and level alone.
pub const FILTERS: [Filter; 4] = [Filter::Point, Filter::Bilinear, Filter::NearestMip, Filter::Trilinear];

/// What is sampled, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// One of [`FILTERS`].
    pub filter: Filter,
    /// Address mode of u and of v.
    pub address: [AddressMode; 2],
    /// Added to the level, in levels.
    pub bias: f64,
    /// Smallest level.
    pub min_lod: f64,
    /// Largest level; wins over the smallest.
    pub max_lod: f64,
}

/// A question and the answer a machine gave to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Normalised coordinates.
    pub at: [f64; 2],
    /// Smallest and largest level that is right, before bias and limits; a filter of level 0 reads neither.
    pub level: [f64; 2],
    /// The answer.
    pub texel: [u8; 4],
}

/// Whether an answer is allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Some allowed coordinate and level give this colour.
    Allowed,
    /// None does.
    Refused {
        /// The channel that is farthest off, 0 red to 3 alpha.
        channel: usize,
        /// At least so far, in units of its last bit.
        off: f64,
    },
    /// Coordinates or levels so uncertain (or undefined) that there is nothing to check.
    Undecided,
}

/// Judges answers about one mipmap.
///
/// ```
/// use texunit::{conform::{Judge, Precision, Sample, Sampling, Verdict}, pyramid::{PlaneImage, Pyramid}};
/// use texunit_hw::{AddressMode, Filter, PyramidKind};
/// let top = PlaneImage::top(2, 1, vec![[0; 4], [255; 4]]);
/// let pyramid = Pyramid { kind: PyramidKind::Mipmap, width: 2, height: 1, planes: vec![top] };
/// let sampling = Sampling { filter: Filter::Bilinear, address: [AddressMode::Clamp; 2], bias: 0.0, min_lod: 0.0, max_lod: 32.0 };
/// let judge = Judge::new(&pyramid, sampling, Precision::default())?;
/// // Half way between the texels, give or take 1/256: 127.5, give or take 1.
/// let answer = |grey| Sample { at: [0.5, 0.5], level: [0.0; 2], texel: [grey; 4] };
/// assert_eq!(judge.verdict(&answer(126)), Verdict::Allowed);
/// assert!(matches!(judge.verdict(&answer(125)), Verdict::Refused { .. }));
/// assert!(judge.explain(&answer(125)).unwrap().contains("between texels 0 and 1"));
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Judge<'p> {
    /// By level.
    planes: Vec<&'p PlaneImage>,
    sampling: Sampling,
    precision: Precision,
}

/// What was found nearest to an answer.
enum Nearest {
    /// The answer itself.
    Found,
    /// Something else, on these levels.
    Miss(Miss, [usize; 2]),
    /// There is nothing to check.
    Undecided,
}

/// What the lengths of a search are limited to: beyond so many texels along an axis anything goes.
const MOST_CELLS: f64 = 8.0;

/// The f32 in which a squared ratio reaches the machine is no fault of the machine.
const LEVEL_SLACK: f64 = 1.0 / (1 << 20) as f64;

impl<'p> Judge<'p> {
    /// For a mipmap.
    ///
    /// # Errors
    /// Another pyramid, and filters that the rule says nothing about.
    pub fn new(pyramid: &'p Pyramid, sampling: Sampling, precision: Precision) -> Result<Self> {
        if pyramid.kind != PyramidKind::Mipmap || !FILTERS.contains(&sampling.filter) {
            return Err(unknown(sampling.filter));
        }
        let last = |size: u32| size.max(1).ilog2() as u8;
        let [last_u, last_v] = [last(pyramid.width), last(pyramid.height)];
        let planes = (0..=last_u.max(last_v)).map_while(|level| pyramid.plane(level.min(last_u), level.min(last_v)));
        Ok(Self { planes: planes.collect(), sampling, precision })
    }

    /// Whether an answer is allowed.
    #[must_use]
    pub fn verdict(&self, sample: &Sample) -> Verdict {
        match self.nearest(sample, Search::UntilHopeless) {
            Nearest::Found => Verdict::Allowed,
            Nearest::Miss(miss, _) => Verdict::Refused { channel: miss.channel, off: miss.off },
            Nearest::Undecided => Verdict::Undecided,
        }
    }

    /// Why an answer is refused, over several lines; none if it is not.
    #[must_use]
    pub fn explain(&self, sample: &Sample) -> Option<String> {
        match self.nearest(sample, Search::ToTheEnd) {
            Nearest::Miss(miss, levels) => Some(self.in_words(sample, &miss, levels)),
            Nearest::Found | Nearest::Undecided => None,
        }
    }

    fn nearest(&self, sample: &Sample, search: Search) -> Nearest {
        let Some(levels) = self.levels(sample) else { return Nearest::Undecided };
        let answer = sample.texel.map(f64::from);
        let steps = [self.precision.subtexel, self.precision.mipmap].map(|bits| exp2(bits.into()));
        let mut nearest = Nearest::Undecided;
        for (levels, blend) in levels {
            let Some(lower) = self.patches(sample, levels[0]) else { return Nearest::Undecided };
            // A filter of one level sees each of its patches alone.
            let upper = if levels[0] == levels[1] { Some(Vec::new()) } else { self.patches(sample, levels[1]) };
            let Some(upper) = upper else { return Nearest::Undecided };
            for patch in &lower {
                for other in 0..upper.len().max(1) {
                    let blend = Blend { patches: [*patch, *upper.get(other).unwrap_or(patch)], blend };
                    let Some(miss) = blend.miss(answer, self.precision.tolerance, steps, search) else {
                        return Nearest::Found;
                    };
                    if !matches!(&nearest, Nearest::Miss(known, _) if known.off <= miss.off) {
                        nearest = Nearest::Miss(miss, levels);
                    }
                }
            }
        }
        nearest
    }

    /// Every pair of levels there can be, and how far from the first to the second.
    fn levels(&self, sample: &Sample) -> Option<Vec<([usize; 2], Interval)>> {
        let Sampling { filter, bias, min_lod, max_lod, .. } = self.sampling;
        let last = (self.planes.len() - 1) as f64;
        if !filter.uses_level() {
            return Some(vec![([0; 2], Interval::ZERO)]);
        }
        let [low, high] = sample.level;
        if low.is_nan() || high.is_nan() {
            return None;
        }
        let slack = exp2(-i32::from(self.precision.mipmap)) + LEVEL_SLACK;
        let limit = |level: f64| (level + bias).max(min_lod.max(0.0)).min(max_lod.min(last));
        let allowed = Interval { low: limit(low - slack), high: limit(high + slack) };
        if filter == Filter::NearestMip {
            // Both answers are right half way: OpenGL takes the sharper, Direct3D the blurrier.
            let whole = ((allowed.low + 0.5).ceil() - 1.0).max(0.0) as usize..=(allowed.high + 0.5).floor() as usize;
            return Some(whole.map(|level| ([level.min(self.planes.len() - 1); 2], Interval::ZERO)).collect());
        }
        let pairs = allowed.low.floor() as usize..=allowed.high.floor() as usize;
        Some(
            pairs
                .map(|level| ([level, (level + 1).min(self.planes.len() - 1)], allowed.within(level as f64)))
                .collect(),
        )
    }

    /// Every set of texels there can be on a level; none if there are too many.
    fn patches(&self, sample: &Sample, level: usize) -> Option<Vec<Patch>> {
        let plane = self.planes[level];
        let [across, down] =
            [(0, plane.width), (1, plane.height)].map(|(axis, size)| self.texels(sample.at[axis], size));
        let [across, down] = [across?, down?];
        let cells = |interval: Interval| interval.low.floor() as i64..=interval.high.floor() as i64;
        let point = self.sampling.filter == Filter::Point;
        let mut patches = Vec::new();
        for j in cells(down) {
            for i in cells(across) {
                let reach = if point { [0, 0, 0, 0] } else { [0, 1, 2, 3] };
                let corners = reach.map(|corner| self.texel(plane, i + (corner & 1), j + (corner >> 1)));
                let within =
                    |interval: Interval, cell: i64| if point { Interval::ZERO } else { interval.within(cell as f64) };
                patches.push(Patch { corners, weights: [within(across, i), within(down, j)] });
            }
        }
        Some(patches)
    }

    /// Where a coordinate may lie on an axis of `size` texels, in texels: from the corner of the first for a point, from its centre
    /// for the filters between texels.
    fn texels(&self, coordinate: f64, size: u32) -> Option<Interval> {
        if !coordinate.is_finite() {
            return None;
        }
        let size = f64::from(size);
        let exponent = if coordinate == 0.0 { -1022 } else { libm::ilogb(coordinate) };
        let slack =
            exp2(exponent - i32::from(self.precision.coordinate)) * size + exp2(-i32::from(self.precision.subtexel));
        let centre = coordinate * size - if self.sampling.filter == Filter::Point { 0.0 } else { 0.5 };
        let interval = Interval { low: centre - slack, high: centre + slack };
        (slack < MOST_CELLS / 2.0).then_some(interval)
    }

    /// The texel of an index, as its address mode says; transparent black outside.
    fn texel(&self, plane: &PlaneImage, i: i64, j: i64) -> [f64; 4] {
        let [u, v] = self.sampling.address;
        match (addressed(i, plane.width, u), addressed(j, plane.height, v)) {
            (Some(i), Some(j)) => plane.texels[j * plane.width as usize + i].map(f64::from),
            _ => [0.0; 4],
        }
    }
}

/// The texel an index stands for.
fn addressed(index: i64, size: u32, mode: AddressMode) -> Option<usize> {
    let size = i64::from(size);
    let inside = match mode {
        AddressMode::Wrap => index.rem_euclid(size),
        AddressMode::Mirror => {
            let there_and_back = index.rem_euclid(2 * size);
            there_and_back.min(2 * size - 1 - there_and_back)
        }
        AddressMode::Clamp => index.clamp(0, size - 1),
        AddressMode::Clip if (0..size).contains(&index) => index,
        AddressMode::Clip => return None,
    };
    usize::try_from(inside).ok()
}

fn exp2(exponent: i32) -> f64 {
    libm::scalbn(1.0, exponent)
}

/// For a filter that is none of [`FILTERS`].
pub(crate) fn unknown(filter: Filter) -> Error {
    use crate::names::Named;
    let remedy = "use point, bilinear, nearest-mip or trilinear: no API promises bits for the others";
    Error::setting("--filters", filter.name(), "not a filter a conformance suite has a rule for", remedy)
}
