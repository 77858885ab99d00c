//! When everything happened, in the formats people have viewers for: one file a format.

pub mod epochs;
pub mod kanata;
pub mod memory_trace;
pub mod perfetto;
pub mod vcd;

use texunit_hw::timing::{FillTimes, RequestTimes, StoredFetch, TapTimes, TimingObserver};

/// The events of the first requests of a run.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    limit: u64,
    fills_of_all: bool,
    seen: u64,
    /// Requests, in order.
    pub requests: Vec<RequestTimes>,
    /// Their taps, in order.
    pub taps: Vec<TapTimes>,
    /// Their lines, in order; of all requests if that was asked for.
    pub fills: Vec<FillTimes>,
    /// What a decompressor asked of memory for them, in order, with the number of the tap; nothing without one.
    pub stored: Vec<(u64, StoredFetch)>,
}

impl Recording {
    /// Records the first `limit` requests, and on request the lines of all.
    #[must_use]
    pub fn new(limit: u64, fills_of_all: bool) -> Self {
        Self { limit, fills_of_all, ..Self::default() }
    }

    /// The lines of the recorded requests only.
    pub fn recorded_fills(&self) -> impl Iterator<Item = &FillTimes> {
        let end = self.end();
        self.fills.iter().take_while(move |fill| fill.tap < end)
    }

    /// Clock and address of what the memory took of them: lines, or what is stored behind them.
    fn taken(&self) -> impl Iterator<Item = (u64, u64)> {
        let end = self.end();
        let lines = self.recorded_fills().filter(|_| self.stored.is_empty());
        let parts = self.stored.iter().take_while(move |(tap, _)| *tap < end);
        lines
            .map(|fill| (fill.fetch.taken, fill.address))
            .chain(parts.map(|(_, part)| (part.fetch.taken, part.address)))
    }

    /// The number of the first tap that was not recorded.
    fn end(&self) -> u64 {
        self.taps.last().map_or(0, |tap| tap.tap + 1)
    }

    /// Every tap with its request.
    fn taps_with_requests(&self) -> impl Iterator<Item = (&TapTimes, &RequestTimes)> {
        self.taps.iter().filter_map(|tap| Some((tap, self.requests.get(tap.request as usize)?)))
    }
}

impl TimingObserver for Recording {
    fn fill(&mut self, fill: FillTimes, stored: &[StoredFetch]) {
        if self.fills_of_all || self.seen < self.limit {
            self.fills.push(fill);
            self.stored.extend(stored.iter().map(|part| (fill.tap, *part)));
        }
    }

    fn tap(&mut self, tap: TapTimes) {
        if self.seen < self.limit {
            self.taps.push(tap);
        }
    }

    fn request(&mut self, request: RequestTimes) {
        if self.seen < self.limit {
            self.requests.push(request);
        }
        self.seen += 1;
    }
}

/// The stages of a tap: short name (Konata's), name, first clock, first clock after it.
fn stages(tap: &TapTimes, request: &RequestTimes) -> [(&'static str, &'static str, u64, u64); 8] {
    [
        ("RQ", "request fifo", request.entry, request.lod),
        ("LO", "lod", request.lod, tap.issue),
        ("AD", "address", tap.issue, tap.tag),
        ("TG", "tag", tap.tag, tap.tag_done + 1),
        ("FI", "fragment fifo", tap.tag_done + 1, tap.data.max(tap.tag_done + 1)),
        ("RD", "data banks", tap.data.max(tap.tag_done + 1), tap.datapath),
        ("BL", "datapath", tap.datapath, request.result),
        ("WB", "result", request.result, request.result + 1),
    ]
}

/// Running values of a counter: (clock, value) at every change, from clocks of things that begin and end.
fn level(spans: impl Iterator<Item = (u64, u64)>) -> Vec<(u64, i64)> {
    let mut steps: Vec<(u64, i64)> = spans.flat_map(|(from, until)| [(from, 1), (until, -1)]).collect();
    steps.sort_unstable();
    let mut values: Vec<(u64, i64)> = Vec::new();
    let mut value = 0;
    for (clock, step) in steps {
        value += step;
        match values.last_mut() {
            Some((last, held)) if *last == clock => *held = value,
            _ => values.push((clock, value)),
        }
    }
    values
}
