//! Traces of the whole unit: requests in, texels and levels out, hits and misses on the way, and the clock of every answer.

use texunit_hw::{
    AddressBatch, AddressMode, Filter, I12F20, LevelRounding, LodSource, Request, Response, Sampler, Sink, Surface,
    Unit,
    address::{Footprint, is_outside},
    cache::{Detail, Geometry, Policy, TexelCache},
    timing::{MainMemory, MemoryParameters, Parameters, Timing},
};

use crate::{
    clocks::{Clocks, Machine},
    lines::{CachedLines, LINE},
    trace::{Random, Trace},
    vectors::{FILTERS, LEVEL_ROUNDINGS, MODES, code, surface_of},
};

/// The taps of a request.
pub fn footprints(unit: &mut Unit<'_>, request: Request) -> Vec<Footprint> {
    let mut taps = Vec::new();
    unit.inspect(&[request], &mut |batch, _| taps.extend_from_slice(batch.taps));
    taps
}

/// Keeps where the texels of every tap are.
#[derive(Default)]
struct Taps {
    /// In order of issue: plane and addresses.
    taps: Vec<(usize, [u64; 4])>,
    /// 1 or 4.
    texels_per_tap: usize,
}

impl Sink for Taps {
    fn take(&mut self, batch: AddressBatch<'_>) {
        self.taps.extend((0..batch.taps()).map(|number| batch.tap(number)));
        self.texels_per_tap = batch.texels_per_tap;
    }
}

/// The byte at an address: a hash that the testbenches compute as well, so that no memory image is needed.
fn byte(address: u64) -> u8 {
    let word = (address >> 2) as u32;
    let mixed = word.wrapping_mul(0x9e37_79b1);
    let mixed = (mixed ^ mixed >> 15).wrapping_mul(0x85eb_ca77);
    ((mixed ^ mixed >> 13) >> (8 * (address & 3))) as u8
}

/// A texture and sampler, and what is asked of it.
struct Scene {
    filter: Filter,
    modes: [AddressMode; 2],
    lod_source: LodSource,
    level_rounding: LevelRounding,
    tiled: bool,
    log2: [u32; 2],
    bias: i16,
    min_lod: i32,
    max_lod: i32,
}

impl Scene {
    fn sampler(&self, base: &Sampler) -> Sampler {
        Sampler {
            filter: self.filter,
            address: self.modes,
            lod_source: self.lod_source,
            level_rounding: self.level_rounding,
            bias: self.bias,
            min_lod: self.min_lod,
            max_lod: self.max_lod,
            ..*base
        }
    }

    fn surface(&self) -> Surface {
        surface_of(self.filter.pyramid(), self.tiled, self.log2)
    }

    fn random(random: &mut Random, turn: usize) -> Self {
        let small = random.once_in(4);
        Self {
            filter: FILTERS[turn % 5],
            modes: [random.pick(&MODES), random.pick(&MODES)],
            lod_source: random.pick(&[LodSource::Gradient, LodSource::Explicit]),
            level_rounding: random.pick(&LEVEL_ROUNDINGS),
            tiled: !random.once_in(4),
            log2: [0; 2].map(|_| if small { random.below(3) } else { 4 + random.below(5) } as u32),
            bias: random.pick(&[0, 0, 64, -200, 4096, -4096]),
            min_lod: random.pick(&[0, 0, 300]),
            max_lod: random.pick(&[8192, 8192, 700]),
        }
    }

    /// The fields of a bind line: u, v, scale_u, scale_v.
    fn bind(&self) -> [u64; 4] {
        let nibbles = [
            code(self.filter, &FILTERS),
            code(self.modes[0], &MODES),
            code(self.modes[1], &MODES),
            (self.lod_source == LodSource::Explicit).into(),
            code(self.level_rounding, &LEVEL_ROUNDINGS),
            self.tiled.into(),
            self.log2[0].into(),
            self.log2[1].into(),
        ];
        let choices = nibbles.into_iter().fold(0, |word, nibble| word << 4 | nibble);
        let bias = u64::from(self.bias.cast_unsigned() & 0x3fff);
        [choices, bias, (self.min_lod as u64) << 16 | self.max_lod as u64, 0]
    }
}

/// A walk along a line of pixels, or a leap.
struct Walk {
    at: [i64; 2],
    step: [i64; 2],
    ratio: u32,
}

impl Walk {
    fn new(random: &mut Random) -> Self {
        let step = [0; 2].map(|_| random.below(1 << 16) as i64 - (1 << 15));
        let at = [0; 2].map(|_| random.below(4 << 20) as i64 - (2 << 20));
        // Mostly near a texel a pixel, so that every level of the chain is met.
        let ratio = ((118 + random.below(30)) as u32) << 23 | random.next() as u32 & 0x7f_ffff;
        Self { at, step, ratio }
    }

    fn request(&mut self, random: &mut Random, source: LodSource) -> Request {
        for axis in 0..2 {
            self.at[axis] += self.step[axis];
        }
        let at = if random.once_in(16) { [0; 2].map(|_| i64::from(random.next() as i32)) } else { self.at };
        let [u, v] = at.map(|bits| I12F20::from_bits(bits as i32));
        let scale = [0; 2].map(|_| match source {
            LodSource::Gradient if random.once_in(40) => random.next() as u32,
            LodSource::Gradient => self.ratio.wrapping_add(random.next() as u32 & 0xff_ffff),
            LodSource::Explicit => (random.below(0x980) as i32 - 0x80).cast_unsigned(),
        });
        Request { scale, ..Request::at(u, v) }
    }
}

