//! BC7: one texel of a block of 4 x 4, in the eight modes of the BPTC specification (ARB_texture_compression_bptc; docs/numerics.md,
//! section 10.3).

use crate::datapath::Texel;

/// What the first bits of a block announce.
#[derive(Clone, Copy, Debug)]
struct Mode {
    subsets: u32,
    partition_bits: u32,
    rotation_bits: u32,
    selection_bits: u32,
    colour_bits: u32,
    alpha_bits: u32,
    /// One lowest bit for each endpoint.
    own_lowest: bool,
    /// One lowest bit for both endpoints of a subset.
    shared_lowest: bool,
    index_bits: u32,
    /// Bits of the second index, 0 where there is none.
    second_bits: u32,
}

#[rustfmt::skip]
const MODES: [Mode; 8] = {
    const fn mode(
        [subsets, partition_bits, rotation_bits, selection_bits]: [u32; 4],
        [colour_bits, alpha_bits]: [u32; 2],
        [own_lowest, shared_lowest]: [bool; 2],
        [index_bits, second_bits]: [u32; 2],
    ) -> Mode {
        Mode {
            subsets, partition_bits, rotation_bits, selection_bits, colour_bits, alpha_bits, own_lowest, shared_lowest,
            index_bits, second_bits,
        }
    }
    [
        mode([3, 4, 0, 0], [4, 0], [true, false], [3, 0]),
        mode([2, 6, 0, 0], [6, 0], [false, true], [3, 0]),
        mode([3, 6, 0, 0], [5, 0], [false, false], [2, 0]),
        mode([2, 6, 0, 0], [7, 0], [true, false], [2, 0]),
        mode([1, 0, 2, 1], [5, 6], [false, false], [2, 3]),
        mode([1, 0, 2, 0], [7, 8], [false, false], [2, 2]),
        mode([1, 0, 0, 0], [7, 7], [true, false], [4, 0]),
        mode([2, 6, 0, 0], [5, 5], [true, false], [2, 0]),
    ]
};

/// Weights of the second endpoint, of 64, for indices of 2, 3 and 4 bits.
const WEIGHTS: [&[u32]; 3] =
    [&[0, 21, 43, 64], &[0, 9, 18, 27, 37, 46, 55, 64], &[0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64]];

/// Subset of texel i in bit i: partitions of two subsets.
#[rustfmt::skip]
const TWO_SUBSETS: [u16; 64] = [
    0xCCCC, 0x8888, 0xEEEE, 0xECC8, 0xC880, 0xFEEC, 0xFEC8, 0xEC80, 0xC800, 0xFFEC, 0xFE80, 0xE800,
    0xFFE8, 0xFF00, 0xFFF0, 0xF000, 0xF710, 0x008E, 0x7100, 0x08CE, 0x008C, 0x7310, 0x3100, 0x8CCE,
    0x088C, 0x3110, 0x6666, 0x366C, 0x17E8, 0x0FF0, 0x718E, 0x399C, 0xAAAA, 0xF0F0, 0x5A5A, 0x33CC,
    0x3C3C, 0x55AA, 0x9696, 0xA55A, 0x73CE, 0x13C8, 0x324C, 0x3BDC, 0x6996, 0xC33C, 0x9966, 0x0660,
    0x0272, 0x04E4, 0x4E40, 0x2720, 0xC936, 0x936C, 0x39C6, 0x639C, 0x9336, 0x9CC6, 0x817E, 0xE718,
    0xCCF0, 0x0FCC, 0x7744, 0xEE22,
];

