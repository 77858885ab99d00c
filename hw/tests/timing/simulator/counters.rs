//! The counters that are sums of others.

use std::collections::BTreeMap;

use super::Log;
use crate::memory::Memory;

/// Adds them.
pub fn total(counters: &mut BTreeMap<String, u64>, log: &Log, memory: &Memory, cycles: u64, line: u64) {
    let get = |counters: &BTreeMap<String, u64>, name: &str| counters.get(name).copied().unwrap_or(0);
    let misses = log.misses.len() as u64;
    let tally = &memory.tally;
    let skipped = get(counters, "reads") - get(counters, "fetches_ok") - get(counters, "fetches_failed");
    let fetch = ["merge", "reorder_buffer", "miss_status", "miss_queue", "blocked"]
        .iter()
        .map(|cause| get(counters, &format!("tag_stall_{cause}")))
        .sum();
    let spread = |values: Vec<u64>| {
        [values.iter().sum(), values.iter().min().copied().unwrap_or(0), values.iter().max().copied().unwrap_or(0)]
    };
    let request_latency = spread(log.requests.iter().map(|[entry, _, result]| result - entry).collect());
    let fill_latency = spread(log.misses.iter().map(|miss| miss.filled - miss.access).collect());
    let derived = [
        ("cycles", cycles),
        ("requests", log.requests.len() as u64),
        ("taps", log.taps.len() as u64),
        ("fetches_skipped", skipped),
        ("fills", misses),
        ("bytes_filled", misses * line),
        ("stall_address", get(counters, "sequencer_stall_tap_fifo")),
        ("stall_fetch", fetch),
        ("stall_wait_read", get(counters, "data_stall_fill")),
        ("stall_ready_read", get(counters, "data_stall_result_fifo") + get(counters, "data_conflict_clocks")),
        ("request_latency_sum", request_latency[0]),
        ("request_latency_min", request_latency[1]),
        ("request_latency_max", request_latency[2]),
        ("fill_latency_sum", fill_latency[0]),
        ("fill_latency_min", fill_latency[1]),
        ("fill_latency_max", fill_latency[2]),
        ("second_level_lookups", tally.second_lookups),
        ("second_level_hits", tally.second_hits),
        ("second_level_misses", tally.second_lookups - tally.second_hits),
        ("memory_requests", tally.requests),
        ("memory_bytes", tally.bytes),
        ("memory_transfer_clocks", tally.transfer_clocks),
        ("row_hits", tally.row_hits),
        ("row_misses", tally.row_misses),
        ("row_conflicts", tally.row_conflicts),
        ("channel_queue_sum", tally.queue_sum),
        ("channel_queue_max", tally.queue_max),
    ];
    for (name, value) in derived {
        counters.insert(name.to_owned(), value);
    }
}
