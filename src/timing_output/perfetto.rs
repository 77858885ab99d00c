//! Chrome's trace JSON, which Perfetto opens: asynchronous spans, since items overlap, and counter tracks. A clock is a microsecond.
//!
//! All taps have one name, and so have all lines, their numbers being arguments: Perfetto packs spans of one name into one track, in the order
//! they begin, and gives every other name a track of its own, sorted as text. `id2.local` keeps them in the process (`id` is global to it).

use std::io::{Result, Write};

use super::{Recording, level, stages};

/// Writes the trace.
///
/// # Errors
/// Those of the writer.
pub fn write(writer: &mut dyn Write, recording: &Recording) -> Result<()> {
    writeln!(writer, "{{\"displayTimeUnit\":\"ms\",\"traceEvents\":[")?;
    write!(writer, r#"{{"ph":"M","pid":1,"name":"process_name","args":{{"name":"texunit (1 clock = 1 us)"}}}}"#)?;
    for (tap, request) in recording.taps_with_requests() {
        let id = tap.tap;
        let mut span = |ph: &str, name: &str, clock: u64, args: &str| {
            write!(
                writer,
                ",\n{{\"ph\":\"{ph}\",\"cat\":\"tap\",\"id2\":{{\"local\":\"{id:#x}\"}},\"pid\":1,\"tid\":1,\
                 \"ts\":{clock},\"name\":\"{name}\"{args}}}"
            )
        };
        span("b", "tap", request.entry, &format!(",\"args\":{{\"tap\":{id},\"request\":{}}}", tap.request))?;
        for (_, name, from, until) in stages(tap, request) {
            if from < until {
                span("b", name, from, "")?;
                span("e", name, until, "")?;
            }
        }
        span("e", "tap", request.result + 1, "")?;
    }
    for (number, fill) in recording.recorded_fills().enumerate() {
        let args = format!(",\"args\":{{\"address\":\"{:#x}\",\"plane\":{}}}", fill.address, fill.plane);
        for (ph, clock, args) in [("b", fill.access, args.as_str()), ("e", fill.fetch.filled, "")] {
            write!(
                writer,
                ",\n{{\"ph\":\"{ph}\",\"cat\":\"line\",\"id2\":{{\"local\":\"{number:#x}\"}},\"pid\":1,\"tid\":2,\
                 \"ts\":{clock},\"name\":\"line\"{args}}}"
            )?;
        }
    }
    let tracks = [
        ("fragment fifo", level(recording.taps.iter().map(|tap| (tap.tag, tap.data + 1)))),
        ("lines on their way", level(recording.recorded_fills().map(|fill| (fill.access, fill.fetch.filled)))),
        ("requests inside", level(recording.requests.iter().map(|one| (one.entry, one.result + 1)))),
    ];
    for (name, values) in tracks {
        for (clock, value) in values {
            write!(
                writer,
                ",\n{{\"ph\":\"C\",\"pid\":1,\"ts\":{clock},\"name\":\"{name}\",\"args\":{{\"value\":{value}}}}}"
            )?;
        }
    }
    writeln!(writer, "\n]}}")
}
