//! The surface: the planes of one texture, each with its base address (docs/numerics.md, section 2; docs/layouts.md).
//!
//! Three pyramids are one: a plane is named by how often each axis was halved, and a pyramid is a set of planes.

use alloc::{boxed::Box, vec::Vec};

use crate::{
    format::{Format, Palette},
    layout::{Arrangement, Layout},
    sampler::PyramidKind,
    sat::ENTRY_BYTES,
};

/// Which planes a pyramid of a texture has, in storage order.
///
/// ```
/// use texunit_hw::{PyramidKind, surface::planes_of};
/// assert_eq!(planes_of(PyramidKind::Mipmap, 4, 2), [(0, 0), (1, 1), (2, 1)]);
/// assert_eq!(planes_of(PyramidKind::Dipmap, 4, 2), [(0, 0), (1, 0), (2, 0), (0, 1)]);
/// assert_eq!(planes_of(PyramidKind::Ripmap, 4, 2), [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)]);
/// ```
#[must_use]
pub fn planes_of(kind: PyramidKind, width: u32, height: u32) -> Vec<(u8, u8)> {
    let [last_u, last_v] = last_levels(width, height);
    match kind {
        PyramidKind::Mipmap => (0..=last_u.max(last_v)).map(|level| (level.min(last_u), level.min(last_v))).collect(),
        PyramidKind::Dipmap => (0..=last_u).map(|lu| (lu, 0)).chain((1..=last_v).map(|lv| (0, lv))).collect(),
        PyramidKind::Sat => alloc::vec![(0, 0)],
        PyramidKind::Ripmap => (0..=last_v).flat_map(|lv| (0..=last_u).map(move |lu| (lu, lv))).collect(),
    }
}

/// `floor(log2)` of both sides: the last level of each axis.
#[must_use]
pub const fn last_levels(width: u32, height: u32) -> [u8; 2] {
    [width.ilog2() as u8, height.ilog2() as u8]
}

/// One plane of a surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plane {
    /// How often the u axis was halved.
    pub lu: u8,
    /// How often the v axis was halved.
    pub lv: u8,
    /// Texels along u.
    pub width: u32,
    /// Texels along v.
    pub height: u32,
    /// Byte address of texel (0, 0).
    pub base: u64,
    arrangement: Arrangement,
    format: Format,
    /// Bytes of an element as this layout stores it.
    element_bytes: u32,
    /// Whether it has memory. One that has none must not be read.
    pub held: bool,
    /// Byte distance of the second and third read of a texel, for a layout that keeps channels apart.
    pub(crate) channels: [u64; 2],
}

impl Plane {
    /// Bytes between the plane's base and the texel's, or its block's, along one axis (0 for u, 1 for v).
    #[must_use]
    pub fn offset(&self, axis: usize, index: u32) -> u64 {
        self.element_offset(axis, index >> self.format.log2_block())
    }

    /// Bytes between the plane's base and an element's, along one axis.
    #[must_use]
    pub fn element_offset(&self, axis: usize, element: u32) -> u64 {
        self.arrangement.offset(axis, element) * u64::from(self.element_bytes)
    }

    /// What one axis adds to a texel's position in its block (see [`Format::decode`]): 0 where elements are texels.
    #[must_use]
    pub const fn position(&self, axis: usize, index: u32) -> u32 {
        let within = index & ((1 << self.format.log2_block()) - 1);
        if axis == 0 { within } else { within << self.format.log2_block() }
    }

    /// Elements along u and along v.
    #[must_use]
    pub fn elements(&self) -> [u32; 2] {
        self.size().map(|texels| self.format.elements(texels))
    }

    /// Byte address of the first byte of a texel, or of its block.
    #[must_use]
    pub fn address(&self, x: u32, y: u32) -> u64 {
        self.base + self.offset(0, x) + self.offset(1, y)
    }

    /// Width and height.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }
}

/// A texture's planes laid out in one address space that starts at 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Surface {
    /// Which planes.
    pub kind: PyramidKind,
    /// How they are arranged.
    pub layout: Layout,
    /// What a texel is stored as.
    pub format: Format,
    /// The colours of a palette format; black without.
    pub palette: Option<Box<Palette>>,
    /// Whether colours are sRGB codes, made linear on their way from the cache to the filter.
    pub srgb: bool,
    /// The planes in storage order.
    pub planes: Vec<Plane>,
    /// Bytes in all, padding included.
    pub bytes: u64,
    /// Last level of each axis.
    pub last_levels: [u8; 2],
}

