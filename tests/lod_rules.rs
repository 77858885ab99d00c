//! The rules that choose a level against the numbers of E4, E15, E27 and those published of the log2 units.

use texunit::{
    front_end::FrontEnd,
    lod_rules::{edge::EdgeCompression, ladder, polygon::PolygonRule},
    machine::Machine,
    scene::{Fragment, Gradient, Norm, Scene, Surface},
};
use texunit_hw::{AddressMode, Filter, Log2};

/// Herf's own `lod`, that of a texture of 256: the other way round.
fn herf_lod(rule: PolygonRule, texels: f64, pixels: f64) -> u8 {
    8 - rule.level(texels, pixels, 8)
}

#[test]
fn the_draft_takes_an_area_for_a_length_and_the_correction_halves_its_logarithm() {
    // E4: pixels on a side, the memo's lod, the right one.
    for (side, printed, corrected) in [(64.0, 4, 6), (32.0, 2, 5), (100.0, 5, 6), (256.0, 8, 8), (1024.0, 8, 8)] {
        let lod = |rule| herf_lod(rule, 256.0 * 256.0, side * side);
        assert_eq!((lod(PolygonRule::HerfPrinted), lod(PolygonRule::Herf)), (printed, corrected), "{side} pixels");
    }
}

#[test]
fn pixels_of_one_shape_share_the_level_of_its_areas() {
    // 256 texels seen on 64 pixels, but compressed unevenly: 2 and 6 texels a pixel, 16 texels under the mean pixel.
    let fragments: Vec<Fragment> = (0..64)
        .map(|x| {
            let texels = if x % 2 == 0 { (2.0, 2.0) } else { (4.0, 7.0) };
            let gradient = Gradient { ux: texels.0 / 256.0, vy: texels.1 / 256.0, ..Gradient::default() };
            Fragment { x, y: 0, u: 0.5, v: 0.5, gradient }
        })
        .collect();
    for (per, level) in [("polygon-herf-printed", 4), ("polygon-herf", 2), ("polygon-flavell", 2)] {
        let machine = Machine::default().with_settings(&[format!("lod.per={per}")]).unwrap();
        for filter in [Filter::Trilinear, Filter::Dipmap] {
            let front_end = FrontEnd::new(&machine, filter, [AddressMode::Wrap; 2], [256; 2]);
            let (requests, _) = front_end.of_shape(&machine, |seen| seen.add(&fragments)).requests(&fragments);
            let expected = [4.0_f32.powi(level).to_bits(); 2];
            assert!(requests.iter().all(|request| request.scale == expected), "{per} {filter:?}");
        }
    }
}

#[test]
fn degenerate_triangles_have_a_level() {
    for rule in [PolygonRule::HerfPrinted, PolygonRule::Herf] {
        assert_eq!(rule.level(0.0, 0.0, 8), 0, "nothing of nothing is the finest, as the memo's NaN is");
        assert_eq!(rule.level(1000.0, 0.0, 8), 8, "what covers no pixel is the coarsest");
    }
    assert_eq!(PolygonRule::Flavell.level(1000.0, 0.0, 8), 8);
}

#[test]
fn flavells_level_is_the_whole_logarithm_to_base_four() {
    // E15: 16:1 tells floor(log4 r) from floor(r / 4); 3:1 tells it from the rounded logarithm.
    for (ratio, level) in [(1.0, 0), (3.0, 0), (4.0, 1), (7.0, 1), (15.9, 1), (16.0, 2), (63.0, 2), (64.0, 3)] {
        assert_eq!(PolygonRule::Flavell.level(ratio, 1.0, 8), level, "{ratio}:1");
    }
    assert_eq!(PolygonRule::HerfPrinted.level(7.0, 1.0, 8), 3, "E15: Herf without the half");
}

#[test]
fn edge_compression_from_rows_and_columns_is_the_norm_of_every_pixel() {
    for name in ["floor", "rectangle-natural", "rectangle-pane"] {
        let scene = Scene::builtin(name).unwrap();
        let Surface::Plane(plane) = scene.surface() else { panic!("{name} is a plane") };
        let size = scene.texture.size();
        let edges = EdgeCompression::new(plane.matrix, 0..scene.size[0], size);
        let mut pixels = 0;
        for fragment in scene.fragments() {
            let squared = Norm::Heckbert.squared_ratio(fragment.gradient.in_texels(size));
            let found = edges.scanline(fragment.y.into()).compression(fragment.x.into()).powi(2);
            let error = found / f64::from(squared) - 1.0;
            assert!(error.abs() < 1e-6, "{name} at {}, {}: {found} for {squared}", fragment.x, fragment.y);
            pixels += 1;
        }
        assert!(pixels > 10_000, "{name}");
    }
}

#[test]
fn the_log2_units_have_the_errors_that_were_published() {
    for rung in ladder::measure() {
        let (exhaustive, sweep) = (rung.exhaustive, rung.sweep);
        assert!((exhaustive.mean - sweep.mean).abs() < 1e-4, "{rung:?}");
        assert!(sweep.worst() <= exhaustive.worst() + 1e-12, "{rung:?}");
        let Some(published) = ladder::published(rung.log2) else { continue };
        // Tables were published to three digits of the ratio's logarithm, two of them with a result of 8 bits.
        let tolerance = if published.mean.is_some() { 0.0001 } else { 0.0015 };
        assert!((rung.unrounded.worst() - published.worst).abs() < tolerance, "{rung:?}");
        if let Some(mean) = published.mean {
            assert!((rung.unrounded.mean - mean).abs() < 0.0001, "{rung:?}");
            assert!(exhaustive.greatest <= 0.0, "{:?} never overestimates", rung.log2);
        }
        if let Some([worst, mean]) = published.eight_bits {
            assert!((exhaustive.worst() - worst).abs() < 0.0001, "{rung:?}");
            assert!((exhaustive.mean - mean).abs() < 0.0001, "{rung:?}");
        }
        if rung.log2 == Log2::Fourth {
            assert!((exhaustive.worst() - 0.0254).abs() < 0.0001, "{rung:?}");
        }
    }
}
