//! Golden traces of the units, from the Rust units.

use std::collections::VecDeque;

use texunit_hw::{
    AddressMode, Filter, Format, I12F20, Layout, LevelRounding, LodSource, Log2, PyramidKind, Request, Response,
    Rounding, Sampler, Surface, Unit,
    address::{AddressUnit, is_outside},
    coordinate::{period_mask, resolve, texel_pair, texel_under},
    datapath::lerp,
    lod::{LevelRange, raw_level},
    taps::weight_bits,
};

use crate::{
    lines::CachedLines,
    trace::{Random, Trace},
    whole::Taps,
};

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

/// Coordinates worth trying on an axis of `size` texels.
fn coordinate(random: &mut Random, size: u32) -> i32 {
    let texel = (1 << 20) / i64::from(size);
    let whole = random.pick(&[
        -(1i64 << 31),
        -(2 << 20),
        -(1 << 20),
        -texel,
        0,
        texel,
        1 << 19,
        1 << 20,
        2 << 20,
        (1 << 31) - 1,
    ]);
    let near = random.pick(&[-1, 0, 1, texel / 2, -texel / 2, texel / 2 - 1, -texel / 2 - 1]);
    match random.below(3) {
        0 => random.next() as i32,
        1 => (random.below(4 << 20) as i64 - (2 << 20)) as i32,
        _ => (whole + near).clamp(i32::MIN.into(), i32::MAX.into()) as i32,
    }
}

/// The coordinate unit: every size, mode and tap.
pub fn coordinates(filter_bits: u8) -> Trace {
    let mut trace = Trace::new(
        "coordinate",
        &["index is 0 and not compared where outside"],
        &[
            ("coordinate", 32),
            ("log2_size", 4),
            ("mode", 4),
            ("point", 4),
            ("upper", 4),
            ("index", 16),
            ("outside", 4),
            ("fraction", 12),
        ],
    );
    let mut random = Random(3);
    for log2_size in 0..=12u32 {
        for mode in MODES {
            for _ in 0..24 {
                let size = 1 << log2_size;
                let point = random.once_in(4);
                let upper = !point && random.once_in(2);
                let bits = coordinate(&mut random, size);
                let reduced = i64::from(bits) & period_mask(mode);
                let pair = texel_pair(reduced, size, filter_bits.into());
                let (index, fraction) =
                    if point { (texel_under(reduced, size), 0) } else { (pair.lower, pair.fraction) };
                let index = resolve(index + i64::from(upper), size, mode);
                trace.push([
                    bits.cast_unsigned().into(),
                    log2_size.into(),
                    code(mode, &MODES),
                    point.into(),
                    upper.into(),
                    index.unwrap_or(0).into(),
                    index.is_none().into(),
                    fraction.into(),
                ]);
            }
        }
    }
    trace
}

/// The layout a flag of the unit selects.
pub fn layout(tiled: bool) -> Layout {
    if tiled { Layout::Tiled { log2_width: 2, log2_height: 2 } } else { Layout::RowMajor }
}

/// A surface with sides of powers of two.
pub fn surface_of(kind: PyramidKind, tiled: bool, log2: [u32; 2]) -> Surface {
    Surface::new(kind, layout(tiled), Format::Rgba8, 1 << log2[0], 1 << log2[1]).expect("sides within limits")
}

