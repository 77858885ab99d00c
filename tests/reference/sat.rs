//! The summed-area table of docs/numerics.md, section 5.3, in the float reference.

use proptest::prelude::*;
use texunit::{pyramid::Pyramid, reference::sat::Sat};
use texunit_hw::{
    AddressMode::{self, Clamp, Clip, Mirror, Wrap},
    I12F20, PyramidKind, Request, Sampler,
};

use crate::{
    MODES,
    planes::{columns, noise, pyramid},
};

fn fixed(turns: f64) -> I12F20 {
    I12F20::from_num(turns)
}

fn answer(texture: &Pyramid, address: [AddressMode; 2], request: &Request) -> [u8; 4] {
    let response = Sat::new(texture, &Sampler { address, ..Sampler::default() }).unwrap().sample(request);
    assert_eq!(response.lod, [0; 2]);
    response.texel
}

#[test]
fn a_box_is_as_wide_as_the_footprint_and_moved_to_the_nearest_texel_borders() {
    let texture = columns(&[10, 20, 40, 80]);
    // Centre and width in texels; answers of wrap, clamp, clip and mirror.
    let rows = [
        (2.0, 2.0, [30; 4]),
        (1.9, 2.2, [30; 4]),
        (2.5, 2.0, [60; 4]), // 1.5 rounds to border 2
        (2.0, 0.0, [40; 4]), // one texel at least, the point tap
        (1.99, 1.4, [20; 4]),
        (2.0, 1.5, [30; 4]),          // 1.5 rounds to 2
        (2.0, 4.0, [38; 4]),          // 37.5, half up
        (0.0, 2.0, [45, 10, 5, 10]),  // texels -1 and 0
        (4.0, 4.0, [38, 70, 30, 60]), // 2 to 5: 40 + 80, and 10 + 20, 80 + 80, nothing, 80 + 40
        (0.5, 9.0, [34, 30, 17, 42]), // -4 to 4: 150 is in it, and 160, 120, nothing and 230
        (-5.5, 1.0, [40, 10, 0, 40]), // texel -6
    ];
    for (centre, width, expected) in rows {
        let request = Request {
            axes: [[fixed(width / 8.0), fixed(0.0)], [fixed(-width / 8.0), fixed(0.0)]],
            ..Request::at(fixed(centre / 4.0), fixed(0.5))
        };
        for (mode, expected) in MODES.into_iter().zip(expected) {
            let address = [mode, Wrap];
            assert_eq!(answer(&texture, address, &request), [expected; 4], "{mode:?}, {width} around {centre}");
        }
    }
}

#[test]
fn a_box_is_4096_texels_wide_at_most() {
    let texture =
        pyramid(PyramidKind::Mipmap, 8192, 1, |lu, _, x, _| [if lu == 0 { (x >= 6144) as u8 * 255 } else { 0 }; 4]);
    let everything = Request { axes: [[I12F20::MAX; 2], [I12F20::MIN; 2]], ..Request::at(fixed(0.5), fixed(0.5)) };
    assert_eq!(answer(&texture, [Clamp; 2], &everything), [0; 4]);
    let later = Request { u: fixed(0.625), ..everything };
    assert_eq!(answer(&texture, [Clamp; 2], &later), [64; 4]); // 1024 of 4096: 63.75
}

