//! Where fragments are and how fast their coordinates change, against plain vector geometry and finite differences.

use proptest::prelude::*;
use texunit::scene::{
    Ellipsoid, Fragment, Gradient, GradientMethod, Matrix, MatrixStepping, Numerators, PixelOrder, Pose, Rectangle,
    Rotation, Scene, Shape,
};

fn with_shape(shape: Shape, size: [u32; 2]) -> Scene {
    Scene { shape, size, ..Scene::builtin("magnified").unwrap() }
}

fn rectangle(size: [f64; 2], euler: [f64; 3], translation: [f64; 3], extends: bool) -> Shape {
    let pose = Pose { rotation: Rotation::Euler(euler), translation };
    let matrix_stepping = MatrixStepping::PerPixel;
    Shape::Rectangle(Rectangle { size, pose, repeats: [2.0, 3.0], extends, matrix_stepping })
}

fn ellipsoid(radii: [f64; 3], euler: [f64; 3], translation: [f64; 3]) -> Shape {
    let pose = Pose { rotation: Rotation::Euler(euler), translation };
    Shape::Ellipsoid(Ellipsoid { radii, pose, repeats: [4.0, 2.0] })
}

/// Rotation about x, then about the turned y, then about the turned z, written out: rows of the matrix.
fn turn([x, y, z]: [f64; 3]) -> [[f64; 3]; 3] {
    let ((sx, cx), (sy, cy), (sz, cz)) = (x.to_radians().sin_cos(), y.to_radians().sin_cos(), z.to_radians().sin_cos());
    [
        [cy * cz, -cy * sz, sy],
        [cx * sz + sx * sy * cz, cx * cz - sx * sy * sz, -sx * cy],
        [sx * sz - cx * sy * cz, sx * cz + cx * sy * sz, cx * cy],
    ]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn column(matrix: [[f64; 3]; 3], index: usize) -> [f64; 3] {
    [matrix[0][index], matrix[1][index], matrix[2][index]]
}

/// The ray through a screen point, and the depth of a point is its parameter.
fn ray(scene: &Scene, x: f64, y: f64) -> [f64; 3] {
    let [width, height] = scene.size.map(f64::from);
    let tangent = (scene.camera.field_of_view.to_radians() / 2.0).tan();
    [(2.0 * x / width - 1.0) * tangent * width / height, (1.0 - 2.0 * y / height) * tangent, -1.0]
}

/// u, v and depth where the ray meets the rectangle's plane.
fn plane_hit(scene: &Scene, shape: &Rectangle, x: f64, y: f64) -> [f64; 3] {
    let Rotation::Euler(euler) = shape.pose.rotation else { panic!("the tests use Euler angles") };
    let (axes, ray) = (turn(euler), ray(scene, x, y));
    let [right, up, normal] = [0, 1, 2].map(|index| column(axes, index));
    let depth = dot(normal, shape.pose.translation) / dot(normal, ray);
    let offset: [f64; 3] = std::array::from_fn(|axis| ray[axis] * depth - shape.pose.translation[axis]);
    let s = dot(right, offset) / shape.size[0] + 0.5;
    let t = 0.5 - dot(up, offset) / shape.size[1];
    [s * shape.repeats[0], t * shape.repeats[1], depth]
}

#[test]
fn the_numerators_are_those_of_the_exact_example() {
    // E1, times 100 to be exact in binary.
    let matrix = Matrix { a: 2.0, b: 1.0, c: 3.0, d: -1.0, e: 2.0, f: 5.0, g: 1.0, h: 2.0, i: 100.0 };
    for (x, l, m) in [(0.0, 94.0, 190.0), (1.0, 91.0, 194.0), (2.0, 88.0, 198.0)] {
        assert_eq!(matrix.numerators(x, 4.0), Numerators { j: 209.0, k: -121.0, l, m });
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The numerators by their definition, w'a - u'g and so on, in exact integers.
    #[test]
    fn the_numerators_follow_their_definition(entries in prop::array::uniform9(-1000_i64..1000), x in 0_i64..4096, y in 0_i64..4096) {
        let [a, b, c, d, e, f, g, h, i] = entries;
        let (u, v, w) = (a * x + b * y + c, d * x + e * y + f, g * x + h * y + i);
        let [fa, fb, fc, fd, fe, ff, fg, fh, fi] = entries.map(|entry| entry as f64);
        let matrix = Matrix { a: fa, b: fb, c: fc, d: fd, e: fe, f: ff, g: fg, h: fh, i: fi };
        let Numerators { j, k, l, m } = matrix.numerators(x as f64, y as f64);
        prop_assert_eq!([j, k, l, m], [w * a - u * g, w * d - v * g, w * b - u * h, w * e - v * h].map(|exact| exact as f64));
        prop_assert_eq!(matrix.projective(x as f64, y as f64), [u, v, w].map(|exact| exact as f64));
    }

    #[test]
    fn the_rectangle_is_where_rays_meet_it_in_front_of_the_eye(
        euler in prop::array::uniform3(-180.0..180.0_f64), translation in (-1.0..1.0_f64, -1.0..1.0_f64, -6.0..1.0_f64),
        extends: bool,
    ) {
        let (x, y, z) = translation;
        let scene = with_shape(rectangle([4.0, 3.0], euler, [x, y, z], extends), [48, 36]);
        let Shape::Rectangle(shape) = scene.shape else { unreachable!() };
        let mut fragments = scene.fragments().peekable();
        let mut behind = 0;
        for (row, column) in (0..36_u16).flat_map(|row| (0..48_u16).map(move |column| (row, column))) {
            let [u, v, depth] = plane_hit(&scene, &shape, f64::from(column) + 0.5, f64::from(row) + 0.5);
            let near_edge = [u, u - 2.0, v, v - 3.0].into_iter().any(|distance| distance.abs() < 1e-9) || depth.abs() > 1e9;
            let inside = extends || ((0.0..2.0).contains(&u) && (0.0..3.0).contains(&v));
            let fragment = fragments.next_if(|fragment| (fragment.x, fragment.y) == (column, row));
            if !near_edge {
                prop_assert_eq!(fragment.is_some(), inside && depth > 0.0, "at {}, {}", column, row);
            }
            behind += u64::from(inside && depth <= 0.0);
            if let Some(fragment) = fragment {
                prop_assert!((fragment.u - u).abs() <= 1e-9 * (1.0 + u.abs() * depth), "{} for {}", fragment.u, u);
                prop_assert!((fragment.v - v).abs() <= 1e-9 * (1.0 + v.abs() * depth), "{} for {}", fragment.v, v);
            }
        }
        prop_assert!(fragments.next().is_none());
        prop_assert!(scene.coverage().behind.abs_diff(behind) <= 2);
    }

    #[test]
    fn analytic_gradients_of_a_plane_are_its_finite_differences(
        euler in prop::array::uniform3(-180.0..180.0_f64), z in -6.0..-2.0_f64,
    ) {
        let scene = with_shape(rectangle([4.0, 3.0], euler, [0.1, -0.2, z], true), [40, 30]);
        check_against_central_differences(&scene, [f64::INFINITY; 2])?;
    }

    #[test]
    fn analytic_gradients_of_an_ellipsoid_are_its_finite_differences(
        radii in prop::array::uniform3(0.4..1.5_f64), euler in prop::array::uniform3(-180.0..180.0_f64), x in -1.0..1.0_f64,
    ) {
        let scene = with_shape(ellipsoid(radii, euler, [x, 0.3, -4.0]), [40, 30]);
        check_against_central_differences(&scene, [4.0, f64::INFINITY])?;
    }

    /// From (u, v) to the point on the surface, and by the camera back to the pixel.
    #[test]
    fn the_ellipsoid_is_where_rays_meet_it(
        radii in prop::array::uniform3(0.4..1.5_f64), euler in prop::array::uniform3(-180.0..180.0_f64),
        place in (-1.0..1.0_f64, -1.0..1.0_f64, -5.0..-2.0_f64),
    ) {
        let centre = [place.0, place.1, place.2];
        let scene = with_shape(ellipsoid(radii, euler, centre), [40, 30]);
        let axes = turn(euler);
        let focal = 15.0 / (scene.camera.field_of_view.to_radians() / 2.0).tan();
        for fragment in scene.fragments() {
            let longitude = (fragment.u / 4.0 - 0.5) * std::f64::consts::TAU;
            let latitude = (0.5 - fragment.v / 2.0) * std::f64::consts::PI;
            let own = [
                radii[0] * latitude.cos() * longitude.sin(),
                radii[1] * latitude.sin(),
                radii[2] * latitude.cos() * longitude.cos(),
            ];
            let point: [f64; 3] = std::array::from_fn(|axis| dot(axes[axis], own) + centre[axis]);
            let screen = [20.0 + focal * point[0] / -point[2], 15.0 - focal * point[1] / -point[2]];
            prop_assert!((screen[0] - f64::from(fragment.x) - 0.5).abs() < 1e-6, "{:?} for {:?}", screen, fragment);
            prop_assert!((screen[1] - f64::from(fragment.y) - 0.5).abs() < 1e-6, "{:?} for {:?}", screen, fragment);
        }
    }
}

/// `around`: where u and v come back to their beginning.
fn check_against_central_differences(scene: &Scene, around: [f64; 2]) -> Result<(), TestCaseError> {
    const STEP: f64 = 1e-4;
    let surface = scene.surface();
    for fragment in scene.fragments() {
        let (x, y) = (f64::from(fragment.x) + 0.5, f64::from(fragment.y) + 0.5);
        // A pixel away from horizon, silhouette and pole: there the differences, not the derivatives, are wrong.
        let neighbours = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
        let inner = neighbours.into_iter().all(|(dx, dy)| surface.uv_at(x + dx, y + dy).is_some());
        let Gradient { ux, uy, vx, vy } = fragment.gradient;
        if !inner || ux.hypot(uy) > 0.3 && around[0].is_finite() {
            continue;
        }
        let difference = |dx: f64, dy: f64| {
            let (u1, v1) = surface.uv_at(x + dx, y + dy).unwrap();
            let (u0, v0) = surface.uv_at(x - dx, y - dy).unwrap();
            let jump = if around[0].is_finite() { around[0] * ((u1 - u0) / around[0]).round() } else { 0.0 };
            [(u1 - u0 - jump) / (2.0 * STEP), (v1 - v0) / (2.0 * STEP)]
        };
        let (across, down) = (difference(STEP, 0.0), difference(0.0, STEP));
        let scale = ux.hypot(uy).hypot(vx.hypot(vy)) + fragment.u.abs() * 1e-3 + fragment.v.abs() * 1e-3;
        for (analytic, numeric) in [(ux, across[0]), (vx, across[1]), (uy, down[0]), (vy, down[1])] {
            prop_assert!(
                (analytic - numeric).abs() < 1e-6 * scale + 1e-8,
                "{} for {} at {:?}",
                analytic,
                numeric,
                fragment
            );
        }
    }
    Ok(())
}

#[test]
fn the_sky_above_a_floor_is_behind_the_eye_and_counted() {
    let scene = Scene::builtin("floor").unwrap();
    let coverage = scene.coverage();
    // Tilted by 80 degrees, the horizon stands where rays rise by 10: rows above tan 10 focal lengths from the centre.
    let focal = 240.0 / 22.5_f64.to_radians().tan();
    let sky = (0..480).filter(|row| 240.0 - (f64::from(*row) + 0.5) > focal * 10_f64.to_radians().tan()).count() as u64;
    assert_eq!(coverage.behind, 640 * sky);
    assert_eq!(coverage.covered + coverage.behind, coverage.pixels);
    assert!(scene.fragments().all(|fragment| !fragment.gradient.is_nan() && fragment.u.is_finite()));
}

#[test]
fn a_forward_difference_on_a_floor_falls_short_by_d_over_d_plus_one() {
    let mut scene = with_shape(rectangle([4.0, 4.0], [-90.0, 0.0, 0.0], [0.0, -1.0, -4.0], true), [64, 48]);
    let analytic: Vec<Fragment> = scene.fragments().collect();
    scene.gradient = GradientMethod::Forward;
    for (forward, analytic) in scene.fragments().zip(analytic) {
        let below_horizon = f64::from(forward.y) + 0.5 - 24.0;
        let ratio = forward.gradient.vy / analytic.gradient.vy;
        assert!((ratio - below_horizon / (below_horizon + 1.0)).abs() < 1e-9, "{ratio} at {below_horizon}");
    }
}

#[test]
fn a_quad_shares_the_differences_of_its_top_left_pixel() {
    for name in ["rectangle-natural", "ellipsoid-pane", "floor"] {
        let mut scene = Scene::builtin(name).unwrap();
        scene.gradient = GradientMethod::Forward;
        let forward: std::collections::BTreeMap<_, _> =
            scene.fragments().map(|fragment| ((fragment.x, fragment.y), fragment.gradient)).collect();
        let fallbacks = scene.coverage().gradient_fallbacks;
        scene.gradient = GradientMethod::Quad;
        let shared = scene
            .fragments()
            .filter(|fragment| forward.get(&(fragment.x & !1, fragment.y & !1)) == Some(&fragment.gradient))
            .count() as u64;
        let coverage = scene.coverage();
        // Those at the outline whose top left pixel is no fragment, or that fell back, differ.
        assert!(shared + coverage.gradient_fallbacks + 2000 > coverage.covered, "{name}: {shared} of {coverage:?}");
        assert!(shared < coverage.covered || name != "ellipsoid-pane");
        assert_eq!(fallbacks > 0, name == "ellipsoid-pane", "{name}");
    }
}

#[test]
fn differences_cross_the_seam_of_an_ellipsoid_the_short_way() {
    let mut scene = with_shape(ellipsoid([1.0; 3], [0.0, 180.0, 0.0], [0.0, 0.0, -4.0]), [200, 150]);
    let analytic: Vec<Fragment> = scene.fragments().collect();
    let at_centre = |fragment: &Fragment| fragment.y == 75 && (90..110).contains(&fragment.x);
    let us = analytic.iter().filter(|fragment| at_centre(fragment)).map(|fragment| fragment.u);
    assert!(us.clone().fold(0.0, f64::max) > 3.9 && us.fold(4.0, f64::min) < 0.1, "the seam is in view");
    for method in [GradientMethod::Forward, GradientMethod::Quad] {
        scene.gradient = method;
        for (fragment, analytic) in scene.fragments().zip(&analytic).filter(|(fragment, _)| at_centre(fragment)) {
            let ratio = fragment.gradient.ux / analytic.gradient.ux;
            assert!((ratio - 1.0).abs() < 0.01, "{method:?}: {ratio} at {fragment:?}");
        }
    }
}

#[test]
fn a_rectangle_seen_edge_on_covers_nothing() {
    let scene = with_shape(rectangle([4.0, 3.0], [0.0; 3], [0.0, 0.0, 0.0], false), [40, 30]);
    assert_eq!(scene.coverage().covered, 0);
}

#[test]
fn the_eye_inside_an_ellipsoid_sees_it_everywhere() {
    let scene = with_shape(ellipsoid([2.0, 3.0, 2.5], [10.0, 20.0, 30.0], [0.1, 0.2, 0.3]), [40, 30]);
    let coverage = scene.coverage();
    assert_eq!(coverage.covered, coverage.pixels);
    check_against_central_differences(&scene, [4.0, f64::INFINITY]).unwrap();
}

/// X4: the sum of rounded steps leaves the line by up to half an ulp per pixel, always to the same side within a binade.
#[test]
fn forward_differencing_in_f32_drifts_systematically() {
    // Facing the camera and filling it: u runs from 0 to 2, w' stays. Errors in ulps of the last binade, that of 1.0.
    let shape = rectangle([10_200.0, 3.0], [0.0; 3], [0.0, 0.0, -3.0], true);
    let mut scene = with_shape(shape, [4096, 1]);
    let exact: Vec<Fragment> = scene.fragments().collect();
    let Shape::Rectangle(rectangle) = &mut scene.shape else { unreachable!() };
    rectangle.matrix_stepping = MatrixStepping::ForwardF32;
    let errors: Vec<f64> =
        scene.fragments().zip(&exact).map(|(stepped, exact)| (stepped.u - exact.u) / f64::from(f32::EPSILON)).collect();
    assert_eq!(errors.len(), 4096);
    let worst = errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()));
    assert!(worst > 100.0 && worst < 2048.0 + 4.0, "worst {worst} ulp");
    // From u = 1 on, every step is rounded by the same residue.
    let last_binade = &errors[2100..];
    let direction = last_binade[last_binade.len() - 1] - last_binade[0];
    assert!(last_binade.windows(100).all(|window| (window[99] - window[0]) * direction > 0.0), "one direction");

    // On a perspective span over a texture of 4096 texels: 1.65 texels, as in X4.
    let mut floor = with_shape(receding_wall(), [4096, 1]);
    let exact: Vec<Fragment> = floor.fragments().collect();
    let Shape::Rectangle(rectangle) = &mut floor.shape else { unreachable!() };
    rectangle.matrix_stepping = MatrixStepping::ForwardF32;
    let texels =
        floor.fragments().zip(&exact).map(|(stepped, exact)| (stepped.u - exact.u).abs() * 4096.0).fold(0.0, f64::max);
    assert!((1.6..1.7).contains(&texels), "{texels} texels");
}

