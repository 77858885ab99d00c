//! What the timing model counts. The document of each field is its definition; reports take it from here.

/// Declares counters: the struct, and the list of names, definitions and values.
macro_rules! counters {
    ($(#[$meta:meta])* $name:ident { $(#[doc = $doc:literal] $field:ident,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $name {
            $(#[doc = $doc] pub $field: u64,)*
        }

        impl $name {
            /// Name and definition of every counter, in order.
            pub const FIELDS: &'static [(&'static str, &'static str)] = &[$((stringify!($field), $doc)),*];

            /// The values, in the order of [`Self::FIELDS`].
            #[must_use]
            pub fn values(&self) -> alloc::vec::Vec<u64> {
                alloc::vec![$(self.$field),*]
            }
        }
    };
}

counters! {
    /// Totals of a run. For every unit `busy + idle + its stalls = cycles` (docs/timing.md, section 7);
    /// `fetches_ok + fetches_failed + fetches_skipped = reads`; `fetches_failed = fills`; `bytes_filled = fills * line`.
    TimingCounters {
        /// Clocks from the first request to the last answer, both included.
        cycles,
        /// Requests answered.
        requests,
        /// Taps issued.
        taps,
        /// Reads of texels inside the texture (one a channel where the layout keeps channels apart).
        reads,
        /// Line accesses that hit, those merged included.
        fetches_ok,
        /// Line accesses that missed.
        fetches_failed,
        /// Reads of a line that their tap had accessed already: no access.
        fetches_skipped,
        /// Accesses that hit a line still on its way.
        fetches_merged,
        /// Lines brought into the first level.
        fills,
        /// Bytes of these lines.
        bytes_filled,
        /// Bytes asked of the memory for them: the same, or those stored behind them where a decompressor stands before the cache.
        bytes_fetched,
        /// Accesses that waited a clock or more for a port of their tag bank.
        tag_bank_conflicts,
        /// Words read from the data banks.
        data_words,
        /// Clocks the data unit took beyond one a tap because words lay in the same bank.
        data_conflict_clocks,
        /// Clocks the data unit wrote lines instead of reading.
        fill_write_clocks,
        /// Sequencer stalled because the tap FIFO had no place: address stall.
        stall_address,
        /// Tag unit stalled by a miss or a merge it had no resource for: the sum of its merge, reorder buffer, miss-status, miss queue and blocked stalls.
        stall_fetch,
        /// Data unit stalled because a line had not come: wait-read stall.
        stall_wait_read,
        /// Data unit stalled although the lines were there (no place in the result FIFO), or at work longer for bank conflicts: ready-read stall.
        stall_ready_read,
        /// Clocks in which a request entered.
        entry_busy,
        /// Clocks after the last request had entered.
        entry_idle,
        /// Clocks the next request found no place in the request FIFO.
        entry_stall_request_fifo,
        /// Clocks the LOD unit took a request.
        lod_busy,
        /// Clocks the LOD unit had no request.
        lod_idle,
        /// Clocks a request found no place in the LOD FIFO.
        lod_stall_lod_fifo,
        /// Clocks a tap was issued.
        sequencer_busy,
        /// Clocks without a request to issue taps of.
        sequencer_idle,
        /// Clocks a tap found no place in the tap FIFO.
        sequencer_stall_tap_fifo,
        /// Clocks with a line access, or with a tap without any passing.
        tag_busy,
        /// Clocks without a tap.
        tag_idle,
        /// Clocks a tap found no place in the fragment FIFO.
        tag_stall_fragment_fifo,
        /// Clocks an access waited for a line on its way that takes no more merges.
        tag_stall_merge,
        /// Clocks a miss found no place in the reorder buffer.
        tag_stall_reorder_buffer,
        /// Clocks a miss found no miss-status entry.
        tag_stall_miss_status,
        /// Clocks a miss found no place in the miss queue.
        tag_stall_miss_queue,
        /// Clocks an access waited behind a miss of the blocking cache.
        tag_stall_blocked,
        /// Clocks the memory took a request: a miss, or a part of what is stored behind one.
        miss_port_busy,
        /// Clocks without a miss to hand over.
        miss_port_idle,
        /// Clocks the memory did not take the request in front.
        miss_port_stall_memory,
        /// Clocks the data unit read or wrote.
        data_busy,
        /// Clocks without a tap.
        data_idle,
        /// Clocks the tap in front waited for lines it missed.
        data_stall_fill,
        /// Clocks the tap in front, its lines there, found no place in the result FIFO.
        data_stall_result_fifo,
        /// Clocks the datapath took a tap.
        datapath_busy,
        /// Clocks it took none.
        datapath_idle,
        /// Clocks a request left.
        result_busy,
        /// Clocks none left.
        result_idle,
        /// Sum over clocks of places taken in the request FIFO; divided by the cycles, its mean occupancy. So for the following.
        request_fifo_sum,
        /// Most places taken in the request FIFO.
        request_fifo_max,
        /// Sum over clocks of places taken in the LOD FIFO.
        lod_fifo_sum,
        /// Most places taken in the LOD FIFO.
        lod_fifo_max,
        /// Sum over clocks of places taken in the tap FIFO.
        tap_fifo_sum,
        /// Most places taken in the tap FIFO.
        tap_fifo_max,
        /// Sum over clocks of places taken in the fragment FIFO.
        fragment_fifo_sum,
        /// Most places taken in the fragment FIFO.
        fragment_fifo_max,
        /// Sum over clocks of places taken in the result FIFO.
        result_fifo_sum,
        /// Most places taken in the result FIFO.
        result_fifo_max,
        /// Sum over clocks of places taken in the miss queue.
        miss_queue_sum,
        /// Most places taken in the miss queue.
        miss_queue_max,
        /// Sum over clocks of places taken in the reorder buffer; 0 in blocking mode.
        reorder_buffer_sum,
        /// Most places taken in the reorder buffer.
        reorder_buffer_max,
        /// Sum over clocks of miss-status entries taken; 0 in blocking mode.
        miss_status_sum,
        /// Most miss-status entries taken.
        miss_status_max,
        /// Sum over requests of the clocks from entering to leaving.
        request_latency_sum,
        /// Shortest of these; 0 without requests.
        request_latency_min,
        /// Longest of these.
        request_latency_max,
        /// Sum over fills of the clocks from the access that missed to the line being there.
        fill_latency_sum,
        /// Shortest of these; 0 without fills.
        fill_latency_min,
        /// Longest of these.
        fill_latency_max,
        /// Clocks the decompressor before the cache worked; 0 without one.
        decompressor_busy,
        /// Clocks it did not.
        decompressor_idle,
        /// Sum over fills of the clocks from the last of the stored bytes coming to the decompressor beginning.
        decompressor_wait_sum,
        /// Lookups in the second level; 0 without one.
        second_level_lookups,
        /// Lookups that found their line there.
        second_level_hits,
        /// Lookups that did not.
        second_level_misses,
        /// Requests to the main memory.
        memory_requests,
        /// Bytes that came from the main memory.
        memory_bytes,
        /// Clocks its links or data buses transferred, over all channels.
        memory_transfer_clocks,
        /// Requests whose DRAM row was open; 0 without DRAM. So for the following.
        row_hits,
        /// Requests whose DRAM bank had no row open.
        row_misses,
        /// Requests whose DRAM bank had another row open.
        row_conflicts,
        /// Sum over clocks of places taken in the queues of all DRAM channels.
        channel_queue_sum,
        /// Most places taken in the queue of one channel.
        channel_queue_max,
    }
}

counters! {
    /// The share of one plane.
    PlaneTiming {
        /// Taps on this plane.
        taps,
        /// Reads of its texels.
        reads,
        /// Line accesses that hit.
        fetches_ok,
        /// Line accesses that missed.
        fetches_failed,
        /// Accesses that hit a line still on its way.
        fetches_merged,
        /// Bytes of lines brought into the first level.
        bytes_filled,
        /// Bytes asked of the memory for them.
        bytes_fetched,
        /// Clocks the data unit waited for lines of its taps.
        stall_wait_read,
        /// Clocks from miss to line, summed over its fills.
        fill_latency_sum,
        /// Misses the second level answered; 0 without one.
        second_level_hits,
        /// Requests whose DRAM row was open.
        row_hits,
        /// Requests whose DRAM bank had no row open.
        row_misses,
        /// Requests whose DRAM bank had another row open.
        row_conflicts,
    }
}

/// Longest bar of a [`Histograms`].
pub const HISTOGRAM_MAX: usize = 64;

/// Requests by what they asked for; the last bar holds that many or more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Histograms {
    /// Requests by number of taps.
    pub taps: [u64; HISTOGRAM_MAX + 1],
    /// Requests by taps per plane read, rounded down: the probes along the footprint.
    pub anisotropy: [u64; HISTOGRAM_MAX + 1],
    /// Requests by number of planes read.
    pub planes: [u64; HISTOGRAM_MAX + 1],
}

