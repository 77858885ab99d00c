//! A path through a scene: the shape moves from its own pose to another, frame by frame. Moving the camera is moving the shape.

use glam::{DQuat, DVec3};
use serde::Serialize;

use super::{Pose, Rotation, Scene, Shape};

/// Where a path ends, and in how many frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Path {
    /// Frames, the first and the last included, 2 to 10000.
    pub frames: u32,
    /// The pose of the shape in the last frame.
    pub end: Pose,
}

/// From one pose to another: straight, and turning evenly. Euler angles each go their own way, so that a full turn is one; other
/// rotations take the shortest way.
fn between(start: Pose, end: Pose, share: f64) -> Pose {
    let mix = |from: f64, to: f64| from + (to - from) * share;
    let mix3 = |from: [f64; 3], to: [f64; 3]| [0, 1, 2].map(|i| mix(from[i], to[i]));
    let rotation = match (start.rotation, end.rotation) {
        (Rotation::Euler(from), Rotation::Euler(to)) => Rotation::Euler(mix3(from, to)),
        (Rotation::About { axis, angle }, Rotation::About { axis: other, angle: to }) if axis == other => {
            Rotation::About { axis, angle: mix(angle, to) }
        }
        (from, to) => {
            let turn = DQuat::from_mat3(&from.matrix()).slerp(DQuat::from_mat3(&to.matrix()), share);
            let (axis, angle): (DVec3, f64) = turn.to_axis_angle();
            Rotation::About { axis: axis.to_array(), angle: angle.to_degrees() }
        }
    };
    Pose { rotation, translation: mix3(start.translation, end.translation) }
}

impl Scene {
    /// Number of frames; 1 without a path.
    #[must_use]
    pub fn frame_count(&self) -> u32 {
        self.path.map_or(1, |path| path.frames)
    }

    /// The scene as it stands in a frame, from 0, without a path.
    ///
    /// ```
    /// use texunit::scene::{Scene, Shape};
    /// let walk = Scene::builtin("walk").unwrap();
    /// let last = walk.frame(walk.frame_count() - 1);
    /// assert_eq!(last.path, None);
    /// assert_ne!(last.shape, walk.frame(0).shape);
    /// ```
    #[must_use]
    pub fn frame(&self, number: u32) -> Self {
        let mut scene = Self { path: None, ..self.clone() };
        if let Some(path) = self.path {
            let share = f64::from(number) / f64::from((path.frames - 1).max(1));
            let pose = match &mut scene.shape {
                Shape::Rectangle(rectangle) => &mut rectangle.pose,
                Shape::Ellipsoid(ellipsoid) => &mut ellipsoid.pose,
            };
            *pose = between(*pose, path.end, share);
        }
        scene
    }
}