/// The address unit: both layouts, all planes of both pyramids.
pub fn addresses() -> Trace {
    let mut trace = Trace::new(
        "address",
        &["address is 0 and not compared where outside"],
        &[("u", 32), ("v", 32), ("base", 32), ("log2_width", 4), ("log2_height", 4), ("mode_u", 4), ("mode_v", 4)]
            .into_iter()
            .chain([
                ("tiled", 4),
                ("point", 4),
                ("corner", 4),
                ("address", 32),
                ("outside", 4),
                ("fraction_u", 12),
                ("fraction_v", 12),
            ])
            .collect::<Vec<_>>(),
    );
    let mut random = Random(4);
    for turn in 0..60 {
        let log2 = if turn < 9 {
            [[12, 12], [0, 0], [12, 0], [0, 12], [1, 1], [2, 2], [3, 1], [1, 3], [2, 7]][turn]
        } else {
            [0; 2].map(|_| random.below(11) as u32)
        };
        let tiled = turn % 3 != 0;
        let kind = if turn % 2 == 0 { PyramidKind::Mipmap } else { PyramidKind::Dipmap };
        let surface = surface_of(kind, tiled, log2);
        let modes = [random.pick(&MODES), random.pick(&MODES)];
        let unit = AddressUnit::new(&surface, modes, 8);
        for _ in 0..20 {
            let index = random.below(surface.planes.len() as u64) as usize;
            let plane = &surface.planes[index];
            let [u, v] = [0, 1].map(|axis| coordinate(&mut random, plane.size()[axis]));
            let point = random.once_in(4);
            let footprint = if point {
                unit.point(index, u.into(), v.into(), 1)
            } else {
                unit.bilinear(index, u.into(), v.into(), 1)
            };
            let corner = if point { 0 } else { random.below(4) };
            let address = footprint.address[corner as usize];
            let outside = is_outside(address);
            trace.push([
                u.cast_unsigned().into(),
                v.cast_unsigned().into(),
                plane.base,
                plane.width.ilog2().into(),
                plane.height.ilog2().into(),
                code(modes[0], &MODES),
                code(modes[1], &MODES),
                tiled.into(),
                point.into(),
                corner,
                if outside { 0 } else { address },
                outside.into(),
                footprint.fraction[0].into(),
                footprint.fraction[1].into(),
            ]);
        }
    }
    trace
}

/// The surface unit: start, then look up every plane; resets before, between and in the middle of a walk.
pub fn surfaces() -> Trace {
    let mut trace = Trace::new(
        "surface",
        &[
            "op 0 idle clock, 1 start, 2 look up (waits for the walk to end), 3 reset; start and look-up carry the same texture",
            "clocks: length of the walk, compared at the first look-up after a start",
        ],
        &[("op", 4), ("dipmap", 4), ("tiled", 4), ("log2_width", 4), ("log2_height", 4), ("plane", 8)]
            .into_iter()
            .chain([("base", 32), ("plane_log2_width", 4), ("plane_log2_height", 4), ("clocks", 8)])
            .collect::<Vec<_>>(),
    );
    let mut random = Random(5);
    for turn in 0..40 {
        let log2 = if turn < 5 {
            [[12, 12], [0, 0], [12, 0], [0, 12], [1, 2]][turn]
        } else {
            [0; 2].map(|_| random.below(13) as u32)
        };
        let (dipmap, tiled) = (turn % 2 == 1, turn % 3 != 0);
        let kind = if dipmap { PyramidKind::Dipmap } else { PyramidKind::Mipmap };
        let surface = surface_of(kind, tiled, log2);
        let texture = [u64::from(dipmap), u64::from(tiled), log2[0].into(), log2[1].into()];
        let mut add = |op: u64, plane: u64, answer: [u64; 4]| {
            let mut line = vec![op];
            line.extend(texture);
            line.push(plane);
            line.extend(answer);
            trace.push(line);
        };
        if turn % 7 == 3 {
            // A walk cut short.
            add(1, 0, [0; 4]);
            add(0, 0, [0; 4]);
            add(3, 0, [0; 4]);
            add(0, 0, [0; 4]);
        }
        add(1, 0, [0; 4]);
        let planes = surface.planes.len() as u64;
        for (index, plane) in (0..).zip(&surface.planes) {
            add(2, index, [plane.base, plane.width.ilog2().into(), plane.height.ilog2().into(), planes]);
        }
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
            let mut seen = Taps::default();
            let mut response = [Response::default()];
            unit.run(&[request], &mut response, &mut seen);
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
                seen.taps.len() as u64,
            ]);
            for tap in 0..2 {
                let (plane, weight) =
                    seen.taps.get(tap).map_or((0, 0), |tap| (tap.plane, u64::from(tap.weight) << shift));
                line.extend([plane.into(), weight]);
            }
            line.extend(response[0].lod.map(u64::from));
            trace.push(line);
        }
    }
    trace
}

