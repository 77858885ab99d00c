//! The LOD unit on all 2^32 bit patterns.

use texunit_hw::{
    Filter, Format, Layout, LevelRounding, LodSource, Log2, PyramidKind, Request, Response, Sampler, Surface,
    lod::LevelRange, memory::store_plane,
};

use super::{
    Bound, Chip, Proof, Tally, Work,
    logarithm::{Answers, MANTISSAS, Segment},
};
use crate::names::Named;

/// Signs times exponent fields.
const BLOCKS: usize = 512;

/// Where not all mantissas of a segment count, its first and last do and, between them, every so manieth: primes, so that no bit stays.
const STRIDE: usize = 8191;

pub(super) fn proofs<C: Chip>() -> Vec<Proof<C>> {
    let rung = |&(name, log2): &(&str, Log2)| {
        Proof::new(
            format!("lod-{name}"),
            format!("log2 unit `{name}`: every f32 bit pattern against thresholds in big integers or exact f64"),
            move |chip: &C, work: &Work<'_>| log2_unit(chip, work, log2),
        )
    };
    let mut proofs: Vec<Proof<C>> = Log2::ALL.iter().map(rung).collect();
    proofs.push(Proof::new(
        "lod-select",
        "bias, clamp, fraction and whole levels: every 32-bit level under four samplers against i64 division",
        select,
    ));
    proofs.push(Proof::new(
        "lod-unit",
        "the whole unit, trilinear on a chain of 13 levels: level and texel of every f32 bit pattern as the ratio of a request",
        whole_unit,
    ));
    proofs
}

/// The first and last mantissas of a segment, and every so manieth between them.
fn chosen(segment: Segment, stride: usize) -> impl Iterator<Item = u32> {
    let Segment { start, end, .. } = segment;
    let last = (!((end - 1 - start) as usize).is_multiple_of(stride)).then_some(end - 1);
    (start..end).step_by(stride).chain(last)
}

/// Inputs whose answer is another than the expected one, counted without a branch: the loops of this file run thousands of millions of
/// times, and this form of them becomes vector instructions.
#[inline]
fn wrong(inputs: impl Iterator<Item = u32>, right: impl Fn(u32) -> bool) -> u64 {
    inputs.map(|input| u64::from(!right(input))).sum()
}

/// [`wrong`] for the log2 units, each with a loop of its own: the choice between them is made once and not for every pattern.
macro_rules! wrong_levels {
    ($chip:expr, $log2:expr, $inputs:expr, $value:expr, $($rung:ident),*) => {
        match $log2 { $(Log2::$rung => wrong($inputs, |bits| $chip.raw_level(bits, Log2::$rung) == $value)),* }
    };
}

fn log2_unit<C: Chip>(chip: &C, work: &Work<'_>, log2: Log2) -> Option<Tally> {
    let answers = Answers::of(log2);
    work.over(BLOCKS, |block| {
        let mut tally = Tally::default();
        let sign_and_exponent = (block as u32) << 23;
        for segment in answers.of_block(block as u32) {
            let Segment { start, end, value } = segment;
            let wrong = if work.quick {
                wrong(chosen(segment, STRIDE), |mantissa| chip.raw_level(sign_and_exponent | mantissa, log2) == value)
            } else {
                let all = (start..end).map(|mantissa| sign_and_exponent | mantissa);
                wrong_levels!(
                    chip, log2, all, value, Exact, Table128, Table64, Table16, Quadratic, Fourth, Herf, HerfPlain,
                    Ilog2
                )
            };
            tally.compared += if work.quick { chosen(segment, STRIDE).count() as u64 } else { u64::from(end - start) };
            tally.mismatches += wrong;
            if wrong > 0 && tally.first.is_none() {
                let level = |mantissa| chip.raw_level(sign_and_exponent | mantissa, log2);
                tally.first = chosen(segment, if work.quick { STRIDE } else { 1 })
                    .find(|&mantissa| level(mantissa) != value)
                    .map(|mantissa| {
                        format!("{:#010X}: {} instead of {value}", sign_and_exponent | mantissa, level(mantissa))
                    });
            }
        }
        tally
    })
}

/// Samplers whose selection is proven, with the last level of the chain.
fn selections() -> [(Sampler, u8); 4] {
    let sampler = Sampler::default();
    [
        (sampler, 12),
        (Sampler { bias: 4096, lod_bits: 4, min_lod: 384, max_lod: 1856, ..sampler }, 20),
        (Sampler { bias: -4096, lod_bits: 0, ..sampler }, 8),
        // The limits crossed, the upper one unaligned.
        (Sampler { bias: 77, lod_bits: 5, min_lod: 2000, max_lod: 1001, ..sampler }, 9),
    ]
}

/// What the rules that make a whole level add before the floor: floor, nearest, GL.
const ADDED: [i64; 3] = [0, 128, 127];

/// What becomes of a level within the limits: at the width of the fraction, and whole by each rule.
fn rounded(level: i64, last: i64, bits: u8) -> ([i32; 3], i32) {
    let step = 256 / (1 << bits);
    let fractional = last.min((2 * level + step).div_euclid(2 * step) * step);
    (ADDED.map(|added| (level + added).div_euclid(256).min(last / 256) as i32), fractional as i32)
}

