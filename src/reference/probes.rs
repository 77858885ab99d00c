//! Where the anisotropic filters look, how often and with what weight (docs/numerics.md, section 5.2).
//!
//! # Why the logarithms and exponentials are safe in f64
//!
//! A threshold `256 log2 x` with `x` a ratio of small integers is an integer when `x` is a power of two, which `libm::log2`
//! hits exactly, and irrational otherwise. The test `no_table_entry_hangs_on_the_error_of_a_logarithm` measures that none of
//! the others is as near to an integer (or, where one rounds, to a half) as the error, and the same of Feline's weights.

use texunit_hw::Filter;

use super::{
    coordinate::{Grid, floored},
    jitter::jitter,
    weights::{gaussian, shares},
};

/// What an anisotropic filter looks along.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Aim {
    /// Footprint axes (du, dv) in turns, as section 9 has them for the filter.
    pub axes: [[f64; 2]; 2],
    /// Screen x and y.
    pub pixel: [u16; 2],
}

/// The axes of a footprint and the level they are filtered at, all in levels.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    /// The logarithm of the major axis.
    major: f64,
    /// The logarithm of the minor axis, not below a texel.
    minor: f64,
    /// The level before bias and limits: the minor axis, raised where the cap would leave gaps.
    pub level: f64,
}

/// One bilinear tap to be read.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// A whole level.
    pub level: f64,
    /// In turns.
    pub at: [f64; 2],
    /// The weights of a request sum to 1.
    pub weight: f64,
}

/// The counts, places and weights of one filter with one cap; empty for filters that are not anisotropic.
#[derive(Clone, Debug)]
pub struct Probes {
    filter: Filter,
    places: Option<Grid>,
    /// How far below the major axis the level may lie: `C`.
    reach: f64,
    /// From which logarithm on there are how many probes, in ascending order; below the first there is one.
    counts: Vec<(f64, usize)>,
    /// The weights of 1, 2, 3 ... probes.
    weights: Vec<Vec<f64>>,
}

impl Probes {
    /// The tables of a filter with at most `cap` probes, real numbers where there is no grid.
    #[must_use]
    pub fn new(filter: Filter, cap: u8, grid: Option<Grid>, places: Option<Grid>) -> Self {
        let cap = usize::from(cap);
        let log2 = |x: f64| libm::log2(x);
        let rounded = |x: f64| grid.map_or(x, |grid| grid.nearest(x));
        let more = |threshold: &dyn Fn(f64) -> f64| {
            (2..=cap).map(|n| (grid.map_or(threshold(n as f64), |grid| grid.ceil(threshold(n as f64))), n)).collect()
        };
        let (reach, counts) = match filter {
            Filter::Texram => {
                let doublings = cap.checked_ilog2().unwrap_or(0);
                // d rounded to a whole level, half up.
                (f64::from(doublings), (1..=doublings).map(|k| (f64::from(k) - 0.5, 1 << k)).collect())
            }
            Filter::Feline => (rounded(log2((cap as f64 + 1.0) / 2.0)), more(&|n| log2((2.0 * n + 1.0) / 4.0))),
            Filter::Fast => (rounded(log2(cap as f64)), more(&|n| log2(n - 0.5))),
            _ => (0.0, Vec::new()),
        };
        let weights = match filter {
            Filter::Texram => (1..=cap).map(|n| vec![1.0 / n as f64; n]).collect(),
            Filter::Feline => (1..=cap).map(|n| gaussian(n, grid)).collect(),
            Filter::Fast => (1..=cap).map(|n| shares(n, grid)).collect(),
            _ => Vec::new(),
        };
        Self { filter, places, reach, counts, weights }
    }

    /// The footprint of the raw levels of both scales.
    #[must_use]
    pub fn axes(&self, raw: [f64; 2]) -> Axes {
        let [major, minor] = [raw[0], raw[1].max(0.0)];
        Axes { major, minor, level: minor.max(major - self.reach) }
    }

    /// Reads the taps of a request at a coordinate in turns; `pair` is the level, the coarser one and the way to it.
    pub fn for_each(&self, at: [f64; 2], axes: Axes, aim: &Aim, pair: [f64; 3], mut read: impl FnMut(Probe)) {
        let [level, coarser, blur] = pair;
        let levels = [(level, 1.0 - blur), (coarser, blur)];
        if self.filter == Filter::Fast {
            for (level, share) in levels {
                let weights = &self.weights[self.count(axes.major + axes.minor - 2.0 * level) - 1];
                for (sample, weight) in weights.iter().enumerate() {
                    let at = self.jittered(at, aim, sample, weights.len(), level);
                    read(Probe { level, at, weight: weight * share });
                }
            }
        } else {
            let weights = &self.weights[self.count((axes.major - axes.minor).max(0.0)) - 1];
            for (probe, weight) in weights.iter().enumerate() {
                let at = [0, 1].map(|axis| at[axis] + self.offset(aim.axes[0][axis], probe, weights.len()));
                for (level, share) in levels {
                    read(Probe { level, at, weight: weight * share });
                }
            }
        }
    }

    /// How many probes a logarithm asks for.
    fn count(&self, logarithm: f64) -> usize {
        self.counts.iter().take_while(|(threshold, _)| logarithm >= *threshold).last().map_or(1, |&(_, count)| count)
    }

    /// Where probe `probe` of `count` lies on the major axis.
    fn offset(&self, axis: f64, probe: usize, count: usize) -> f64 {
        let [probe, count] = [probe as f64, count as f64];
        let spread = if self.filter == Filter::Texram { 2.0 * count } else { count + 1.0 };
        floored(self.places, axis * (2.0 * probe + 1.0 - count) / spread)
    }

    /// Where FAST's sample `sample` of `count` lies: strata along the longer side, anywhere along the other.
    fn jittered(&self, at: [f64; 2], aim: &Aim, sample: usize, count: usize, level: f64) -> [f64; 2] {
        if count == 1 {
            return at;
        }
        let [x, y] = jitter(aim.pixel, sample as u32, level as u32);
        let [sample, count] = [sample as f64, count as f64];
        [0, 1].map(|axis| {
            let along = aim.axes[0][axis] * (sample + x - count / 2.0) / count;
            let across = aim.axes[1][axis] * (y - 0.5);
            at[axis] + floored(self.places, along) + floored(self.places, across)
        })
    }
}
