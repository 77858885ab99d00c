//! A request a lane, from coordinates to texels, in registers all the way.

use super::{
    address::{Addresses, Taps},
    filter,
    level::{Logarithm, brilinear_weights},
    machine::{Machine, transposed},
    room::{Table, Texels, ask_ahead},
};
use crate::{
    address_stream::TapRows,
    lod::LevelRange,
    request::{Request, Response},
    sampler::{Filter, LevelRounding, Sampler},
    taps::TapUnit,
};

/// A texture unit in lanes.
#[derive(Clone, Debug)]
pub(super) struct Kernel<'m> {
    filter: Filter,
    addresses: Addresses,
    texels: Texels<'m>,
    logarithm: Logarithm,
    chain: LevelRange,
    axes: [LevelRange; 2],
    /// Storage index of plane (0, lv) of a Dipmap is this plus lv, for lv above zero; one less than a Ripmap's planes a row.
    row_planes: i32,
    /// What a filter of one whole level adds before it cuts the fraction.
    level_rounding: i32,
    brilinear: Table,
}

/// What a filter makes of requests before there are addresses.
#[derive(Clone, Copy)]
struct Levels<M: Machine> {
    /// A plane a tap.
    planes: [M::Words; 4],
    /// Weights of the blurrier of two taps, of 256: of the first pair, and of the second pair or between both.
    t: [M::Words; 2],
    /// Levels of a response.
    lod: M::Words,
}

/// Requests between the address unit and the datapath.
#[derive(Clone, Copy)]
struct Made<M: Machine, const TAPS: usize> {
    taps: [Taps<M>; TAPS],
    levels: Levels<M>,
}

/// Registers of requests made before the first is filtered. Addresses and filters are loops of their own: each is short enough for the host
/// to work on two turns at a time, and needs no more registers than it has.
const STAGE: usize = 4;

/// Bytes of requests asked for before they are needed: the host's own foresight ends at every page.
const AHEAD: usize = 4096;

impl<'m> Kernel<'m> {
    pub(super) fn new(sampler: &Sampler, unit: &TapUnit, bytes: &'m [u8]) -> Option<Self> {
        Some(Self {
            filter: sampler.filter,
            addresses: Addresses::new(unit.address(), bytes.len() as u64)?,
            texels: Texels::new(bytes)?,
            logarithm: Logarithm::new(sampler)?,
            chain: unit.chain,
            axes: unit.axes,
            row_planes: unit.row_planes as i32,
            level_rounding: match sampler.level_rounding {
                LevelRounding::Floor => 0,
                LevelRounding::Nearest => 128,
                LevelRounding::Gl => 127,
            },
            brilinear: Table::new(brilinear_weights(sampler.brilinear_threshold.into()))?,
        })
    }

    /// Taps of a request.
    pub(super) const fn taps(&self) -> usize {
        taps_of(self.filter as u8)
    }

    /// Answers requests, and writes their taps from the one numbered `first`, as far as either is asked for, as many requests as fill registers.
    ///
    /// # Panics
    /// If there is not room for the taps.
    #[inline(always)]
    pub(super) fn run<M: Machine>(
        &self,
        m: M,
        requests: &[Request],
        responses: Option<&mut [Response]>,
        rows: Option<&mut TapRows>,
        first: usize,
    ) {
        // A loop a filter: its taps and weights stay in registers.
        macro_rules! filters {
            ($($filter:ident)*) => {
                match self.filter {
                    $(Filter::$filter => {
                        const FILTER: u8 = Filter::$filter as u8;
                        self.registers::<M, FILTER, { taps_of(FILTER) }>(m, requests, responses, rows, first);
                    })*
                    _ => unreachable!("no kernel is made for filters of many taps"),
                }
            };
        }
        filters!(Point Bilinear NearestMip Trilinear Brilinear MipDouble Dipmap DipmapTrilinear Ripmap);
    }