fn select<C: Chip>(chip: &C, work: &Work<'_>) -> Option<Tally> {
    const PIECE: i64 = 1 << 16;
    let ranges = selections().map(|(sampler, last)| {
        let end = 256 * i64::from(last);
        let answers: Vec<_> = (0..=end).map(|level| rounded(level, end, sampler.lod_bits)).collect();
        (sampler, LevelRange::new(&sampler, last), answers)
    });
    // Quick: the pieces around zero, and those at both ends.
    let pieces: Vec<i64> = if work.quick { vec![0, 1, 32767, 32768, 65534, 65535] } else { (0..1 << 16).collect() };
    work.over(pieces.len(), |number| {
        let mut tally = Tally::default();
        let begin = pieces[number] * PIECE - (1 << 31);
        for (sampler, range, answers) in &ranges {
            let end = answers.len() as i64 - 1;
            let [low, high] = [i64::from(sampler.min_lod.max(0)), i64::from(sampler.max_lod).min(end)];
            let limited = |raw: i64| {
                let biased = (raw + i64::from(sampler.bias)).clamp(i32::MIN.into(), i32::MAX.into());
                biased.max(low).min(high)
            };
            let mut raw = begin;
            while raw < begin + PIECE {
                let level = limited(raw);
                // Most pieces have one level from end to end: limiting keeps the order.
                let next = if limited(begin + PIECE - 1) == level { begin + PIECE } else { raw + 1 };
                let ([floor, nearest, gl], fractional) = answers[level as usize];
                let right = |raw: i32| {
                    (chip.fractional(range, raw) == fractional)
                        & (chip.whole(range, raw, LevelRounding::Floor) == floor)
                        & (chip.whole(range, raw, LevelRounding::Nearest) == nearest)
                        & (chip.whole(range, raw, LevelRounding::Gl) == gl)
                };
                let wrong = wrong((0..(next - raw) as u32).map(|step| (raw as u32).wrapping_add(step)), |raw| {
                    right(raw as i32)
                });
                tally.compared += (next - raw) as u64;
                tally.mismatches += wrong;
                if wrong > 0 && tally.first.is_none() {
                    tally.first = (raw..next).find(|raw| !right(*raw as i32)).map(|raw| {
                        let found = chip.fractional(range, raw as i32);
                        format!("raw level {raw} with {sampler:?}: {found} instead of {fractional}, or a whole level")
                    });
                }
                raw = next;
            }
        }
        tally
    })
}

/// A chain of levels of one grey each.
const LAST: u8 = 12;
const GREY: u32 = 20;

fn whole_unit<C: Chip>(chip: &C, work: &Work<'_>) -> Option<Tally> {
    let surface =
        Surface::new(PyramidKind::Mipmap, Layout::RowMajor, Format::Rgba8, 1 << LAST, 1).expect("a row of 2^12 texels");
    let mut bytes = vec![0; surface.bytes as usize];
    for (level, plane) in surface.planes.iter().enumerate() {
        let texels = vec![(GREY * level as u32) as u8; 4 * plane.width as usize];
        store_plane(&surface, level, &texels, &mut bytes).expect("RGBA8 has room for any texel");
    }
    let sampler = Sampler { filter: Filter::Trilinear, lod_source: LodSource::Gradient, ..Sampler::default() };
    let bound = Bound { sampler, surface: &surface, bytes: &bytes };
    let answers = Answers::of(sampler.log2);
    // Pieces of a quarter of a block.
    const PARTS: u32 = 4;
    work.over(BLOCKS * PARTS as usize, |piece| {
        let (block, part) = (piece as u32 / PARTS, piece as u32 % PARTS);
        let within = part * (MANTISSAS / PARTS)..(part + 1) * (MANTISSAS / PARTS);
        let mut tally = Tally::default();
        let mut unit = chip.unit(&bound);
        let (mut requests, mut expected) = (Vec::new(), Vec::new());
        let mut flush = |requests: &mut Vec<Request>, expected: &mut Vec<Response>| {
            let mut responses = vec![Response::default(); requests.len()];
            chip.answer(&mut unit, requests, &mut responses);
            for ((request, expected), response) in requests.iter().zip(expected.iter()).zip(&responses) {
                tally.count(expected == response, || {
                    format!("ratio {:#010X}: {response:?} instead of {expected:?}", request.scale[0])
                });
            }
            requests.clear();
            expected.clear();
        };
        for segment in answers.of_block(block) {
            let part = Segment {
                start: segment.start.max(within.start),
                end: segment.end.min(within.end),
                value: segment.value,
            };
            if part.start >= part.end {
                continue;
            }
            let level = segment.value.clamp(0, 256 * i32::from(LAST)) as u32;
            let (whole, blur) = (level / 256, level % 256);
            let grey = (GREY * (256 * whole + blur) + 128) / 256;
            let response = Response { texel: [grey as u8; 4], lod: [level as u16; 2] };
            for mantissa in chosen(part, if work.quick { STRIDE } else { 1 }) {
                requests.push(Request { scale: [block << 23 | mantissa, 0], ..Request::default() });
                expected.push(response);
                if requests.len() == 4096 {
                    flush(&mut requests, &mut expected);
                }
            }
        }
        flush(&mut requests, &mut expected);
        tally
    })
}
