//! Pyramid kernels against their definitions in f64, and against the numbers of E16, E18 and E19.

use proptest::prelude::*;
use texunit::{
    names::Named,
    pyramid::{Build, From, Kernel, PlaneImage, PlaneRounding, axis::AxisTaps, drift::*, response::Response},
};
use texunit_hw::{AddressMode, PyramidKind};

const DESIGNED: [Kernel; 3] = [Kernel::Tent, Kernel::Lanczos, Kernel::Kaiser];

/// Blow's half kernels, taps at 0.5 to 6.5 source texels (E18).
const LANCZOS_HALF: [f64; 7] = [0.44449, 0.13838, -0.07199, -0.04077, 0.02222, 0.01029, -0.00263];
const KAISER_HALF: [f64; 7] = [0.44476, 0.13806, -0.07156, -0.04060, 0.02268, 0.01164, -0.00498];

fn one_of<T: Named + std::fmt::Debug>() -> impl Strategy<Value = T> {
    (0..T::ALL.len()).prop_map(|index| T::ALL[index].1)
}

fn designed() -> impl Strategy<Value = (Kernel, u8)> {
    (0..DESIGNED.len(), 1u8..=32).prop_map(|(kernel, half)| (DESIGNED[kernel], 2 * half))
}

fn texture(width: u32, height: u32, seed: u32) -> PlaneImage {
    let mut state = seed;
    let texels = std::iter::repeat_with(|| {
        [0; 4].map(|_: u8| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
    });
    PlaneImage::top(width, height, texels.take((width * height) as usize).collect())
}

/// The modified Bessel function I0 by its integral, not its series.
fn i0(x: f64) -> f64 {
    let steps = 2000;
    (0..steps)
        .map(|step| (x * (std::f64::consts::PI * (f64::from(step) + 0.5) / f64::from(steps)).cos()).exp())
        .sum::<f64>()
        / f64::from(steps)
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-12 { 1.0 } else { (std::f64::consts::PI * x).sin() / (std::f64::consts::PI * x) }
}

/// What section 8 says of a texel of a smaller axis, in floats: a weight per source texel.
fn real_weights(kernel: Kernel, width: u8, edge: AddressMode, source: i64, target: i64, i: i64) -> Vec<f64> {
    let scale = source as f64 / target as f64;
    let radius = f64::from(width) / 4.0 * scale;
    let centre = (i as f64 + 0.5) * scale;
    let mut raw = Vec::new();
    for k in -64 * source..65 * source {
        let x = k as f64 + 0.5 - centre;
        if x.abs() < radius - 1e-9 {
            let window = match kernel {
                Kernel::Tent => 1.0 - x.abs() / radius,
                Kernel::Lanczos => sinc(x / scale) * sinc(x / radius),
                _ => sinc(x / scale) * i0(4.0 * (1.0 - (x / radius).powi(2)).sqrt()),
            };
            raw.push((k, window));
        }
    }
    let total: f64 = raw.iter().map(|(_, weight)| weight).sum();
    let mut weights = vec![0.0; source as usize];
    for (mut k, weight) in raw {
        // Walks back into the texture, reflection by reflection or turn by turn.
        let inside = loop {
            if (0..source).contains(&k) {
                break Some(k);
            }
            match edge {
                AddressMode::Wrap => k += if k < 0 { source } else { -source },
                AddressMode::Clamp => k += if k < 0 { 1 } else { -1 },
                AddressMode::Mirror => k = if k < 0 { -1 - k } else { 2 * source - 1 - k },
                AddressMode::Clip => break None,
            }
        };
        if let Some(k) = inside {
            weights[k as usize] += weight / total;
        }
    }
    weights
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn designed_planes_are_within_a_quarter_step_of_the_real_kernel(
        (kernel, width) in designed(),
        edge in one_of::<AddressMode>(),
        (columns, rows) in (1u32..=20, 1u32..=20),
        seed: u32,
    ) {
        let mut top = texture(columns, rows, seed);
        top.texels[0] = [255, 255, 255, 0]; // straight alpha, so that colour is free of it
        let build = Build { kernel, width: Some(width), edge, ..Build::default() };
        for plane in &build.pyramid(PyramidKind::Ripmap, &top).unwrap().planes {
            let axis = |source, target, i| if source == target {
                (0..source).map(|k| f64::from(u8::from(k == i))).collect()
            } else {
                real_weights(kernel, width, edge, source, target, i)
            };
            let across: Vec<_> = (0..plane.width).map(|i| axis(columns.into(), plane.width.into(), i.into())).collect();
            for j in 0..plane.height {
                let down = axis(rows.into(), plane.height.into(), j.into());
                for i in 0..plane.width {
                    let sum: f64 = (0..rows * columns).map(|at| {
                        let (x, y) = ((at % columns) as usize, (at / columns) as usize);
                        down[y] * across[i as usize][x] * f64::from(top.texels[at as usize][1])
                    }).sum();
                    let got = f64::from(plane.texels[(j * plane.width + i) as usize][1]);
                    prop_assert!((got - sum.clamp(0.0, 255.0)).abs() <= 0.75, "{kernel:?} {width}: {got} for {sum}");
                }
            }
        }
    }

    #[test]
    fn integer_taps_sum_exactly_to_their_total(
        (kernel, width) in designed(),
        source in 2u32..=300,
        halvings in 1u8..=8,
        edge in one_of::<AddressMode>(),
    ) {
        let target = (source >> halvings).max(1);
        let taps = AxisTaps::new(kernel, Some(width), edge, source, target);
        prop_assert!(taps.total.count_ones() == 1 && taps.total >= 1 << 14);
        for i in 0..taps.len() {
            let sum: i64 = taps.of(i).iter().map(|tap| i64::from(tap.weight)).sum();
            if edge != AddressMode::Clip {
                prop_assert_eq!(sum, taps.total);
            }
            prop_assert!(taps.of(i).windows(2).all(|pair| pair[0].texel < pair[1].texel));
            prop_assert!(taps.of(i).iter().all(|tap| tap.texel < source));
        }
    }

    #[test]
    fn a_flat_texture_stays_flat(
        value: [u8; 4],
        kernel in one_of::<Kernel>(),
        half_width in proptest::option::of(1u8..=32),
        from in one_of::<From>(),
        rounding in one_of::<PlaneRounding>(),
        edge in one_of::<AddressMode>(),
        (columns, rows) in (1u32..=70, 1u32..=70),
    ) {
        // Clip fades at the border by design, for kernels that reach beyond it.
        let reaches_out = DESIGNED.contains(&kernel);
        let edge = if reaches_out && edge == AddressMode::Clip { AddressMode::Mirror } else { edge };
        let width = half_width.filter(|_| reaches_out).map(|half| 2 * half);
        let top = PlaneImage::top(columns, rows, vec![value; (columns * rows) as usize]);
        for kind in [PyramidKind::Mipmap, PyramidKind::Ripmap] {
            let pyramid = Build { kernel, width, from, rounding, edge }.pyramid(kind, &top).unwrap();
            prop_assert!(pyramid.planes.iter().all(|plane| plane.texels.iter().all(|&texel| texel == value)));
        }
    }

    #[test]
    fn premultiplied_textures_stay_premultiplied(
        kernel in one_of::<Kernel>(),
        edge in one_of::<AddressMode>(),
        from in one_of::<From>(),
        (columns, rows) in (1u32..=40, 1u32..=40),
        seed: u32,
    ) {
        let mut top = texture(columns, rows, seed);
        for texel in &mut top.texels {
            *texel = texel.map(|channel| channel.min(texel[3]));
        }
        let pyramid = Build { kernel, edge, from, ..Build::default() }.pyramid(PyramidKind::Ripmap, &top).unwrap();
        for plane in &pyramid.planes {
            prop_assert!(plane.texels.iter().all(|&[r, g, b, a]| r <= a && g <= a && b <= a));
        }
    }

    #[test]
    fn a_wrapped_texture_rolled_by_two_gives_its_half_rolled_by_one(
        (kernel, width) in designed(),
        half in 1u32..=24,
        seed: u32,
    ) {
        let top = texture(2 * half, 1, seed);
        let mut rolled = top.clone();
        rolled.texels.rotate_left(2 % (2 * half as usize));
        let level_one = |texture| {
            let build = Build { kernel, width: Some(width), ..Build::default() };
            build.planes(texture, &[(1, 0)], |_| ()).unwrap()[0].texels.clone()
        };
        if top.texels.iter().any(|t| t[0] > t[3]) {
            let mut expected = level_one(&top);
            expected.rotate_left(1);
            prop_assert_eq!(level_one(&rolled), expected);
        }
    }

    #[test]
    fn a_mirror_image_gives_the_mirrored_plane(
        (kernel, width) in designed(),
        edge in one_of::<AddressMode>(),
        half in 1u32..=24,
        seed: u32,
    ) {
        let top = texture(2 * half, 1, seed);
        let mut turned = top.clone();
        turned.texels.reverse();
        let build = Build { kernel, width: Some(width), edge, ..Build::default() };
        let level_one = |texture| build.planes(texture, &[(1, 0)], |_| ()).unwrap()[0].texels.clone();
        let mut expected = level_one(&top);
        expected.reverse();
        prop_assert_eq!(level_one(&turned), expected);
    }
}

#[test]
fn straight_alpha_leaves_colour_alone() {
    let top = PlaneImage::top(4, 4, vec![[200, 100, 50, 0]; 16]);
    let pyramid = Build { kernel: Kernel::Kaiser, ..Build::default() }.pyramid(PyramidKind::Mipmap, &top).unwrap();
    assert!(pyramid.planes.iter().all(|plane| plane.texels.iter().all(|&texel| texel == [200, 100, 50, 0])));
}

#[test]
fn clip_fades_to_transparent_black_at_the_border_only() {
    let top = PlaneImage::top(64, 1, vec![[255; 4]; 64]);
    let build = Build { kernel: Kernel::Kaiser, edge: AddressMode::Clip, ..Build::default() };
    let half = &build.pyramid(PyramidKind::Mipmap, &top).unwrap().planes[1];
    // The 14 taps of texel i are source texels 2i - 6 to 2i + 7.
    assert!(half.texels[3..29].iter().all(|&texel| texel == [255; 4]));
    assert!(half.texels[0][3] < 255 && half.texels[31] == half.texels[0]);
}

#[test]
fn point_takes_the_texel_under_the_centre() {
    let top = PlaneImage::top(5, 1, (0..5).map(|x| [10 * x; 4]).collect());
    for (from, last) in [(From::Top, 20), (From::Above, 30)] {
        let build = Build { kernel: Kernel::Point, from, ..Build::default() };
        let planes = build.pyramid(PyramidKind::Mipmap, &top).unwrap().planes;
        let grey = |level: usize| planes[level].texels.iter().map(|texel| texel[0]).collect::<Vec<_>>();
        assert_eq!(grey(1), [10, 30], "centres at 1.25 and 3.75");
        assert_eq!(grey(2), [last], "centre at 2.5 of five, or at 1.0 of two");
    }
}

#[test]
fn half_kernels_are_blows_fourteen_taps() {
    let mut widest = 0.0_f64;
    for (kernel, expected) in [(Kernel::Lanczos, LANCZOS_HALF), (Kernel::Kaiser, KAISER_HALF)] {
        let taps = Response::of(kernel, Some(14)).unwrap().taps;
        assert_eq!(taps.len(), 14);
        for (distance, value) in expected.iter().enumerate() {
            for tap in [taps[6 - distance], taps[7 + distance]] {
                // Half a unit of 2^-14, half a unit of the fifth digit, and one unit that forces the sum.
                assert!((tap - value).abs() < 1.6 / 16384.0, "{kernel:?} at {distance}.5: {tap}, not {value}");
            }
        }
        assert_eq!(taps.iter().sum::<f64>(), 1.0);
    }
    let [lanczos, kaiser] = [Kernel::Lanczos, Kernel::Kaiser].map(|kernel| Response::of(kernel, None).unwrap().taps);
    for (a, b) in lanczos.iter().zip(&kaiser) {
        widest = widest.max((a - b).abs());
    }
    assert!((widest - 0.00235).abs() < 1e-4, "beta is 4, not 4 pi (0.0313): {widest}");
}

#[test]
fn the_default_tent_is_one_three_three_one() {
    assert_eq!(Response::of(Kernel::Tent, None).unwrap().taps, [0.125, 0.375, 0.375, 0.125]);
}

#[test]
fn bands_and_ringing_are_those_of_the_errata() {
    for (kernel, pass, stop) in
        [(Kernel::Box, 0.0177, 0.1817), (Kernel::Lanczos, 0.0224, 0.0217), (Kernel::Kaiser, 0.0217, 0.0214)]
    {
        let response = Response::of(kernel, None).unwrap();
        assert!((response.pass_loss() - pass).abs() < 1e-4, "{kernel:?} loses {}", response.pass_loss());
        assert!((response.stop_leak() - stop).abs() < 1e-4, "{kernel:?} leaks {}", response.stop_leak());
    }
    let (low, high) = Response::of(Kernel::Kaiser, None).unwrap().step_extremes(true);
    assert!((low + 2.9).abs() < 0.05 && (high - 257.9).abs() < 0.05, "{low} to {high}");
    let point = Response::of(Kernel::Point, None).unwrap();
    assert_eq!((point.pass_loss(), point.stop_leak()), (0.0, 1.0));
    assert_eq!(Response::of(Kernel::Box, None).unwrap().step_extremes(false), (0.0, 255.0));
}

#[test]
fn a_plane_shows_the_ringing_the_response_foretells() {
    // Half-tone levels keep the lobes inside 8 bits: 64 to 192 is a step of 128.
    for (first_bright, aligned) in [(64, true), (63, false)] {
        let top = PlaneImage::top(128, 1, (0..128).map(|x| [if x < first_bright { 64 } else { 192 }; 4]).collect());
        let build = Build { kernel: Kernel::Kaiser, edge: AddressMode::Clamp, ..Build::default() };
        let half = &build.planes(&top, &[(1, 0)], |_| ()).unwrap()[0];
        let (low, high) = Response::of(Kernel::Kaiser, None).unwrap().step_extremes(aligned);
        let foretold = [low, high].map(|value| (64.0 + value * 128.0 / 255.0).round() as u8);
        let greys = || half.texels.iter().map(|texel| texel[0]);
        assert_eq!([greys().min().unwrap(), greys().max().unwrap()], foretold);
    }
}

#[test]
fn widths_a_kernel_cannot_have_are_refused_with_what_would_do() {
    for (kernel, width) in
        [(Kernel::Kaiser, 13), (Kernel::Tent, 0), (Kernel::Lanczos, 66), (Kernel::Box, 2), (Kernel::Point, 2)]
    {
        let build = Build { kernel, width: Some(width), ..Build::default() };
        let message = build.pyramid(PyramidKind::Mipmap, &texture(4, 4, 1)).unwrap_err().to_string();
        assert!(message.starts_with(&format!("width = {width}:")) && message.contains("help: "), "{message}");
    }
}

#[test]
fn planes_do_not_depend_on_the_number_of_threads() {
    let top = texture(150, 90, 5);
    let build = Build { kernel: Kernel::Lanczos, ..Build::default() };
    let [one, five] = [1, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| build.pyramid(PyramidKind::Ripmap, &top).unwrap())
    });
    assert_eq!(one, five);
}

