//! A small rasterizer: triangles in order, each in tiles of 8 x 8 pixels, each of 2 x 2 quads, with a depth buffer before the texture unit.
//!
//! Edges and coordinates are linear forms over the screen (Olano & Greer 1997; Herf's matrix again), so a triangle that passes
//! behind the eye needs no clipping: what is behind has w' <= 0.

use glam::{DMat3, DVec3};

use super::{
    Stream, StreamRequest,
    mesh::{Mesh, Triangle},
};
use crate::scene::{Camera, Fragment, Gradient, Matrix};

/// Edge of a tile, pixels.
const TILE: u32 = 8;

/// The requests of a mesh in view of a camera, in the order a GPU makes them: of a pixel drawn over, both.
#[must_use]
pub fn rasterize(mesh: Mesh, camera: Camera, size: [u32; 2]) -> Stream {
    let mut requests = Vec::new();
    // The nearest 1/depth so far.
    let mut nearest = vec![0.0_f64; size[0] as usize * size[1] as usize];
    for triangle in &mesh.triangles {
        if let Some(setup) = Setup::new(triangle, camera, size) {
            setup.visit(size, |x, y| {
                let Some((w, fragment)) = setup.fragment(x, y) else { return };
                let nearest = &mut nearest[y as usize * size[0] as usize + x as usize];
                if w > *nearest {
                    *nearest = w;
                    requests.push(StreamRequest { fragment, texture: triangle.texture, filter: None });
                }
            });
        }
    }
    Stream { textures: mesh.textures, requests, size: Some(size) }
}

/// What is constant over a triangle.
struct Setup {
    /// The barycentric coordinates over the depth.
    edges: Matrix,
    /// u', v' and w'.
    texture: Matrix,
    /// First and last pixel of each axis it may cover.
    bounds: [[u32; 2]; 2],
}

impl Setup {
    /// `None` where nothing can be seen of it.
    fn new(triangle: &Triangle, camera: Camera, size: [u32; 2]) -> Option<Self> {
        let screen = triangle.corners.map(|corner| camera.projection(size) * corner.position);
        if screen.iter().all(|corner| corner.z <= 0.0) {
            return None;
        }
        let edges = DMat3::from_cols(screen[0], screen[1], screen[2]).inverse();
        if !edges.is_finite() {
            return None;
        }
        let [a, b, c] = triangle.corners.map(|corner| DVec3::new(corner.uv.x, corner.uv.y, 1.0));
        let texture = DMat3::from_cols(a, b, c) * edges;
        let in_front = screen.iter().all(|corner| corner.z > 0.0);
        let bounds = [0, 1].map(|axis| {
            let last = size[axis] - 1;
            if !in_front {
                return [0, last];
            }
            let places = screen.map(|corner| corner[axis] / corner.z);
            let low = places.into_iter().fold(f64::INFINITY, f64::min).floor();
            let high = places.into_iter().fold(f64::NEG_INFINITY, f64::max).ceil();
            // Casts saturate: what lies left of the screen starts at its edge.
            [low as u32, (high as u32).min(last)]
        });
        let texture = Matrix::from_columns(texture);
        Some(Self { edges: Matrix::from_columns(edges), texture, bounds })
    }

    /// Every pixel of the bounds by tiles and quads.
    fn visit(&self, size: [u32; 2], mut pixel: impl FnMut(u32, u32)) {
        let [[left, right], [top, bottom]] = self.bounds;
        let tiles = |first: u32, last: u32| (first / TILE * TILE..=last).step_by(TILE as usize);
        for tile_y in tiles(top, bottom) {
            for tile_x in tiles(left, right) {
                for number in 0..TILE * TILE {
                    let (quad, within) = (number / 4, number % 4);
                    let x = tile_x + quad % (TILE / 2) * 2 + within % 2;
                    let y = tile_y + quad / (TILE / 2) * 2 + within / 2;
                    if x < size[0] && y < size[1] {
                        pixel(x, y);
                    }
                }
            }
        }
    }

    /// The fragment of a pixel whose centre is inside and before the eye, with its 1/depth.
    fn fragment(&self, x: u32, y: u32) -> Option<(f64, Fragment)> {
        let centre = [x, y].map(|place| f64::from(place) + 0.5);
        if self.edges.projective(centre[0], centre[1]).into_iter().any(|edge| edge < 0.0) {
            return None;
        }
        let [u, v, w] = self.texture.projective(centre[0], centre[1]);
        if w < f64::MIN_POSITIVE {
            return None;
        }
        let depth = w.recip();
        let numerators = self.texture.numerators(centre[0], centre[1]);
        let over_w2 = |numerator: f64| numerator * depth * depth;
        let gradient = Gradient {
            ux: over_w2(numerators.j),
            vx: over_w2(numerators.k),
            uy: over_w2(numerators.l),
            vy: over_w2(numerators.m),
        };
        Some((w, Fragment { x: x as u16, y: y as u16, u: u * depth, v: v * depth, gradient }))
    }
}
