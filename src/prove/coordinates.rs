//! Coordinates: every 12.20 value through every address mode, every f32 into 12.20.

use texunit_hw::{
    AddressMode, Format, Layout, PyramidKind, Surface,
    address::{AddressUnit, is_outside},
};

use super::{Chip, Proof, Tally, Work};
use crate::names::Named;

/// Textures: two sizes at a time, one an axis, powers of two and others, and the width of the fraction.
const SIZES: [([u32; 2], u8); 2] = [([1, 256], 8), ([1000, 32768], 12)];

pub(super) fn proofs<C: Chip>() -> Vec<Proof<C>> {
    let of_mode = |&(name, mode): &(&str, AddressMode)| {
        let sizes: Vec<String> = SIZES.iter().flat_map(|(size, _)| size.map(|side| side.to_string())).collect();
        Proof::new(
            format!("coordinate-{name}"),
            format!(
                "address unit, {name}: every 12.20 coordinate, point and bilinear, on {} texels, against steps of a line",
                sizes.join(", ")
            ),
            move |chip: &C, work: &Work<'_>| address_mode(chip, work, mode),
        )
    };
    let mut proofs: Vec<Proof<C>> = AddressMode::ALL.iter().map(of_mode).collect();
    proofs.push(Proof::new(
        "convert",
        "front end: every f32 bit pattern to 12.20 under every address mode against f64 and i64",
        convert,
    ));
    proofs
}

/// Coordinate units in one repeat.
const TURN: i64 = 1 << 20;

/// A coordinate on its way along an axis, by addition and comparison only: the texel index without bounds, and how far in it, of
/// 2^20.
#[derive(Clone, Copy)]
struct Walk {
    index: i64,
    within: i64,
    size: i64,
}

impl Walk {
    /// At a coordinate, `half` a texel (of 2^20) back.
    fn at(coordinate: i64, size: u32, half: i64) -> Self {
        let position = i128::from(coordinate) * i128::from(size) - i128::from(half);
        let turn = i128::from(TURN);
        Self {
            index: position.div_euclid(turn) as i64,
            within: position.rem_euclid(turn) as i64,
            size: i64::from(size),
        }
    }

    /// Coordinates from here on in the same texel, this one among them.
    fn left(&self) -> i64 {
        (TURN - self.within + self.size - 1) / self.size
    }

    /// So many coordinates on, not beyond the first of the next texel.
    fn walk(&mut self, steps: i64) {
        self.within += steps * self.size;
        if self.within >= TURN {
            self.within -= TURN;
            self.index += 1;
        }
    }
}

/// No texel.
const NONE: u64 = u64::MAX;

/// The texel an index stands for: by how often the texture was passed.
fn standing_for(index: i64, size: i64, mode: AddressMode) -> u64 {
    let (passed, within) = (index.div_euclid(size), index.rem_euclid(size));
    let backwards = mode == AddressMode::Mirror && passed % 2 != 0;
    let texel = match mode {
        AddressMode::Clamp if passed < 0 => 0,
        AddressMode::Clamp if passed > 0 => size - 1,
        AddressMode::Clip if passed != 0 => return NONE,
        _ if backwards => size - 1 - within,
        _ => within,
    };
    texel as u64
}

/// Both axes of a texture at one coordinate.
#[derive(Clone, Copy)]
struct Both {
    bilinear: [Walk; 2],
    point: [Walk; 2],
}

impl Both {
    fn at(coordinate: i64, size: [u32; 2]) -> Self {
        Self {
            bilinear: size.map(|size| Walk::at(coordinate, size, TURN / 2)),
            point: size.map(|size| Walk::at(coordinate, size, 0)),
        }
    }

    /// Coordinates from here on with the same texels.
    fn left(&self) -> i64 {
        self.bilinear.iter().chain(&self.point).map(Walk::left).min().unwrap_or(1)
    }

    fn walk(&mut self, steps: i64) {
        self.bilinear.iter_mut().chain(&mut self.point).for_each(|walk| walk.walk(steps));
    }

    /// Where the texels lie, row by row: four of the bilinear tap, and the one of the point tap.
    fn addresses(&self, size: [u32; 2], mode: AddressMode, element: u64) -> ([u64; 4], u64) {
        let standing_for = |axis: usize, index: i64| standing_for(index, size[axis].into(), mode);
        let byte = |column: u64, row: u64| {
            if column == NONE || row == NONE { NONE } else { (column + row * u64::from(size[0])) * element }
        };
        let [columns, rows] =
            [0, 1].map(|axis| [0, 1].map(|next| standing_for(axis, self.bilinear[axis].index + next)));
        let [column, row] = [0, 1].map(|axis| standing_for(axis, self.point[axis].index));
        ([0, 1, 2, 3].map(|texel| byte(columns[texel & 1], rows[texel >> 1])), byte(column, row))
    }
}

