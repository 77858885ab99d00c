//! Pyramids: a texture and its halvings, as a set of planes (docs/numerics.md, sections 2 and 8).
//!
//! A plane is named by how often each axis was halved, so a mipmap, a dipmap and a ripmap differ in their list of planes
//! and in nothing else.

pub mod axis;
pub mod box_sums;
pub mod build;
pub mod drift;
pub mod image_file;
pub mod kernel;
pub mod response;

pub use build::{Build, From, PlaneRounding};
use image::RgbaImage;
pub use kernel::Kernel;
use texunit_hw::PyramidKind;
pub use texunit_hw::surface::planes_of;

/// One image of a pyramid: the texture halved `lu` times along u and `lv` times along v.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneImage {
    /// Halvings of the u axis (columns).
    pub lu: u8,
    /// Halvings of the v axis (rows).
    pub lv: u8,
    /// Texels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// RGBA8, row after row from the top, `width * height` of them; none of a plane that was left out.
    pub texels: Vec<[u8; 4]>,
}

/// A texture and its halvings.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    /// Which planes it holds.
    pub kind: PyramidKind,
    /// Columns of plane (0, 0).
    pub width: u32,
    /// Rows of plane (0, 0).
    pub height: u32,
    /// The planes, in the order of [`planes_of`].
    pub planes: Vec<PlaneImage>,
}

impl PlaneImage {
    /// A texture: plane (0, 0).
    ///
    /// # Panics
    /// When `texels` is not `width * height` long.
    #[must_use]
    pub fn top(width: u32, height: u32, texels: Vec<[u8; 4]>) -> Self {
        assert_eq!(texels.len(), width as usize * height as usize, "texels of a {width} x {height} plane");
        Self { lu: 0, lv: 0, width, height, texels }
    }

    /// A texture from an image.
    #[must_use]
    pub fn of_image(image: &RgbaImage) -> Self {
        Self::top(image.width(), image.height(), image.pixels().map(|pixel| pixel.0).collect())
    }
}

impl Pyramid {
    /// The plane halved `lu` and `lv` times, if this pyramid has it.
    #[must_use]
    pub fn plane(&self, lu: u8, lv: u8) -> Option<&PlaneImage> {
        self.planes.iter().find(|plane| (plane.lu, plane.lv) == (lu, lv))
    }

    /// Texels of all planes together.
    #[must_use]
    pub fn texels(&self) -> u64 {
        self.planes.iter().map(|plane| plane.texels.len() as u64).sum()
    }

    /// Memory as a multiple of the texture alone: 4/3 for a large square mipmap (numerics-input 1.4).
    #[must_use]
    pub fn memory_multiple(&self) -> f64 {
        self.texels() as f64 / (f64::from(self.width) * f64::from(self.height))
    }
}

/// Texels along an axis of `size` after `halvings`: halved and floored, at least 1.
#[must_use]
pub const fn halved(size: u32, halvings: u8) -> u32 {
    let texels = if halvings < 32 { size >> halvings } else { 0 };
    if texels == 0 { 1 } else { texels }
}
