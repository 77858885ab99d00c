//! The LOD norms against the table of E3 and an independent largest singular value; the axis rules against E9 and E10.

use proptest::prelude::*;
use texunit::scene::{AxisRule, Gradient, Norm};

const R: f64 = std::f64::consts::FRAC_1_SQRT_2;

fn gradient(ux: f64, uy: f64, vx: f64, vy: f64) -> Gradient {
    Gradient { ux, uy, vx, vy }
}

fn level(squared: f32) -> f64 {
    f64::from(squared).log2() / 2.0
}

#[test]
fn the_norms_give_the_levels_of_the_table() {
    const NONE: f64 = f64::NEG_INFINITY;
    // Heckbert, Herf, max, area, sigma1, min.
    let table = [
        ("8x, rotated 45", gradient(8.0 * R, -8.0 * R, 8.0 * R, 8.0 * R), [3.0, 3.0, 2.5, 3.0, 3.0, 2.5]),
        ("8:1, texture rotated", gradient(8.0 * R, -R, 8.0 * R, R), [3.0, 2.51, 2.5, 1.5, 3.0, -0.5]),
        ("8:1, screen rotated", gradient(8.0 * R, -8.0 * R, R, R), [2.51, 3.0, 2.5, 1.5, 3.0, 2.5]),
        ("u-shear", gradient(8.0, 8.0, 0.0, 0.0), [3.0, 3.5, 3.0, NONE, 3.5, 3.0]),
        ("u and v together", gradient(8.0, 0.0, 8.0, 0.0), [3.5, 3.0, 3.0, NONE, 3.5, NONE]),
        ("all entries 8", gradient(8.0, 8.0, 8.0, 8.0), [3.5, 3.5, 3.0, NONE, 4.0, 3.0]),
    ];
    for (case, gradient, expected) in table {
        for (norm, expected) in Norm::ALL.into_iter().zip(expected) {
            let found = level(norm.squared_ratio(gradient));
            assert!(found == expected || (found - expected).abs() < 0.006, "{case}: {norm:?} {found} for {expected}");
        }
    }
}

#[test]
fn axis_rules_drive_the_pyramids_of_the_errata() {
    let levels = |rule: AxisRule, gradient| rule.squared_ratios(gradient).map(level);
    let floor = gradient(1.0, 0.0, 0.0, 8.0);
    // E9: [column, row].
    assert_eq!(levels(AxisRule::TextureAxes, floor), [0.0, 3.0]);
    assert_eq!(levels(AxisRule::Paper2a, floor), [0.0, 3.0]);
    assert_eq!(levels(AxisRule::PaperStep3, floor), [3.0, 0.0]);
    // E10: u along screen y.
    let turned = gradient(0.0, 8.0, 1.0, 0.0);
    assert_eq!(levels(AxisRule::TextureAxes, turned), [3.0, 0.0]);
    assert_eq!(levels(AxisRule::Paper2a, turned), [0.0, 3.0]);
}

#[test]
fn a_texture_that_is_not_square_scales_each_axis_by_its_own_size() {
    let texels = gradient(0.5, 0.25, 0.125, 1.0).in_texels([256, 16]);
    assert_eq!(texels, gradient(128.0, 64.0, 2.0, 16.0));
}

proptest! {
    /// sigma1 by its definition: the longest image of a unit vector, searched. The other norms but the area are within their
    /// bounds below it.
    #[test]
    fn sigma1_is_the_longest_axis_and_the_norms_fall_short_as_bounded(entries in prop::array::uniform4(-100.0..100.0_f64)) {
        let [ux, uy, vx, vy] = entries;
        let longest = (0..3600)
            .map(|step| f64::from(step) * std::f64::consts::PI / 3600.0)
            .map(|angle| (ux * angle.cos() + uy * angle.sin()).hypot(vx * angle.cos() + vy * angle.sin()))
            .fold(0.0, f64::max);
        let of = |norm: Norm| f64::from(norm.squared_ratio(gradient(ux, uy, vx, vy)));
        let sigma1 = of(Norm::Sigma1).sqrt();
        prop_assert!((sigma1 - longest).abs() <= 1e-5 * longest, "{} for {}", sigma1, longest);
        for (norm, least) in [(Norm::Heckbert, -0.5), (Norm::Herf, -0.5), (Norm::Max, -1.0)] {
            let short = of(norm).log2() / 2.0 - sigma1.log2();
            prop_assert!((least - 1e-6..=1e-6).contains(&short), "{:?} {}", norm, short);
        }
        prop_assert!(of(Norm::Area) <= of(Norm::Sigma1) * (1.0 + 1e-6));
    }

    #[test]
    fn no_ratio_is_nan_unless_the_gradient_is(bits in prop::array::uniform4(any::<u64>()), pick in 0_usize..4) {
        let entries = bits.map(f64::from_bits);
        for entries in [entries, std::array::from_fn(|index| if index == pick { f64::INFINITY } else { entries[index] })] {
            let [ux, uy, vx, vy] = entries;
            let gradient = gradient(ux, uy, vx, vy);
            let ratios = Norm::ALL.map(|norm| norm.squared_ratio(gradient));
            if gradient.is_nan() {
                prop_assert!(ratios[0].is_nan() && ratios[1].is_nan() && ratios[2].is_nan());
            } else {
                prop_assert!(ratios.into_iter().all(|ratio| ratio >= 0.0), "{:?} of {:?}", ratios, gradient);
                let axes = AxisRule::TextureAxes.squared_ratios(gradient);
                prop_assert!(axes.into_iter().all(|ratio| ratio >= 0.0), "{:?} of {:?}", axes, gradient);
            }
        }
    }
}
