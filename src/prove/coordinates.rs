//! Coordinates: every 12.20 value through every address mode, every f32 into 12.20.

use texunit_hw::{
    AddressMode, Format, Layout, PyramidKind, Surface,
    address::{AddressUnit, is_outside},
};

use super::{Chip, Proof, Tally, Work};
use crate::names::Named;

/// Textures: two sizes at a time, one an axis, powers of two and others, and the width of the fraction.
const SIZES: [([u32; 2], u8); 3] = [([1, 256], 8), ([5, 4096], 8), ([1000, 32768], 12)];

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

    /// To the next coordinate; whether into the next texel.
    #[inline]
    fn step(&mut self) -> bool {
        self.within += self.size;
        let next = self.within >= TURN;
        if next {
            self.within -= TURN;
            self.index += 1;
        }
        next
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

/// Both axes of a texture at one coordinate: the texels of a bilinear tap, and of a point tap.
struct Both {
    bilinear: [Walk; 2],
    point: [Walk; 2],
    pair: [[u64; 2]; 2],
    texel: [u64; 2],
    mode: AddressMode,
}

impl Both {
    fn at(coordinate: i64, size: [u32; 2], mode: AddressMode) -> Self {
        let bilinear = size.map(|size| Walk::at(coordinate, size, TURN / 2));
        let point = size.map(|size| Walk::at(coordinate, size, 0));
        let mut both = Self { bilinear, point, pair: [[0; 2]; 2], texel: [0; 2], mode };
        for axis in 0..2 {
            both.look_up(axis);
        }
        both
    }

    fn look_up(&mut self, axis: usize) {
        let Walk { index, size, .. } = self.bilinear[axis];
        self.pair[axis] = [index, index + 1].map(|index| standing_for(index, size, self.mode));
        self.texel[axis] = standing_for(self.point[axis].index, size, self.mode);
    }

    #[inline]
    fn step(&mut self) {
        for axis in 0..2 {
            if self.bilinear[axis].step() | self.point[axis].step() {
                self.look_up(axis);
            }
        }
    }
}

/// Where a texel lies, one byte each, row by row.
#[inline]
fn byte([column, row]: [u64; 2], width: u64) -> u64 {
    if column == NONE || row == NONE { NONE } else { column + row * width }
}

fn address_mode<C: Chip>(chip: &C, work: &Work<'_>, mode: AddressMode) -> Option<Tally> {
    const PIECE: i64 = 1 << 14;
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
            let width = u64::from(size[0]);
            let mut expected = Both::at(begin, *size, mode);
            for coordinate in begin..begin + PIECE {
                let tap = chip.bilinear(unit, coordinate, coordinate);
                let point = chip.point(unit, 0, coordinate, coordinate);
                let [columns, rows] = expected.pair;
                let mut right = true;
                for (number, &address) in tap.address.iter().enumerate() {
                    let texel = byte([columns[number & 1], rows[number >> 1]], width);
                    right &= if texel == NONE { is_outside(address) } else { address == texel * element };
                }
                let texel = byte(expected.texel, width);
                let address = point.address[0];
                right &= if texel == NONE { is_outside(address) } else { address == texel * element };
                for axis in 0..2 {
                    let fraction = expected.bilinear[axis].within / (TURN >> bits);
                    right &= i64::from(tap.fraction[axis]) == fraction;
                }
                tally.count(right, || {
                    format!(
                        "coordinate {coordinate} on {size:?}: {tap:?} and {point:?} instead of texels {:?} and {:?}",
                        expected.pair, expected.texel
                    )
                });
                expected.step();
            }
        }
        tally
    })
}

fn convert<C: Chip>(chip: &C, work: &Work<'_>) -> Option<Tally> {
    let modes: Vec<AddressMode> = AddressMode::ALL.iter().map(|(_, mode)| *mode).collect();
    work.over(512, |block| {
        let mut tally = Tally::default();
        for mantissa in
            (0..1u32 << 23).step_by(if work.quick { 8191 } else { 1 }).chain(work.quick.then_some((1 << 23) - 1))
        {
            let bits = (block as u32) << 23 | mantissa;
            for &mode in &modes {
                let found = chip.convert(bits, mode);
                let expected = fixed(f32::from_bits(bits), mode);
                let found = (found.value.to_bits(), found.undefined);
                tally.count(found == expected, || {
                    format!("{bits:#010X} under {}: {found:?} instead of {expected:?}", mode.name())
                });
            }
        }
        tally
    })
}

/// Section 1.1. Twenty bits more are exact in f64, and so is its floor.
#[inline]
fn fixed(x: f32, mode: AddressMode) -> (i32, bool) {
    let units = (f64::from(x) * TURN as f64).floor();
    let periodic = matches!(mode, AddressMode::Wrap | AddressMode::Mirror);
    if x.is_nan() || periodic && x.is_infinite() {
        (0, true)
    } else if periodic {
        // A float of 24 bits that reaches 2^62 has nothing below bit 32.
        (if units.abs() < 4.6e18 { units as i64 as i32 } else { 0 }, false)
    } else {
        (units.clamp(f64::from(i32::MIN), f64::from(i32::MAX)) as i32, false)
    }
}
