//! What is generated: the package of the default machine, and the table of the log2 unit.

use texunit_hw::{Log2, coordinate::COORDINATE_BITS, lod::raw_level, surface::PLANE_ALIGNMENT};

/// Longest side of a texture the RTL has wires for, as a power of two. The Rust model goes to 2^20.
pub const MAX_LOG2_SIDE: u32 = 12;

/// The default machine's numbers.
pub struct Profile {
    pub log2: u64,
    pub lod_bits: u64,
    pub filter_bits: u64,
    pub rounding: u64,
    pub tile: [u64; 2],
    pub sets: u64,
    pub ways: u64,
    pub line: u64,
    pub fragment_fifo: u64,
}

impl Profile {
    /// Reads what the RTL needs of a machine file.
    pub fn read(text: &str) -> Self {
        let table: toml::Table = text.parse().expect("a machine file is TOML");
        let number = |section: &str, key: &str| table[section][key].as_integer().expect("a number").cast_unsigned();
        let choice = |section: &str, key: &str, names: &[&str]| {
            let name = table[section][key].as_str().expect("a name");
            names.iter().position(|known| *known == name).unwrap_or_else(|| panic!("{section}.{key} = {name}")) as u64
        };
        let layout = table["texture"]["layout"].as_str().expect("a name");
        let tile = layout.strip_prefix("tiled-").and_then(|size| size.split_once('x')).expect("a tiled layout");
        Self {
            log2: choice("lod", "log2", &["exact", "herf", "ilog2"]),
            lod_bits: number("lod", "bits"),
            filter_bits: number("filter", "bits"),
            rounding: choice("filter", "rounding", &["once", "staged-round", "staged-truncate"]),
            tile: [tile.0, tile.1].map(|side| u64::from(side.parse::<u32>().expect("a side").ilog2())),
            sets: number("cache", "sets"),
            ways: number("cache", "ways"),
            line: number("cache", "line"),
            fragment_fifo: 32,
        }
    }
}

/// hw/rtl/tex_pkg.sv.
pub fn package(profile: &Profile) -> String {
    // Mipmap: a plane a level. Dipmap: the base and the halvings of either side.
    let planes = 2 * MAX_LOG2_SIDE + 1;
    let bits_for = |largest: u32| 32 - largest.leading_zeros();
    let integer = |name: &str, value: u64| format!("  localparam int {name} = {value};\n");
    let choices = |bits: u32, names: &[&str]| -> String {
        (0..)
            .zip(names)
            .map(|(value, name)| format!("  localparam logic [{}:0] {name} = {bits}'d{value};\n", bits - 1))
            .collect()
    };
    // A dipmap of the largest texture is just under three times its base: 4 N^2 bytes, times four for the next power of two.
    let address_bits = 2 * MAX_LOG2_SIDE + 2 + 2;
    [
        "// Generated from hw/profiles/herf-12.20.toml: TEXUNIT_BLESS=1 cargo test --release -p texunit-hw --test rtl\n".into(),
        "//\n// Every width the units share, every choice by number, and the default machine's parameters.\n".into(),
        "package tex_pkg;\n  // Widths.\n".into(),
        integer("CoordinateBits", COORDINATE_BITS.into()),
        "  // Textures are powers of two up to this side.\n".into(),
        integer("MaxLog2Side", MAX_LOG2_SIDE.into()),
        integer("LevelBits", bits_for(MAX_LOG2_SIDE).into()),
        "  // Of a dipmap with that side.\n".into(),
        integer("Planes", planes.into()),
        integer("PlaneBits", bits_for(planes - 1).into()),
        "  // Bytes of it.\n".into(),
        integer("AddressBits", address_bits.into()),
        integer("PlaneAlignmentLog2", PLANE_ALIGNMENT.ilog2().into()),
        "\n  // Choices that are parameters.\n".into(),
        integer("Log2Exact", 0),
        integer("Log2Herf", 1),
        integer("Log2Ilog2", 2),
        integer("RoundOnce", 0),
        integer("RoundStaged", 1),
        integer("RoundStagedTruncate", 2),
        "\n  // Choices that are inputs.\n".into(),
        choices(3, &["FilterPoint", "FilterBilinear", "FilterNearestMip", "FilterTrilinear", "FilterDipmap"]),
        choices(2, &["AddressWrap", "AddressClamp", "AddressClip", "AddressMirror"]),
        choices(2, &["LevelFloor", "LevelNearest", "LevelGl"]),
        "\n  // The default machine.\n".into(),
        integer("Log2", profile.log2),
        integer("LodBits", profile.lod_bits),
        integer("FilterBits", profile.filter_bits),
        integer("Rounding", profile.rounding),
        integer("TileLog2Width", profile.tile[0]),
        integer("TileLog2Height", profile.tile[1]),
        integer("Sets", profile.sets),
        integer("Ways", profile.ways),
        integer("LineLog2Bytes", profile.line.ilog2().into()),
        "  // Texels between the tags and the data banks.\n".into(),
        integer("FragmentFifoDepth", profile.fragment_fifo),
        "endpackage : tex_pkg\n".into(),
    ]
    .concat()
}

/// hw/rtl/log2_table.sv: level and boundary of every cell, from the Rust unit's answers and not from its table.
pub fn log2_table() -> String {
    let level = |mantissa: u32| raw_level(127 << 23 | mantissa, Log2::Exact).cast_unsigned();
    let rows: String = (0..256u32)
        .map(|index| {
            let (first, last) = (index << 15, index << 15 | 0x7fff);
            let boundary = if level(last) == level(first) {
                0xff_ffff
            } else {
                let (mut below, mut above) = (first, last);
                while above - below > 1 {
                    let middle = below + (above - below) / 2;
                    if level(middle) == level(first) { below = middle } else { above = middle }
                }
                above
            };
            format!("      8'd{index:<3}: {{level_o, boundary_o}} = 32'h{:02x}_{boundary:06x};\n", level(first))
        })
        .collect();
    format!(
        "// Generated: TEXUNIT_BLESS=1 cargo test --release -p texunit-hw --test rtl
//
// The exact log2 unit's table (docs/numerics.md, section 4.1): for each value of the top 8 mantissa
// bits the rounded logarithm at the first mantissa, in 1/128 octave, and the mantissa at which it
// becomes one more (all ones: not here). Steps lie further apart than a cell is wide, so one
// comparator is enough. Combinational.
module log2_table (
  input  logic [7:0]  index_i,
  output logic [7:0]  level_o,
  output logic [23:0] boundary_o
);
  always_comb begin
    case (index_i)
{rows}      default: {{level_o, boundary_o}} = 32'h00_000000;
    endcase
  end
endmodule : log2_table
"
    )
}
