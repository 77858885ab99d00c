//! Golden traces of the units, from the Rust units.

mod addresses;
mod arithmetic;
mod levels;
mod storage;

use texunit_hw::{AddressMode, Filter, Format, Layout, LevelRounding, Log2, PyramidKind, Rounding, Surface};

pub use addresses::{addresses, coordinates, surfaces};
pub use arithmetic::{datapath, lerp_of, lerps};
pub use levels::{lod, taps};
pub use storage::{cache, fragment_fifo, memory};

pub const FILTERS: [Filter; 5] =
    [Filter::Point, Filter::Bilinear, Filter::NearestMip, Filter::Trilinear, Filter::Dipmap];
pub const MODES: [AddressMode; 4] = [AddressMode::Wrap, AddressMode::Clamp, AddressMode::Clip, AddressMode::Mirror];
pub const LEVEL_ROUNDINGS: [LevelRounding; 3] = [LevelRounding::Floor, LevelRounding::Nearest, LevelRounding::Gl];
pub const LOG2S: [Log2; 3] = [Log2::Exact, Log2::Herf, Log2::Ilog2];
pub const ROUNDINGS: [Rounding; 3] = [Rounding::Once, Rounding::StagedRound, Rounding::StagedTruncate];

/// The number tex_pkg.sv gives a choice: its place in the list above.
pub fn code<T: PartialEq>(choice: T, choices: &[T]) -> u64 {
    choices.iter().position(|other| *other == choice).expect("a listed choice") as u64
}

/// The layout a flag of the unit selects.
pub fn layout(tiled: bool) -> Layout {
    if tiled { Layout::Tiled { log2_width: 2, log2_height: 2 } } else { Layout::RowMajor }
}

/// A surface with sides of powers of two.
pub fn surface_of(kind: PyramidKind, tiled: bool, log2: [u32; 2]) -> Surface {
    Surface::new(kind, layout(tiled), Format::Rgba8, 1 << log2[0], 1 << log2[1]).expect("sides within limits")
}
