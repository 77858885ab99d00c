//! The one spelling of everything a user can choose: the same on the command line, in TOML, JSON, traces and documents.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser::SerializeTuple};
use texunit_hw::timing::{BankHash, Mapping, Mode, Page};
use texunit_hw::{AddressMode, Filter, Format, Layout, LevelRounding, LodSource, Log2, PyramidKind, Rounding};

use crate::timing_settings::MemoryKind;

use crate::lod_rules::polygon::{LevelPer, PolygonRule};
use crate::pyramid::{From as PlanesFrom, Kernel, PlaneRounding};
use crate::scene::{AxisRule, GradientMethod, MatrixStepping, Norm, Pattern, PixelOrder};
use crate::texture_memory::Decompress;

/// A closed set of choices, each with a name.
pub trait Named: Copy + PartialEq + 'static {
    /// What is being chosen, for messages.
    const WHAT: &'static str;
    /// Every choice with its name, in the order they are listed to a user.
    const ALL: &'static [(&'static str, Self)];

    /// The name of this choice.
    fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, choice)| *choice == self).map_or("unnamed", |(name, _)| name)
    }

    /// The choice of a name.
    ///
    /// # Errors
    /// A sentence that lists the names there are.
    fn from_name(name: &str) -> Result<Self, String> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, choice)| *choice).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|(name, _)| *name).collect();
            format!("no {} is named `{name}`: use {}", Self::WHAT, names.join(", "))
        })
    }
}

/// What `--filter` can name: the filters of the unit, and the one no unit has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnyFilter {
    /// On the chip.
    Unit(Filter),
    /// The elliptical weighted average, in floats only.
    Ewa,
}

impl AnyFilter {
    /// All of them, in the order they are listed to a user.
    pub fn all() -> impl Iterator<Item = Self> {
        Filter::ALL.iter().map(|(_, filter)| Self::Unit(*filter)).chain([Self::Ewa])
    }

    /// The name of this filter.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unit(filter) => filter.name(),
            Self::Ewa => "ewa",
        }
    }

    /// The filter of a name.
    ///
    /// # Errors
    /// A sentence that lists the names there are.
    pub fn from_name(name: &str) -> Result<Self, String> {
        if name == Self::Ewa.name() {
            return Ok(Self::Ewa);
        }
        Filter::from_name(name).map(Self::Unit).map_err(|problem| format!("{problem}, ewa"))
    }

    /// The filter of the unit whose pyramid this one reads.
    #[must_use]
    pub const fn on_pyramid_of(self) -> Filter {
        match self {
            Self::Unit(filter) => filter,
            Self::Ewa => Filter::Trilinear,
        }
    }
}

macro_rules! names {
    ($($type:ty, $what:literal { $($name:literal => $choice:expr),* $(,)? })*) => {
        $(impl Named for $type {
            const WHAT: &'static str = $what;
            const ALL: &'static [(&'static str, Self)] = &[$(($name, $choice)),*];
        })*
    };
}