    #[inline(always)]
    fn registers<M: Machine, const FILTER: u8, const TAPS: usize>(
        &self,
        m: M,
        requests: &[Request],
        responses: Option<&mut [Response]>,
        mut rows: Option<&mut TapRows>,
        mut first: usize,
    ) {
        let nothing = m.splat(0);
        let levels = Levels { planes: [nothing; 4], t: [nothing; 2], lod: nothing };
        let mut stage = [Made { taps: [Taps { corners: [nothing; 4], fractions: [nothing; 2] }; TAPS], levels }; STAGE];
        let mut responses = responses.map(|responses| responses.chunks_exact_mut(M::LANES));
        for requests in requests.chunks(STAGE * M::LANES) {
            let stage = &mut stage[..requests.len() / M::LANES];
            for (requests, made) in requests.chunks_exact(M::LANES).zip(&mut *stage) {
                // The other half is asked for by the next loop: a host waits for no more than so much at a time.
                ask_ahead(&requests[..M::LANES / 2], AHEAD);
                self.make::<M, FILTER, TAPS>(m, requests, made);
            }
            if let Some(rows) = &mut rows {
                let texels = if FILTER == Filter::Point as u8 { 1 } else { 4 };
                for Made { taps, levels } in &*stage {
                    let mut planes = [nothing; TAPS];
                    planes.copy_from_slice(&levels.planes[..TAPS]);
                    self.addresses.write(m, taps, planes, texels, first, rows);
                    first += TAPS * M::LANES;
                }
            }
            if let Some(responses) = &mut responses {
                for ((made, requests), responses) in stage.iter().zip(requests.chunks_exact(M::LANES)).zip(responses) {
                    ask_ahead(&requests[M::LANES / 2..], AHEAD);
                    m.respond(responses, self.filter::<M, FILTER, TAPS>(m, made), made.levels.lod);
                }
            }
        }
    }

    /// The address unit.
    #[inline(always)]
    fn make<M: Machine, const FILTER: u8, const TAPS: usize>(
        &self,
        m: M,
        requests: &[Request],
        made: &mut Made<M, TAPS>,
    ) {
        let heads = [m.heads(requests, 0), m.heads(requests, 1), m.heads(requests, 2), m.heads(requests, 3)];
        let [u, v, scale_u, scale_v] = transposed(m, heads);
        let (at, scale) = ([u, v], [scale_u, scale_v]);
        made.levels = self.levels::<M, FILTER>(m, scale);
        if FILTER == Filter::Point as u8 {
            made.taps[0].corners[0] = self.addresses.point(m, made.levels.planes[0], at);
            return;
        }
        for (tap, plane) in made.taps.iter_mut().zip(made.levels.planes) {
            *tap = self.addresses.bilinear(m, plane, at);
        }
    }

    /// The datapath.
    #[inline(always)]
    fn filter<M: Machine, const FILTER: u8, const TAPS: usize>(&self, m: M, made: &Made<M, TAPS>) -> M::Words {
        let (taps, t) = (&made.taps, &made.levels.t);
        if FILTER == Filter::Point as u8 {
            return m.texels(self.texels, taps[0].corners[0]);
        }
        let first = filter::bilinear(m, self.texels, &taps[0]);
        if TAPS == 1 {
            return filter::one(m, first);
        }
        let second = filter::bilinear(m, self.texels, &taps[1]);
        if TAPS == 2 {
            return filter::two(m, first, second, t[0]);
        }
        let (third, fourth) = (filter::bilinear(m, self.texels, &taps[2]), filter::bilinear(m, self.texels, &taps[3]));
        if FILTER == Filter::Ripmap as u8 {
            filter::four(m, [first, second, third, fourth], *t)
        } else {
            filter::mean_of_two(m, [(first, second, t[0]), (third, fourth, t[1])])
        }
    }

