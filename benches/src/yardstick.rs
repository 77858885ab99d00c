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

/// The eight addresses of a request, and its fractions.
#[inline(always)]
fn footprint(request: &Request, bases: &[u32; 11]) -> ([[u32; 4]; 2], [[u64; 2]; 2], u64) {
    let bits = request.scale[0] & 0x7FFF_FFFF;
    let lod = ((bits >> 16) as i32 - (127 << 7)).clamp(0, 10 << 8);
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
