//! Kanata 0004, the log of the Konata pipeline viewer (shioyadan/Konata, docs/kanata-log-format.md). A tap is an instruction; lane 0
//! holds its stages, lane 1 the lines it waits for (MS). A tap retires when its request leaves. In a label, backslash n is Konata's line break.

use std::io::{Result, Write};

use super::{Recording, stages};

/// Writes the log.
///
/// # Errors
/// Those of the writer.
pub fn write(writer: &mut dyn Write, recording: &Recording) -> Result<()> {
    // Commands by clock; of one clock, what ends before what begins.
    let mut commands: Vec<(u64, u8, u64, String)> = Vec::new();
    for (retired, (tap, request)) in recording.taps_with_requests().enumerate() {
        let id = tap.tap;
        commands.push((
            request.entry,
            1,
            id,
            format!("I\t{id}\t{id}\t0\nL\t{id}\t0\trequest {} tap {id} plane {}", tap.request, tap.plane),
        ));
        for (short, name, from, until) in stages(tap, request) {
            if from < until {
                commands.push((from, 2, id, format!("S\t{id}\t0\t{short}")));
                commands.push((until, 0, id, format!("E\t{id}\t0\t{short}")));
                commands.push((from, 1, id, format!("L\t{id}\t1\t{name}: {from} to {until}\\n")));
            }
        }
        commands.push((request.result + 1, 3, id, format!("R\t{id}\t{retired}\t0")));
    }
    // Lines of one tap overlap; the lane shows from the first miss to the last line.
    let mut fills = recording.recorded_fills().peekable();
    while let Some(first) = fills.next() {
        let (id, mut until) = (first.tap, first.fetch.filled);
        let mut lines = format!("line {:#x}", first.address);
        while let Some(next) = fills.next_if(|next| next.tap == id) {
            until = until.max(next.fetch.filled);
            lines += &format!(", {:#x}", next.address);
        }
        commands.push((first.access, 2, id, format!("S\t{id}\t1\tMS")));
        commands.push((first.access, 2, id, format!("L\t{id}\t1\t{lines}\\n")));
        commands.push((until, 0, id, format!("E\t{id}\t1\tMS")));
    }
    // Instructions appear in the order of their numbers, whatever the clock.
    commands.sort_by_key(|command| (command.0, command.1, command.2));
    writeln!(writer, "Kanata\t0004")?;
    let mut clock = commands.first().map_or(0, |command| command.0);
    writeln!(writer, "C=\t{clock}")?;
    for (at, _, _, command) in commands {
        if at > clock {
            writeln!(writer, "C\t{}", at - clock)?;
            clock = at;
        }
        writeln!(writer, "{command}")?;
    }
    Ok(())
}
