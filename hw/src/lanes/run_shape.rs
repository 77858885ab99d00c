//! How lines and texels follow from addresses, on any machine.

/// Of a cache and a texel.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(target_arch = "x86_64"), expect(dead_code, reason = "only lanes ask"))]
pub(crate) struct RunShape {
    /// Bits of an address within a line, and within a texel.
    pub(crate) line_shift: u32,
    pub(crate) texel_shift: u32,
    /// Of a line's number, its set; `None` where a line just used is not the next victim in any case.
    pub(crate) set_mask: Option<u32>,
}
