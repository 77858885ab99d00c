//! The log2 units from docs/numerics.md, section 4.1, in other arithmetic than the chip's: powers of big integers for the exact one and
//! the tables, f64 (exact for numbers of so few bits) and u128 for the others.

use texunit_hw::Log2;

/// Mantissas of an octave.
pub const MANTISSAS: u32 = 1 << 23;

/// The mantissas `start..end` of an octave have this answer in 1/128 octave, counted from the octave's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// The first of them.
    pub start: u32,
    /// The first that is not.
    pub end: u32,
    /// `g` of section 4.1.
    pub value: i32,
}

/// A log2 unit over all mantissas: for even and for odd octaves.
#[derive(Clone, Debug)]
pub struct Answers {
    parity: [Vec<Segment>; 2],
}

impl Answers {
    /// Of a unit.
    #[must_use]
    pub fn of(log2: Log2) -> Self {
        let boundaries = boundaries(log2);
        Self { parity: [0, 1].map(|parity| segments(|mantissa| answer(log2, &boundaries, parity, mantissa))) }
    }

    /// The answers to the 2^23 bit patterns of a sign and an exponent field, complete raw levels.
    #[must_use]
    pub fn of_block(&self, sign_and_exponent: u32) -> Vec<Segment> {
        let exponent = (sign_and_exponent & 255) as i32;
        let all = |value| vec![Segment { start: 0, end: MANTISSAS, value }];
        match exponent {
            255 => all(16384),
            0 => all(-16256),
            _ => {
                let octave = exponent - 127;
                let of_octave = &self.parity[octave.rem_euclid(2) as usize];
                of_octave.iter().map(|segment| Segment { value: 128 * octave + segment.value, ..*segment }).collect()
            }
        }
    }
}

/// The runs of equal answers: where each ends is found by bisection, for by its definition no answer of a unit falls as the mantissa
/// rises.
fn segments(answer: impl Fn(u32) -> i32) -> Vec<Segment> {
    let mut segments = Vec::new();
    let mut start = 0;
    while start < MANTISSAS {
        let value = answer(start);
        let (mut end, mut other) = (start + 1, MANTISSAS);
        while end < other {
            let middle = u32::midpoint(end, other);
            if answer(middle) == value { end = middle + 1 } else { other = middle }
        }
        segments.push(Segment { start, end, value });
        start = end;
    }
    segments
}

/// The first mantissa with each of the answers 1..=128 of the exact unit; for tables the answers of their entries.
fn boundaries(log2: Log2) -> Vec<u32> {
    let entries = match log2 {
        Log2::Exact => {
            let first = |half_steps: u32| {
                let mut range = 0..MANTISSAS;
                while !range.is_empty() {
                    let middle = u32::midpoint(range.start, range.end);
                    if reaches(MANTISSAS + middle, 23, half_steps) {
                        range.end = middle
                    } else {
                        range.start = middle + 1
                    }
                }
                range.start
            };
            return (1..=128).map(|answer| first(2 * answer - 1)).collect();
        }
        Log2::Table128 => 128,
        Log2::Table64 => 64,
        Log2::Table16 => 16,
        _ => return Vec::new(),
    };
    // 1 + (2i + 1)/(2n), to the nearest 1/128 octave.
    let nearest = |entry: u32| {
        let reached = |answer: &u32| reaches(2 * entries + 2 * entry + 1, entries.ilog2() + 1, 2 * answer - 1);
        (1..=128).take_while(reached).count() as u32
    };
    (0..entries).map(nearest).collect()
}

/// Whether `numerator / 2^shift` is at least `2^(half_steps / 256)`: by its 256th power, exactly.
fn reaches(numerator: u32, shift: u32, half_steps: u32) -> bool {
    let mut power = vec![numerator];
    for _ in 0..8 {
        power = square(&power);
    }
    let bits = 32 * power.len() as u32 - power.last().map_or(0, |limb| limb.leading_zeros());
    bits > 256 * shift + half_steps
}

/// The square of a number of 32-bit limbs, lowest first, without leading zeros.
fn square(number: &[u32]) -> Vec<u32> {
    let mut product = vec![0u32; 2 * number.len()];
    for (i, &a) in number.iter().enumerate() {
        let mut carry = 0u64;
        for (j, &b) in number.iter().enumerate() {
            let sum = u64::from(a) * u64::from(b) + u64::from(product[i + j]) + carry;
            product[i + j] = sum as u32;
            carry = sum >> 32;
        }
        product[i + number.len()] = carry as u32;
    }
    while product.last() == Some(&0) {
        product.pop();
    }
    product
}

/// `g` of section 4.1 in an octave of this parity.
fn answer(log2: Log2, boundaries: &[u32], parity: u32, mantissa: u32) -> i32 {
    let x = f64::from(mantissa) / f64::from(MANTISSAS);
    match log2 {
        Log2::Exact => boundaries.partition_point(|first| *first <= mantissa) as i32,
        Log2::Table128 | Log2::Table64 | Log2::Table16 => {
            boundaries[(u64::from(mantissa) * boundaries.len() as u64 / u64::from(MANTISSAS)) as usize] as i32
        }
        Log2::Quadratic => {
            let y = (4096.0 * x).floor() / 4096.0;
            (128.0 * (y + 89.0 / 256.0 * y * (1.0 - y)) + 0.5).floor() as i32
        }
        Log2::Fourth => {
            let p = (1.0 + x) * (1.0 + x);
            if p < 2.0 { (64.0 * (p - 1.0)).floor() as i32 } else { 64 + (64.0 * (p / 2.0 - 1.0)).floor() as i32 }
        }
        Log2::Herf => (128.0 * x).floor() as i32,
        // floor(256 r) is the largest n with n^2 2^23 <= 2^16 (2^23 + m) 2^p.
        Log2::HerfPlain => {
            let limit = u128::from(MANTISSAS + mantissa) << (16 + parity);
            let fits = |n: u128| (n * n) << 23 <= limit;
            let mut root = (256.0 * ((1.0 + x) * f64::from(1 + parity)).sqrt()) as u128;
            while !fits(root) {
                root -= 1;
            }
            while fits(root + 1) {
                root += 1;
            }
            root as i32 - 256 - 128 * parity as i32
        }
        Log2::Ilog2 => -128 * parity as i32,
    }
}
