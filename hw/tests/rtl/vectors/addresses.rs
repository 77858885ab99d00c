//! Of a coordinate to an address: the coordinate unit, the address unit and the table of planes.

use texunit_hw::{
    PyramidKind,
    address::{AddressUnit, is_outside},
    coordinate::{period_mask, resolve, texel_pair, texel_under},
};

use super::{MODES, code, surface_of};
use crate::trace::{Random, Trace};

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
