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

/// No texel.
const NONE: u64 = u64::MAX;

/// A texel of an axis that repeats: of which copy of the texture, and which of it.
#[derive(Clone, Copy)]
struct Repeated {
    copy: i64,
    texel: i64,
}

impl Repeated {
    /// The one after it.
    fn next(self, size: i64) -> Self {
        if self.texel + 1 == size {
            Self { copy: self.copy + 1, texel: 0 }
        } else {
            Self { texel: self.texel + 1, ..self }
        }
    }

    /// The texel of the texture it stands for: by which copy it is of.
    fn standing_for(self, size: i64, mode: AddressMode) -> u64 {
        let Self { copy, texel } = self;
        let is_backwards = mode == AddressMode::Mirror && copy % 2 != 0;
        let texel = match mode {
            AddressMode::Clamp if copy < 0 => 0,
            AddressMode::Clamp if copy > 0 => size - 1,
            AddressMode::Clip if copy != 0 => return NONE,
            _ if is_backwards => size - 1 - texel,
            _ => texel,
        };
        texel as u64
    }
}

/// A coordinate on its way along an axis, by addition and comparison only: a texel, and how far in it, of 2^20.
#[derive(Clone, Copy)]
struct Walk {
    at: Repeated,
    within: i64,
    size: i64,
}

impl Walk {
    /// At a coordinate, `half` a texel (of 2^20) back.
    fn at(coordinate: i64, size: u32, half: i64) -> Self {
        let size = i64::from(size);
        let position = i128::from(coordinate) * i128::from(size) - i128::from(half);
        let (turn, side) = (i128::from(TURN), i128::from(size));
        let index = position.div_euclid(turn);
        let at = Repeated { copy: index.div_euclid(side) as i64, texel: index.rem_euclid(side) as i64 };
        Self { at, within: position.rem_euclid(turn) as i64, size }
    }

    /// Coordinates from here on in the same texel, this one among them.
    fn left(&self) -> i64 {
        // Both fit 32 bits, whose division is several times as fast.
        i64::from((TURN - self.within + self.size - 1) as u32 / self.size as u32)
    }

    /// So many coordinates on, not beyond the first of the next texel.
    fn walk(&mut self, steps: i64) {
        self.within += steps * self.size;
        if self.within >= TURN {
            self.within -= TURN;
            self.at = self.at.next(self.size);
        }
    }
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
    fn addresses(&self, mode: AddressMode, element: u64) -> ([u64; 4], u64) {
        let width = self.point[0].size as u64;
        let byte = |column: u64, row: u64| {
            if column == NONE || row == NONE { NONE } else { (column + row * width) * element }
        };
        let [columns, rows] = self
            .bilinear
            .map(|Walk { at, size, .. }| [at, at.next(size)].map(|repeated| repeated.standing_for(size, mode)));
        let [column, row] = self.point.map(|walk| walk.at.standing_for(walk.size, mode));
        ([0, 1, 2, 3].map(|texel| byte(columns[texel & 1], rows[texel >> 1])), byte(column, row))
    }
}

/// Coordinates with the same texels: only the fractions change among them, and a loop over them has no branch.
struct Run {
    begin: i64,
    /// Addresses of the bilinear tap, and that of the point tap.
    four: [u64; 4],
    one: u64,
    /// How far in a texel the bilinear tap is at the first, of 2^20, and how much farther at each of the others.
    within: [i64; 2],
    sides: [i64; 2],
    /// From 2^20 of a texel to the bits of a fraction.
    shift: u32,
}

impl Run {
    /// Bits in which the taps of a coordinate are not as they should be. `CLIPPED` if some texels are none; where all are there an
    /// address outside differs from any.
    #[inline(always)]
    fn differing<const CLIPPED: bool>(&self, chip: &impl Chip, unit: &AddressUnit, step: i64) -> u64 {
        let at = self.begin + step;
        let seen = |address: u64| if CLIPPED && is_outside(address) { NONE } else { address };
        let mut differing = seen(chip.point(unit, 0, at, at).address[0]) ^ self.one;
        let tap = chip.bilinear(unit, at, at);
        for texel in 0..4 {
            differing |= seen(tap.address[texel]) ^ self.four[texel];
        }
        for axis in 0..2 {
            let fraction = (self.within[axis] + step * self.sides[axis]) >> self.shift;
            differing |= u64::from(tap.fraction[axis]) ^ fraction as u64;
        }
        differing
    }

