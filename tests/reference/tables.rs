//! Tables the reference makes with logarithms and exponentials: no entry hangs on the error of one.

use texunit::reference::{
    Grid,
    weights::{gaussian, gaussian_ratios, shares},
};

const LEVEL: f64 = 256.0;

#[test]
fn no_table_entry_hangs_on_the_error_of_a_logarithm() {
    // An ulp of a logarithm below 8, of an exponential and of a sum of 64 of them, times 256: far less than this.
    let error = 1e-9;
    let from_whole = |x: f64| (x - x.round()).abs();
    let mut nearest = [1.0_f64; 3];
    for n in 2..=64 {
        let n = f64::from(n);
        for threshold in [(2.0 * n + 1.0) / 4.0, n - 0.5] {
            nearest[0] = nearest[0].min(from_whole(LEVEL * libm::log2(threshold)));
        }
        for reach in [f64::midpoint(n, 1.0), n] {
            let exact = libm::log2(reach);
            if exact.fract() != 0.0 {
                nearest[1] = nearest[1].min(from_whole(LEVEL * exact + 0.5));
            }
        }
    }
    for count in 2..=64 {
        for weight in gaussian_ratios(count) {
            nearest[2] = nearest[2].min(from_whole(LEVEL * weight + 0.5));
        }
    }
    // As measured; a wrong table entry needs an error of this size.
    for (nearest, measured) in nearest.into_iter().zip(NEAREST) {
        assert!(nearest > error && (nearest / measured - 1.0).abs() < 0.01, "{nearest:e}, not {measured:e}");
    }
}

/// Thresholds from an integer; caps from a half; Feline's weights from a half. In 1/256.
const NEAREST: [f64; 3] = [1.6007e-3, 8.0037e-4, 2.4295e-4];

#[test]
fn the_weights_of_any_number_of_probes_are_symmetric_and_sum_to_one() {
    for count in 1..=64 {
        let weights = gaussian(count, Some(Grid::new(8)));
        assert_eq!(weights.iter().sum::<f64>(), 1.0);
        assert!(weights.iter().eq(weights.iter().rev()), "{count}: {weights:?}");
        assert!(weights.iter().all(|weight| *weight >= 0.0 && (weight * LEVEL).fract() == 0.0), "{count}");
        assert_eq!(shares(count, Some(Grid::new(8))).iter().sum::<f64>(), 1.0);
    }
}

#[test]
fn no_mantissa_is_near_a_boundary_of_the_logarithm() {
    let error = 7.3e-12; // what the comment of reference::lod allows libm::log2 and the addition of one half
    let distance = |mantissa: u32| {
        let position = 128.0 * libm::log2(1.0 + f64::from(mantissa) / 8_388_608.0) + 0.5;
        (position - position.round()).abs()
    };
    let nearest = (0..1 << 23).map(distance).fold(1.0, f64::min);
    // A measured distance is itself off by the error, hence twice; and the comment's number is held to be the measured one.
    assert!(nearest > 2.0 * error);
    assert!((nearest - NEAREST_MANTISSA).abs() < 1e-10, "{nearest:e}");
}

/// In 1/128 of an octave.
const NEAREST_MANTISSA: f64 = 4.27e-8;
