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

/// A prime: in a quick proof only so many mantissas of a segment count, and its first and last.
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

/// The mantissas of a segment that are compared.
fn chosen(segment: Segment, quick: bool) -> impl Iterator<Item = u32> {
    let Segment { start, end, .. } = segment;
    let last = (quick && !((end - 1 - start) as usize).is_multiple_of(STRIDE)).then_some(end - 1);
    (start..end).step_by(if quick { STRIDE } else { 1 }).chain(last)
}

fn log2_unit<C: Chip>(chip: &C, work: &Work<'_>, log2: Log2) -> Option<Tally> {
    let answers = Answers::of(log2);
    work.over(BLOCKS, |block| {
        let mut tally = Tally::default();
        for segment in answers.of_block(block as u32) {
            let right = |mantissa: u32| chip.raw_level((block as u32) << 23 | mantissa, log2) == segment.value;
            // Counted without a branch: this loop runs 4 thousand million times.
            let (compared, wrong) = if work.quick {
                chosen(segment, true)
                    .fold((0, 0), |(all, wrong), mantissa| (all + 1, wrong + u64::from(!right(mantissa))))
            } else {
                let wrong: u64 = (segment.start..segment.end).map(|mantissa| u64::from(!right(mantissa))).sum();
                (u64::from(segment.end - segment.start), wrong)
            };
            tally.compared += compared;
            tally.mismatches += wrong;
            if wrong > 0 && tally.first.is_none() {
                tally.first = chosen(segment, work.quick).find(|&mantissa| !right(mantissa)).map(|mantissa| {
                    let bits = (block as u32) << 23 | mantissa;
                    format!("{bits:#010X}: {} instead of {}", chip.raw_level(bits, log2), segment.value)
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

/// The rules that make a whole level, with what each adds before the floor.
const WHOLE: [(LevelRounding, i64); 3] =
    [(LevelRounding::Floor, 0), (LevelRounding::Nearest, 128), (LevelRounding::Gl, 127)];

/// What becomes of a level within the limits: at the width of the fraction, and whole by each rule.
fn rounded(level: i64, last: i64, bits: u8) -> ([i32; 3], i32) {
    let step = 256 / (1 << bits);
    let fractional = last.min((2 * level + step).div_euclid(2 * step) * step);
    (WHOLE.map(|(_, added)| (level + added).div_euclid(256).min(last / 256) as i32), fractional as i32)
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
            for raw in begin..begin + PIECE {
                let biased = (raw + i64::from(sampler.bias)).clamp(i32::MIN.into(), i32::MAX.into());
                let (whole, fractional) = answers[biased.max(low).min(high) as usize];
                let raw = raw as i32;
                let mut right = chip.fractional(range, raw) == fractional;
                for ((rounding, _), whole) in WHOLE.into_iter().zip(whole) {
                    right &= chip.whole(range, raw, rounding) == whole;
                }
                tally.count(right, || {
                    format!(
                        "raw level {raw} with {sampler:?}: {} instead of {fractional}, or a whole level",
                        chip.fractional(range, raw)
                    )
                });
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
    // Pieces of 1/16 of a block: 2^19 requests.
    const PARTS: u32 = 16;
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
            for mantissa in chosen(part, work.quick) {
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
