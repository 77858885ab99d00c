//! Of texels to an answer: the lerp and the datapath.

use texunit_hw::{
    Filter, I12F20, LodSource, Request, Response, Rounding, Sampler, Unit, address::is_outside, datapath::lerp,
    taps::weight_bits,
};

use super::{FILTERS, MODES, surface_of};
use crate::{
    trace::{Random, Trace},
    whole::footprints,
};

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
            let taps = footprints(&mut unit, request);
            let mut response = [Response::default()];
            unit.run(&[request], &mut response, &mut ());
            let point = filter == Filter::Point;
            let mut line = random.pauses().to_vec();
            line.extend([taps.len() as u64, point.into()]);
            for tap in 0..2 {
                let Some(tap) = taps.get(tap) else {
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
