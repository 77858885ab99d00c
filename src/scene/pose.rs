//! Where a shape is and how it is turned, in camera space.

use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// A rotation, in one of the two ways people write one. Degrees; right-handed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Rotation {
    /// About the shape's own x axis, then its own y axis as it is after that, then its own z axis: tilt, swing, turn in its
    /// own plane. Degrees.
    Euler([f64; 3]),
    /// About one axis.
    About {
        /// The axis, of any length but zero.
        axis: [f64; 3],
        /// Degrees.
        angle: f64,
    },
}

impl Default for Rotation {
    fn default() -> Self {
        Self::Euler([0.0; 3])
    }
}

impl Rotation {
    /// The matrix that turns the shape.
    #[must_use]
    pub fn matrix(self) -> DMat3 {
        match self {
            Self::Euler(degrees) => {
                let [x, y, z] = degrees.map(f64::to_radians);
                DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z)
            }
            Self::About { axis, angle } => {
                let axis = DVec3::from_array(axis).normalize_or(DVec3::Z);
                DMat3::from_quat(DQuat::from_axis_angle(axis, angle.to_radians()))
            }
        }
    }
}

/// Rotation, then translation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Pose {
    /// How the shape is turned about its own centre.
    pub rotation: Rotation,
    /// Where its centre is: x right, y up, -z away from the eye.
    pub translation: [f64; 3],
}