    /// The filter's program (see `taps`), as far as the planes and weights.
    #[inline(always)]
    fn levels<M: Machine, const FILTER: u8>(&self, m: M, [scale_u, scale_v]: [M::Words; 2]) -> Levels<M> {
        let nothing = m.splat(0);
        let mut levels = Levels { planes: [nothing; 4], t: [nothing; 2], lod: nothing };
        let half = m.splat(128);
        match FILTER {
            _ if FILTER == Filter::NearestMip as u8 => {
                let level = self.chain.whole_lanes(m, self.logarithm.raw(m, scale_u), self.level_rounding);
                levels.planes[0] = level;
                levels.lod = both(m, m.shl(level, 8));
            }
            _ if FILTER == Filter::Trilinear as u8 => {
                let split = self.chain.split_lanes(m, self.logarithm.raw(m, scale_u));
                levels.planes = [split.level, split.coarser, nothing, nothing];
                levels.t[0] = split.t;
                levels.lod = both(m, split.lod);
            }
            _ if FILTER == Filter::Brilinear as u8 => {
                let split = self.chain.split_lanes(m, self.logarithm.raw(m, scale_u));
                levels.planes = [split.level, split.coarser, nothing, nothing];
                levels.t[0] = m.gather(&self.brilinear, split.t);
                levels.lod = both(m, m.add(m.shl(split.level, 8), levels.t[0]));
            }
            _ if FILTER == Filter::MipDouble as u8 => {
                let u = self.chain.whole_lanes(m, self.logarithm.raw(m, scale_u), 0);
                let v = self.chain.whole_lanes(m, self.logarithm.raw(m, scale_v), 0);
                levels.planes = [u, v, nothing, nothing];
                levels.t[0] = half;
                levels.lod = pair(m, m.shl(u, 8), m.shl(v, 8));
            }
            _ if FILTER == Filter::Dipmap as u8 => {
                let u = self.axes[0].whole_lanes(m, self.logarithm.raw(m, scale_u), 0);
                let v = self.axes[1].whole_lanes(m, self.logarithm.raw(m, scale_v), 0);
                levels.planes = [u, self.row_plane(m, v), nothing, nothing];
                levels.t[0] = half;
                levels.lod = pair(m, m.shl(u, 8), m.shl(v, 8));
            }
            _ if FILTER == Filter::DipmapTrilinear as u8 => {
                let u = self.axes[0].split_lanes(m, self.logarithm.raw(m, scale_u));
                let v = self.axes[1].split_lanes(m, self.logarithm.raw(m, scale_v));
                levels.planes = [u.level, u.coarser, self.row_plane(m, v.level), self.row_plane(m, v.coarser)];
                levels.t = [u.t, v.t];
                levels.lod = pair(m, u.lod, v.lod);
            }
            _ if FILTER == Filter::Ripmap as u8 => {
                let u = self.axes[0].split_lanes(m, self.logarithm.raw(m, scale_u));
                let v = self.axes[1].split_lanes(m, self.logarithm.raw(m, scale_v));
                let planes_of_row = m.splat(self.row_planes + 1);
                let rows = [m.mul(v.level, planes_of_row), m.mul(v.coarser, planes_of_row)];
                levels.planes = [
                    m.add(rows[0], u.level),
                    m.add(rows[0], u.coarser),
                    m.add(rows[1], u.level),
                    m.add(rows[1], u.coarser),
                ];
                levels.t = [u.t, v.t];
                levels.lod = pair(m, u.lod, v.lod);
            }
            _ => {}
        }
        levels
    }

    /// Storage indices of planes (0, lv) of a Dipmap.
    #[inline(always)]
    fn row_plane<M: Machine>(&self, m: M, lv: M::Words) -> M::Words {
        m.add(lv, m.where_positive(lv, m.splat(self.row_planes)))
    }
}

/// Taps of a request of a filter.
const fn taps_of(filter: u8) -> usize {
    const ONE: [u8; 3] = [Filter::Point as u8, Filter::Bilinear as u8, Filter::NearestMip as u8];
    const FOUR: [u8; 2] = [Filter::DipmapTrilinear as u8, Filter::Ripmap as u8];
    if filter == ONE[0] || filter == ONE[1] || filter == ONE[2] {
        1
    } else if filter == FOUR[0] || filter == FOUR[1] {
        4
    } else {
        2
    }
}

/// Two levels as the halves of a word.
#[inline(always)]
fn pair<M: Machine>(m: M, u: M::Words, v: M::Words) -> M::Words {
    m.or(u, m.shl(v, 16))
}

/// One level as both halves of a word.
#[inline(always)]
fn both<M: Machine>(m: M, lod: M::Words) -> M::Words {
    pair(m, lod, lod)
}
