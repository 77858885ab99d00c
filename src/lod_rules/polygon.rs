//! One level for a whole polygon, from the areas of its triangle in the texture and on the screen.

use texunit_hw::lod::ilog2;

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

/// Twice the area of a triangle: what both sides of the ratio may be given as.
#[must_use]
pub fn doubled_area(corners: [[f64; 2]; 3]) -> f64 {
    let [p, q] = [1, 2].map(|corner: usize| [0, 1].map(|i| corners[corner][i] - corners[0][i]));
    (p[0] * q[1] - p[1] * q[0]).abs()
}