impl Default for Histograms {
    fn default() -> Self {
        let empty = [0; HISTOGRAM_MAX + 1];
        Self { taps: empty, anisotropy: empty, planes: empty }
    }
}

/// Sum, least and most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    sum: u64,
    least: u64,
    most: u64,
}

impl Default for Spread {
    fn default() -> Self {
        Self { sum: 0, least: u64::MAX, most: 0 }
    }
}

impl Spread {
    #[inline(always)]
    pub(super) fn add(&mut self, value: u64) {
        self.sum += value;
        self.least = self.least.min(value);
        self.most = self.most.max(value);
    }

    /// Adds what is between these clocks and those, all below 2^63. A value that is neither the least nor the most yet needs no branch.
    #[inline(always)]
    pub(super) fn add_between(&mut self, begins: &[u64], ends: &[u64]) {
        let values = || ends.iter().zip(begins).map(|(end, begin)| end - begin);
        let (mut sum, mut beyond) = (0, 0);
        for value in values() {
            sum += value;
            beyond |= value.wrapping_sub(self.least) | self.most.wrapping_sub(value);
        }
        if beyond.cast_signed() < 0 || self.least == u64::MAX {
            values().for_each(|value| self.add(value));
        } else {
            self.sum += sum;
        }
    }

    /// Sum, least (0 of none) and most.
    pub(super) const fn all(&self) -> (u64, u64, u64) {
        (self.sum, if self.least == u64::MAX { 0 } else { self.least }, self.most)
    }
}
