//! Plain scalar loops for one case: trilinear RGBA8 in 4 x 4 tiles, 64 sets x 4 ways x 64 bytes, LRU.

use texunit_hw::Request;

use crate::workload::SIDE;

/// Byte offsets of the levels of a 1024 x 1024 RGBA8 Mipmap in 4 x 4 tiles, each level a multiple of 256 bytes.
fn level_bases() -> [u32; 11] {
    let mut bases = [0; 11];
    let mut base = 0u32;
    for (level, slot) in bases.iter_mut().enumerate() {
        *slot = base;
        let tiles = ((SIDE >> level).max(1)).div_ceil(4);
        base = (base + tiles * tiles * 64).next_multiple_of(256);
    }
    bases
}

/// Exact 4-way LRU over 64 sets, most recent first.
#[derive(Debug)]
pub struct Lru {
    tags: [[u32; 4]; 64],
    /// Lookups that missed.
    pub misses: u64,
}

impl Default for Lru {
    fn default() -> Self {
        Self { tags: [[u32::MAX; 4]; 64], misses: 0 }
    }
}

impl Lru {
    /// Looks up the line of an address.
    #[inline(always)]
    pub fn access(&mut self, address: u32) {
        let line = address >> 6;
        let ways = &mut self.tags[(line & 63) as usize];
        if ways[0] == line {
            return;
        }
        if ways[1] == line {
            ways.swap(0, 1);
        } else if ways[2] == line {
            *ways = [line, ways[0], ways[1], ways[3]];
        } else {
            self.misses += u64::from(ways[3] != line);
            *ways = [line, ways[0], ways[1], ways[2]];
        }
    }
}

#[inline(always)]
fn lerp_packed(a: u64, b: u64, fraction: u64) -> u64 {
    // Four 16-bit lanes of 8-bit channels, rounded half up.
    ((a * (256 - fraction) + b * fraction + 0x0080_0080_0080_0080) >> 8) & 0x00FF_00FF_00FF_00FF
}

#[inline(always)]
fn spread(texel: u32) -> u64 {
    let texel = u64::from(texel);
    (texel & 0x00FF_00FF) | (texel & 0xFF00_FF00) << 24
}

#[inline(always)]
fn gather(spread: u64) -> u32 {
    ((spread & 0x00FF_00FF) | (spread >> 24 & 0xFF00_FF00)) as u32
}

/// Level of detail, 8 fraction bits.
#[inline(always)]
fn lod(request: &Request) -> i32 {
    let bits = request.scale[0] & 0x7FFF_FFFF;
    ((bits >> 16) as i32 - (127 << 7)).clamp(0, 10 << 8)
}

/// The eight addresses of a request, and its fractions.
#[inline(always)]
fn footprint(request: &Request, bases: &[u32; 11]) -> ([[u32; 4]; 2], [[u64; 2]; 2], u64) {
    let lod = lod(request);
    let (level, t) = ((lod >> 8) as u32, (lod & 255) as u64);
    let mut addresses = [[0; 4]; 2];
    let mut fractions = [[0; 2]; 2];
    for number in 0..2 {
        let level = (level + number as u32).min(10);
        (addresses[number], fractions[number]) = tap(request, level, bases[level as usize]);
    }
    (addresses, fractions, t)
}

/// The four addresses of a tap of one level, and its fractions.
#[inline(always)]
fn tap(request: &Request, level: u32, base: u32) -> ([u32; 4], [u64; 2]) {
    let log2 = 10 - level;
    let (mask, tiles) = ((1u32 << log2) - 1, ((1u32 << log2) + 3) / 4);
    let [u, v] = [request.u, request.v].map(|c| ((c.to_bits() as u32) << log2).wrapping_sub(1 << 19));
    let [x0, y0] = [u, v].map(|p| p >> 20 & mask);
    let [x1, y1] = [(x0 + 1) & mask, (y0 + 1) & mask];
    let columns = [x0, x1].map(|x| (x >> 2) * 64 + (x & 3) * 4);
    let rows = [y0, y1].map(|y| (y >> 2) * tiles * 64 + (y & 3) * 16);
    let addresses = [
        base + columns[0] + rows[0],
        base + columns[1] + rows[0],
        base + columns[0] + rows[1],
        base + columns[1] + rows[1],
    ];
    (addresses, [u, v].map(|p| u64::from(p >> 12 & 255)))
}

#[inline(always)]
fn sample(bytes: &[u8], addresses: &[[u32; 4]; 2], fractions: &[[u64; 2]; 2], t: u64) -> u32 {
    let mut levels = [0u64; 2];
    for number in 0..2 {
        let [f, g] = fractions[number];
        levels[number] = sample_tap(bytes, &addresses[number], f, g);
    }
    gather(lerp_packed(levels[0], levels[1], t))
}

#[inline(always)]
fn sample_tap(bytes: &[u8], addresses: &[u32; 4], f: u64, g: u64) -> u64 {
    let [c00, c10, c01, c11] = addresses.map(|address| {
        let at = address as usize;
        spread(u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]))
    });
    lerp_packed(lerp_packed(c00, c10, f), lerp_packed(c01, c11, f), g)
}