/// The cache tags, clock by clock: idle clocks, look-ups without update, flushes and resets.
pub fn cache(sets: u64, ways: usize) -> Trace {
    let mut trace = Trace::new(
        "cache",
        &["one clock a line; hit and way are compared in every clock, with or without update"],
        &[("reset", 4), ("flush", 4), ("update", 4), ("line", 24), ("hit", 4), ("way", 4)],
    );
    let mut random = Random(7);
    let mut lines = CachedLines::new(sets, ways);
    let mut line = 0;
    for turn in 0..1500 {
        let [reset, flush] = [turn == 0 || random.once_in(200), turn > 0 && random.once_in(150)].map(u64::from);
        line = match random.below(8) {
            0 => line,
            1 => random.next() & 0x3f_ffff,
            2 => (line + 1) & 0x3f_ffff,
            // As many lines as fit, and half as many again, so that the order of use matters.
            _ => random.below(sets * ways as u64 * 3 / 2 + 1) ^ if random.once_in(20) { sets << 4 } else { 0 },
        };
        let update = u64::from(!random.once_in(5));
        if reset == 1 {
            lines.clear();
        }
        let (hit, way) = lines.find(line);
        trace.push([reset, flush, update, line, hit.into(), way]);
        if reset == 0 && flush == 1 {
            lines.clear();
        } else if reset == 0 && update == 1 {
            lines.touch(line);
        }
    }
    trace
}

/// The fragment FIFO, clock by clock: full and empty, written and read at once, reset while holding.
pub fn fragment_fifo(depth: usize) -> Trace {
    let mut trace = Trace::new(
        "fragment_fifo",
        &["one clock a line; outputs of the same clock; data_o is 0 and not compared where not valid"],
        &[
            ("reset", 4),
            ("valid_i", 4),
            ("ready_i", 4),
            ("data_i", 16),
            ("ready_o", 4),
            ("valid_o", 4),
            ("data_o", 16),
            ("held", 8),
        ],
    );
    let mut random = Random(8);
    let mut held: VecDeque<u64> = VecDeque::new();
    let mut writes_of_8 = 4;
    for turn in 0..1200 {
        // Stretches of filling, of draining and of balance.
        if turn % 40 == 0 {
            writes_of_8 = random.pick(&[0, 2, 4, 6, 8]);
        }
        let reset = turn == 0 || random.once_in(120);
        if reset {
            held.clear();
        }
        let valid = random.below(8) < writes_of_8;
        let ready = random.below(8) >= writes_of_8 || random.once_in(4);
        let data = random.next() & 0xffff;
        let (ready_out, front) = (held.len() < depth, held.front().copied());
        trace.push([
            reset.into(),
            valid.into(),
            ready.into(),
            data,
            ready_out.into(),
            front.is_some().into(),
            front.unwrap_or(0),
            held.len() as u64,
        ]);
        if !reset && ready && front.is_some() {
            held.pop_front();
        }
        if !reset && valid && ready_out {
            held.push_back(data);
        }
    }
    trace
}

/// The data banks, clock by clock: reads of filled slots, fills read through, clocks without enable.
pub fn memory(slots: usize) -> Trace {
    let mut trace = Trace::new(
        "memory",
        &["one clock a line; texel b of a line is seed + b * 0x9e3779b1; texel is the output of the next clock"],
        &[("enable", 4), ("fill", 4), ("slot", 8), ("seed", 32), ("word", 4), ("known", 4), ("texel", 32)],
    );
    let mut random = Random(10);
    let mut seeds = vec![None; slots];
    let mut shown: Option<u32> = None;
    for _ in 0..600 {
        let (enable, fill) = (!random.once_in(5), random.once_in(3));
        let (slot, seed, word) = (random.below(slots as u64), random.next() as u32, random.below(16));
        if enable {
            if fill {
                seeds[slot as usize] = Some(seed);
            }
            shown = seeds[slot as usize].map(|seed| seed.wrapping_add((word as u32).wrapping_mul(0x9e37_79b1)));
        }
        let known = shown.is_some().into();
        trace.push([enable.into(), fill.into(), slot, seed.into(), word, known, shown.unwrap_or(0).into()]);
    }
    trace
}

