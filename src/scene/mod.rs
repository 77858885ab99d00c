//! Scenes: a textured rectangle or ellipsoid, freely turned and moved before a perspective camera, as in the Dipmap paper; the
//! fragments they make, and the ground truth of what they should look like.
//!
//! A scene is a TOML file ([`Scene::load`]) or one of those built in ([`Scene::builtin`]). Fragments come in floats: the front
//! end of the chip turns them into requests.

mod builtin;
mod camera;
mod ellipsoid;
mod file;
mod footprint;
mod gradient;
mod ground_truth;
mod natural;
mod noise;
mod order;
mod path;
mod pose;
mod raster;
mod rectangle;
mod texture;
mod whole;

use serde::Serialize;

pub use self::{
    camera::Camera,
    ellipsoid::{Ellipsoid, Quadric},
    footprint::{AxisRule, Norm},
    gradient::{Gradient, GradientMethod},
    ground_truth::{GroundTruth, MOST_SAMPLES, Supersampling, footprint_average},
    order::{PixelOrder, Span, Spans},
    path::Path,
    pose::{Pose, Rotation},
    raster::{Blocks, Coverage, Fragments},
    rectangle::{Matrix, MatrixStepping, Numerators, Plane, Rectangle},
    texture::{Pattern, Procedural, Texture, TextureSource},
};

/// A scene, with every default filled in: what a report shows to say what was run.
///
/// ```
/// use texunit::scene::Scene;
/// let scene = Scene::builtin("floor").unwrap();
/// let mut farthest: f64 = 0.0;
/// let coverage = scene.for_each_block(|fragments| {
///     farthest = fragments.iter().map(|fragment| fragment.gradient.vy.abs()).fold(farthest, f64::max);
/// });
/// assert_eq!(coverage.pixels, 640 * 480);
/// assert!(coverage.behind > 0); // the sky
/// assert!(farthest > 1.0); // more than a whole texture per pixel at the horizon
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Scene {
    /// What it is called on the command line.
    pub name: String,
    /// One line about it.
    pub description: String,
    /// Width and height of the image, pixels, 1 to 16384.
    pub size: [u32; 2],
    /// The order in which pixels are visited.
    pub order: PixelOrder,
    /// Edge of a tile, pixels, when visiting by tiles.
    pub tile: u32,
    /// How gradients are found.
    pub gradient: GradientMethod,
    /// The camera.
    pub camera: Camera,
    /// What is seen.
    pub shape: Shape,
    /// How it moves, if it does: all but `texunit frames` and `texunit reuse` see the first frame only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<Path>,
    /// What is on it.
    pub texture: Texture,
    /// How the ground truth is sampled.
    pub ground_truth: Supersampling,
}

/// What a scene shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// A rectangle, or the plane it lies in.
    Rectangle(Rectangle),
    /// An ellipsoid.
    Ellipsoid(Ellipsoid),
}

/// A pixel of the shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// Column, from the left.
    pub x: u16,
    /// Row, from the top.
    pub y: u16,
    /// Normalised texture coordinate at the pixel's centre, 1.0 is one repeat: to the right in the image.
    pub u: f64,
    /// The same, down in the image.
    pub v: f64,
    /// Its change per pixel step.
    pub gradient: Gradient,
}

/// A shape as its camera sees it: everything constant over the image is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// A rectangle or a plane.
    Plane(Plane),
    /// An ellipsoid.
    Quadric(Quadric),
}

impl Surface {
    /// Normalised texture coordinates under a point of the screen (pixel centres at +0.5), `None` where the shape is not.
    #[must_use]
    #[inline]
    pub fn uv_at(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        match self {
            Self::Plane(plane) => plane.uv_at(x, y),
            Self::Quadric(quadric) => quadric.uv_at(x, y),
        }
    }

    /// Appends the fragments of a run of pixels to `out` and counts what was left out.
    fn span(&self, span: Span, method: GradientMethod, out: &mut Vec<Fragment>, coverage: &mut Coverage) {
        match self {
            Self::Plane(plane) => plane.span(span, method, out, coverage),
            Self::Quadric(quadric) => quadric.span(span, method, out, coverage),
        }
    }
}

impl Scene {
    /// The shape as the camera sees it.
    #[must_use]
    pub fn surface(&self) -> Surface {
        match &self.shape {
            Shape::Rectangle(rectangle) => Surface::Plane(rectangle.project(self.camera, self.size)),
            Shape::Ellipsoid(ellipsoid) => Surface::Quadric(ellipsoid.project(self.camera, self.size)),
        }
    }

    /// The fragments in pixel order, block by block: a frame of any size in the memory of a block.
    pub fn for_each_block(&self, mut visit: impl FnMut(&[Fragment])) -> Coverage {
        let mut blocks = self.blocks();
        while let Some(block) = blocks.next_block() {
            visit(block);
        }
        blocks.coverage()
    }

    /// The same, to be pulled.
    #[must_use]
    pub fn blocks(&self) -> Blocks {
        Blocks::new(self)
    }

    /// The fragments in pixel order, one by one.
    pub fn fragments(&self) -> impl Iterator<Item = Fragment> + use<> {
        Fragments::new(self)
    }

    /// How many pixels have a fragment, and why others have none.
    #[must_use]
    pub fn coverage(&self) -> Coverage {
        self.for_each_block(|_| ())
    }

    /// Normalised texture coordinates under one point of the screen; for many points take [`Scene::surface`] first.
    #[must_use]
    pub fn uv_at(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        self.surface().uv_at(x, y)
    }
}
