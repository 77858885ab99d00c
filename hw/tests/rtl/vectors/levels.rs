//! Of a ratio to the taps of levels: the LOD unit and the tap unit.

use texunit_hw::{
    LevelRounding, LodSource, Log2, Request, Response, Sampler, Unit,
    lod::{LevelRange, raw_level},
    taps::weight_bits,
};

use super::{FILTERS, LEVEL_ROUNDINGS, code, surface_of};
use crate::{
    trace::{Random, Trace},
    whole::footprints,
};

/// Wraps a signed number into `bits`.
fn bits_of(value: i64, bits: u32) -> u64 {
    value as u64 & ((1 << bits) - 1)
}

/// The LOD unit: every exponent, every boundary of the table, explicit levels, crossing clamps.
pub fn lod(log2: Log2, lod_bits: u8) -> Trace {
    let mut trace = Trace::new(
        "lod",
        &["inputs up to level_rounding, then outputs; raw is that of the ratio even for an explicit level"],
        &[("scale", 32), ("explicit", 4), ("bias", 16), ("min_lod", 16), ("max_lod", 16), ("last", 4)]
            .into_iter()
            .chain([("level_rounding", 4), ("raw", 16), ("clamped", 16), ("fractional", 16), ("whole", 4)])
            .collect::<Vec<_>>(),
    );
    let mut random = Random(9);
    let mut add = |scale: u32, explicit: bool, bias: i16, min_lod: i32, max_lod: i32, last: u8, rounding| {
        let sampler = Sampler { bias, min_lod, max_lod, lod_bits, log2, ..Sampler::default() };
        let ratio = raw_level(scale, log2);
        let raw = if explicit { scale.cast_signed() } else { ratio };
        let range = LevelRange::new(&sampler, last);
        trace.push([
            scale.into(),
            explicit.into(),
            bits_of(bias.into(), 14),
            min_lod as u64,
            max_lod as u64,
            last.into(),
            code(rounding, &LEVEL_ROUNDINGS),
            bits_of(ratio.into(), 16),
            range.clamp(raw) as u64,
            range.fractional(raw) as u64,
            range.whole(raw, rounding) as u64,
        ]);
    };
    // Every exponent at its first, second, a middle and its last mantissa.
    for exponent in 0..=255u32 {
        let mantissa = [0, 1, random.next() as u32 & 0x7f_ffff, 0x7f_ffff][exponent as usize % 4];
        add(exponent << 23 | mantissa, false, 0, 0, 32 << 8, 12, LevelRounding::Nearest);
    }
    // Both sides of every step of the logarithm, found by bisection.
    for step in 1..=128 {
        let (mut below, mut above) = (127u32 << 23, 128u32 << 23);
        while above - below > 1 {
            let middle = below + (above - below) / 2;
            if raw_level(middle, log2) < step { below = middle } else { above = middle }
        }
        add(below, false, 0, 0, 32 << 8, 12, LevelRounding::Floor);
        add(above, false, 0, 0, 32 << 8, 12, LevelRounding::Gl);
    }
    // Halves and their neighbours, where the rounding rules differ.
    for quarter in 0..=4 * 13u32 {
        for offset in [-1i32, 0, 1] {
            let level = (quarter as i32 * 64 + offset).cast_unsigned();
            for rounding in LEVEL_ROUNDINGS {
                add(level, true, 0, 0, 32 << 8, 12, rounding);
            }
        }
    }
    for extreme in [0, 1, u32::MAX, 1 << 31, (1 << 31) - 1, 0x8000_0001] {
        for bias in [-4096, -1, 0, 1, 4096] {
            add(extreme, true, bias, 0, 32 << 8, 12, LevelRounding::Nearest);
            add(extreme, false, bias, 0, 32 << 8, 12, LevelRounding::Nearest);
        }
    }
    for _ in 0..700 {
        let scale = if random.once_in(2) {
            random.next() as u32
        } else {
            ((100 + random.below(60)) as u32) << 23 | random.next() as u32 & 0x7f_ffff
        };
        let explicit = random.once_in(4);
        let scale = if explicit { scale % 0x1400 } else { scale };
        let bias = random.below(8193) as i16 - 4096;
        let bias = if random.once_in(2) { bias / 16 } else { bias };
        let [min_lod, max_lod] = [
            random.pick(&[0, random.0 as i32 & 0xfff, 8192]),
            random.pick(&[0, (random.0 >> 20) as i32 & 0xfff, 8192]),
        ];
        add(scale, explicit, bias, min_lod, max_lod, random.below(13) as u8, random.pick(&LEVEL_ROUNDINGS));
    }
    trace
}

/// The tap unit: what the Rust unit's taps were, for levels of every kind.
pub fn taps() -> Trace {
    let mut trace = Trace::new(
        "taps",
        &[
            "before the item: reset, then idle clocks; after it is taken: stall clocks in which no texel is taken",
            "weights sum to 256; a request of one tap has plane and weight 0 for the second",
        ],
        &[
            ("reset", 4),
            ("idle", 4),
            ("stall", 4),
            ("filter", 4),
            ("last", 4),
            ("last_u", 4),
            ("fractional", 16),
            ("whole", 4),
        ]
        .into_iter()
        .chain([("level_u", 4), ("level_v", 4), ("taps", 4), ("plane_0", 8), ("weight_0", 12), ("plane_1", 8)])
        .chain([("weight_1", 12), ("lod_u", 16), ("lod_v", 16)])
        .collect::<Vec<_>>(),
    );
    let mut random = Random(6);
    for turn in 0..100 {
        let filter = FILTERS[turn % 5];
        let log2 = [0; 2].map(|_| random.below(9) as u32);
        let level_rounding = random.pick(&LEVEL_ROUNDINGS);
        let sampler = Sampler { filter, level_rounding, lod_source: LodSource::Explicit, ..Sampler::default() };
        let surface = surface_of(filter.pyramid(), true, log2);
        let bytes = vec![0; surface.bytes as usize];
        let mut unit = Unit::new(&sampler, &surface, &bytes).expect("a unit of the default widths");
        let lasts = if filter.level_per_axis() { surface.last_levels } else { [surface.last_level(); 2] };
        for _ in 0..10 {
            let scale = [0; 2].map(|_| random.pick(&[0, 1, 127, 128, 129, 255, 256, random.0 as u32 & 0xfff]));
            let request = Request { scale, ..Request::default() };
            let taps = footprints(&mut unit, request);
            let mut response = [Response::default()];
            unit.run(&[request], &mut response, &mut ());
            let ranges = lasts.map(|last| LevelRange::new(&sampler, last));
            let raw = scale.map(u32::cast_signed);
            let shift = 8 - weight_bits(filter);
            let mut line = random.pauses().to_vec();
            line.extend([
                code(filter, &FILTERS),
                surface.last_level().into(),
                surface.last_levels[0].into(),
                ranges[0].fractional(raw[0]) as u64,
                ranges[0].whole(raw[0], level_rounding) as u64,
                ranges[0].clamp(raw[0]) as u64 >> 8,
                ranges[1].clamp(raw[1]) as u64 >> 8,
                taps.len() as u64,
            ]);
            for tap in 0..2 {
                let (plane, weight) = taps.get(tap).map_or((0, 0), |tap| (tap.plane, u64::from(tap.weight) << shift));
                line.extend([plane.into(), weight]);
            }
            line.extend(response[0].lod.map(u64::from));
            trace.push(line);
        }
    }
    trace
}
