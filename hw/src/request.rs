//! What enters the unit and what leaves it. The formats are those of docs/numerics.md, section 1.

use fixed::types::I12F20;

/// One texture request, as a shader or scan converter hands it to the unit.
///
/// ```
/// use texunit_hw::{I12F20, Request};
/// let request = Request::at(I12F20::from_bits(0x80000), I12F20::from_bits(0x40000));
/// assert_eq!(request.u.to_bits(), 0x80000); // u = 0.5, half way across the texture
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Request {
    /// Horizontal coordinate, 12.20, one repeat of the texture is 1.0.
    pub u: I12F20,
    /// Vertical coordinate, 12.20.
    pub v: I12F20,
    /// What selects the level, per [`LodSource`]: the bits of an f32 squared ratio (texels per pixel, squared), or an 8.8
    /// level sign-extended to 32 bits. `[0]` is the only one, or that of the u axis; `[1]` that of the v axis.
    pub scale: [u32; 2],
    /// Footprint axes (du, dv) in 12.20, read by anisotropic filters only.
    pub axes: [[I12F20; 2]; 2],
    /// Screen position: read by hashes and reports, never by address arithmetic.
    pub pixel: [u16; 2],
}

impl Request {
    /// A request at a coordinate, everything else zero.
    #[must_use]
    pub fn at(u: I12F20, v: I12F20) -> Self {
        Self { u, v, ..Self::default() }
    }
}

/// One filtered texel and the level it came from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Response {
    /// Red, green, blue, alpha, 8 bits each.
    pub texel: [u8; 4],
    /// Levels used, 8.8, after clamping and rounding: of the u axis (or the only one), and of the v axis (or the same).
    pub lod: [u16; 2],
}

/// How [`Request::scale`] is to be read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LodSource {
    /// An 8.8 level, two's complement, sign-extended.
    Explicit,
    /// The bits of an f32: squared texels per pixel.
    #[default]
    Gradient,
}
