//! The datapath: one interpolation, four texels, two levels, over every fraction.

use texunit_hw::{
    AddressMode, Filter, Format, I12F20, Layout, LodSource, PyramidKind, Request, Response, Rounding, Sampler, Surface,
    Texel, Unit, memory::store_plane,
};

use super::{Bound, Chip, Proof, Tally, Work};
use crate::names::Named;

const ROUNDINGS: [Rounding; 3] = [Rounding::Once, Rounding::StagedRound, Rounding::StagedTruncate];

pub(super) fn proofs<C: Chip>() -> Vec<Proof<C>> {
    vec![
        Proof::new(
            "lerp",
            "one interpolation: every a, b and fraction of 8 bits, rounded and truncated, against i64 division; within a..b, monotone",
            lerp,
        ),
        Proof::new(
            "lerp-unit",
            "the whole unit on a row of two texels: every a, b and fraction of 8 bits under every rounding",
            lerp_unit,
        ),
        Proof::new(
            "bilinear",
            "the whole unit on 2 x 2 texels: every pair of fractions at every width 1..12 under every rounding; constants stay, within the corners, monotone",
            |chip: &C, work: &Work<'_>| weights(chip, work, false),
        ),
        Proof::new(
            "trilinear",
            "the same between two levels of 4 x 4: every u and level fraction at every width, with every v fraction up to 8 bits and four above",
            |chip: &C, work: &Work<'_>| weights(chip, work, true),
        ),
    ]
}

fn lerp<C: Chip>(chip: &C, work: &Work<'_>) -> Option<Tally> {
    work.over(if work.quick { 8 } else { 256 }, |piece| {
        let a = if work.quick { [0, 1, 2, 127, 128, 200, 254, 255][piece] } else { piece as i64 };
        let mut tally = Tally::default();
        for half in [0, 128] {
            for b in 0..256i64 {
                let mut before = a;
                for fraction in 0..256i64 {
                    let value = chip.lerp(a as u64, b as u64, fraction as u64, 8, half as u64) as i64;
                    let exact = (256 * a + (b - a) * fraction + half).div_euclid(256);
                    let within = (a.min(b)..=a.max(b)).contains(&value);
                    let monotone = (value - before) * (b - a) >= 0;
                    tally.count(value == exact && within && monotone, || {
                        format!("{a} to {b} at {fraction}/256 plus {half}: {value} instead of {exact}")
                    });
                    before = value;
                }
            }
        }
        tally
    })
}

/// A small texture.
struct Small {
    surface: Surface,
    bytes: Vec<u8>,
}

impl Small {
    /// A mipmap of these levels, largest first.
    fn new(size: [u32; 2], levels: &[Vec<Texel>]) -> Self {
        let surface = Surface::new(PyramidKind::Mipmap, Layout::RowMajor, Format::Rgba8, size[0], size[1])
            .expect("a small texture has every layout");
        let mut bytes = vec![0; surface.bytes as usize];
        for (level, texels) in levels.iter().enumerate() {
            store_plane(&surface, level, texels.as_flattened(), &mut bytes).expect("RGBA8 has room for any texel");
        }
        Self { surface, bytes }
    }

    fn bind(&self, sampler: Sampler) -> Bound<'_> {
        Bound { sampler, surface: &self.surface, bytes: &self.bytes }
    }
}

/// The answers to some requests.
fn ask<C: Chip>(chip: &C, unit: &mut Unit<'_>, requests: &[Request]) -> Vec<Response> {
    let mut responses = vec![Response::default(); requests.len()];
    chip.answer(unit, requests, &mut responses);
    responses
}

fn sampler(filter: Filter, filter_bits: u8, rounding: Rounding) -> Sampler {
    Sampler {
        filter,
        address: [AddressMode::Clamp; 2],
        filter_bits,
        rounding,
        lod_source: LodSource::Explicit,
        ..Sampler::default()
    }
}