    /// The wrong ones of so many coordinates: the first, and how many.
    fn wrong<const CLIPPED: bool>(&self, chip: &impl Chip, unit: &AddressUnit, steps: i64) -> Option<(i64, u64)> {
        let mut any = 0;
        for step in 0..steps {
            any |= self.differing::<CLIPPED>(chip, unit, step);
        }
        if any == 0 {
            return None;
        }
        let mut wrong = (0..steps).filter(|&step| self.differing::<CLIPPED>(chip, unit, step) != 0);
        wrong.next().map(|first| (first, 1 + wrong.count() as u64))
    }
}

/// One texture of [`SIZES`] under an address mode.
struct Axes {
    size: [u32; 2],
    mode: AddressMode,
    unit: AddressUnit,
    /// Bytes of a texel.
    element: u64,
    shift: u32,
}

impl Axes {
    fn new(size: [u32; 2], bits: u8, mode: AddressMode) -> Self {
        let surface = Surface::new(PyramidKind::Sat, Layout::RowMajor, Format::L8, size[0], size[1])
            .expect("sizes that exist, row by row");
        let unit = AddressUnit::new(&surface, [mode; 2], bits);
        let (element, shift) = (surface.bytes_per_read().into(), TURN.ilog2() - u32::from(bits));
        Self { size, mode, unit, element, shift }
    }

    /// The coordinates of a piece.
    fn piece<C: Chip>(&self, chip: &C, begin: i64, end: i64, tally: &mut Tally) {
        let mut expected = Both::at(begin, self.size);
        let mut coordinate = begin;
        while coordinate < end {
            let steps = expected.left().min(end - coordinate);
            let (four, one) = expected.addresses(self.mode, self.element);
            let (within, sides) = (expected.bilinear.map(|walk| walk.within), expected.bilinear.map(|walk| walk.size));
            let run = Run { begin: coordinate, four, one, within, sides, shift: self.shift };
            let wrong = if one == NONE || four.contains(&NONE) {
                run.wrong::<true>(chip, &self.unit, steps)
            } else {
                run.wrong::<false>(chip, &self.unit, steps)
            };
            tally.compared += steps as u64;
            if let Some((first, count)) = wrong {
                tally.mismatches += count;
                tally.first.get_or_insert_with(|| {
                    let at = coordinate + first;
                    let (tap, point) = (chip.bilinear(&self.unit, at, at), chip.point(&self.unit, 0, at, at));
                    format!("coordinate {at} on {:?}: {tap:?} and {point:?} instead of {four:?} and {one}", self.size)
                });
            }
            expected.walk(steps);
            coordinate += steps;
        }
    }
}

fn address_mode<C: Chip>(chip: &C, work: &Work<'_>, mode: AddressMode) -> Option<Tally> {
    const PIECE: i64 = 1 << 16;
    const PIECES: i64 = (1 << 32) / PIECE;
    let textures = SIZES.map(|(size, bits)| Axes::new(size, bits, mode));
    // Quick: both ends of the repeats around zero and at the ends of the range.
    let a_turn = TURN / PIECE;
    let near = |piece: &i64| [0, a_turn - 1].contains(&(piece % a_turn));
    let turns = [0, 1, 2046, 2047, 2048, 2049, 4094, 4095];
    let pieces: Vec<i64> =
        (0..PIECES).filter(|piece| !work.quick || near(piece) && turns.contains(&(piece / a_turn))).collect();
    work.over(pieces.len(), |number| {
        let begin = pieces[number] * PIECE - (1 << 31);
        let mut tally = Tally::default();
        textures.iter().for_each(|texture| texture.piece(chip, begin, begin + PIECE, &mut tally));
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
