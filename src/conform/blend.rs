//! The colours a set of texels can give while their weights roam their intervals.

use super::interval::Interval;

/// Four texels, and the weights of the second column and of the second row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1).
    pub corners: [[f64; 4]; 4],
    /// Of u and v.
    pub weights: [Interval; 2],
}

/// Two patches, and the weight of the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend {
    /// Of the sharper and of the blurrier level.
    pub patches: [Patch; 2],
    /// How far from the first to the second.
    pub blend: Interval,
}

/// The nearest that was found to an answer out of reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Miss {
    /// How far the worst channel is off, in units of its last bit.
    pub off: f64,
    /// That channel.
    pub channel: usize,
    /// The nearest colour.
    pub colour: [f64; 4],
    /// Its weights: u and v of the first patch, u and v of the second, blend.
    pub weights: [f64; 5],
}

/// How long to look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// Until some channel is known to be out of reach; the miss is then a bound, channel by channel.
    UntilHopeless,
    /// For the nearest colour.
    ToTheEnd,
}

/// How nearly a descent must reach an answer, in units of the last bit.
const NEAR: f64 = 1.0 / 256.0;
/// What parts of the tolerance a descent aims for, one after the other.
const AIMS: [f64; 3] = [1.0, 0.9, 0.98];
/// Descents beside those from the grid.
const DESCENTS: usize = 6;
/// Most weights of an interval that are tried on the grid: two widths of a step, and some for the coordinate.
const GRID_MOST: i64 = 4;
/// Rounds of a descent. Most answers that need one come within reach in a handful.
const ROUNDS: usize = 300;
/// Halvings of an interval in search of a minimum.
const HALVINGS: usize = 32;

impl Patch {
    fn colour(&self, [u, v]: [f64; 2]) -> [f64; 4] {
        let [c00, c10, c01, c11] = &self.corners;
        [0, 1, 2, 3].map(|channel| {
            let top = c00[channel] + (c10[channel] - c00[channel]) * u;
            let bottom = c01[channel] + (c11[channel] - c01[channel]) * u;
            top + (bottom - top) * v
        })
    }

    /// The least and the greatest of each channel: linear in each weight, so at the ends.
    fn range(&self) -> [[f64; 4]; 2] {
        let [u, v] = self.weights;
        let ends = [[u.low, v.low], [u.high, v.low], [u.low, v.high], [u.high, v.high]].map(|at| self.colour(at));
        bounds(&ends)
    }
}

fn bounds(colours: &[[f64; 4]]) -> [[f64; 4]; 2] {
    let pick = |better: fn(f64, f64) -> f64| {
        [0, 1, 2, 3].map(|channel| colours.iter().map(|colour| colour[channel]).reduce(better).unwrap_or(0.0))
    };
    [pick(f64::min), pick(f64::max)]
}

impl Blend {
    fn intervals(&self) -> [Interval; 5] {
        let [first, second] = &self.patches;
        [first.weights[0], first.weights[1], second.weights[0], second.weights[1], self.blend]
    }

    fn colour(&self, weights: [f64; 5]) -> [f64; 4] {
        let [first, second] =
            [0, 1].map(|level| self.patches[level].colour([weights[2 * level], weights[2 * level + 1]]));
        [0, 1, 2, 3].map(|channel| first[channel] + (second[channel] - first[channel]) * weights[4])
    }

    /// None if some weights give each channel of the answer, within the tolerance. `steps` is what the promised bits count to, of the
    /// weights between texels and between levels.
    pub fn miss(&self, answer: [f64; 4], tolerance: f64, steps: [f64; 2], search: Search) -> Option<Miss> {
        let middle = self.intervals().map(Interval::middle);
        if farthest(self.colour(middle), answer).1 <= tolerance {
            return None;
        }
        // What no weights give one channel, they do not give four: the exact bound of each, and no search.
        let [first, second] = [self.patches[0].range(), self.patches[1].range()];
        let mixed = [self.blend.low, self.blend.high].map(|t| {
            [0, 1].map(|end| [0, 1, 2, 3].map(|channel| first[end][channel] * (1.0 - t) + second[end][channel] * t))
        });
        let [low, high] = bounds(mixed.as_flattened());
        let beyond = |channel: usize| (low[channel] - answer[channel]).max(answer[channel] - high[channel]);
        let hopeless = (0..4).any(|channel| beyond(channel) > tolerance + NEAR);
        if hopeless && search == Search::UntilHopeless {
            let colour = [0, 1, 2, 3].map(|channel: usize| answer[channel].clamp(low[channel], high[channel]));
            let (channel, off) = farthest(colour, answer);
            return Some(Miss { off, channel, colour, weights: middle });
        }
        // A machine that cuts to just the promised bits lies on their grid, often at an end of what is allowed: look there first.
        let mut starts = self.on_grid(steps);
        let far = |weights: &[f64; 5]| farthest(self.colour(*weights), answer).1;
        let by_distance = |a: &[f64; 5], b: &[f64; 5]| far(a).total_cmp(&far(b));
        starts.sort_by(by_distance);
        if starts.first().is_some_and(|nearest| far(nearest) <= tolerance + NEAR) {
            return None;
        }
        // Intervals of few bits are wide, and the sum of squares then has more than one valley: begin where it is nearest already.
        starts.truncate(2);
        let mut others = self.starts();
        others.sort_by(by_distance);
        starts.extend(others.into_iter().take(DESCENTS));
        let mut best: Option<Miss> = None;
        for mut weights in starts {
            for aim in AIMS {
                weights = self.descend(answer, tolerance, aim * tolerance, weights);
                let colour = self.colour(weights);
                let (channel, off) = farthest(colour, answer);
                if off <= tolerance + NEAR {
                    return None;
                }
                if best.is_none_or(|best| off < best.off) {
                    best = Some(Miss { off, channel, colour, weights });
                }
            }
        }
        best
    }