/// Subset of texel i in bits 2i and 2i + 1: partitions of three subsets.
#[rustfmt::skip]
const THREE_SUBSETS: [u32; 64] = [
    0xAA68_5050, 0x6A5A_5040, 0x5A5A_4200, 0x5450_A0A8, 0xA5A5_0000, 0xA0A0_5050, 0x5555_A0A0, 0x5A5A_5050,
    0xAA55_0000, 0xAA55_5500, 0xAAAA_5500, 0x9090_9090, 0x9494_9494, 0xA4A4_A4A4, 0xA9A5_9450, 0x2A0A_4250,
    0xA594_5040, 0x0A42_5054, 0xA5A5_A500, 0x55A0_A0A0, 0xA8A8_5454, 0x6A6A_4040, 0xA4A4_5000, 0x1A1A_0500,
    0x0050_A4A4, 0xAAA5_9090, 0x1469_6914, 0x6969_1400, 0xA085_85A0, 0xAA82_1414, 0x50A4_A450, 0x6A5A_0200,
    0xA9A5_8000, 0x5090_A0A8, 0xA8A0_9050, 0x2424_2424, 0x00AA_5500, 0x2492_4924, 0x2449_9224, 0x50A5_0A50,
    0x500A_A550, 0xAAAA_4444, 0x6666_0000, 0xA5A0_A5A0, 0x50A0_50A0, 0x6928_6928, 0x44AA_AA44, 0x6666_6600,
    0xAA44_4444, 0x54A8_54A8, 0x9580_9580, 0x9696_9600, 0xA854_54A8, 0x8095_9580, 0xAA14_1414, 0x9696_0000,
    0xAAAA_1414, 0xA050_50A0, 0xA0A5_A5A0, 0x9600_0000, 0x4080_4080, 0xA9A8_A9A8, 0xAAAA_AA44, 0x2A4A_5254,
];

/// The texel of subset 1 whose index has its top bit left out, of two subsets. That of subset 0 is always texel 0.
#[rustfmt::skip]
const ANCHOR_OF_TWO: [u8; 64] = [
    15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 2, 8, 2,
    2, 8, 8, 15, 2, 8, 2, 2, 8, 8, 2, 2, 15, 15, 6, 8, 2, 8, 15, 15,
    2, 8, 2, 2, 2, 15, 15, 6, 6, 2, 6, 8, 15, 15, 2, 2, 15, 15, 15, 15,
    15, 2, 2, 15,
];

/// The same of three subsets, for subsets 1 and 2.
#[rustfmt::skip]
const ANCHORS_OF_THREE: [[u8; 2]; 64] = [
    [3, 15], [3, 8], [15, 8], [15, 3], [8, 15], [3, 15], [15, 3], [15, 8], [8, 15], [8, 15],
    [6, 15], [6, 15], [6, 15], [5, 15], [3, 15], [3, 8], [3, 15], [3, 8], [8, 15], [15, 3],
    [3, 15], [3, 8], [6, 15], [10, 8], [5, 3], [8, 15], [8, 6], [6, 10], [8, 15], [5, 15],
    [15, 10], [15, 8], [8, 15], [15, 3], [3, 15], [5, 10], [6, 10], [10, 8], [8, 9], [15, 10],
    [15, 6], [3, 15], [15, 8], [5, 15], [15, 3], [15, 6], [15, 6], [15, 8], [3, 15], [15, 3],
    [5, 15], [5, 15], [5, 15], [8, 15], [5, 15], [10, 15], [5, 15], [10, 15], [8, 15], [13, 15],
    [15, 3], [12, 15], [3, 15], [3, 8],
];

/// A block as it is read from bit 0 upwards.
struct Bits {
    block: u128,
    next: u32,
}

impl Bits {
    #[inline]
    fn take(&mut self, count: u32) -> u32 {
        let value = (self.block >> self.next) as u32 & ((1 << count) - 1);
        self.next += count;
        value
    }
}

/// Texels of a partition's subsets whose index is one bit short, beside texel 0.
fn anchors(subsets: u32, partition: usize) -> &'static [u8] {
    match subsets {
        2 => core::slice::from_ref(&ANCHOR_OF_TWO[partition]),
        3 => &ANCHORS_OF_THREE[partition],
        _ => &[],
    }
}

fn subset_of(subsets: u32, partition: usize, position: u32) -> u32 {
    match subsets {
        2 => u32::from(TWO_SUBSETS[partition] >> position & 1),
        3 => THREE_SUBSETS[partition] >> (2 * position) & 3,
        _ => 0,
    }
}

