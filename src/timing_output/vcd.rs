//! Value change dump, for waveform viewers: a `valid` and an `item` for every unit, and how full the queues are. A clock is a nanosecond.

use std::{
    collections::BTreeMap,
    io::{Result, Write},
};

use vcd::{IdCode, TimescaleUnit, VarType, Writer};

use super::{Recording, level};

/// Bits of an item number and of a level.
const BITS: u32 = 32;

/// Writes the dump.
///
/// # Errors
/// Those of the writer.
pub fn write(writer: &mut dyn Write, recording: &Recording) -> Result<()> {
    let requests = &recording.requests;
    let taps = &recording.taps;
    // Unit, and clock and item of everything it took.
    let units: [(&str, Vec<(u64, u64)>); 8] = [
        ("entry", requests.iter().map(|one| (one.entry, one.request)).collect()),
        ("lod", requests.iter().map(|one| (one.lod, one.request)).collect()),
        ("sequencer", taps.iter().map(|one| (one.issue, one.tap)).collect()),
        ("tag", taps.iter().map(|one| (one.tag, one.tap)).collect()),
        ("miss_port", recording.taken().collect()),
        ("data", taps.iter().map(|one| (one.data, one.tap)).collect()),
        ("datapath", taps.iter().map(|one| (one.datapath, one.tap)).collect()),
        ("result", requests.iter().map(|one| (one.result, one.request)).collect()),
    ];
    let levels = [
        ("request_fifo", level(requests.iter().map(|one| (one.entry, one.lod + 1)))),
        ("tap_fifo", level(taps.iter().map(|one| (one.issue, one.tag + 1)))),
        ("fragment_fifo", level(taps.iter().map(|one| (one.tag, one.data + 1)))),
        ("lines_on_their_way", level(recording.recorded_fills().map(|one| (one.access, one.fetch.filled)))),
    ];

    let mut vcd = Writer::new(writer);
    vcd.timescale(1, TimescaleUnit::NS)?;
    vcd.add_module("texunit")?;
    // Bits and value by clock and signal: what was said last of a signal in a clock holds, and nothing else is written of it.
    let mut changes: BTreeMap<(u64, IdCode), (u32, u64)> = BTreeMap::new();
    for (name, items) in units {
        vcd.add_module(name)?;
        let valid = vcd.add_var(VarType::Wire, 1, "valid", None)?;
        let item = vcd.add_var(VarType::Wire, BITS, "item", None)?;
        vcd.upscope()?;
        changes.insert((0, valid), (1, 0));
        for (position, &(clock, number)) in items.iter().enumerate() {
            // Of several items in one clock the last is shown.
            let next = items.get(position + 1).map(|next| next.0);
            if next != Some(clock) {
                changes.insert((clock, valid), (1, 1));
                changes.insert((clock, item), (BITS, number));
            }
            if next.is_none_or(|next| next > clock + 1) {
                changes.insert((clock + 1, valid), (1, 0));
            }
        }
    }
    for (name, values) in levels {
        let signal = vcd.add_var(VarType::Wire, BITS, name, None)?;
        changes.insert((0, signal), (BITS, 0));
        changes.extend(values.into_iter().map(|(clock, value)| ((clock, signal), (BITS, value.unsigned_abs()))));
    }
    vcd.upscope()?;
    vcd.enddefinitions()?;

    let mut clock = None;
    for ((at, signal), (bits, value)) in changes {
        if clock != Some(at) {
            vcd.timestamp(at)?;
            clock = Some(at);
        }
        if bits == 1 {
            vcd.change_scalar(signal, value != 0)?;
        } else {
            let bits: Vec<vcd::Value> = (0..bits).rev().map(|bit| (value >> bit & 1 != 0).into()).collect();
            vcd.change_vector(signal, bits)?;
        }
    }
    vcd.flush()
}