    /// All weights that are whole numbers of `steps` (of the texels' weights, of the levels'), the middle ones where there are many.
    fn on_grid(&self, steps: [f64; 2]) -> Vec<[f64; 5]> {
        let intervals = self.intervals();
        let of = |number: usize| -> Vec<f64> {
            if (2..4).contains(&number) && self.blend.high == 0.0 {
                return vec![intervals[number].middle()];
            }
            let Interval { low, high } = intervals[number];
            let steps = steps[usize::from(number == 4)];
            let (first, last) = ((low * steps).ceil() as i64, (high * steps).floor() as i64);
            let skip = ((last - first + 1 - GRID_MOST) / 2).max(0);
            let grid = (first + skip..=last - skip).map(|number| number as f64 / steps);
            let mut weights: Vec<f64> = grid.collect();
            if weights.is_empty() {
                weights.push(intervals[number].middle());
            }
            weights
        };
        let mut all = vec![[0.0; 5]];
        for number in 0..5 {
            let weights = of(number);
            all = all
                .iter()
                .flat_map(|known| {
                    weights.iter().map(|weight| {
                        let mut more = *known;
                        more[number] = *weight;
                        more
                    })
                })
                .collect();
        }
        all
    }

    /// Places within the intervals: a quarter, half and three quarters of the way, u and v alike on both levels.
    fn starts(&self) -> Vec<[f64; 5]> {
        let ways = [0.25, 0.5, 0.75];
        let along = |interval: Interval, way: f64| interval.low + (interval.high - interval.low) * way;
        let intervals = self.intervals();
        let mut starts = Vec::with_capacity(27);
        for u in ways {
            for v in ways {
                starts.extend(
                    ways.map(|t| [0, 1, 2, 3, 4].map(|number| along(intervals[number], [u, v, u, v, t][number]))),
                );
            }
        }
        starts
    }

    /// One weight after the other to where the channels' squared excess is least. That sum is smooth, and over intervals as narrow as
    /// these as good as convex. It nears a thin set of good places ever more slowly, but passes through on the way to a place beyond, so it
    /// may aim for less than is tolerated.
    fn descend(&self, answer: [f64; 4], tolerance: f64, aim: f64, mut weights: [f64; 5]) -> [f64; 5] {
        let intervals = self.intervals();
        for _ in 0..ROUNDS {
            let before = weights;
            for number in 0..5 {
                let Interval { mut low, mut high } = intervals[number];
                let at = |weight: f64| {
                    let mut weights = weights;
                    weights[number] = weight;
                    self.colour(weights)
                };
                let [zero, one] = [at(0.0), at(1.0)];
                let slope = |weight: f64| -> f64 {
                    let channels = zero.iter().zip(one).zip(answer);
                    channels
                        .map(|((&zero, one), answer)| {
                            let beyond = zero + (one - zero) * weight - answer;
                            (one - zero) * (beyond - beyond.clamp(-aim, aim))
                        })
                        .sum()
                };
                if slope(weights[number]) == 0.0 {
                    continue;
                }
                for _ in 0..HALVINGS {
                    let middle = f64::midpoint(low, high);
                    if slope(middle) > 0.0 { high = middle } else { low = middle }
                }
                weights[number] = f64::midpoint(low, high);
            }
            let settled = weights.iter().zip(before).all(|(now, before)| (now - before).abs() < 1e-12);
            if settled || farthest(self.colour(weights), answer).1 <= tolerance + NEAR {
                break;
            }
        }
        weights
    }
}

/// The channel that is farthest off, and by how much.
fn farthest(colour: [f64; 4], answer: [f64; 4]) -> (usize, f64) {
    let mut worst = (0, 0.0);
    for channel in 0..4 {
        let off = (colour[channel] - answer[channel]).abs();
        if off > worst.1 {
            worst = (channel, off);
        }
    }
    worst
}