/// A surface that cannot be laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceError {
    /// A side is zero or above [`LARGEST_SIDE`].
    Size {
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
    },
    /// Williams' arrangement holds the Mipmap of a square texture.
    Williams {
        /// What was asked for.
        kind: PyramidKind,
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
    },
    /// Williams' arrangement holds bytes of red, green and blue.
    WilliamsFormat(Format),
    /// Blocks above 2^12 on a side, or a superblock smaller than its block.
    Block(Layout),
}

/// The longest side of a texture: with it, every product in the coordinate unit stays within 64 bits.
pub const LARGEST_SIDE: u32 = 1 << 20;

impl core::fmt::Display for SurfaceError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Size { width, height } => {
                write!(f, "a texture of {width} x {height}: each side must be 1 to {LARGEST_SIDE}")
            }
            Self::Williams { kind, width, height } => write!(
                f,
                "the williams layout holds the mipmap of a square texture, not the {kind:?} of {width} x {height}"
            ),
            Self::WilliamsFormat(format) => {
                write!(f, "the williams layout holds bytes of red, green and blue, and {format:?} has none")
            }
            Self::Block(layout) => {
                write!(f, "{layout:?}: blocks are at most 2^12 on a side and not larger than their superblock")
            }
        }
    }
}

impl core::error::Error for SurfaceError {}

/// Bits of x in an address of [`Surface::map`].
const MAP_BITS: u32 = LARGEST_SIDE.trailing_zeros();

/// Column and row of an address of [`Surface::map`].
///
/// ```
/// use texunit_hw::{PyramidKind, Surface, surface::place_on_map};
/// let map = Surface::map(PyramidKind::Mipmap, 8, 8)?;
/// assert_eq!(place_on_map(map.planes[1].address(2, 3)), [2, 3]);
/// # Ok::<(), texunit_hw::SurfaceError>(())
/// ```
#[inline]
#[must_use]
pub const fn place_on_map(address: u64) -> [u32; 2] {
    [(address & (LARGEST_SIDE as u64 - 1)) as u32, (address >> MAP_BITS) as u32]
}

/// Planes start at multiples of this, so that none shares a line of a usual cache with its neighbour.
pub const PLANE_ALIGNMENT: u64 = 256;

impl Surface {
    /// Lays out the planes one after the other.
    ///
    /// ```
    /// use texunit_hw::{Format, Layout, PyramidKind, Surface};
    /// let surface = Surface::new(PyramidKind::Mipmap, Layout::RowMajor, Format::Rgba8, 256, 256)?;
    /// assert_eq!(surface.planes[0].address(3, 2), 4 * (2 * 256 + 3));
    /// assert_eq!(surface.planes[1].base, 4 * 256 * 256);
    /// # Ok::<(), texunit_hw::SurfaceError>(())
    /// ```
    ///
    /// # Errors
    /// A size or a combination there is no layout for.
    pub fn new(
        kind: PyramidKind,
        layout: Layout,
        format: Format,
        width: u32,
        height: u32,
    ) -> Result<Self, SurfaceError> {
        Self::of_planes(kind, layout, format, [width, height], |_, _| true)
    }

