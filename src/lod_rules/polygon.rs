//! One level for a whole polygon, from the areas of its triangle in the texture and on the screen.

use texunit_hw::lod::ilog2;

use crate::scene::Fragment;

/// Which rule, and as whose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PolygonRule {
    /// Herf's draft as printed: the logarithm of an *area* ratio taken for that of a length (E4).
    HerfPrinted,
    /// The same halved, by an arithmetic shift. It floors towards the blurrier level: his levels count the other way (E7).
    Herf,
    /// Flavell: a level up for each multiple of four, `floor(log4 r)`, towards the sharper level (E15).
    Flavell,
}

impl PolygonRule {
    /// Every rule, in the order of the table.
    pub const ALL: [Self; 3] = [Self::HerfPrinted, Self::Herf, Self::Flavell];

    /// The level, 0 the largest image, of a triangle of `texels` texels that covers `pixels` pixels, of a texture with levels
    /// up to `last`.
    ///
    /// ```
    /// use texunit::lod_rules::polygon::PolygonRule;
    /// // A 256 x 256 texture on 64 x 64 pixels: 4 texels a pixel along each side, level 2.
    /// let level = |rule: PolygonRule| rule.level(256.0 * 256.0, 64.0 * 64.0, 8);
    /// assert_eq!(PolygonRule::ALL.map(level), [4, 2, 2]);
    /// ```
    #[must_use]
    pub fn level(self, texels: f64, pixels: f64, last: u8) -> u8 {
        let last = i32::from(last);
        // The memo inverts the texture's area beforehand and works in floats.
        let ratio = (pixels as f32) * (1.0 / texels as f32);
        let level = match self {
            Self::HerfPrinted => last - (last.saturating_add(ilog2(ratio.to_bits()))).clamp(0, last),
            Self::Herf => last - (last + (ilog2(ratio.to_bits()) >> 1)).clamp(0, last),
            Self::Flavell => (ilog2(((texels / pixels) as f32).to_bits()) >> 1).clamp(0, last),
        };
        level as u8
    }
}

/// What a level is selected for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LevelPer {
    /// Every pixel, from its own gradient.
    #[default]
    Pixel,
    /// The whole shape, from what is seen of it. Filters that look along the footprint of a pixel select none and go on.
    Polygon(PolygonRule),
}

/// What is seen of a shape: the texels of level 0 under its pixels, and the pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenArea {
    size: [u32; 2],
    texels: f64,
    pixels: f64,
}

impl SeenArea {
    /// Nothing yet, of a texture of `size` texels.
    #[must_use]
    pub const fn of_texture(size: [u32; 2]) -> Self {
        Self { size, texels: 0.0, pixels: 0.0 }
    }

    /// Adds fragments, each the determinant of its gradient.
    pub fn add(&mut self, fragments: &[Fragment]) {
        self.pixels += fragments.len() as f64;
        self.texels += fragments
            .iter()
            .map(|fragment| fragment.gradient.in_texels(self.size))
            .map(|texels| (texels.ux * texels.vy - texels.uy * texels.vx).abs())
            .sum::<f64>();
    }

    /// The level of it all.
    #[must_use]
    pub fn level(&self, rule: PolygonRule) -> u8 {
        rule.level(self.texels, self.pixels, self.size[0].max(self.size[1]).ilog2() as u8)
    }
}
