//! What the front end tells anisotropic filters about a footprint (docs/numerics.md, section 9), against real numbers.

use proptest::prelude::*;
use texunit::{
    front_end::FrontEnd,
    machine::Machine,
    reference::{footprint::Footprint, front_end::vector_to_fixed},
    scene::{Fragment, Gradient},
};
use texunit_hw::{AddressMode::Wrap, Filter, Request};

const ANISOTROPIC: [Filter; 3] = [Filter::Texram, Filter::Feline, Filter::Fast];

/// A gradient in texels of a 64 x 32 texture.
fn steps(x: [f64; 2], y: [f64; 2]) -> Gradient {
    Gradient { ux: x[0] / 64.0, vx: x[1] / 32.0, uy: y[0] / 64.0, vy: y[1] / 32.0 }
}

fn request(filter: Filter, gradient: Gradient) -> Request {
    let front_end = FrontEnd::new(&Machine::default(), filter, [Wrap; 2], [64, 32]);
    front_end.request(&Fragment { x: 3, y: 4, u: 0.0, v: 0.0, gradient }).0
}

#[test]
fn footprints_are_those_of_the_table() {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs().max(1.0);
    // A step of (3, 4) in x and (8, -6) in y: at right angles, 5 and 10 texels long.
    let gradient = steps([3.0, 4.0], [8.0, -6.0]);
    let [x, y] = [[3.0 / 64.0, 4.0 / 32.0], [8.0 / 64.0, -6.0 / 32.0]];
    let none = [0.0; 2];
    let rows = [
        (Filter::Texram, gradient, [100.0, 25.0], [y, none]),
        (Filter::Feline, gradient, [100.0, 25.0], [y, none]),
        (Filter::Fast, gradient, [100.0, 25.0], [y, x]),
        // Equal lengths: x is the longer one.
        (Filter::Texram, steps([2.0, 0.0], [0.0, 2.0]), [4.0, 4.0], [[2.0 / 64.0, 0.0], none]),
        // No area: no minor axis; sigma1 squared is 5 and 20 together.
        (Filter::Texram, steps([1.0, 2.0], [2.0, 4.0]), [20.0, 0.0], [[2.0 / 64.0, 4.0 / 32.0], none]),
        (
            Filter::Fast,
            steps([1.0, 2.0], [2.0, 4.0]),
            [25.0, 0.0],
            [[2.0 / 64.0, 4.0 / 32.0], [1.0 / 64.0, 2.0 / 32.0]],
        ),
        (Filter::Texram, Gradient::default(), [0.0, 0.0], [none; 2]),
        (Filter::Ripmap, gradient, [64.0, 36.0], [none; 2]),
        (Filter::Trilinear, gradient, [100.0, 25.0], [none; 2]),
    ];
    for (filter, gradient, squared, axes) in rows {
        let footprint = Footprint::new(filter, gradient, [64, 32], [3, 4]);
        for (value, expected) in footprint.squared.into_iter().zip(squared) {
            assert!(close(value, expected), "{filter:?} {footprint:?}");
        }
        for (value, expected) in footprint.axes.as_flattened().iter().zip(axes.as_flattened()) {
            assert!(close(*value, *expected), "{filter:?} {footprint:?}");
        }
        if filter.is_anisotropic() {
            let request = request(filter, gradient);
            assert_eq!(request.pixel, [3, 4]);
            assert_eq!(request.scale.map(f32::from_bits).map(f64::from), squared, "{filter:?}");
        }
    }
}

#[test]
fn vectors_are_rounded_to_nearest_and_saturate() {
    let unit = f64::exp2(-20.0);
    let below_a_half = f64::from_bits(0.5_f64.to_bits() - 1);
    let rows = [
        (1.0, 1 << 20),
        (0.5 * unit, 1),
        (below_a_half * unit, 0),
        (-0.5 * unit, 0),
        (-0.51 * unit, -1),
        (2048.0, i32::MAX),
        (-2048.0, i32::MIN),
        (f64::INFINITY, i32::MAX),
        (f64::NEG_INFINITY, i32::MIN),
        (f64::NAN, 0),
    ];
    for (x, expected) in rows {
        assert_eq!(vector_to_fixed(x), expected, "{x:e}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn the_front_end_rounds_what_the_real_numbers_say(
        x in [-1.0..1.0_f64, -1.0..1.0_f64],
        y in [-1.0..1.0_f64, -1.0..1.0_f64],
        octaves in -12.0..8.0_f64,
    ) {
        let length = octaves.exp2();
        let gradient = steps(x.map(|one| one * length), y.map(|one| one * length));
        for filter in ANISOTROPIC {
            let request = request(filter, gradient);
            let footprint = Footprint::new(filter, gradient, [64, 32], [3, 4]);
            let [major, minor] = footprint.squared;
            for (bits, expected) in request.scale.into_iter().zip(footprint.squared) {
                let relative = (f64::from(f32::from_bits(bits)) / expected - 1.0).abs();
                prop_assert!(relative < 3e-7, "{filter:?} {footprint:?} {request:?}");
            }
            // Which way the major axis of an ellipse points is nobody's business, nor where it lies in a circle.
            let feline = filter == Filter::Feline;
            if feline && minor > 0.98 * major {
                continue;
            }
            let misses = |sign: f64| {
                let pairs = request.axes.as_flattened().iter().zip(footprint.axes.as_flattened());
                pairs.map(|(found, real)| vector_to_fixed(sign * real).abs_diff(found.to_bits())).max().unwrap()
            };
            let missed = if feline { misses(1.0).min(misses(-1.0)) } else { misses(1.0) };
            prop_assert!(missed <= u32::from(feline), "{filter:?} {footprint:?} {request:?}");
        }
    }
}
