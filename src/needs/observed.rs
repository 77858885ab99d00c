//! One pass over requests: which texels of which planes they ask for, and which bits of them matter.

use texunit_hw::{
    AddressMode, Filter, Footprint, PyramidKind, Request, Sampler, Surface, Unit, address::is_outside,
    coordinate::COORDINATE_BITS, surface::place_on_map, taps::most_taps,
};

use super::tiles::TileSet;
use crate::error::{Error, Result};

/// What some requests need of a filter on a texture of one size.
///
/// ```
/// use texunit::needs::Needs;
/// use texunit_hw::{Filter, I12F20, Request, Sampler};
/// // One texel a pixel, in the middle of the texture: trilinear asks for two taps, and one of them has weight zero.
/// let requests = [Request { scale: [1.0f32.to_bits(), 0], ..Request::at(I12F20::from_num(0.5), I12F20::from_num(0.5)) }];
/// let needs = Needs::of(&requests, &Sampler::default(), [64, 64])?;
/// assert_eq!((needs.taps, needs.needed_taps, needs.stands_for), (2, 1, Some(Filter::Bilinear)));
/// assert_eq!(needs.address_logic, [false; 2]); // nothing wraps around
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Needs {
    /// The filter asked for.
    pub filter: Filter,
    /// Width and height of the texture.
    pub size: [u32; 2],
    /// Requests.
    pub requests: u64,
    /// Taps the filter's whole program issues.
    pub taps: u64,
    /// Taps that are left without those of weight zero and without doubles.
    pub needed_taps: u64,
    /// Every plane of the pyramid, in storage order.
    pub planes: Vec<PlaneNeeds>,
    /// Smallest and largest level reported, 8.8; none without requests.
    pub levels: Option<[u16; 2]>,
    /// The filter that gives every answer as well: one tap of level 0 a request.
    pub stands_for: Option<Filter>,
    /// Whether a texel index leaves the plane along u, along v: where none does, no address mode is needed.
    pub address_logic: [bool; 2],
    /// Bits of u and of v that an answer depends on.
    pub coordinate_bits: [CoordinateBits; 2],
    /// Whole and fraction bits of the level that an answer depends on.
    pub lod_bits: [u8; 2],
}

/// Bits of a coordinate that matter: two's complement, `integer` above the point (the sign among them) and `fraction` below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoordinateBits {
    /// Bits above the point: none where the address mode or the scene keeps to one repeat.
    pub integer: u8,
    /// Bits below the point.
    pub fraction: u8,
}

/// What is needed of one plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlaneNeeds {
    /// Halvings of u and of v.
    pub halvings: (u8, u8),
    /// Texels along u and along v.
    pub size: [u32; 2],
    /// Taps on it; a plane without any is not needed.
    pub taps: u64,
    /// First and last column, first and last row read.
    pub window: Option<[[u32; 2]; 2]>,
    /// Tiles read.
    pub tiles: TileSet,
}

impl PlaneNeeds {
    fn see(&mut self, tap: &Footprint, texels: usize) {
        self.taps += 1;
        for &address in tap.address[..texels].iter().filter(|&&address| !is_outside(address)) {
            let place = place_on_map(address);
            self.tiles.add(place);
            let [columns, rows] = self.window.get_or_insert(place.map(|at| [at, at]));
            *columns = [columns[0].min(place[0]), columns[1].max(place[0])];
            *rows = [rows[0].min(place[1]), rows[1].max(place[1])];
        }
    }
}

fn cannot(error: impl std::fmt::Display) -> Error {
    Error::setting("texture", "this size and sampler", error.to_string(), "change the texture or the machine")
}

