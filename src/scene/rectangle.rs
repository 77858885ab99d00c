//! The textured rectangle, through Herf's 3x3 matrix from screen to texture (Herf 1999, parts 1 to 3).

use glam::{DMat3, DVec3, dvec3};
use serde::Serialize;

use super::{Camera, Coverage, Fragment, Gradient, GradientMethod, Pose, order::Span};

/// A rectangle facing the camera before it is turned; u runs along its width from the left, v down its height from the top.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Rectangle {
    /// Width and height, in units of the camera space.
    pub size: [f64; 2],
    /// Rotation and translation of its centre.
    #[serde(flatten)]
    pub pose: Pose,
    /// How often the texture repeats along the width and the height.
    pub repeats: [f64; 2],
    /// The whole plane, to the horizon, instead of the rectangle only.
    pub extends: bool,
    /// How u', v' and w' go from pixel to pixel.
    pub matrix_stepping: MatrixStepping,
}

/// How the three linear forms are evaluated along a scanline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MatrixStepping {
    /// Anew at every pixel, in f64.
    #[default]
    PerPixel,
    /// By one f32 addition per pixel from the left end of the row, as in Herf's part 3. It drifts, up to half an ulp a pixel
    /// and always the same way (X4). Analytic gradients are stepped with it; differences are not.
    ForwardF32,
}

impl Rectangle {
    /// The plane as a camera sees it.
    #[must_use]
    pub fn project(&self, camera: Camera, size: [u32; 2]) -> Plane {
        let turn = self.pose.rotation.matrix();
        let centre = DVec3::from_array(self.pose.translation);
        let along_u = turn * dvec3(self.size[0], 0.0, 0.0);
        let along_v = turn * dvec3(0.0, -self.size[1], 0.0);
        let corner = centre - (along_u + along_v) / 2.0;
        let to_screen = camera.projection(size) * DMat3::from_cols(along_u, along_v, corner);
        // Seen edge-on there is no inverse; all zeros puts every pixel at w' = 0, outside.
        let to_unit = Some(to_screen.inverse()).filter(|inverse| inverse.is_finite()).unwrap_or(DMat3::ZERO);
        let repeat = DMat3::from_diagonal(dvec3(self.repeats[0], self.repeats[1], 1.0));
        Plane {
            matrix: Matrix::from_columns(repeat * to_unit),
            extent: (!self.extends).then_some(self.repeats),
            stepping: self.matrix_stepping,
        }
    }
}

/// Herf's matrix, by his letters: `[u' v' w'] = [x y 1] . [a d g; b e h; c f i]`, then u = u'/w', v = v'/w'.
/// w' is the reciprocal of the depth: not positive at and behind the horizon.
///
/// ```
/// use texunit::scene::{Matrix, Numerators};
/// // The example of E1: at y = 4, j and k are the same for every x; l and m are linear in x.
/// let matrix = Matrix { a: 2.0, b: 1.0, c: 3.0, d: -1.0, e: 2.0, f: 5.0, g: 1.0, h: 2.0, i: 100.0 };
/// for (x, l, m) in [(0.0, 94.0, 190.0), (1.0, 91.0, 194.0), (2.0, 88.0, 198.0)] {
///     assert_eq!(matrix.numerators(x, 4.0), Numerators { j: 209.0, k: -121.0, l, m });
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the letters are the documentation, see the formula above")]
pub struct Matrix {
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub d: f64,
    pub e: f64,
    pub f: f64,
    pub g: f64,
    pub h: f64,
    pub i: f64,
}

/// The numerators of the derivatives: du/dx = j/w'^2, dv/dx = k/w'^2, du/dy = l/w'^2, dv/dy = m/w'^2.
/// j and k depend on y only, l and m on x only (E1: the memo's sentence has it the other way round, its code does not).
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the letters are Herf's, see the formulas above")]
pub struct Numerators {
    pub j: f64,
    pub k: f64,
    pub l: f64,
    pub m: f64,
}

impl Matrix {
    /// From glam's matrix for column vectors, whose columns are the rows of Herf's for row vectors.
    #[must_use]
    pub fn from_columns(matrix: DMat3) -> Self {
        let [[a, d, g], [b, e, h], [c, f, i]] = matrix.to_cols_array_2d();
        Self { a, b, c, d, e, f, g, h, i }
    }

    /// `[u', v', w']` at a screen point.
    #[must_use]
    #[inline]
    pub fn projective(&self, x: f64, y: f64) -> [f64; 3] {
        [self.a * x + (self.b * y + self.c), self.d * x + (self.e * y + self.f), self.g * x + (self.h * y + self.i)]
    }

    /// The numerators of the derivatives at a screen point.
    #[must_use]
    #[inline]
    pub fn numerators(&self, x: f64, y: f64) -> Numerators {
        let Self { a, b, c, d, e, f, g, h, i } = *self;
        // Six cofactors: the slope of l in x is minus that of j in y, that of m minus that of k.
        let (j_slope, k_slope) = (a * h - b * g, d * h - e * g);
        Numerators {
            j: j_slope * y + (a * i - c * g),
            k: k_slope * y + (d * i - f * g),
            l: (b * i - c * h) - j_slope * x,
            m: (e * i - f * h) - k_slope * x,
        }
    }
}

/// A rectangle, or the plane it lies in, on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// From screen to repeats of the texture.
    pub matrix: Matrix,
    /// u and v end here; `None`: at the horizon.
    pub extent: Option<[f64; 2]>,
    stepping: MatrixStepping,
}