#[test]
fn expected_drifts_are_those_of_the_errata() {
    let drifts = Averaging::ALL.map(Averaging::expected_drift);
    assert_eq!(drifts, [-0.375, 0.125, 0.0, 0.5, 0.625, 0.0, 0.0]);
}

#[test]
fn six_truncated_levels_darken_noise_as_the_errata_say() {
    for (bits, per_cent, band) in [(8, -0.85, 0.1), (6, -3.5, 0.3), (5, -7.6, 0.5), (4, -13.8, 1.5)] {
        let channel = Channel::random(256, bits, 3);
        let drift = channel.drift(Averaging::Truncate, 6)[5] * 100.0 / f64::from((1u32 << bits) - 1);
        assert!((drift - per_cent).abs() < band, "{bits} bits: {drift} %");
    }
}

#[test]
fn one_step_a_level_brightens_more_than_truncation_darkens() {
    let flat = Channel::of_image(&PlaneImage::top(64, 64, vec![[100; 4]; 4096]), 8);
    assert_eq!(flat.drift(Averaging::Truncate, 6), [0.0; 6], "flat areas lose nothing");
    assert_eq!(flat.drift(Averaging::TruncatePlusOne, 6), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(flat.drift(Averaging::TruncatePlusExpected, 6), [0.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
}