fn lerp_unit<C: Chip>(chip: &C, work: &Work<'_>) -> Option<Tally> {
    // The fraction of u = 1/4 is 0 on a row of two texels; half way across the row v has one texel twice.
    let requests: Vec<Request> = (0..256)
        .map(|fraction| Request::at(I12F20::from_bits((1 << 18) + (fraction << 11)), I12F20::from_bits(1 << 19)))
        .collect();
    work.over(if work.quick { 8 } else { 256 }, |piece| {
        let a = if work.quick { 36 * piece as u8 } else { piece as u8 };
        let mut tally = Tally::default();
        for four in 0..64u8 {
            let right: Texel = std::array::from_fn(|channel| 4 * four + channel as u8);
            let texture = Small::new([2, 1], &[vec![[a; 4], right]]);
            for rounding in ROUNDINGS {
                let half = if rounding == Rounding::StagedTruncate { 0 } else { 128 };
                let mut unit = chip.unit(&texture.bind(sampler(Filter::Bilinear, 8, rounding)));
                let responses = ask(chip, &mut unit, &requests);
                for (fraction, response) in responses.iter().enumerate() {
                    for (channel, &b) in right.iter().enumerate() {
                        let exact = (256 * i64::from(a) + (i64::from(b) - i64::from(a)) * fraction as i64 + half)
                            .div_euclid(256);
                        tally.count(i64::from(response.texel[channel]) == exact, || {
                            let value = response.texel[channel];
                            format!("{} of {a} and {b} at {fraction}/256: {value} instead of {exact}", rounding.name())
                        });
                    }
                }
            }
        }
        tally
    })
}

/// Coordinate units in one repeat.
const TURN: i64 = 1 << 20;

/// A position on an axis of `size` texels under clamp: two texels and the fraction.
fn place(coordinate: i64, size: i64, bits: u32) -> ([usize; 2], i64) {
    let position = coordinate * size - TURN / 2;
    let lower = position.div_euclid(TURN);
    let fraction = position.rem_euclid(TURN) >> (TURN.ilog2() - bits);
    ([lower, lower + 1].map(|index| index.clamp(0, size - 1) as usize), fraction)
}

/// Section 6, the channels of one tap: with one rounding to come the exact sums in units of 2^-2b; else the values. Shifts of i64 are
/// divisions that floor.
fn tap(plane: &[Texel], size: i64, at: [i64; 2], bits: u32, rounding: Rounding) -> [i64; 4] {
    let ([i0, i1], f) = place(at[0], size, bits);
    let ([j0, j1], g) = place(at[1], size, bits);
    let texel = |i: usize, j: usize| plane[j * size as usize + i].map(i64::from);
    let four = [texel(i0, j0), texel(i1, j0), texel(i0, j1), texel(i1, j1)];
    std::array::from_fn(|channel| {
        let [a, b, c, d] = four.map(|texel| texel[channel]);
        if rounding == Rounding::Once {
            let top = (a << bits) + f * (b - a);
            let bottom = (c << bits) + f * (d - c);
            (top << bits) + g * (bottom - top)
        } else {
            let half = if rounding == Rounding::StagedRound { (1 << bits) >> 1 } else { 0 };
            let between = |a: i64, b: i64, fraction: i64| ((a << bits) + (b - a) * fraction + half) >> bits;
            between(between(a, b, f), between(c, d, f), g)
        }
    })
}

/// A texture and what is known of it beforehand: its least and largest value, and whether it rises along u, in each channel.
struct Subject {
    levels: Vec<Vec<Texel>>,
    side: i64,
    texture: Small,
    least: Texel,
    largest: Texel,
    rises: [bool; 4],
}

impl Subject {
    fn new(levels: Vec<Vec<Texel>>) -> Self {
        let side = levels[0].len().isqrt();
        let all = || levels.iter().flatten();
        let extreme = |pick: fn(u8, u8) -> u8| -> Texel {
            std::array::from_fn(|channel| all().map(|texel| texel[channel]).reduce(pick).unwrap_or(0))
        };
        let rises = std::array::from_fn(|channel| {
            let rises = |row: &[Texel]| row.is_sorted_by_key(|texel| texel[channel]);
            levels.iter().all(|level| level.chunks(level.len().isqrt()).all(rises))
        });
        let (least, largest) = (extreme(u8::min), extreme(u8::max));
        let texture = Small::new([side as u32; 2], &levels);
        Self { side: side as i64, texture, least, largest, rises, levels }
    }
}

/// Corner indicators, rising rows, two from a generator, and constants: all of them where there is time.
fn subjects(trilinear: bool, all_constants: bool) -> Vec<Subject> {
    let mut seed = 0x7E78_u32;
    let mut draw = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        seed.to_be_bytes()
    };
    let sides: &[usize] = if trilinear { &[4, 2, 1] } else { &[2, 1] };
    let of = |texel: &mut dyn FnMut(usize, usize, usize) -> Texel| {
        let level = |&side: &usize| (0..side * side).map(|at| texel(side, at % side, at / side)).collect();
        Subject::new(sides.iter().map(level).collect())
    };
    let mut subjects = vec![
        of(&mut |_, i, j| std::array::from_fn(|channel| if channel == 2 * (j % 2) + i % 2 { 255 } else { 0 })),
        of(&mut |side, i, j| {
            let rising = ((2 * i + 1) * 255 / (2 * side)) as u8;
            [rising, 255 * u8::from(i > 0), 100 + i as u8, (10 * i + 60 * j) as u8]
        }),
        of(&mut |_, _, _| draw()),
    ];
    for four in 0..if all_constants { 64u8 } else { 1 } {
        let base = if all_constants { 4 * four } else { 252 };
        subjects.push(of(&mut |_, _, _| std::array::from_fn(|channel| base + channel as u8)));
    }
    subjects
}

