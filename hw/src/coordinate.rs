//! Coordinates: from float bits to 12.20, and from 12.20 to texel indices (docs/numerics.md, sections 1.1 and 3).

/// What happens to a coordinate outside the texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum AddressMode {
    /// Repeat: exact modulo 1 at any value.
    #[default]
    Wrap,
    /// The edge texel.
    Clamp,
    /// Transparent black outside (Herf's Clip; right for premultiplied alpha).
    Clip,
    /// Repeat, every second time mirrored.
    Mirror,
}
