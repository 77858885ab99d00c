//! The planes a texture is sampled from (docs/numerics.md, section 2).

use texunit_hw::PyramidKind;

/// One plane: the texture with its axes halved `lu` and `lv` times.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlaneImage {
    /// How often the u axis was halved.
    pub lu: u8,
    /// How often the v axis was halved.
    pub lv: u8,
    /// Texels along u.
    pub width: u32,
    /// Texels along v.
    pub height: u32,
    /// Row by row, `width * height` of them: red, green, blue, alpha.
    pub texels: Vec<[u8; 4]>,
}

/// A texture and its smaller images.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pyramid {
    /// Which planes there are.
    pub kind: PyramidKind,
    /// Texels of level 0 along u.
    pub width: u32,
    /// Texels of level 0 along v.
    pub height: u32,
    /// In the storage order of docs/numerics.md, section 2; the first is level 0.
    pub planes: Vec<PlaneImage>,
}