/// Clocks from the first request of a texture to its last response, both included.
pub struct Totals {
    /// By clocks.rs.
    pub recurrence: u64,
    /// By the timing model told to be this machine.
    pub timing_model: u64,
}

/// The timing model as the RTL: every texel a tap of its own, as docs/hardware.md says. Latencies from 2.
fn timing_model(sets: u64, ways: usize, machine: Machine) -> Timing {
    let places = 1 << 16;
    let parameters = Parameters {
        fragment_fifo: machine.fragment_fifo as u32,
        // The RTL's own limit is the FIFO alone.
        miss_status: places,
        merges: places,
        miss_queue: places,
        reorder_buffer: places,
        tag_banks: 1,
        data_banks: 1,
        data_bank_bytes: LINE as u32,
        lod_latency: 1,
        address_latency: 1,
        tag_latency: 1,
        data_latency: 1,
        filter_latency: 4,
        ..Parameters::default()
    };
    // One clock to the memory and one for the line on its link.
    let latency = machine.latency.saturating_sub(2) as u32;
    let main = MainMemory::Fixed { latency, bytes_per_clock: LINE as u32 };
    let geometry = Geometry { sets: sets as u32, ways: ways as u32, line: LINE as u32 };
    let cache = TexelCache::new(geometry, Policy::Lru, 4, Detail::default()).expect("a shape the RTL has");
    Timing::new(&parameters, &MemoryParameters { main, second_level: None }, cache, 4, ()).expect("a machine that runs")
}

/// Requests of each texture.
const REQUESTS: usize = 40;

/// The whole unit; `base` holds the widths. Also how many clocks each texture takes on `machine` without pauses, as the recurrence
/// has them: compared with what the testbench counts.
pub fn unit(base: &Sampler, sets: u64, ways: usize, textures: usize, machine: Machine) -> (Trace, Vec<Totals>) {
    let mut trace = Trace::new(
        "unit",
        &[
            "op 0 request, 1 bind a sampler and a texture (waits until the unit is idle), 2 reset (what is inside is lost)",
            "bind: u = filter mode_u mode_v explicit level_rounding tiled log2_width log2_height, a nibble each; v = bias;",
            "bind: scale_u = min_lod << 16 | max_lod",
            "before the item: idle clocks; after it is taken: stall clocks in which no response is taken",
            "accesses: look-ups of the request, hits: bit i set if look-up i hits",
            "the memory word at byte address 4 w: h = w * 9e3779b1; h = (h ^ h >> 15) * 85ebca77; h ^ h >> 13; all mod 2^32",
        ],
        &[("op", 4), ("idle", 4), ("stall", 4), ("u", 32), ("v", 32), ("scale_u", 32), ("scale_v", 32)]
            .into_iter()
            .chain([("texel", 32), ("lod_u", 16), ("lod_v", 16), ("accesses", 4), ("hits", 8)])
            .collect::<Vec<_>>(),
    );
    let mut random = Random(13);
    let mut segments = Vec::new();
    for turn in 0..textures {
        let scene = Scene::random(&mut random, turn);
        let (sampler, surface) = (scene.sampler(base), scene.surface());
        let bytes: Vec<u8> = (0..surface.bytes).map(byte).collect();
        let mut unit = Unit::new(&sampler, &surface, &bytes).expect("a unit");
        let mut lines = CachedLines::new(sets, ways);
        let mut clocks = Clocks::new(machine);
        let mut timing = timing_model(sets, ways, machine);
        let mut add = |op: u64, pauses: [u64; 3], inputs: [u64; 4], outputs: [u64; 5]| {
            let mut line = vec![op, pauses[1], pauses[2]];
            line.extend(inputs);
            line.extend(outputs);
            trace.push(line);
        };
        if turn == 0 {
            add(2, [0; 3], [0; 4], [0; 5]);
        }
        add(1, random.pauses(), scene.bind(), [0; 5]);
        let mut walk = Walk::new(&mut random);
        for index in 0..REQUESTS {
            if index % 20 == 0 {
                walk = Walk::new(&mut random);
            }
            let request = walk.request(&mut random, scene.lod_source);
            let mut seen = Taps::default();
            let mut response = [Response::default()];
            unit.run(&[request], &mut response, &mut seen);
            let (mut accesses, mut hits) = (0, 0);
            clocks.request();
            let mut texels: Vec<(usize, Option<u64>)> = Vec::new();
            for (plane, addresses) in &seen.taps {
                for &address in &addresses[..seen.texels_per_tap] {
                    let outside = is_outside(address);
                    let hit = outside || lines.touch(address / LINE);
                    if !outside {
                        hits |= u64::from(hit) << accesses;
                        accesses += 1;
                    }
                    clocks.texel(!hit);
                    texels.push((*plane, (!outside).then_some(address)));
                }
            }
            timing.request(texels.iter().map(|(plane, address)| (*plane, address.as_slice())));
            let pauses = random.pauses();
            let inputs = [
                request.u.to_bits().cast_unsigned(),
                request.v.to_bits().cast_unsigned(),
                request.scale[0],
                request.scale[1],
            ];
            let outputs = [
                u32::from_le_bytes(response[0].texel).into(),
                response[0].lod[0].into(),
                response[0].lod[1].into(),
                accesses,
                hits,
            ];
            add(0, pauses, inputs.map(u64::from), outputs);
        }
        segments.push(Totals { recurrence: clocks.total(), timing_model: timing.counters().cycles });
        // Sometimes the texture is torn away with requests inside.
        if turn % 4 == 1 {
            add(2, [0; 3], [0; 4], [0; 5]);
        }
    }
    (trace, segments)
}
