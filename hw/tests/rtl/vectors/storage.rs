//! What holds lines and fragments: tags, data banks, the fragment FIFO.

use std::collections::VecDeque;

use crate::{
    lines::CachedLines,
    trace::{Random, Trace},
};

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
