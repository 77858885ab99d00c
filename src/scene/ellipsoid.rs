//! The textured ellipsoid, intersected exactly at every pixel, with exact derivatives.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use serde::Serialize;

use super::{Camera, Coverage, Fragment, Gradient, GradientMethod, Pose, order::Span};

/// An ellipsoid with its poles on its own y axis. u is the longitude, from the back (-z) around the left; v the latitude, from
/// the north pole down.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Ellipsoid {
    /// Half axes along its own x, y, z.
    pub radii: [f64; 3],
    /// Rotation and translation of its centre.
    #[serde(flatten)]
    pub pose: Pose,
    /// How often the texture repeats around the equator and from pole to pole.
    pub repeats: [f64; 2],
}

impl Ellipsoid {
    /// The ellipsoid as a camera sees it.
    #[must_use]
    pub fn project(&self, camera: Camera, size: [u32; 2]) -> Quadric {
        let to_sphere =
            DMat3::from_diagonal(DVec3::from_array(self.radii).recip()) * self.pose.rotation.matrix().transpose();
        Quadric {
            eye: to_sphere * -DVec3::from_array(self.pose.translation),
            rays: camera.rays(size).map(|ray| to_sphere * ray),
            repeats: self.repeats,
        }
    }
}

/// Eye and rays in the space where the ellipsoid is the unit sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadric {
    eye: DVec3,
    /// The ray through screen point (x, y) is `x * rays[0] + y * rays[1] + rays[2]`.
    rays: [DVec3; 3],
    repeats: [f64; 2],
}

/// A ray meets the sphere.
struct Hit {
    /// The point, of length 1: the normal too.
    point: DVec3,
    ray: DVec3,
    /// Ray parameter: the depth.
    depth: f64,
    /// `point . ray`, from the square root itself: it vanishes at the silhouette and must not vanish earlier.
    facing: f64,
}

impl Quadric {
    #[inline]
    fn hit(&self, x: f64, y: f64) -> Option<Hit> {
        let ray = self.rays[0] * x + self.rays[1] * y + self.rays[2];
        let (a, b, c) = (ray.dot(ray), self.eye.dot(ray), self.eye.dot(self.eye) - 1.0);
        let discriminant = b * b - a * c;
        // A tangent ray is a miss: its derivatives are infinite. So is an ellipsoid behind the eye.
        if discriminant.is_nan() || discriminant <= 0.0 || (c >= 0.0 && b >= 0.0) {
            return None;
        }
        let root = discriminant.sqrt();
        // From outside, the near root, in the form without cancellation; from inside, the only positive one.
        let (depth, facing) = if c >= 0.0 { (c / (root - b), -root) } else { ((root - b) / a, root) };
        Some(Hit { point: self.eye + ray * depth, ray, depth, facing })
    }

    fn coordinates(&self, point: DVec3) -> (f64, f64) {
        let longitude = libm::atan2(point.x, point.z);
        let latitude = libm::atan2(point.y, (point.x * point.x + point.z * point.z).sqrt());
        ((longitude / (2.0 * PI) + 0.5) * self.repeats[0], (0.5 - latitude / PI) * self.repeats[1])
    }

    /// (u, v) at a screen point, `None` beside the ellipsoid.
    #[must_use]
    #[inline]
    pub fn uv_at(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        self.hit(x, y).map(|hit| self.coordinates(hit.point))
    }

    /// The derivatives at a hit: the surface stays at length 1, so the depth gives way.
    fn derivative(&self, hit: &Hit) -> Gradient {
        let step = |across: DVec3| {
            let deeper = -hit.depth * hit.point.dot(across) / hit.facing;
            let motion = across * hit.depth + hit.ray * deeper;
            // Squared distance from the axis, 0 at a pole, where the longitude has no derivative: huge, not NaN.
            let from_axis = (hit.point.x * hit.point.x + hit.point.z * hit.point.z).max(1e-200);
            let longitude = (hit.point.z * motion.x - hit.point.x * motion.z) / from_axis;
            let latitude = motion.y / from_axis.sqrt();
            (longitude / (2.0 * PI) * self.repeats[0], -latitude / PI * self.repeats[1])
        };
        let ((ux, vx), (uy, vy)) = (step(self.rays[0]), step(self.rays[1]));
        Gradient { ux, uy, vx, vy }
    }

    /// Forward differences from pixel (x, y), across the seam of the longitude the short way; `None` if one of the three
    /// points misses: an ellipsoid has nothing to extend.
    fn difference(&self, (x, y): (u32, u32)) -> Option<Gradient> {
        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let (u, v) = self.uv_at(x, y)?;
        let (right_u, right_v) = self.uv_at(x + 1.0, y)?;
        let (below_u, below_v) = self.uv_at(x, y + 1.0)?;
        let around = self.repeats[0];
        let unwrapped = |difference: f64| difference - around * (difference / around).round();
        Some(Gradient { ux: unwrapped(right_u - u), uy: unwrapped(below_u - u), vx: right_v - v, vy: below_v - v })
    }

    pub(super) fn span(&self, span: Span, method: GradientMethod, out: &mut Vec<Fragment>, coverage: &mut Coverage) {
        let y = f64::from(span.y) + 0.5;
        for column in span.x..span.x + span.length {
            let Some(hit) = self.hit(f64::from(column) + 0.5, y) else { continue };
            let gradient = match method.anchor(column, span.y) {
                None => self.derivative(&hit),
                Some(anchor) => self.difference(anchor).unwrap_or_else(|| {
                    coverage.gradient_fallbacks += 1;
                    self.derivative(&hit)
                }),
            };
            out.push(Fragment::new(column, span.y, self.coordinates(hit.point), gradient));
        }
    }
}
