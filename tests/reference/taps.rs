//! Taps: which texels, with which weights, rounded where.

use texunit_hw::{
    AddressMode::{Clamp, Clip, Mirror, Wrap},
    Filter, I12F20, LodSource, PyramidKind, Request, Response, Sampler,
};

use crate::{
    FILTERS, MODES, ROUNDINGS, answer, at,
    planes::{columns, pyramid},
    red, sampler,
};

#[test]
fn a_point_tap_takes_the_texel_under_the_coordinate() {
    let texture = columns(&[10, 20, 30, 40]);
    let tiny = f64::exp2(-20.0);
    let rows = [
        (0.0, [10, 10, 10, 10]),
        (0.25 - tiny, [10, 10, 10, 10]),
        (0.25, [20, 20, 20, 20]),
        (1.0 - tiny, [40, 40, 40, 40]),
        (1.0, [10, 40, 0, 40]),
        (1.3, [20, 40, 0, 30]),
        (2.0, [10, 40, 0, 10]),
        (-tiny, [40, 10, 0, 10]),
        (-0.3, [30, 10, 0, 20]),
        (-2048.0, [10, 10, 0, 10]),
        (2048.0 - tiny, [40, 40, 0, 10]),
    ];
    for (u, expected) in rows {
        for (mode, expected) in MODES.into_iter().zip(expected) {
            // Along v there is one texel, which only clip leaves.
            assert_eq!(red(&texture, &sampler(Filter::Point, mode), &at(u, 0.5)), expected, "{mode:?} at {u}");
        }
    }
}

#[test]
fn a_bilinear_tap_weighs_the_texels_around_the_coordinate() {
    let texture = columns(&[0, 200]);
    // p = 2u - 1/2: the fraction is that of p.
    let rows = [
        (0.25, [0, 0, 0, 0]),
        (0.5, [100, 100, 100, 100]),
        (0.75, [200, 200, 200, 200]),
        (0.375, [50, 50, 50, 50]),
        (1.0, [100, 200, 100, 200]), // between texel 1 and index 2: texel 0, texel 1, nothing, texel 1
        (0.0, [100, 0, 0, 0]),       // between index -1 and texel 0
        (-0.25, [200, 0, 0, 0]),     // on index -1
        (1.25, [0, 200, 0, 200]),    // on index 2
    ];
    for (u, expected) in rows {
        for (mode, expected) in MODES.into_iter().zip(expected) {
            assert_eq!(red(&texture, &sampler(Filter::Bilinear, mode), &at(u, 0.5)), expected, "{mode:?} at {u}");
        }
    }
}

#[test]
fn the_filter_fraction_is_truncated_to_its_bits() {
    let texture = columns(&[0, 255]);
    // u = 0.25 + 0.31 / 2: the fraction is 0.31.
    let request = at(0.405, 0.5);
    // floor(0.31 * 2^b) * 255 / 2^b, half up: 0; 1/4; 2/8; 4/16; 79/256; 1269/4096.
    for (bits, expected) in [(1, 0), (2, 64), (3, 64), (4, 64), (8, 79), (12, 79)] {
        let sampler = Sampler { filter_bits: bits, ..sampler(Filter::Bilinear, Clamp) };
        assert_eq!(red(&texture, &sampler, &request), expected, "{bits} bits");
    }
}

#[test]
fn a_texture_of_five_by_three_is_scaled_exactly() {
    let texture = pyramid(PyramidKind::Mipmap, 5, 3, |lu, _, x, y| [50 * x as u8, [0, 50, 200][y as usize], lu, 255]);
    // u = 0.5 is p = 2, texel 2 exactly; v = 2/3 (floored to 12.20) is p = 1.4999..., fraction 127/256.
    let bilinear = answer(&texture, &sampler(Filter::Bilinear, Clamp), &at(0.5, 2.0 / 3.0));
    assert_eq!(bilinear.texel, [100, 124, 0, 255]); // 50 + 150 * 127/256 = 124.4
    // u = 0.6 floors below texel 3 of 5: 629145 * 5 = 3145725 < 3 * 2^20.
    assert_eq!(answer(&texture, &sampler(Filter::Point, Wrap), &at(0.6, 0.0)).texel, [100, 0, 0, 255]);
    let a_step_up = Request::at(I12F20::from_bits(629_146), I12F20::ZERO);
    assert_eq!(answer(&texture, &sampler(Filter::Point, Wrap), &a_step_up).texel, [150, 0, 0, 255]);
    // 5 x 3 halves to 2 x 1, then to 1 x 1: the level count is floor(log2 5) + 1 = 3.
    assert_eq!(texture.planes.iter().map(|p| (p.width, p.height)).collect::<Vec<_>>(), [(5, 3), (2, 1), (1, 1)]);
    let coarsest = Request { scale: [f32::INFINITY.to_bits(); 2], ..at(0.5, 0.5) };
    assert_eq!(answer(&texture, &sampler(Filter::Trilinear, Wrap), &coarsest).lod, [512; 2]);
}