/// Whether a tap reads a texel the plane does not have, if no address mode brings it back.
fn leaves_the_plane(requests: &[Request], sampler: &Sampler, axis: usize, size: [u32; 2]) -> Result<bool> {
    if sampler.filter == Filter::Sat {
        // Sums beyond the border are other reads, not other indices.
        return Ok(true);
    }
    let mut address = [AddressMode::Clamp; 2];
    address[axis] = AddressMode::Clip;
    let sampler = Sampler { address, skip_empty_taps: true, ..*sampler };
    let map = Surface::map(sampler.filter.pyramid(), size[0], size[1]).map_err(cannot)?;
    let mut unit = Unit::without_memory(&sampler, &map).map_err(cannot)?;
    for requests in requests.chunks(1 << 10) {
        let mut outside = false;
        unit.inspect(requests, &mut |batch, _| {
            let mut addresses = batch.taps.iter().flat_map(|tap| &tap.address[..batch.texels_per_tap]);
            outside |= addresses.any(|&address| is_outside(address));
        });
        if outside {
            return Ok(true);
        }
    }
    Ok(false)
}

impl Needs {
    /// Looks at requests of a texture of this size.
    ///
    /// # Errors
    /// A size or sampler no unit can be built for.
    pub fn of(requests: &[Request], sampler: &Sampler, size: [u32; 2]) -> Result<Self> {
        let filter = sampler.filter;
        let map = Surface::map(filter.pyramid(), size[0], size[1]).map_err(cannot)?;
        let base_map = Surface::map(PyramidKind::Mipmap, size[0], size[1]).map_err(cannot)?;
        let simple = if matches!(filter, Filter::Point | Filter::Sat) { Filter::Point } else { Filter::Bilinear };
        let simplest = Sampler { filter: simple, skip_empty_taps: true, ..*sampler };
        let lean = Sampler { skip_empty_taps: true, ..*sampler };
        let whole = Sampler { skip_empty_taps: false, ..*sampler };
        let mut unit = Unit::without_memory(&lean, &map).map_err(cannot)?;
        let mut whole_unit = Unit::without_memory(&whole, &map).map_err(cannot)?;
        let mut simple_unit = Unit::without_memory(&simplest, &base_map).map_err(cannot)?;

        let mut planes: Vec<PlaneNeeds> = map
            .planes
            .iter()
            .map(|plane| PlaneNeeds {
                halvings: (plane.lu, plane.lv),
                size: plane.size(),
                taps: 0,
                window: None,
                tiles: TileSet::new(plane.size()),
            })
            .collect();
        let (mut taps, mut needed_taps) = (0, 0);
        let (most, always) = most_taps(filter);
        let (mut alike, mut levels, mut level_bits) = (true, None, 0);
        let mut base_taps: Vec<Footprint> = Vec::new();
        for requests in requests.chunks(1 << 10) {
            base_taps.clear();
            simple_unit.inspect(requests, &mut |batch, _| base_taps.extend(batch.taps));
            if always {
                taps += (most * requests.len()) as u64;
            } else {
                whole_unit.inspect(requests, &mut |batch, _| taps += batch.taps.len() as u64);
            }
            let mut base = base_taps.iter();
            unit.inspect(requests, &mut |batch, lods| {
                needed_taps += batch.taps.len() as u64;
                for tap in batch.taps {
                    planes[usize::from(tap.plane)].see(tap, batch.texels_per_tap);
                }
                for (taps, lods) in batch.per_request().zip(lods) {
                    alike &= *lods == [0; 2] && base.next().is_some_and(|base| answers_like(filter, taps, base));
                    let [low, high] = levels.get_or_insert([u16::MAX, 0]);
                    *low = (*low).min(lods[0]).min(lods[1]);
                    *high = (*high).max(lods[0]).max(lods[1]);
                    level_bits |= lods[0] | lods[1];
                }
            });
        }
        let stands_for = (alike && !requests.is_empty()).then_some(simple);
        let read = if stands_for.is_some() { &simplest } else { &lean };
        let mut address_logic = [true; 2];
        for (axis, needed) in address_logic.iter_mut().enumerate() {
            *needed = leaves_the_plane(requests, read, axis, size)?;
        }
        let mut needs = Self {
            filter,
            size,
            requests: requests.len() as u64,
            taps,
            needed_taps,
            planes,
            levels,
            stands_for,
            address_logic,
            coordinate_bits: [CoordinateBits { integer: 0, fraction: 0 }; 2],
            lod_bits: [0; 2],
        };
        needs.coordinate_bits = [0, 1].map(|axis| needs.coordinate_bits(requests, sampler, axis));
        if let Some([_, highest]) = levels {
            let whole = u16::BITS - (highest >> 8).leading_zeros();
            let fraction = if level_bits & 255 == 0 { 0 } else { 8 - level_bits.trailing_zeros() };
            needs.lod_bits = [whole as u8, fraction as u8];
        }
        Ok(needs)
    }