/// Where a point of the screen falls on the plane.
enum Place {
    Outside,
    Behind,
    Inside,
}

impl Plane {
    /// Coverage of the half-open range [0, extent), without a division. A point behind the eye counts as behind where it
    /// would be inside if the sign of w' were ignored, as 1/w'^4 ignores it (X2).
    #[inline]
    fn place(&self, [u, v, w]: [f64; 3]) -> Place {
        let in_front = w >= f64::MIN_POSITIVE;
        let inside = match self.extent {
            None => true,
            Some([width, height]) if in_front => u >= 0.0 && v >= 0.0 && u < width * w && v < height * w,
            Some([width, height]) => w < 0.0 && u <= 0.0 && v <= 0.0 && u > width * w && v > height * w,
        };
        match (inside, in_front) {
            (false, _) => Place::Outside,
            (true, false) => Place::Behind,
            (true, true) => Place::Inside,
        }
    }

    /// (u, v) at a screen point, `None` outside the rectangle or behind the eye.
    #[must_use]
    #[inline]
    pub fn uv_at(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let [u, v, w] = self.matrix.projective(x, y);
        matches!(self.place([u, v, w]), Place::Inside).then(|| (u * w.recip(), v * w.recip()))
    }

    /// (u, v) of the plane beyond the rectangle too, where it is in front of the eye.
    fn extended(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let [u, v, w] = self.matrix.projective(x, y);
        (w >= f64::MIN_POSITIVE).then(|| (u * w.recip(), v * w.recip()))
    }

    /// Forward differences from pixel (x, y); `None` if one of the three points is behind the eye.
    fn difference(&self, (x, y): (u32, u32)) -> Option<Gradient> {
        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let (u, v) = self.extended(x, y)?;
        let (right_u, right_v) = self.extended(x + 1.0, y)?;
        let (below_u, below_v) = self.extended(x, y + 1.0)?;
        Some(Gradient { ux: right_u - u, uy: below_u - u, vx: right_v - v, vy: below_v - v })
    }

    pub(super) fn span(&self, span: Span, method: GradientMethod, out: &mut Vec<Fragment>, coverage: &mut Coverage) {
        match self.stepping {
            MatrixStepping::PerPixel => self.per_pixel(span, method, out, coverage),
            MatrixStepping::ForwardF32 => self.stepped(span, method, out, coverage),
        }
    }

    fn per_pixel(&self, span: Span, method: GradientMethod, out: &mut Vec<Fragment>, coverage: &mut Coverage) {
        let y = f64::from(span.y) + 0.5;
        for column in span.x..span.x + span.length {
            let x = f64::from(column) + 0.5;
            let point @ [u, v, w] = self.matrix.projective(x, y);
            match self.place(point) {
                Place::Outside => continue,
                Place::Behind => {
                    coverage.behind += 1;
                    continue;
                }
                Place::Inside => {}
            }
            let depth = w.recip();
            let analytic = || {
                let Numerators { j, k, l, m } = self.matrix.numerators(x, y);
                // One factor after the other: 1/w'^2 alone would overflow sooner (X1).
                let over_w2 = |numerator: f64| numerator * depth * depth;
                Gradient { ux: over_w2(j), vx: over_w2(k), uy: over_w2(l), vy: over_w2(m) }
            };
            let gradient = match method.anchor(column, span.y) {
                None => analytic(),
                Some(anchor) => self.difference(anchor).unwrap_or_else(|| {
                    coverage.gradient_fallbacks += 1;
                    analytic()
                }),
            };
            out.push(Fragment::new(column, span.y, (u * depth, v * depth), gradient));
        }
    }

    /// Part 3 of the memo in f32: u', v', w', l and m by one addition each, j and k once a row.
    #[allow(clippy::cast_possible_truncation, reason = "f32 is the point")]
    fn stepped(&self, span: Span, method: GradientMethod, out: &mut Vec<Fragment>, coverage: &mut Coverage) {
        let (left, y) = (0.5, f64::from(span.y) + 0.5);
        let matrix = &self.matrix;
        let start = matrix.numerators(left, y);
        let next = matrix.numerators(left + 1.0, y);
        let (j, k) = (start.j as f32, start.k as f32);
        let [u, v, w] = matrix.projective(left, y);
        let mut value = [u, v, w, start.l, start.m].map(|form| form as f32);
        let step = [matrix.a, matrix.d, matrix.g, next.l - start.l, next.m - start.m].map(|slope| slope as f32);
        for column in 0..span.x + span.length {
            if column > 0 {
                for (value, step) in value.iter_mut().zip(step) {
                    *value += step;
                }
            }
            if column < span.x {
                continue;
            }
            let [u, v, w, l, m] = value;
            match self.place([u, v, w].map(f64::from)) {
                Place::Inside if w >= f32::MIN_POSITIVE => {}
                Place::Outside => continue,
                Place::Behind | Place::Inside => {
                    coverage.behind += 1;
                    continue;
                }
            }
            let depth = w.recip();
            let gradient = match method.anchor(column, span.y).map(|anchor| self.difference(anchor)) {
                Some(Some(difference)) => difference,
                fallback => {
                    coverage.gradient_fallbacks += u64::from(fallback.is_some());
                    let over_w2 = |numerator: f32| f64::from(numerator * depth * depth);
                    Gradient { ux: over_w2(j), vx: over_w2(k), uy: over_w2(l), vy: over_w2(m) }
                }
            };
            out.push(Fragment::new(column, span.y, (f64::from(u * depth), f64::from(v * depth)), gradient));
        }
    }
}
