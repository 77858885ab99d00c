//! Flavell's edge compression (1998, equations 7 and 20; E27): the longer side of the pixel's parallelogram in the texture, with
//! everything that does not change along a row or a column taken out of the inner loop.
//!
//! `max(sqrt(ux^2 + vx^2), sqrt(uy^2 + vy^2))`: the numerators of ux and vx depend on y only, those of uy and vy on x only, and
//! all four share the denominator `w'^2`. So one root a row, one root a column, and two multiplications and a comparison a
//! pixel. His value is in repeats of the texture; here the texture's size is multiplied into the roots.

use std::ops::Range;

use crate::scene::{Matrix, Numerators};

/// The terms of a polygon's columns.
#[derive(Clone, Debug)]
pub struct EdgeCompression {
    matrix: Matrix,
    size: [f64; 2],
    first: u32,
    /// `yl`: a column's side of the parallelogram, times `w'^2`.
    columns: Vec<f64>,
}

/// The terms of a row.
#[derive(Clone, Copy, Debug)]
pub struct Scanline<'e> {
    edges: &'e EdgeCompression,
    /// `xl`: the row's side of the parallelogram, times `w'^2`.
    row: f64,
    y: f64,
}

impl EdgeCompression {
    /// For the columns a polygon covers; `matrix` goes from the screen to repeats of a texture of `size` texels.
    #[must_use]
    pub fn new(matrix: Matrix, columns: Range<u32>, size: [u32; 2]) -> Self {
        let size = size.map(f64::from);
        let first = columns.start;
        let columns = columns.map(|column| {
            let Numerators { l, m, .. } = matrix.numerators(f64::from(column) + 0.5, 0.5);
            libm::hypot(l * size[0], m * size[1])
        });
        Self { matrix, size, first, columns: columns.collect() }
    }

    /// For a row of pixels.
    #[must_use]
    pub fn scanline(&self, row: u32) -> Scanline<'_> {
        let y = f64::from(row) + 0.5;
        let Numerators { j, k, .. } = self.matrix.numerators(0.5, y);
        Scanline { edges: self, row: libm::hypot(j * self.size[0], k * self.size[1]), y }
    }
}

impl Scanline<'_> {
    /// Texels of level 0 per pixel at a column of the polygon. The inner loop: `1/w'` is there already, for u and v.
    ///
    /// # Panics
    /// Outside the polygon's columns.
    #[must_use]
    pub fn compression(&self, column: u32) -> f64 {
        let [_, _, w] = self.edges.matrix.projective(f64::from(column) + 0.5, self.y);
        let depth = w.recip();
        self.row.max(self.edges.columns[(column - self.edges.first) as usize]) * depth * depth
    }
}