/// What lerp.sv answers: exact, eight bits longer, or rounded to 8 bits.
pub fn lerp_of(a: u64, b: u64, fraction: u64, rounding: Rounding) -> u64 {
    match rounding {
        Rounding::Once => lerp(a << 8, b << 8, fraction, 8, 0),
        Rounding::StagedRound => lerp(a, b, fraction, 8, 128),
        Rounding::StagedTruncate => lerp(a, b, fraction, 8, 0),
    }
}

/// One lerp: corners and random values.
pub fn lerps(rounding: Rounding) -> Trace {
    let fields = [("a", 8), ("b", 8), ("fraction", 8), ("value", 16)];
    let mut trace = Trace::new("lerp", &["8 fraction bits; value is exact (16 bits) or rounded to 8"], &fields);
    let mut random = Random(11);
    for turn in 0..1000u64 {
        let edge = [0, 1, 127, 128, 254, 255];
        let [a, b, fraction] = if turn < 216 {
            [edge[turn as usize / 36], edge[turn as usize / 6 % 6], edge[turn as usize % 6]]
        } else {
            [0; 3].map(|_| random.below(256))
        };
        trace.push([a, b, fraction, lerp_of(a, b, fraction, rounding)]);
    }
    trace
}

/// The datapath: texels, fractions and weights as the Rust unit saw them, and its answers.
pub fn datapath(filter_bits: u8, rounding: Rounding) -> Trace {
    let tap = |names: [&'static str; 7]| names.into_iter().zip([32, 32, 32, 32, 12, 12, 12]);
    let mut trace = Trace::new(
        "datapath",
        &[
            "before the item: reset, then idle clocks between its texels; after it is taken: stall clocks in which no response is taken",
            "texels (i0, j0), (i1, j0), (i0, j1), (i1, j1) of each tap, red in the lowest byte; a point tap has the first only",
        ],
        &[("reset", 4), ("idle", 4), ("stall", 4), ("taps", 4), ("point", 4)]
            .into_iter()
            .chain(tap(["t00", "t01", "t02", "t03", "fraction_u0", "fraction_v0", "weight_0"]))
            .chain(tap(["t10", "t11", "t12", "t13", "fraction_u1", "fraction_v1", "weight_1"]))
            .chain([("texel", 32)])
            .collect::<Vec<_>>(),
    );
    let mut random = Random(12);
    for turn in 0..60 {
        let filter = FILTERS[turn % 5];
        let address = [random.pick(&MODES), random.pick(&MODES)];
        let sampler =
            Sampler { filter, address, filter_bits, rounding, lod_source: LodSource::Explicit, ..Sampler::default() };
        let surface = surface_of(filter.pyramid(), true, [3, 2]);
        // Noise, extremes, and a flat colour, which must come out unchanged.
        let bytes: Vec<u8> = (0..surface.bytes)
            .map(|_| match turn / 5 % 3 {
                0 => random.next() as u8,
                1 => random.pick(&[0, 255]),
                _ => 0x5a,
            })
            .collect();
        let mut unit = Unit::new(&sampler, &surface, &bytes).expect("a unit");
        for _ in 0..10 {
            let [u, v] = [0; 2].map(|_| I12F20::from_bits(random.below(3 << 20) as i32 - (1 << 20)));
            let request = Request { scale: [0; 2].map(|_| random.below(0x400) as u32), ..Request::at(u, v) };
            let mut seen = Taps::default();
            let mut response = [Response::default()];
            unit.run(&[request], &mut response, &mut seen);
            let point = filter == Filter::Point;
            let mut line = random.pauses().to_vec();
            line.extend([seen.taps.len() as u64, point.into()]);
            for tap in 0..2 {
                let Some(tap) = seen.taps.get(tap) else {
                    line.extend([0; 7]);
                    continue;
                };
                for (corner, &address) in tap.address.iter().enumerate() {
                    let known = !is_outside(address) && (corner == 0 || !point);
                    let texel = if known { &bytes[address as usize..address as usize + 4] } else { &[0; 4] };
                    line.push(u32::from_le_bytes(texel.try_into().expect("four bytes")).into());
                }
                line.extend(tap.fraction.map(u64::from));
                line.push(u64::from(tap.weight) << (8 - weight_bits(filter)));
            }
            line.push(u32::from_le_bytes(response[0].texel).into());
            trace.push(line);
        }
    }
    trace
}