/// A wall from depth 1 at the left edge of the image to depth 10 at the right: w' falls from 1 to 0.1, u rises from 0 to 1.
fn receding_wall() -> Shape {
    let edge = 4096.0 * 22.5_f64.to_radians().tan();
    let swing = 9.0_f64.atan2(11.0 * edge).to_degrees();
    let mut wall = rectangle([9.0_f64.hypot(11.0 * edge), 3.0], [0.0, swing, 0.0], [4.5 * edge, 0.0, -5.5], true);
    let Shape::Rectangle(rectangle) = &mut wall else { unreachable!() };
    rectangle.repeats = [1.0, 1.0];
    wall
}

#[test]
fn the_order_of_pixels_changes_no_fragment_in_either_stepping() {
    for stepping in [MatrixStepping::PerPixel, MatrixStepping::ForwardF32] {
        let mut scene = Scene::builtin("rectangle-natural").unwrap();
        scene.size = [150, 90];
        let Shape::Rectangle(rectangle) = &mut scene.shape else { unreachable!() };
        rectangle.matrix_stepping = stepping;
        let sorted = |scene: &Scene| {
            let mut fragments: Vec<Fragment> = scene.fragments().collect();
            fragments.sort_by_key(|fragment| (fragment.y, fragment.x));
            fragments
        };
        let scanline: Vec<Fragment> = scene.fragments().collect();
        for order in [PixelOrder::Tiles, PixelOrder::Morton] {
            scene.order = order;
            assert!(scene.fragments().ne(scanline.iter().copied()), "{order:?} is an order of its own");
            assert_eq!(sorted(&scene), scanline, "{order:?}");
        }
    }
}