fn weights<C: Chip>(chip: &C, work: &Work<'_>, trilinear: bool) -> Option<Tally> {
    let [few, many] = [false, true].map(|all| subjects(trilinear, all && !trilinear));
    // A piece is a width and a fraction of v, or of the level.
    let rows = |bits: u32| if trilinear { 256 } else { 1 << bits };
    let pieces: Vec<(u32, i64)> = (1..=12u32)
        .flat_map(|bits| (0..rows(bits)).map(move |row| (bits, row)))
        .filter(|&(bits, row)| {
            let last = rows(bits) - 1;
            !work.quick || row == 0 || row == last || row == last / 2 + 1 || row % 97 == 31
        })
        .collect();
    work.over(pieces.len(), |piece| {
        let (bits, row) = pieces[piece];
        let one = 1i64 << bits;
        let columns: Vec<i64> = if work.quick && bits > 4 {
            (0..one).filter(|f| f % 61 == 7 || [0, 1, one / 2, one - 1].contains(f)).collect()
        } else {
            (0..one).collect()
        };
        // From one texel centre to the next on level 0.
        let side = if trilinear { 4 } else { 2 };
        let coordinate = |fraction: i64| (TURN / 2 + (side / 2 - 1) * TURN + fraction * (TURN >> bits)) / side;
        let rows: Vec<(i64, i32)> = match (trilinear, work.quick || bits > 8) {
            (false, _) => vec![(row, 0)],
            (true, false) => (0..one).map(|g| (g, row as i32)).collect(),
            (true, true) => [0, 1, one / 2, one - 1].into_iter().map(|g| (g, row as i32)).collect(),
        };
        let filter = if trilinear { Filter::Trilinear } else { Filter::Bilinear };
        let mut tally = Tally::default();
        for subject in if bits <= 8 && !(work.quick && bits > 4) { &many } else { &few } {
            for rounding in ROUNDINGS {
                let mut unit = chip.unit(&subject.texture.bind(sampler(filter, bits as u8, rounding)));
                for &(g, blur) in &rows {
                    let requests: Vec<Request> = columns
                        .iter()
                        .map(|&f| {
                            let [u, v] = [f, g].map(|fraction| I12F20::from_bits(coordinate(fraction) as i32));
                            Request { scale: [blur as u32, 0], ..Request::at(u, v) }
                        })
                        .collect();
                    let mut before = [0; 4];
                    for (request, response) in requests.iter().zip(ask(chip, &mut unit, &requests)) {
                        let at = [request.u, request.v].map(|c| i64::from(c.to_bits()));
                        let tap = |level: usize| tap(&subject.levels[level], subject.side >> level, at, bits, rounding);
                        let near = tap(0);
                        let far = if trilinear { tap(1) } else { near };
                        let mut right = true;
                        for (channel, &value) in response.texel.iter().enumerate() {
                            let exact = if trilinear {
                                blend(near[channel], far[channel], blur.into(), bits, rounding)
                            } else {
                                whole(near[channel], bits, rounding)
                            };
                            right &= i64::from(value) == exact
                                && (subject.least[channel]..=subject.largest[channel]).contains(&value)
                                && (value >= before[channel] || !subject.rises[channel]);
                        }
                        before = response.texel;
                        tally.count(right, || {
                            let name = rounding.name();
                            format!(
                                "{bits} bits, {name}, level fraction {blur}/256, u and v {at:?} of 2^20: {:?} of {:?}",
                                response.texel, subject.levels
                            )
                        });
                    }
                }
            }
        }
        tally
    })
}

/// One tap of weight one.
fn whole(tap: i64, bits: u32, rounding: Rounding) -> i64 {
    if rounding == Rounding::Once { (tap + (1 << (2 * bits) >> 1)) >> (2 * bits) } else { tap }
}

/// Two taps of 256ths.
fn blend(near: i64, far: i64, blur: i64, bits: u32, rounding: Rounding) -> i64 {
    let below = if rounding == Rounding::Once { 8 + 2 * bits } else { 8 };
    let half = if rounding == Rounding::StagedTruncate { 0 } else { 1 << (below - 1) };
    (256 * near + (far - near) * blur + half) >> below
}