/// Where the index of a texel stands in its list, and its bits: anchors before it and itself are one bit short.
fn index_place(position: u32, bits: u32, anchors: &[u8]) -> (u32, u32) {
    let is_anchor = position == 0 || anchors.iter().any(|&anchor| u32::from(anchor) == position);
    let short_before =
        u32::from(position > 0) + anchors.iter().filter(|&&anchor| u32::from(anchor) < position).count() as u32;
    (position * bits - short_before, bits - u32::from(is_anchor))
}

/// A code of `bits` bits as 8, its upper bits repeated below.
const fn expand(code: u32, bits: u32) -> u32 {
    let high = code << (8 - bits);
    high | high >> bits
}

/// The texel at a position of a BC7 block of 16 bytes; transparent black in the reserved mode.
pub fn texel(block: &[u8], position: u32) -> Texel {
    let mut bytes = [0; 16];
    bytes.copy_from_slice(&block[..16]);
    let number = bytes[0].trailing_zeros();
    let Some(mode) = MODES.get(number as usize) else { return [0; 4] };
    let mut bits = Bits { block: u128::from_le_bytes(bytes), next: number + 1 };
    let partition = bits.take(mode.partition_bits) as usize;
    let rotation = bits.take(mode.rotation_bits);
    let selection = bits.take(mode.selection_bits);
    let subset = subset_of(mode.subsets, partition, position);

    // Codes lie channel by channel, endpoint by endpoint.
    let endpoints = 2 * mode.subsets;
    let first = bits.next;
    let alpha_first = first + 3 * endpoints * mode.colour_bits;
    let lowest_first = alpha_first + endpoints * mode.alpha_bits;
    let code = |at: u32, count: u32| Bits { block: bits.block, next: at }.take(count);
    let endpoint = |number: u32| -> [u32; 4] {
        let lowest = if mode.own_lowest {
            Some(code(lowest_first + number, 1))
        } else if mode.shared_lowest {
            Some(code(lowest_first + number / 2, 1))
        } else {
            None
        };
        let whole = |code: u32, bits: u32| match lowest {
            Some(lowest) => expand(code << 1 | lowest, bits + 1),
            None => expand(code, bits),
        };
        let colour = |channel: u32| {
            whole(code(first + (channel * endpoints + number) * mode.colour_bits, mode.colour_bits), mode.colour_bits)
        };
        let alpha = match mode.alpha_bits {
            0 => 255,
            bits => whole(code(alpha_first + number * bits, bits), bits),
        };
        [colour(0), colour(1), colour(2), alpha]
    };
    let [low, high] = [endpoint(2 * subset), endpoint(2 * subset + 1)];

    let lowest_bits = if mode.own_lowest {
        endpoints
    } else if mode.shared_lowest {
        mode.subsets
    } else {
        0
    };
    let indices = lowest_first + lowest_bits;
    let anchors = anchors(mode.subsets, partition);
    let weight = |list: u32, bits: u32| {
        let (place, count) = index_place(position, bits, anchors);
        WEIGHTS[bits as usize - 2][code(list + place, count) as usize]
    };
    let first_weight = weight(indices, mode.index_bits);
    let [colour_weight, alpha_weight] = if mode.second_bits == 0 {
        [first_weight; 2]
    } else {
        // The first list has one short index, its texel 0.
        let second_weight = weight(indices + 16 * mode.index_bits - 1, mode.second_bits);
        if selection == 0 { [first_weight, second_weight] } else { [second_weight, first_weight] }
    };
    let between = |channel: usize, weight: u32| ((64 - weight) * low[channel] + weight * high[channel] + 32) >> 6;
    let mut texel = [
        between(0, colour_weight) as u8,
        between(1, colour_weight) as u8,
        between(2, colour_weight) as u8,
        between(3, alpha_weight) as u8,
    ];
    if rotation > 0 {
        texel.swap(rotation as usize - 1, 3);
    }
    texel
}
