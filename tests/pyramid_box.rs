//! The box kernel, plane sets and their memory, against counting areas texel by texel.

use proptest::prelude::*;
use texunit::pyramid::{Build, From, PlaneImage, PlaneRounding, Pyramid};
use texunit_hw::PyramidKind;

const KINDS: [PyramidKind; 3] = [PyramidKind::Mipmap, PyramidKind::Dipmap, PyramidKind::Ripmap];
const ROUNDINGS: [PlaneRounding; 3] = [PlaneRounding::HalfEven, PlaneRounding::HalfUp, PlaneRounding::Truncate];

/// Texels from a linear congruential generator, high bits.
fn noise(width: u32, height: u32, seed: u32) -> PlaneImage {
    let mut state = seed;
    let texels = std::iter::repeat_with(|| {
        [0; 4].map(|_: u8| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
    });
    PlaneImage::top(width, height, texels.take((width * height) as usize).collect())
}

fn grey(width: u32, height: u32, value: impl Fn(u32, u32) -> u8) -> PlaneImage {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| [value(x, y); 4]).collect();
    PlaneImage::top(width, height, texels)
}

fn build(kind: PyramidKind, top: &PlaneImage, from: From, rounding: PlaneRounding) -> Pyramid {
    Build { from, rounding, ..Build::default() }.pyramid(kind, top).unwrap()
}

/// Cuts every source texel into `n_u` x `n_v` equal pieces, so that every new texel is `N_u` x `N_v` whole pieces, and counts.
fn counted(source: &PlaneImage, width: u32, height: u32, rounding: PlaneRounding) -> Vec<[u8; 4]> {
    let mut texels = Vec::new();
    for j in 0..height {
        for i in 0..width {
            let mut sums = [0i64; 4];
            for y in j * source.height..(j + 1) * source.height {
                for x in i * source.width..(i + 1) * source.width {
                    let texel = source.texels[(y / height * source.width + x / width) as usize];
                    (0..4).for_each(|channel| sums[channel] += i64::from(texel[channel]));
                }
            }
            let pieces = i64::from(source.width * source.height);
            texels.push(sums.map(|sum| {
                let below = (0..=255).rev().find(|value| value * pieces <= sum).unwrap();
                let (down, up) = (sum - below * pieces, (below + 1) * pieces - sum);
                let up_wins = match rounding {
                    PlaneRounding::Truncate => false,
                    PlaneRounding::HalfUp => up <= down,
                    PlaneRounding::HalfEven => up < down || (up == down && below % 2 == 1),
                };
                (below + i64::from(up_wins)) as u8
            }));
        }
    }
    texels
}

/// The source of a plane with `from: above`, spelled out per pyramid.
fn plane_above(kind: PyramidKind, pyramid: &Pyramid, number: usize) -> &PlaneImage {
    let PlaneImage { lu, lv, .. } = pyramid.planes[number];
    match kind {
        PyramidKind::Mipmap => &pyramid.planes[number - 1],
        PyramidKind::Dipmap if lv == 0 => pyramid.plane(lu - 1, 0).unwrap(),
        PyramidKind::Dipmap => pyramid.plane(0, lv - 1).unwrap(),
        PyramidKind::Ripmap if lu > 0 => pyramid.plane(lu - 1, lv).unwrap(),
        PyramidKind::Ripmap => pyramid.plane(0, lv - 1).unwrap(),
        PyramidKind::Sat => panic!("a summed-area table has one plane, made from none"),
    }
}