    /// Bits of one axis' coordinates that reach an address or a fraction.
    fn coordinate_bits(&self, requests: &[Request], sampler: &Sampler, axis: usize) -> CoordinateBits {
        let (mut all, mut low, mut high) = (0, i32::MAX, i32::MIN);
        for request in requests {
            let bits = [request.u, request.v][axis].to_bits();
            (all, low, high) = (all | bits, low.min(bits), high.max(bits));
        }
        let read = self.stands_for.unwrap_or(self.filter);
        let needed = self.planes.iter().filter(|plane| plane.taps > 0).map(|plane| plane.size[axis]);
        // A product with 2^n needs n bits for the index and the filter's below; any other product, and any sum with the place of a
        // probe, needs all there are, wherever the probes of these requests fall: a lower bit may carry.
        let below = needed
            .map(|size| if size.is_power_of_two() { size.trailing_zeros() } else { COORDINATE_BITS })
            .max()
            .unwrap_or(0);
        let used = match read {
            _ if self.filter.is_anisotropic() => COORDINATE_BITS,
            Filter::Point => below,
            Filter::Sat => below + 1,
            _ => below + u32::from(sampler.filter_bits),
        };
        let there = COORDINATE_BITS.saturating_sub(all.trailing_zeros());
        let integer = if !self.address_logic[axis] || requests.is_empty() {
            0
        } else {
            // What is left of the point, with a sign where not all is in the first repeat.
            let [low, high] = [low, high].map(|bits| bits >> COORDINATE_BITS);
            let within = low == 0 && high == 0;
            let magnitude = i32::BITS - high.max(!low).leading_zeros();
            match sampler.address[axis] {
                AddressMode::Wrap => 0,
                _ if within => 0,
                AddressMode::Mirror => 1,
                AddressMode::Clamp | AddressMode::Clip => magnitude + 1,
            }
        };
        CoordinateBits { integer: integer as u8, fraction: used.min(COORDINATE_BITS).min(there) as u8 }
    }

    /// Whether taps of weight read from this plane.
    #[must_use]
    pub fn plane(&self, lu: u8, lv: u8) -> bool {
        self.planes.iter().any(|plane| plane.halvings == (lu, lv) && plane.taps > 0)
    }

    /// The size of the smallest texture whose pyramid has every plane that is read: that of the largest of them.
    #[must_use]
    pub fn smallest_texture(&self) -> [u32; 2] {
        let read = || self.planes.iter().filter(|plane| plane.taps > 0).map(|plane| plane.size);
        [0, 1].map(|axis| read().map(|size| size[axis]).max().unwrap_or(0))
    }

    /// Tiles read and tiles there are, of all planes.
    #[must_use]
    pub fn tiles(&self) -> [u64; 2] {
        [TileSet::len, TileSet::all].map(|count| self.planes.iter().map(|plane| count(&plane.tiles)).sum())
    }
}

/// Whether a request's taps are one, and read what the simple filter's tap reads.
fn answers_like(filter: Filter, taps: &[Footprint], base: &Footprint) -> bool {
    if filter == Filter::Sat {
        // A box of one texel is the point tap (docs/numerics.md, section 5.3).
        return taps.first().is_some_and(|tap| tap.fraction == [1, 1]);
    }
    let [tap] = taps else { return false };
    tap.plane == 0 && tap.address == base.address && tap.fraction == base.fraction
}