#[test]
fn a_one_texel_texture_is_its_texel_everywhere_but_fades_in_clip() {
    let texture = columns(&[200]);
    for filter in FILTERS {
        let kind = filter.pyramid();
        let texture = pyramid(kind, 1, 1, |_, _, _, _| [200; 4]);
        for mode in [Wrap, Clamp, Mirror] {
            for (u, v) in [(0.0, 0.0), (0.5, 0.5), (-3.7, 1999.1), (0.999, -0.001)] {
                let request = Request { scale: [u32::MAX, 0x3f80_0000], ..at(u, v) };
                assert_eq!(answer(&texture, &sampler(filter, mode), &request).texel, [200; 4], "{filter:?} {mode:?}");
            }
        }
    }
    for (u, v, expected) in [(0.5, 0.5, 200), (0.0, 0.5, 100), (0.0, 0.0, 50), (-0.25, 0.5, 50), (-0.5, 0.5, 0)] {
        assert_eq!(red(&texture, &sampler(Filter::Bilinear, Clip), &at(u, v)), expected, "clip at {u}, {v}");
    }
}

#[test]
fn the_roundings_differ_where_the_page_says_so() {
    // c00, c10, c01, c11 at f = g = 1/2, answers in the order of ROUNDINGS.
    let rows = [
        ([0, 1, 0, 1], [1, 1, 0]), // 0.5 along u
        ([0, 1, 0, 0], [0, 1, 0]), // 0.25; along u 0.5 -> 1, along v 0.5 -> 1
        ([1, 1, 0, 1], [1, 1, 0]), // 0.75; truncated 1 and 0, then 0
        ([255, 255, 255, 255], [255; 3]),
    ];
    for (texels, expected) in rows {
        let texture = pyramid(PyramidKind::Mipmap, 2, 2, |_, _, x, y| {
            [texels.get((2 * y + x) as usize).copied().unwrap_or(0); 4]
        });
        for (rounding, expected) in ROUNDINGS.into_iter().zip(expected) {
            let sampler = Sampler { rounding, ..sampler(Filter::Bilinear, Clamp) };
            assert_eq!(red(&texture, &sampler, &at(0.5, 0.5)), expected, "{texels:?} {rounding:?}");
        }
    }
    // Over the taps: 0 and 1 in halves.
    let texture = pyramid(PyramidKind::Mipmap, 2, 1, |lu, _, _, _| [lu; 4]);
    for (rounding, expected) in ROUNDINGS.into_iter().zip([1, 1, 0]) {
        let sampler = Sampler { rounding, lod_source: LodSource::Explicit, ..Sampler::default() };
        assert_eq!(red(&texture, &sampler, &Request { scale: [128; 2], ..at(0.5, 0.5) }), expected, "{rounding:?}");
    }
}

#[test]
fn dipmap_averages_a_column_plane_and_a_row_plane() {
    let texture = pyramid(PyramidKind::Dipmap, 8, 4, |lu, lv, _, _| [10 * lu + 100 * lv; 4]);
    let sampler = Sampler { filter: Filter::Dipmap, lod_source: LodSource::Explicit, ..Sampler::default() };
    // Level of u, of v; texel of (lu, 0) and (0, lv) halved, half up; each level its own floor, 0..=3 and 0..=2.
    let rows = [
        ([0, 0], 0, [0, 0]),
        ([0x100, 0], 5, [0x100, 0]),
        ([0x1ff, 0x80], 5, [0x100, 0]),
        ([0x300, 0x200], 115, [0x300, 0x200]),
        ([0x7fff, 0x7fff], 115, [0x300, 0x200]),
        ([0, 0x100], 50, [0, 0x100]),
    ];
    for (scale, expected, lod) in rows {
        let response = answer(&texture, &sampler, &Request { scale, ..at(0.3, 0.7) });
        assert_eq!(response, Response { texel: [expected; 4], lod }, "{scale:x?}");
    }
}