fn address_mode<C: Chip>(chip: &C, work: &Work<'_>, mode: AddressMode) -> Option<Tally> {
    const PIECE: i64 = 1 << 16;
    const PIECES: i64 = (1 << 32) / PIECE;
    let units = SIZES.map(|(size, bits)| {
        let surface = Surface::new(PyramidKind::Sat, Layout::RowMajor, Format::L8, size[0], size[1])
            .expect("sizes that exist, row by row");
        (size, bits, AddressUnit::new(&surface, [mode; 2], bits), u64::from(surface.bytes_per_read()))
    });
    // Quick: both ends of the repeats around zero and at the ends of the range.
    let a_turn = TURN / PIECE;
    let near = |piece: &i64| [0, a_turn - 1].contains(&(piece % a_turn));
    let turns = [0, 1, 2046, 2047, 2048, 2049, 4094, 4095];
    let pieces: Vec<i64> =
        (0..PIECES).filter(|piece| !work.quick || near(piece) && turns.contains(&(piece / a_turn))).collect();
    work.over(pieces.len(), |number| {
        let begin = pieces[number] * PIECE - (1 << 31);
        let mut tally = Tally::default();
        for (size, bits, unit, element) in &units {
            let shift = TURN.ilog2() - u32::from(*bits);
            let mut expected = Both::at(begin, *size);
            let mut coordinate = begin;
            while coordinate < begin + PIECE {
                // As far as the texels are the same only the fractions change: that loop has no branch.
                let steps = expected.left().min(begin + PIECE - coordinate);
                let (four, one) = expected.addresses(*size, mode, *element);
                let [within_u, within_v] = expected.bilinear.map(|walk| walk.within);
                let [side_u, side_v] = size.map(i64::from);
                let is_wrong = |step: i64| {
                    let tap = chip.bilinear(unit, coordinate + step, coordinate + step);
                    let point = chip.point(unit, 0, coordinate + step, coordinate + step);
                    let seen = |address: u64| if is_outside(address) { NONE } else { address };
                    let mut wrong = seen(point.address[0]) ^ one;
                    for (address, expected) in tap.address.into_iter().zip(four) {
                        wrong |= seen(address) ^ expected;
                    }
                    wrong |= u64::from(tap.fraction[0]) ^ ((within_u + step * side_u) >> shift) as u64;
                    wrong |= u64::from(tap.fraction[1]) ^ ((within_v + step * side_v) >> shift) as u64;
                    wrong != 0
                };
                let wrong: u64 = (0..steps).map(|step| u64::from(is_wrong(step))).sum();
                tally.compared += steps as u64;
                tally.mismatches += wrong;
                if wrong > 0 && tally.first.is_none() {
                    tally.first = (0..steps).find(|step| is_wrong(*step)).map(|step| {
                        let at = coordinate + step;
                        let (tap, point) = (chip.bilinear(unit, at, at), chip.point(unit, 0, at, at));
                        format!("coordinate {at} on {size:?}: {tap:?} and {point:?} instead of {four:?} and {one}")
                    });
                }
                expected.walk(steps);
                coordinate += steps;
            }
        }
        tally
    })
}

fn convert<C: Chip>(chip: &C, work: &Work<'_>) -> Option<Tally> {
    use AddressMode::{Clamp, Clip, Mirror, Wrap};
    work.over(512, |block| {
        let mut tally = Tally::default();
        for mantissa in
            (0..1u32 << 23).step_by(if work.quick { 8191 } else { 1 }).chain(work.quick.then_some((1 << 23) - 1))
        {
            let bits = (block as u32) << 23 | mantissa;
            let expected = Fixed::of(f32::from_bits(bits));
            let of_mode = |mode: AddressMode| {
                let found = chip.convert(bits, mode);
                (found.value.to_bits(), found.undefined)
            };
            let mut compare = |mode: AddressMode, expected: (i32, bool)| {
                tally.count(of_mode(mode) == expected, || {
                    format!("{bits:#010X} under {}: {:?} instead of {expected:?}", mode.name(), of_mode(mode))
                });
            };
            compare(Wrap, expected.periodic);
            compare(Mirror, expected.periodic);
            compare(Clamp, expected.saturated);
            compare(Clip, expected.saturated);
        }
        tally
    })
}

/// Section 1.1 for one float: coordinate and whether it is undefined.
struct Fixed {
    periodic: (i32, bool),
    saturated: (i32, bool),
}

impl Fixed {
    /// Twenty bits more are exact in f64.
    #[inline]
    fn of(x: f32) -> Self {
        if !x.is_finite() {
            let end = if x > 0.0 { i32::MAX } else { i32::MIN };
            return Self { periodic: (0, true), saturated: if x.is_nan() { (0, true) } else { (end, false) } };
        }
        let units = f64::from(x) * TURN as f64;
        if units.abs() < 4.6e18 {
            // Towards zero, then one less if that was up: the floor.
            let towards_zero = units as i64;
            let floor = towards_zero - i64::from(towards_zero as f64 > units);
            let saturated = floor.clamp(i32::MIN.into(), i32::MAX.into());
            Self { periodic: (floor as i32, false), saturated: (saturated as i32, false) }
        } else {
            // A float of 24 bits that reaches 2^62 has nothing below bit 32.
            Self { periodic: (0, false), saturated: (if units > 0.0 { i32::MAX } else { i32::MIN }, false) }
        }
    }
}