fn side() -> impl Strategy<Value = u32> {
    prop_oneof![1u32..=40, (0u32..=5).prop_map(|log2| 1 << log2)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn every_box_texel_is_the_counted_average_of_its_area(width in side(), height in side(), seed: u32, rule in 0usize..3) {
        let (top, rounding) = (noise(width, height, seed), ROUNDINGS[rule]);
        for kind in KINDS {
            let from_top = build(kind, &top, From::Top, rounding);
            let from_above = build(kind, &top, From::Above, rounding);
            prop_assert_eq!(&from_top.planes[0], &top);
            prop_assert_eq!(&from_above.planes[0], &top);
            for number in 1..from_top.planes.len() {
                let plane = &from_top.planes[number];
                prop_assert_eq!(&plane.texels, &counted(&top, plane.width, plane.height, rounding));
                let (plane, source) = (&from_above.planes[number], plane_above(kind, &from_above, number));
                prop_assert_eq!(&plane.texels, &counted(source, plane.width, plane.height, rounding));
            }
        }
    }

    #[test]
    fn a_plane_is_the_same_in_every_pyramid_that_has_it(width in 1u32..=64, height in 1u32..=64, seed: u32) {
        let top = noise(width, height, seed);
        let [mip, dip, rip] = KINDS.map(|kind| build(kind, &top, From::Top, PlaneRounding::HalfEven));
        for plane in mip.planes.iter().chain(&dip.planes) {
            prop_assert_eq!(rip.plane(plane.lu, plane.lv).unwrap(), plane);
        }
    }
}

#[test]
fn large_powers_of_two_agree_with_counting_too() {
    let top = noise(256, 128, 7);
    for rounding in ROUNDINGS {
        let mip = build(PyramidKind::Mipmap, &top, From::Top, rounding);
        for plane in &mip.planes[3..] {
            assert_eq!(
                plane.texels,
                counted(&top, plane.width, plane.height, rounding),
                "plane {} {}",
                plane.lu,
                plane.lv
            );
        }
    }
}

#[test]
fn box_from_the_top_is_the_recursion_where_nothing_is_rounded() {
    // Multiples of 16 survive two halvings of both axes, multiples of 64 six halvings of one (E20).
    let square = PlaneImage {
        texels: noise(32, 32, 3).texels.iter().map(|t| t.map(|c| c & 0xF0)).collect(),
        ..noise(32, 32, 3)
    };
    let line =
        PlaneImage { texels: noise(64, 1, 4).texels.iter().map(|t| t.map(|c| c & 0xC0)).collect(), ..noise(64, 1, 4) };
    for rounding in ROUNDINGS {
        for (top, levels) in [(&square, 2), (&line, 6)] {
            let [by_top, by_above] =
                [From::Top, From::Above].map(|from| build(PyramidKind::Mipmap, top, from, rounding));
            assert_eq!(by_top.planes[..=levels], by_above.planes[..=levels]);
        }
    }
}

#[test]
fn memory_follows_the_closed_formulas() {
    let texels =
        |kind, width, height| build(kind, &grey(width, height, |_, _| 0), From::Top, PlaneRounding::HalfEven).texels();
    let [mip, dip, rip] = KINDS;
    for log2 in 0..=8 {
        let n = 1u64 << log2;
        let side = n as u32;
        assert_eq!(texels(mip, side, side), (4 * n * n - 1) / 3);
        assert_eq!(texels(dip, side, side), 3 * n * n - 2 * n, "the base is stored once (E11)");
        assert_eq!(texels(rip, side, side), (2 * n - 1) * (2 * n - 1));
        for kind in KINDS {
            assert_eq!(texels(kind, side, 1), 2 * n - 1, "2 - 1/N (X11)");
            assert_eq!(texels(kind, 1, side), 2 * n - 1);
        }
    }
    let multiple = |kind| build(kind, &grey(1024, 16, |_, _| 0), From::Top, PlaneRounding::HalfEven).memory_multiple();
    for (kind, expected) in [(mip, 1.336), (dip, 2.937), (rip, 3.873)] {
        assert!((multiple(kind) - expected).abs() < 5e-4, "{kind:?} of 1024 x 16: {}", multiple(kind));
    }
}

#[test]
fn an_exhausted_axis_is_left_alone_while_the_other_halves_on() {
    let line = grey(8, 1, |x, _| [0, 10, 20, 30, 40, 50, 60, 70][x as usize]);
    for (top, turned) in [(line.clone(), false), (PlaneImage { width: 1, height: 8, ..line }, true)] {
        let mip = build(PyramidKind::Mipmap, &top, From::Top, PlaneRounding::HalfEven);
        let halvings: Vec<_> = mip.planes.iter().map(|plane| if turned { plane.lv } else { plane.lu }).collect();
        assert_eq!(halvings, [0, 1, 2, 3]);
        assert!(mip.planes.iter().all(|plane| if turned { plane.lu == 0 } else { plane.lv == 0 }));
        let level = |number: usize| mip.planes[number].texels.iter().map(|texel| texel[0]).collect::<Vec<_>>();
        assert_eq!(level(1), [5, 25, 45, 65]);
        assert_eq!(level(2), [15, 55]);
        assert_eq!(level(3), [35]);
    }
}

#[test]
fn a_single_texel_is_its_own_pyramid() {
    for kind in KINDS {
        let pyramid = build(kind, &noise(1, 1, 9), From::Top, PlaneRounding::Truncate);
        assert_eq!(pyramid.planes, [noise(1, 1, 9)]);
    }
}

#[test]
fn five_columns_become_two_with_weights_two_two_one_and_one_two_two() {
    // 255 / 5 = 51: no rounding in the way (X13).
    for from in [From::Top, From::Above] {
        let weights: Vec<_> = (0..5)
            .map(|lit| {
                let top = grey(5, 1, |x, _| if x == lit { 255 } else { 0 });
                let half = build(PyramidKind::Mipmap, &top, from, PlaneRounding::HalfEven).planes[1].clone();
                [half.texels[0][0] / 51, half.texels[1][0] / 51]
            })
            .collect();
        assert_eq!(weights, [[2, 0], [2, 0], [1, 1], [0, 2], [0, 2]]);
    }
}

#[test]
fn means_stay_put_from_the_top_and_sink_by_three_eighths_a_level_when_truncated() {
    let top = noise(256, 256, 19);
    let mean =
        |plane: &PlaneImage| plane.texels.iter().map(|t| f64::from(t[1])).sum::<f64>() / plane.texels.len() as f64;
    let still = build(PyramidKind::Mipmap, &top, From::Top, PlaneRounding::HalfEven);
    let sinking = build(PyramidKind::Mipmap, &top, From::Above, PlaneRounding::Truncate);
    for level in 1..=8 {
        let drift = (mean(&still.planes[level]) - mean(&top)).abs();
        // Four standard deviations of the mean of `width^2` independent roundings; 0.005 at level 1 (X19).
        let band = (4.0 * 0.2887 / f64::from(still.planes[level].width)).min(0.5);
        assert!(drift <= band, "level {level} drifts by {drift}");
        let sunk = mean(&sinking.planes[level]) - mean(&top);
        assert!((sunk + 0.375 * level as f64).abs() < 0.1 * level as f64, "level {level} sank by {sunk}");
    }
}