    /// The same with memory only for the planes of which `held(lu, lv)` is true. [`Layout::Williams`] has its planes in one square
    /// and holds them all.
    ///
    /// # Errors
    /// A size or a combination there is no layout for.
    pub fn of_planes(
        kind: PyramidKind,
        layout: Layout,
        format: Format,
        [width, height]: [u32; 2],
        held: impl Fn(u8, u8) -> bool,
    ) -> Result<Self, SurfaceError> {
        let sides = 1..=LARGEST_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(SurfaceError::Size { width, height });
        }
        check_blocks(layout)?;
        if layout == Layout::Williams {
            return Self::williams(kind, format, width, height);
        }
        // A summed-area table holds sums of decoded texels, whatever they were stored as.
        let (format, element_bytes) = match kind {
            PyramidKind::Sat => (Format::Rgba8, ENTRY_BYTES),
            _ => (format, format.element_bytes()),
        };
        let element = u64::from(element_bytes);
        let mut base = 0u64;
        let planes = planes_of(kind, width, height)
            .into_iter()
            .map(|(lu, lv)| {
                let size = [(width >> lu).max(1), (height >> lv).max(1)];
                let arrangement = Arrangement::new(layout, size.map(|texels| format.elements(texels)));
                let plane = Plane {
                    lu,
                    lv,
                    width: size[0],
                    height: size[1],
                    base,
                    arrangement,
                    format,
                    element_bytes,
                    held: held(lu, lv),
                    channels: [0; 2],
                };
                if plane.held {
                    base = (base + arrangement.elements * element).next_multiple_of(PLANE_ALIGNMENT);
                }
                plane
            })
            .collect();
        let last_levels = last_levels(width, height);
        Ok(Self { kind, layout, format, palette: None, srgb: false, planes, bytes: base, last_levels })
    }

    /// A map: no memory, but the same planes with every texel at the "address" `y << 20 | x` of its own plane, so that an analysis
    /// finds places where a cache finds bytes ([`place_on_map`]).
    ///
    /// # Errors
    /// A size there is no texture of.
    pub fn map(kind: PyramidKind, width: u32, height: u32) -> Result<Self, SurfaceError> {
        let mut map = Self::new(kind, Layout::RowMajor, Format::A8, width, height)?;
        for plane in &mut map.planes {
            plane.base = 0;
            plane.arrangement = Arrangement::rows(1 << MAP_BITS, plane.height);
            (plane.element_bytes, plane.held) = (1, false);
        }
        map.bytes = 0;
        Ok(map)
    }

    /// Williams 1983, figure 1: a square of one byte an element, twice the texture's side. Level l of side s has red at (s, 0), green at
    /// (0, s) and blue at (s, s); the quadrant at the origin holds level l + 1, which is why any level is reached by a shift.
    fn williams(kind: PyramidKind, format: Format, width: u32, height: u32) -> Result<Self, SurfaceError> {
        if kind != PyramidKind::Mipmap || width != height {
            return Err(SurfaceError::Williams { kind, width, height });
        }
        if format != Format::Rgba8 {
            return Err(SurfaceError::WilliamsFormat(format));
        }
        let pitch = 2 * u64::from(width);
        let planes = planes_of(kind, width, height)
            .into_iter()
            .map(|(lu, lv)| {
                let side = (width >> lu).max(1);
                let red = u64::from(side);
                let green = red * pitch;
                Plane {
                    lu,
                    lv,
                    width: side,
                    height: side,
                    base: red,
                    arrangement: Arrangement::rows(pitch, side),
                    format,
                    element_bytes: 1,
                    held: true,
                    channels: [green - red, green],
                }
            })
            .collect();
        let bytes = pitch * pitch;
        let (layout, last_levels) = (Layout::Williams, last_levels(width, height));
        Ok(Self { kind, layout, format, palette: None, srgb: false, planes, bytes, last_levels })
    }

    /// Reads a texel takes: one, or one a channel where the layout keeps channels apart.
    #[must_use]
    pub const fn reads_per_texel(&self) -> u32 {
        if matches!(self.layout, Layout::Williams) { 3 } else { 1 }
    }

    /// Bytes one read asks for.
    #[must_use]
    pub const fn bytes_per_read(&self) -> u32 {
        match (self.layout, self.kind) {
            (Layout::Williams, _) => 1,
            (_, PyramidKind::Sat) => ENTRY_BYTES,
            _ => self.format.element_bytes(),
        }
    }

    /// The addresses a texel is read from; only the first [`Self::reads_per_texel`] count.
    #[must_use]
    pub fn texel_addresses(&self, plane: usize, x: u32, y: u32) -> [u64; 3] {
        let plane = &self.planes[plane];
        let first = plane.address(x, y);
        [first, first + plane.channels[0], first + plane.channels[1]]
    }

    /// Storage index of a plane, if the pyramid holds it.
    #[inline]
    #[must_use]
    pub fn index(&self, lu: u8, lv: u8) -> usize {
        match self.kind {
            PyramidKind::Sat => 0,
            PyramidKind::Mipmap => lu.max(lv) as usize,
            PyramidKind::Dipmap => {
                if lv == 0 {
                    lu as usize
                } else {
                    self.last_levels[0] as usize + lv as usize
                }
            }
            PyramidKind::Ripmap => lv as usize * (self.last_levels[0] as usize + 1) + lu as usize,
        }
    }

    /// Number of the last level of a Mipmap's chain.
    #[must_use]
    pub fn last_level(&self) -> u8 {
        self.last_levels[0].max(self.last_levels[1])
    }
}

fn check_blocks(layout: Layout) -> Result<(), SurfaceError> {
    let fits = match layout {
        Layout::Tiled { log2_width, log2_height } => log2_width <= 12 && log2_height <= 12,
        Layout::Blocked { block, superblock } => {
            (0..2).all(|axis| superblock[axis] <= 12 && block[axis] <= superblock[axis])
        }
        _ => true,
    };
    if fits { Ok(()) } else { Err(SurfaceError::Block(layout)) }
}
