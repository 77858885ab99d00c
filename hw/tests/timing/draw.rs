//! Machines and streams drawn from numbers that proptest can shrink.

use std::sync::{Arc, LazyLock};

use texunit_hw::{
    Format, Layout, PyramidKind, Surface,
    decompression::{Decompressed, StoredLines},
    timing::{
        BankHash, DramParameters, MainMemory, Mapping, MemoryParameters, Mode, Page, Parameters, SecondLevelParameters,
    },
};

use crate::simulator::{Machine, StoredTexture, Tap};

/// Turns numbers that proptest can shrink into choices.
pub struct Draw<'a>(pub std::slice::Iter<'a, u32>);

impl Draw<'_> {
    fn below(&mut self, n: u32) -> u32 {
        self.0.next().copied().unwrap_or(0) % n
    }
    fn from<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u32) as usize]
    }
    fn depth(&mut self) -> u32 {
        1 + self.from(&[0, 1, 2, 3, 7, 15, 40])
    }
    fn latency(&mut self) -> u32 {
        1 + self.below(5)
    }
}

/// Reads of a tap at most.
pub const READS: u32 = 4;

/// A machine.
pub fn machine(draw: &mut Draw<'_>) -> Machine {
    // Half of them do one thing a clock, and half of these have FIFOs deep enough for it: the model has a loop of its own for them.
    let (single, ample) = (draw.below(2) == 0, draw.below(2) == 0);
    let widths = if single { [1; 4] } else { [3, 4, 2, 2] };
    let mut pipeline = Parameters {
        mode: draw.from(&[Mode::Prefetching, Mode::Prefetching, Mode::Prefetching, Mode::Blocking]),
        pixel_pipes: 1 + draw.below(widths[0]),
        taps_per_clock: 1 + draw.below(widths[1]),
        request_fifo: draw.depth(),
        lod_fifo: draw.depth(),
        tap_fifo: draw.depth(),
        fragment_fifo: draw.depth(),
        result_fifo: draw.depth(),
        tag_banks: draw.from(&[1, 2, 4, 8]),
        tag_ports: 1 + draw.below(widths[2]),
        tag_hash: draw.from(&[BankHash::Low, BankHash::Xor]),
        miss_status: draw.depth(),
        merges: draw.from(&[0, 1, 2, 100]),
        miss_queue: draw.depth(),
        reorder_buffer: READS - 1 + draw.depth(),
        data_banks: draw.from(&[1, 2, 4, 16]),
        data_bank_bytes: draw.from(&[4, 8, 32]),
        data_ports: 1 + draw.below(widths[3]),
        data_hash: draw.from(&[BankHash::Low, BankHash::Xor]),
        fill_write_bytes: draw.from(&[0, 8, 16, 64]),
        lod_latency: draw.latency(),
        address_latency: draw.latency(),
        tag_latency: draw.latency(),
        data_latency: draw.latency(),
        filter_latency: draw.latency(),
        decompress_latency: draw.latency(),
        decompress_texels_per_clock: draw.from(&[16, 4, 3, 1]),
    };
    if single && ample {
        pipeline.mode = Mode::Prefetching;
        pipeline.request_fifo += 1;
        pipeline.lod_fifo += pipeline.lod_latency;
        pipeline.tap_fifo += pipeline.address_latency;
        pipeline.result_fifo += pipeline.data_latency + pipeline.filter_latency;
    }
    let line = draw.from(&[16, 32, 64]);
    let second_level = draw.from(&[false, false, true]).then(|| SecondLevelParameters {
        sets: 1 + draw.below(5),
        ways: 1 + draw.below(3),
        line: line << draw.below(2),
        latency: draw.latency(),
        bytes_per_clock: draw.from(&[64, 16, 5]),
        miss_queue: draw.depth(),
    });
    let block = second_level.map_or(line, |second| second.line);
    let main = if draw.below(2) == 0 {
        MainMemory::Fixed { latency: draw.below(50), bytes_per_clock: draw.from(&[64, 16, 8, 3]) }
    } else {
        let interleave = block << draw.below(3);
        MainMemory::Dram(DramParameters {
            channels: 1 + draw.below(3),
            interleave,
            banks: draw.from(&[1, 2, 4]),
            row_bytes: interleave << draw.below(3),
            page: draw.from(&[Page::Open, Page::Closed]),
            mapping: draw.from(&[Mapping::RowBankColumn, Mapping::RowColumnBank]),
            bank_xor: draw.below(2) == 1,
            queue: draw.depth(),
            controller_latency: draw.below(8),
            trcd: draw.below(8),
            trp: draw.below(8),
            tcas: draw.below(8),
            tras: draw.below(20),
            burst_length: draw.from(&[1, 2, 8]),
            bus_bytes: draw.from(&[2, 4, 16]),
            beats_per_clock: 1 + draw.below(2),
        })
    };
    Machine {
        pipeline,
        memory: MemoryParameters { main, second_level },
        sets: 1 + draw.below(6),
        ways: 1 + draw.below(3),
        line,
        stored: (draw.below(3) == 0).then(|| &STORED[draw.below(STORED.len() as u32) as usize]),
    }
}

