//! A refusal in words.

use texunit_hw::Filter;

use super::{Judge, Sample, blend::Miss};

/// Channel names.
const CHANNELS: [&str; 4] = ["red", "green", "blue", "alpha"];

impl Judge<'_> {
    /// What was allowed, and what came nearest.
    pub(super) fn in_words(&self, sample: &Sample, miss: &Miss, levels: [usize; 2]) -> String {
        let mut words = format!(
            "the answer is {:?}, and no allowed coordinate and level give that: {} is {:.2} off, {} is tolerated\n",
            sample.texel, CHANNELS[miss.channel], miss.off, self.precision.tolerance
        );
        for (place, level) in levels.into_iter().enumerate() {
            if place == 1 && levels[0] == level {
                break;
            }
            for (axis, name) in ["u", "v"].into_iter().enumerate() {
                words += &self.axis_in_words(sample, level, axis, name);
            }
        }
        if self.sampling.filter.uses_level() {
            let [low, high] = sample.level.map(|level| level + self.sampling.bias);
            let slack = super::exp2(-i32::from(self.precision.mipmap));
            let range = if low < high { format!("{low:.4} to {high:.4}") } else { format!("{low:.4}") };
            words += &format!(
                "  level: {range} is right, {:.4} to {:.4} allowed, within the limits of sampler and mipmap\n",
                low - slack,
                high + slack
            );
        }
        let colour = miss.colour.map(|channel| format!("{channel:.2}")).join(", ");
        words += &format!("  nearest allowed colour: ({colour})");
        words
    }

    fn axis_in_words(&self, sample: &Sample, level: usize, axis: usize, name: &str) -> String {
        let plane = self.planes[level];
        let size = [plane.width, plane.height][axis];
        let Some(allowed) = self.texels(sample.at[axis], size) else { return String::new() };
        let point = self.sampling.filter == Filter::Point;
        let half = if point { 0.0 } else { 0.5 };
        let [first, last] = [allowed.low.floor(), allowed.high.floor()];
        let texels = match (point, first == last) {
            (true, true) => format!("texel {first}"),
            (true, false) => format!("texels {first} to {last}"),
            (false, true) => format!(
                "between texels {first} and {}, weight of the second {:.4} to {:.4}",
                first + 1.0,
                allowed.low - first,
                allowed.high - first
            ),
            (false, false) => format!("between texels {first} and {}", last + 1.0),
        };
        format!(
            "  level {level}: {name} = {:.7} is texel coordinate {:.4} of {size}, {:.4} to {:.4} allowed: {texels}\n",
            sample.at[axis],
            sample.at[axis] * f64::from(size),
            allowed.low + half,
            allowed.high + half
        )
    }
}
