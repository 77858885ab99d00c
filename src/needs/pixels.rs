//! What the pixels of a scene ask for, whatever the filter: levels, shapes of footprints.

use serde_json::{Value, json};
use texunit_hw::{Filter, lod::raw_level};

use crate::{
    front_end::FrontEnd,
    machine::{Machine, to_level},
    scene::{AxisRule, Fragment, Scene},
};

/// Footprints of a scene's pixels, counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PixelNeeds {
    /// Pixels with a fragment.
    pub pixels: u64,
    /// Of those, where level 0 is enough: a texel covers a pixel or more.
    pub magnified: u64,
    /// Within an eighth of a level of a texel a pixel.
    pub one_to_one: u64,
    /// Minified along neither axis of the texture, u only, v only, both.
    pub minified: [u64; 4],
    /// By level of detail: none, then above 0 up to 1, above 1 up to 2, and so on.
    pub levels: Vec<u64>,
    /// Smallest and largest level of detail before the clamp, 8.8.
    pub range: Option<[i32; 2]>,
    /// By the logarithm of the footprint's ratio of axes, rounded down: 1 to 2, 2 to 4, and so on.
    pub anisotropy: Vec<u64>,
}

fn count(bars: &mut Vec<u64>, place: usize) {
    if place >= bars.len() {
        bars.resize(place + 1, 0);
    }
    bars[place] += 1;
}

impl PixelNeeds {
    /// Looks at every pixel of a scene, with the norm, log2 unit and bias of a machine.
    #[must_use]
    pub fn of(scene: &Scene, machine: &Machine) -> Self {
        let mut needs = Self::default();
        let footprints = FrontEnd::new(machine, Filter::Feline, scene.texture.wrap, scene.texture.size());
        scene.for_each_block(|fragments| {
            fragments.iter().for_each(|fragment| needs.see(fragment, machine, &footprints))
        });
        needs
    }

    fn see(&mut self, fragment: &Fragment, machine: &Machine, footprints: &FrontEnd) {
        let raw = |squared: f32| raw_level(squared.to_bits(), machine.lod.log2);
        let texels = fragment.gradient.in_texels(footprints.size);
        let level = raw(machine.lod.norm.squared_ratio(texels)).saturating_add(to_level(machine.lod.bias));
        self.pixels += 1;
        self.magnified += u64::from(level <= 0);
        self.one_to_one += u64::from(level.abs() <= 32);
        let [u, v] = AxisRule::TextureAxes.squared_ratios(texels).map(|squared| raw(squared) > 0);
        self.minified[usize::from(u) + 2 * usize::from(v)] += 1;
        count(&mut self.levels, ((level.clamp(0, 32 << 8) + 255) >> 8) as usize);
        let [low, high] = self.range.get_or_insert([level; 2]);
        (*low, *high) = ((*low).min(level), (*high).max(level));
        let (request, _) = footprints.request(fragment);
        let [major, minor] = request.scale.map(|scale| raw_level(scale, machine.lod.log2));
        // Logarithms of squares, in 1/256 of a level: an octave of the ratio is a level.
        count(&mut self.anisotropy, (major.saturating_sub(minor).clamp(0, 16 << 8) >> 8) as usize);
    }

    /// As JSON; levels in levels.
    #[must_use]
    pub fn json(&self) -> Value {
        let [neither, u, v, both] = self.minified;
        json!({
            "pixels": self.pixels,
            "magnified": self.magnified,
            "one_to_one": self.one_to_one,
            "minified": { "neither": neither, "u": u, "v": v, "both": both },
            "levels": self.levels,
            "level_range": self.range.map(|range| range.map(|level| f64::from(level) / 256.0)),
            "anisotropy": self.anisotropy,
        })
    }
}