/// Textures in memory whose texels take all addresses that a stream reads.
static STORED: LazyLock<Vec<StoredTexture>> = LazyLock::new(|| {
    let layouts = [Layout::RowMajor, Layout::Tiled { log2_width: 2, log2_height: 2 }, Layout::Morton];
    let formats = [Format::Bc1, Format::Bc3, Format::Rgb565, Format::L8];
    let sizes = layouts.into_iter().flat_map(|layout| [(layout, [128, 64]), (layout, [256, 128])]);
    let sizes = sizes.chain([(Layout::RowMajor, [99, 77])]);
    sizes.flat_map(|(layout, size)| formats.map(|format| stored_texture(layout, format, size))).collect()
});

fn stored_texture(layout: Layout, format: Format, [width, height]: [u32; 2]) -> StoredTexture {
    let surface = |format| Surface::new(PyramidKind::Mipmap, layout, format, width, height).unwrap();
    let (held, stored) = (surface(Format::Rgba8), surface(format));
    // Not at the beginning of a burst or of a second-level line, as no texture of the unit is: so both are cut everywhere.
    let base = 3 * u64::from(format.element_bytes());
    let mut elements = vec![None; held.bytes as usize / 4 + 16];
    for (from, to) in stored.planes.iter().zip(&held.planes) {
        for (x, y) in (0..to.height).flat_map(|y| (0..to.width).map(move |x| (x, y))) {
            elements[to.address(x, y) as usize / 4] = Some(base + from.address(x, y));
        }
    }
    let texture = Decompressed { held: (&held, 0), stored: (&stored, base) };
    let lines = [16, 32, 64].map(|line| Arc::new(StoredLines::new(line, [texture])));
    StoredTexture { element_bytes: format.element_bytes(), elements, lines }
}

/// Taps that wander: mostly near the last, sometimes far. Half of the streams have texels outside, and taps of one texel; the model
/// takes the others without a copy of their addresses.
pub fn stream(draw: &mut Draw<'_>, requests: u32) -> Vec<Vec<Tap>> {
    let span = draw.from(&[64, 512, 4096]);
    let most_taps = 1 + draw.below(4);
    let reads_of_taps: &[usize] = draw.from(&[&[4], &[4, 4, 4, 4, 1, 2, 0]]);
    let mut at = 0;
    (0..requests)
        .map(|_| {
            let taps = 1 + draw.below(most_taps);
            (0..taps)
                .map(|_| {
                    at = match draw.below(4) {
                        0 => 4 * u64::from(draw.below(span)),
                        _ => at + 4 * u64::from(draw.below(6)),
                    };
                    let row = 4 * u64::from(draw.from(&[1u32, 4, 16, 64]));
                    let reads = draw.from(reads_of_taps);
                    let addresses = [at, at + 4, at + row, at + row + 4];
                    Tap { plane: draw.below(3) as usize, addresses: addresses[..reads].to_vec() }
                })
                .collect()
        })
        .collect()
}