/// Section 5.3 as a chip would do it: a table of 32-bit words that wrap around, and signed terms of table positions.
fn from_the_table(texture: &Pyramid, address: [AddressMode; 2], request: &Request) -> ([u8; 4], usize) {
    let size = [i64::from(texture.width), i64::from(texture.height)];
    let width = texture.width as usize;
    let mut table = vec![[0_u32; 4]; texture.planes[0].texels.len()];
    for (place, texel) in texture.planes[0].texels.iter().enumerate() {
        let (x, y) = (place % width, place / width);
        for channel in 0..4 {
            let entry = |x: usize, y: usize, there: bool| if there { table[y * width + x][channel] } else { 0 };
            table[place][channel] = u32::from(texel[channel])
                .wrapping_add(entry(x.wrapping_sub(1), y, x > 0))
                .wrapping_add(entry(x, y.wrapping_sub(1), y > 0))
                .wrapping_sub(entry(x.wrapping_sub(1), y.wrapping_sub(1), x > 0 && y > 0));
        }
    }
    let mut area = 1;
    let terms = [0, 1].map(|axis| {
        let n = size[axis];
        let extent: i64 = request.axes.iter().map(|vector| i64::from(vector[axis].to_bits()).abs()).sum();
        let wide = ((extent * n + (1 << 19)) >> 20).clamp(1, 4096);
        let c = i64::from([request.u, request.v][axis].to_bits());
        let low = (2 * c * n - (wide << 20) + (1 << 20)) >> 21;
        area *= wide as u64;
        let ends = [(low + wide, 1), (low, -1)];
        let mut terms = std::collections::BTreeMap::new();
        for (x, sign) in ends {
            let (k, r) = (x.div_euclid(n), x.rem_euclid(n));
            let (k2, r2) = (x.div_euclid(2 * n), x.rem_euclid(2 * n));
            let list: &[(i64, i64)] = &match address[axis] {
                Wrap => [(r, 1), (n, k)],
                Mirror if r2 < n => [(r2, 1), (n, 2 * k2)],
                Mirror => [(2 * n - r2, -1), (n, 2 * k2 + 2)],
                Clamp if x < 0 => [(1, x), (0, 0)],
                Clamp if x > n => [(n, 1 + x - n), (n - 1, n - x)],
                Clamp => [(x, 1), (0, 0)],
                Clip => [(x.clamp(0, n), 1), (0, 0)],
            };
            for (position, multiplicity) in list {
                *terms.entry(*position).or_insert(0) += sign * multiplicity;
            }
        }
        terms.retain(|position, multiplicity| *position > 0 && *multiplicity != 0);
        assert!(terms.len() <= 3);
        terms
    });
    let mut sums = [0_u32; 4];
    for (q, rows) in &terms[1] {
        for (p, columns) in &terms[0] {
            let entry = table[(q - 1) as usize * width + (p - 1) as usize];
            for (sum, word) in sums.iter_mut().zip(entry) {
                *sum = sum.wrapping_add(word.wrapping_mul((rows * columns) as u32));
            }
        }
    }
    let answer = sums.map(|sum| ((2 * u64::from(sum) + area) / (2 * area)) as u8);
    (answer, terms[0].len() * terms[1].len())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn adding_up_texels_gives_what_the_table_gives(
        places in any::<[i32; 2]>(),
        near in any::<bool>(),
        axes in any::<[[i32; 2]; 2]>(),
        shift in 0..24_u32,
        modes in [proptest::sample::select(MODES.to_vec()), proptest::sample::select(MODES.to_vec())],
        size in (1..=40_u32, 1..=40_u32),
        seed in any::<u32>(),
    ) {
        let texture = noise(PyramidKind::Mipmap, size, seed);
        let [u, v] = places.map(|place| I12F20::from_bits(if near { place >> 10 } else { place }));
        let axes = axes.map(|axis| axis.map(|one| I12F20::from_bits(one >> shift)));
        let request = Request { axes, ..Request::at(u, v) };
        let (expected, reads) = from_the_table(&texture, modes, &request);
        prop_assert_eq!(answer(&texture, modes, &request), expected);
        prop_assert!(reads <= 9);

        // Within a texel of each edge of the real box, for boxes the limit leaves alone.
        let sampler = Sampler { address: modes, ..Sampler::default() };
        let turns = |c: I12F20| f64::from(c.to_bits()) / 1_048_576.0;
        let steps = axes.map(|axis| axis.map(turns));
        let ideal = Sat::new(&texture, &sampler).unwrap().ideal([turns(u), turns(v)], steps);
        let shift_error: f64 = [(0, size.0), (1, size.1)]
            .map(|(axis, n)| {
                let width = ((steps[0][axis].abs() + steps[1][axis].abs()) * f64::from(n)).clamp(1.0, 4096.0);
                2.0 / width.round()
            })
            .iter()
            .sum();
        for channel in 0..4 {
            let error = (f64::from(expected[channel]) - ideal[channel]).abs();
            prop_assert!(error <= 255.0 * shift_error + 0.5 + 1e-6, "{error} {ideal:?} {expected:?}");
        }
    }
}

#[test]
fn the_ideal_of_a_magnified_table_is_bilinear() {
    let texture = columns(&[0, 200]);
    let sat = Sat::new(&texture, &Sampler { address: [Clamp; 2], ..Sampler::default() }).unwrap();
    let [red, ..] = sat.ideal([0.25 + 0.5 / 4.0, 0.5], [[0.0; 2]; 2]);
    assert!((red - 50.0).abs() < 1e-9, "{red}");
    let [red, ..] = sat.ideal([f64::NAN, 0.5], [[f64::INFINITY, 0.0], [f64::NAN, 0.0]]);
    assert!((red - 100.0).abs() < 0.1, "{red}");
}
