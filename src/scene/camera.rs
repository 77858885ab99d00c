//! The perspective camera: at the origin, looking along -z, y up. Screen x runs right and y down, pixel centres at +0.5.

use glam::{DMat3, DVec3, dvec3};
use serde::Serialize;

/// A pinhole camera. Moving it is moving the shape: poses are in its coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Camera {
    /// The vertical angle of view, degrees.
    pub field_of_view: f64,
}

impl Camera {
    /// Distance from the eye to the screen, in pixels.
    #[must_use]
    pub fn focal_length(self, size: [u32; 2]) -> f64 {
        f64::from(size[1]) / (2.0 * libm::tan(self.field_of_view.to_radians() / 2.0))
    }

    /// The 3x3 matrix from camera space to homogeneous screen coordinates: (x w, y w, w), w the depth along -z.
    #[must_use]
    pub fn projection(self, size: [u32; 2]) -> DMat3 {
        let focal_length = self.focal_length(size);
        let [centre_x, centre_y] = size.map(|pixels| f64::from(pixels) / 2.0);
        DMat3::from_cols(
            dvec3(focal_length, 0.0, 0.0),
            dvec3(0.0, -focal_length, 0.0),
            dvec3(-centre_x, -centre_y, -1.0),
        )
    }

    /// The ray through screen point (x, y) is `x * rays[0] + y * rays[1] + rays[2]`, at depth 1.
    #[must_use]
    pub fn rays(self, size: [u32; 2]) -> [DVec3; 3] {
        let focal_length = self.focal_length(size);
        let [centre_x, centre_y] = size.map(|pixels| f64::from(pixels) / 2.0);
        [
            dvec3(1.0 / focal_length, 0.0, 0.0),
            dvec3(0.0, -1.0 / focal_length, 0.0),
            dvec3(-centre_x / focal_length, centre_y / focal_length, -1.0),
        ]
    }
}
