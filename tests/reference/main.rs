//! The float reference against numbers worked out by hand from docs/numerics.md, and against its own limit, the ideal.

mod ewa;
mod filters;
mod ideal;
mod levels;
mod planes;
mod sat;
mod tables;
mod taps;

use planes::pyramid;
use texunit::{pyramid::Pyramid, reference::Reference};
use texunit_hw::{
    AddressMode::{self, Clamp, Clip, Mirror, Wrap},
    Filter, I12F20, PyramidKind, Request, Response, Rounding, Sampler,
};

const MODES: [AddressMode; 4] = [Wrap, Clamp, Clip, Mirror];

const FILTERS: [Filter; 5] = [Filter::Point, Filter::Bilinear, Filter::NearestMip, Filter::Trilinear, Filter::Dipmap];

const ROUNDINGS: [Rounding; 3] = [Rounding::Once, Rounding::StagedRound, Rounding::StagedTruncate];

/// Turns as 12.20, floored, as section 1.1 has it (`I12F20::from_num` rounds to nearest).
fn fixed(turns: f64) -> I12F20 {
    I12F20::from_bits((turns * 1_048_576.0).floor() as i32)
}

fn at(u: f64, v: f64) -> Request {
    Request::at(fixed(u), fixed(v))
}

fn answer(pyramid: &Pyramid, sampler: &Sampler, request: &Request) -> Response {
    Reference::new(pyramid, sampler).unwrap().sample(request)
}

fn red(pyramid: &Pyramid, sampler: &Sampler, request: &Request) -> u8 {
    answer(pyramid, sampler, request).texel[0]
}

fn sampler(filter: Filter, mode: AddressMode) -> Sampler {
    Sampler { filter, address: [mode; 2], ..Sampler::default() }
}

/// A column 65536 texels high, so that levels 0 to 16 can be seen; every texel of level l is 10 l.
fn tower() -> Pyramid {
    pyramid(PyramidKind::Mipmap, 1, 1 << 16, |_, lv, _, _| [10 * lv; 4])
}

#[test]
fn a_pyramid_without_the_planes_of_the_filter_is_refused() {
    let mipmap = pyramid(PyramidKind::Mipmap, 8, 8, |_, _, _, _| [0; 4]);
    let refused = |texture: &Pyramid, filter| Reference::new(texture, &sampler(filter, Wrap)).unwrap_err().to_string();
    assert!(refused(&mipmap, Filter::Dipmap).contains("has no plane (1, 0) of 4 x 8 texels"));
    let mut short = mipmap.clone();
    short.planes[1].texels.pop();
    assert!(refused(&short, Filter::Trilinear).contains("has no plane (1, 1) of 4 x 4 texels"));
    let empty = Pyramid { width: 0, ..mipmap.clone() };
    assert!(refused(&empty, Filter::Point).contains("0 texels"));
    let wide = Sampler { filter_bits: 13, ..Sampler::default() };
    assert!(Reference::new(&mipmap, &wide).unwrap_err().to_string().contains("filter_bits = 13"));
}