names! {
    Filter, "filter" {
        "point" => Self::Point,
        "bilinear" => Self::Bilinear,
        "nearest-mip" => Self::NearestMip,
        "trilinear" => Self::Trilinear,
        "brilinear" => Self::Brilinear,
        "mip-double" => Self::MipDouble,
        "dipmap" => Self::Dipmap,
        "dipmap-trilinear" => Self::DipmapTrilinear,
        "ripmap" => Self::Ripmap,
        "texram" => Self::Texram,
        "feline" => Self::Feline,
        "fast" => Self::Fast,
        "sat" => Self::Sat,
    }
    Mode, "timing mode" { "prefetching" => Self::Prefetching, "blocking" => Self::Blocking }
    BankHash, "bank hash" { "low" => Self::Low, "xor" => Self::Xor }
    Page, "page policy" { "open" => Self::Open, "closed" => Self::Closed }
    Mapping, "address mapping" { "row-bank-column" => Self::RowBankColumn, "row-column-bank" => Self::RowColumnBank }
    MemoryKind, "memory" { "fixed" => Self::Fixed, "dram" => Self::Dram }
    PyramidKind, "pyramid" { "mipmap" => Self::Mipmap, "dipmap" => Self::Dipmap, "ripmap" => Self::Ripmap, "sat" => Self::Sat }
    Kernel, "kernel" {
        "point" => Self::Point, "box" => Self::Box, "tent" => Self::Tent, "lanczos" => Self::Lanczos, "kaiser" => Self::Kaiser,
    }
    PlanesFrom, "source of planes" { "top" => Self::Top, "above" => Self::Above }
    PlaneRounding, "pyramid rounding" {
        "half-even" => Self::HalfEven, "half-up" => Self::HalfUp, "truncate" => Self::Truncate,
    }
    AddressMode, "wrap" { "wrap" => Self::Wrap, "clamp" => Self::Clamp, "clip" => Self::Clip, "mirror" => Self::Mirror }
    LodSource, "LOD source" { "explicit" => Self::Explicit, "gradient" => Self::Gradient }
    Log2, "log2 unit" {
        "exact" => Self::Exact, "table-128" => Self::Table128, "table-64" => Self::Table64, "table-16" => Self::Table16,
        "quadratic" => Self::Quadratic, "fourth" => Self::Fourth, "herf" => Self::Herf, "herf-plain" => Self::HerfPlain,
        "ilog2" => Self::Ilog2,
    }
    LevelRounding, "level rounding" { "floor" => Self::Floor, "nearest" => Self::Nearest, "gl" => Self::Gl }
    Rounding, "rounding" {
        "once" => Self::Once, "staged-round" => Self::StagedRound, "staged-truncate" => Self::StagedTruncate,
    }
    Format, "format" {
        "rgba8" => Self::Rgba8, "rgb565" => Self::Rgb565, "argb1555" => Self::Argb1555, "argb4444" => Self::Argb4444,
        "l8" => Self::L8, "a8" => Self::A8, "la8" => Self::La8, "palette8" => Self::Palette8,
        "bc1" => Self::Bc1, "bc3" => Self::Bc3, "bc7" => Self::Bc7,
    }
}

/// Names for types of this crate, which serde can then read and write without an attribute.
macro_rules! names_of_ours {
    ($($type:ty, $what:literal { $($name:literal => $choice:expr),* $(,)? })*) => {
        names! { $($type, $what { $($name => $choice),* })* }
        $(impl Serialize for $type {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                by_name::serialize(self, serializer)
            }
        }
        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                by_name::deserialize(deserializer)
            }
        })*
    };
}

names_of_ours! {
    Norm, "LOD norm" {
        "heckbert" => Self::Heckbert, "herf" => Self::Herf, "max" => Self::Max, "area" => Self::Area,
        "sigma1" => Self::Sigma1, "min" => Self::Min,
    }
    AxisRule, "axis rule" {
        "texture-axes" => Self::TextureAxes, "paper-step3" => Self::PaperStep3, "paper-2a" => Self::Paper2a,
    }
    LevelPer, "owner of a level" {
        "pixel" => Self::Pixel, "polygon-herf-printed" => Self::Polygon(PolygonRule::HerfPrinted),
        "polygon-herf" => Self::Polygon(PolygonRule::Herf), "polygon-flavell" => Self::Polygon(PolygonRule::Flavell),
    }
    GradientMethod, "gradient method" {
        "analytic" => Self::Analytic, "forward" => Self::Forward, "quad" => Self::Quad,
    }
    Decompress, "place to decompress" { "after-cache" => Self::AfterCache, "before-cache" => Self::BeforeCache }
    PixelOrder, "pixel order" { "scanline" => Self::Scanline, "tiles" => Self::Tiles, "morton" => Self::Morton }
    MatrixStepping, "matrix stepping" { "per-pixel" => Self::PerPixel, "forward-f32" => Self::ForwardF32 }
    Pattern, "pattern" { "checkerboard" => Self::Checkerboard, "pane" => Self::Pane, "natural" => Self::Natural }
}

/// For `#[serde(with = "crate::names::by_name")]` on any [`Named`] field.
pub mod by_name {
    use super::{Deserialize, Deserializer, Named, Serializer, de};

