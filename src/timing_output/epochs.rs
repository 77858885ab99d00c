//! Counters every N requests, as CSV.

use std::io::{Error, Result, Write};

use texunit_hw::timing::TimingCounters;

/// One line an epoch: its number and every counter. Counters that end in `_max` or `_min` are those of the run so far; all
/// others, cycles included, are the difference to the epoch before.
///
/// # Errors
/// Those of the writer.
pub fn write(writer: &mut dyn Write, epochs: &[TimingCounters]) -> Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    let names = TimingCounters::FIELDS.iter().map(|(name, _)| *name);
    csv.write_record(std::iter::once("epoch").chain(names)).map_err(Error::other)?;
    let mut before = TimingCounters::default().values();
    for (number, epoch) in epochs.iter().enumerate() {
        let now = epoch.values();
        let cells = TimingCounters::FIELDS.iter().zip(now.iter().zip(&before)).map(|((name, _), (now, before))| {
            let running = name.ends_with("_max") || name.ends_with("_min");
            // A clock idle so far may turn out to have waited for a later request, so idle clocks are signed.
            (if running { i128::from(*now) } else { i128::from(*now) - i128::from(*before) }).to_string()
        });
        csv.write_record(std::iter::once(number.to_string()).chain(cells)).map_err(Error::other)?;
        before = now;
    }
    csv.flush()
}