/// Texels and cache.
pub fn whole_path(requests: &[Request], bytes: &[u8], out: &mut [u32]) -> u64 {
    let bases = level_bases();
    let mut cache = Lru::default();
    for (request, out) in requests.iter().zip(out) {
        let (addresses, fractions, t) = footprint(request, &bases);
        for address in addresses.as_flattened() {
            cache.access(*address);
        }
        *out = sample(bytes, &addresses, &fractions, t);
    }
    cache.misses
}

/// Texels only.
pub fn sampling(requests: &[Request], bytes: &[u8], out: &mut [u32]) {
    let bases = level_bases();
    for (request, out) in requests.iter().zip(out) {
        let (addresses, fractions, t) = footprint(request, &bases);
        *out = sample(bytes, &addresses, &fractions, t);
    }
}

/// Texels of level 0 only.
pub fn bilinear(requests: &[Request], bytes: &[u8], out: &mut [u32]) {
    for (request, out) in requests.iter().zip(out) {
        let (addresses, [f, g]) = tap(request, 0, 0);
        *out = gather(sample_tap(bytes, &addresses, f, g));
    }
}

/// Addresses and cache only.
pub fn caching(requests: &[Request]) -> u64 {
    let bases = level_bases();
    let mut cache = Lru::default();
    for request in requests {
        for address in footprint(request, &bases).0.as_flattened() {
            cache.access(*address);
        }
    }
    cache.misses
}

/// The cache alone, from an address stream.
pub fn cache_alone(addresses: &[u64]) -> u64 {
    let mut cache = Lru::default();
    for &address in addresses {
        cache.access(address as u32);
    }
    cache.misses
}

/// What [`whole_path_with_counters`] counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Lookups of each level.
    pub lookups: [u64; 11],
    /// Misses of each level by class: compulsory, capacity, conflict.
    pub misses: [[u64; 3]; 11],
    /// Texels used of all lines fetched.
    pub used: u64,
}

/// The cache with every counter the model keeps: which texels of its lines are used, and the class of every miss, for which a fully
/// associative LRU cache of as many lines runs beside it, a list through a table by line.
struct CountedLru {
    cache: Lru,
    counted: Counted,
    marks: Vec<u16>,
    seen: Vec<bool>,
    /// Neighbours in the list of lines from the last used to the first, 0 standing for its two ends.
    next: Vec<u32>,
    before: Vec<u32>,
    listed: Vec<bool>,
    length: u32,
}

impl CountedLru {
    fn new(lines: usize) -> Self {
        Self {
            cache: Lru::default(),
            counted: Counted::default(),
            marks: vec![0; lines],
            seen: vec![false; lines],
            next: vec![0; lines + 1],
            before: vec![0; lines + 1],
            listed: vec![false; lines + 1],
            length: 0,
        }
    }

    /// Moves a line to the front of the list; whether it was there.
    #[inline(always)]
    fn list(&mut self, line: u32) -> bool {
        let node = line + 1;
        let first = self.next[0];
        if first == node {
            return true;
        }
        let was = self.listed[node as usize];
        if was {
            self.unlink(node);
        } else if self.length == 256 {
            let last = self.before[0];
            self.unlink(last);
            self.listed[last as usize] = false;
        } else {
            self.length += 1;
        }
        self.listed[node as usize] = true;
        let first = self.next[0];
        self.next[0] = node;
        self.before[node as usize] = 0;
        self.next[node as usize] = first;
        self.before[first as usize] = node;
        was
    }

    #[inline(always)]
    fn unlink(&mut self, node: u32) {
        let (before, next) = (self.before[node as usize], self.next[node as usize]);
        self.next[before as usize] = next;
        self.before[next as usize] = before;
    }

    #[inline(always)]
    fn access(&mut self, address: u32, level: usize) {
        let line = address >> 6;
        self.counted.lookups[level] += 1;
        let listed = self.list(line);
        let ways = &mut self.cache.tags[(line & 63) as usize];
        if ways[0] != line {
            if ways[1] == line {
                ways.swap(0, 1);
            } else if ways[2] == line {
                *ways = [line, ways[0], ways[1], ways[3]];
            } else {
                let last = ways[3];
                *ways = [line, ways[0], ways[1], ways[2]];
                if last != line {
                    if let Some(marks) = self.marks.get_mut(last as usize) {
                        self.counted.used += u64::from(std::mem::take(marks).count_ones());
                    }
                    let class = match (listed, self.seen[line as usize]) {
                        (true, _) => 2,
                        (false, true) => 1,
                        (false, false) => 0,
                    };
                    self.seen[line as usize] = true;
                    self.counted.misses[level][class] += 1;
                }
            }
        }
        self.marks[line as usize] |= 1 << (address >> 2 & 15);
    }
}

/// Texels and cache, with every counter of the model.
pub fn whole_path_with_counters(requests: &[Request], bytes: &[u8], out: &mut [u32]) -> Counted {
    let bases = level_bases();
    let mut cache = CountedLru::new(bytes.len().div_ceil(64));
    for (request, out) in requests.iter().zip(out) {
        let (addresses, fractions, t) = footprint(request, &bases);
        let level = (lod(request) >> 8) as usize;
        for (number, tap) in addresses.iter().enumerate() {
            for address in tap {
                cache.access(*address, (level + number).min(10));
            }
        }
        *out = sample(bytes, &addresses, &fractions, t);
    }
    let still_there: u32 = cache.marks.iter().map(|marks| marks.count_ones()).sum();
    cache.counted.used += u64::from(still_there);
    cache.counted
}
