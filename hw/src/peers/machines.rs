//! The machines: peers.md (b1), one row each.

use super::{Arithmetic, Blend, Coordinate, LevelUnit, Logarithm, Rounding, Shape, Space, Weights};

const fn texels(bits: u32) -> Coordinate {
    Coordinate { space: Space::Texels, bits, nearest: false, half_texel: true }
}

const fn normalised(bits: u32) -> Coordinate {
    Coordinate { space: Space::Normalised, bits, nearest: false, half_texel: true }
}

const fn level(squarings: u32, logarithm: Logarithm, bits: u32) -> Option<LevelUnit> {
    Some(LevelUnit { squarings, logarithm, bits, nearest: false })
}

/// What an API asks for at least: its bits, and nothing lost beside them.
const fn promised(name: &'static str, source: &'static str, level_bits: u32) -> Arithmetic {
    Arithmetic {
        name,
        source,
        assumed: "an API sets a least precision and no arithmetic: to nearest, rounded once, is ours",
        coordinate: Coordinate { space: Space::Texels, bits: 8, nearest: true, half_texel: true },
        fraction: 8,
        shape: Shape::Square,
        weights: Weights::Binary,
        rounding: Rounding::Once,
        full_scale: 255,
        level: Some(LevelUnit { squarings: 1, logarithm: Logarithm::Exact, bits: level_bits, nearest: true }),
        blend: Blend::Once { bits: level_bits },
    }
}

/// 3dfx: alike but for the width of the fraction.
const fn voodoo(name: &'static str, fraction: u32) -> Arithmetic {
    Arithmetic {
        name,
        source: "MAME voodoo, 86Box, SpinalVoodoo (stored versions)",
        assumed: "MAME's rounding is not known, so SpinalVoodoo's truncation; MAME's level, 86Box and SpinalVoodoo have half of it; one level, its floor: trilinear takes two units",
        coordinate: texels(8),
        fraction,
        shape: Shape::Square,
        weights: Weights::Binary,
        rounding: Rounding::OnceTruncate,
        full_scale: 255,
        level: level(1, Logarithm::TableFloor { index: 7, entry: 8 }, 8),
        blend: Blend::None,
    }
}

/// The machines: this unit's own defaults for comparison, APIs, then the others.
pub const MACHINES: &[Arithmetic] = &[
    Arithmetic {
        name: "herf-12.20",
        source: "docs/numerics.md",
        assumed: "",
        coordinate: normalised(20),
        ..promised("", "", 8)
    },
    promised("d3d11", "D3D11_SUBTEXEL_FRACTIONAL_BIT_COUNT and D3D12_MIP_LOD_FRACTIONAL_BIT_COUNT", 8),
    promised("vulkan-roadmap-2022", "VK-GL-CTS vktApiFeatureInfo.cpp: 8 sub-texel, 6 mipmap", 6),
    Arithmetic {
        name: "vortex",
        source: "Vortex hw/rtl/tex/VX_tex_{addr,sampler,lerp}.sv",
        assumed: "the level is an operand there; here that of its software, whose fraction is 0",
        coordinate: normalised(23),
        fraction: 8,
        shape: Shape::Square,
        weights: Weights::OfOnes,
        rounding: Rounding::Staged,
        full_scale: 255,
        level: level(0, Logarithm::Whole, 0),
        blend: Blend::Lerp { bits: 8, weights: Weights::OfOnes, rounding: Rounding::Staged },
    },
    voodoo("voodoo-1", 4),
    voodoo("voodoo-2", 8),
    Arithmetic {
        name: "n64",
        source: "angrylion-rdp-plus tcoord.c, tex.c",
        assumed: "mid-texel, sharpen and detail modes are left out; two levels are blended in the combiner, rounded half up",
        coordinate: Coordinate { half_texel: false, ..texels(5) },
        fraction: 5,
        shape: Shape::Triangle,
        weights: Weights::Binary,
        rounding: Rounding::Staged,
        full_scale: 255,
        level: level(0, Logarithm::Linear, 8),
        blend: Blend::Lerp { bits: 8, weights: Weights::Binary, rounding: Rounding::Staged },
    },
    Arithmetic {
        name: "gamecube",
        source: "Dolphin VideoBackends/Software/TextureSampler.cpp, Rasterizer.cpp",
        assumed: "",
        coordinate: texels(7),
        fraction: 7,
        shape: Shape::Square,
        weights: Weights::Binary,
        rounding: Rounding::OnceTruncate,
        full_scale: 255,
        level: level(0, Logarithm::Linear, 4),
        blend: Blend::Lerp { bits: 4, weights: Weights::Binary, rounding: Rounding::OnceTruncate },
    },
    Arithmetic {
        name: "playstation-2",
        source: "PCSX2 GS software renderer (excerpts)",
        assumed: "lerps cut off; its level comes from Q by a cubic logarithm of unknown coefficients: the logarithm itself, of 16 bits, is taken",
        coordinate: texels(16),
        fraction: 4,
        shape: Shape::Square,
        weights: Weights::Binary,
        rounding: Rounding::StagedTruncate,
        full_scale: 255,
        level: level(0, Logarithm::Exact, 16),
        blend: Blend::Lerp { bits: 4, weights: Weights::Binary, rounding: Rounding::StagedTruncate },
    },
    Arithmetic {
        name: "milkymist",
        source: "Milkymist cores/tmu2/rtl: coordinates in 1/64 texel (numerics-input.md 1.1)",
        assumed: "half texel, weights and one truncation are not known; RGB565 there, 8 bits a channel here; no mipmaps",
        coordinate: texels(6),
        fraction: 6,
        shape: Shape::Square,
        weights: Weights::Binary,
        rounding: Rounding::OnceTruncate,
        full_scale: 255,
        level: None,
        blend: Blend::None,
    },
    Arithmetic {
        name: "gplgpu",
        source: "gplgpu hdl/de3d/des_frag_gen.v, de3d_texel_pipe.v, hdl/math/log2_table.v",
        assumed: "the pixel centre with a half texel; two levels meet in the fog blender, taken as a lerp of 8 bits half up",
        coordinate: texels(9),
        fraction: 9,
        shape: Shape::Square,
        weights: Weights::Complement,
        rounding: Rounding::Staged,
        full_scale: 255,
        level: level(0, Logarithm::Linear, 6),
        blend: Blend::Lerp { bits: 8, weights: Weights::Binary, rounding: Rounding::Staged },
    },
    Arithmetic {
        name: "swiftshader",
        source: "SwiftShader src/Pipeline/SamplerCore.cpp, 16-bit path",
        assumed: "channels widened by 257; the order of products as its four-weight path has it",
        coordinate: normalised(16),
        fraction: 16,
        shape: Shape::Square,
        weights: Weights::AlwaysComplement,
        rounding: Rounding::UpperHalves,
        full_scale: 65535,
        level: level(2, Logarithm::Linear, 16),
        blend: Blend::Lerp { bits: 16, weights: Weights::AlwaysComplement, rounding: Rounding::UpperHalves },
    },
    Arithmetic {
        name: "llvmpipe",
        source: "Mesa gallivm lp_bld_sample_aos.c",
        assumed: "the level cut off at 8 bits",
        coordinate: Coordinate { nearest: true, ..texels(8) },
        fraction: 8,
        shape: Shape::Square,
        weights: Weights::Binary,
        rounding: Rounding::Staged,
        full_scale: 255,
        level: level(1, Logarithm::Linear, 8),
        blend: Blend::Lerp { bits: 8, weights: Weights::Binary, rounding: Rounding::Staged },
    },
];