    /// Writes the name.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<T: Named, S: Serializer>(choice: &T, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(choice.name())
    }

    /// Reads a name.
    ///
    /// # Errors
    /// An unknown name, with those there are.
    pub fn deserialize<'de, T: Named, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
        T::from_name(&String::deserialize(deserializer)?).map_err(de::Error::custom)
    }
}

/// For `#[serde(with = "crate::names::by_name_per_axis")]` on an array of two of a [`Named`]: u, v.
pub mod by_name_per_axis {
    use super::{Deserialize, Deserializer, Named, SerializeTuple, Serializer, de};

    /// Writes both names.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<T: Named, S: Serializer>(choices: &[T; 2], serializer: S) -> Result<S::Ok, S::Error> {
        let mut pair = serializer.serialize_tuple(2)?;
        for choice in choices {
            pair.serialize_element(choice.name())?;
        }
        pair.end()
    }

    /// Reads two names.
    ///
    /// # Errors
    /// An unknown name, with those there are.
    pub fn deserialize<'de, T: Named, D: Deserializer<'de>>(deserializer: D) -> Result<[T; 2], D::Error> {
        let [u, v] = <[String; 2]>::deserialize(deserializer)?;
        Ok([T::from_name(&u).map_err(de::Error::custom)?, T::from_name(&v).map_err(de::Error::custom)?])
    }
}

/// For `#[serde(with = "crate::names::layout")]`.
pub mod layout {
    use super::{Deserialize, Deserializer, Layout, Serializer, de, layout_from_name, layout_name};

    /// Writes the name.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<S: Serializer>(layout: &Layout, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&layout_name(*layout))
    }

    /// Reads a name.
    ///
    /// # Errors
    /// See [`layout_from_name`].
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Layout, D::Error> {
        layout_from_name(&String::deserialize(deserializer)?).map_err(de::Error::custom)
    }
}

/// `row-major`, `tiled-4x4`, `morton`, `williams`, `blocked-4x4-64x64` (block, superblock).
#[must_use]
pub fn layout_name(layout: Layout) -> String {
    match layout {
        Layout::RowMajor => "row-major".into(),
        Layout::Morton => "morton".into(),
        Layout::Williams => "williams".into(),
        Layout::Tiled { log2_width, log2_height } => format!("tiled-{}x{}", 1 << log2_width, 1 << log2_height),
        Layout::Blocked { block: [a, b], superblock: [c, d] } => {
            format!("blocked-{}x{}-{}x{}", 1 << a, 1 << b, 1 << c, 1 << d)
        }
    }
}

/// The layout of a name as [`layout_name`] writes it.
///
/// # Errors
/// A sentence that lists the forms there are.
pub fn layout_from_name(name: &str) -> Result<Layout, String> {
    let complain = || {
        format!(
            "no layout is named `{name}`: use row-major, tiled-WxH, morton, williams or blocked-WxH-WxH, \
             with W and H powers of two up to 4096"
        )
    };
    let block = |text: &str| -> Option<[u8; 2]> {
        let (width, height) = text.split_once('x')?;
        let log2 = |side: &str| {
            let side: u32 = side.parse().ok()?;
            (side.is_power_of_two() && side <= 4096).then(|| side.trailing_zeros() as u8)
        };
        Some([log2(width)?, log2(height)?])
    };
    let parts: Vec<&str> = name.split('-').collect();
    match parts.as_slice() {
        ["row", "major"] => Some(Layout::RowMajor),
        ["morton"] => Some(Layout::Morton),
        ["williams"] => Some(Layout::Williams),
        ["tiled", tile] => block(tile).map(|[log2_width, log2_height]| Layout::Tiled { log2_width, log2_height }),
        ["blocked", small, large] => block(small).zip(block(large)).and_then(|(block, superblock)| {
            (block[0] <= superblock[0] && block[1] <= superblock[1]).then_some(Layout::Blocked { block, superblock })
        }),
        _ => None,
    }
    .ok_or_else(complain)
}
