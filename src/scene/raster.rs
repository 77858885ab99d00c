//! From a scene to its fragments, in pixel order.

use serde::Serialize;

use super::{Fragment, Gradient, GradientMethod, Scene, Surface, order::Spans};

/// A block is handed on when it has at least this many fragments: small enough for the first-level cache of the host.
const BLOCK: usize = 256;

impl Fragment {
    #[inline]
    #[allow(clippy::cast_possible_truncation, reason = "a scene has at most 16384 pixels per axis")]
    pub(super) fn new(x: u32, y: u32, (u, v): (f64, f64), gradient: Gradient) -> Self {
        Self { x: x as u16, y: y as u16, u, v, gradient }
    }
}

/// What the pixels of a scene came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Coverage {
    /// Pixels of the image.
    pub pixels: u64,
    /// Pixels with a fragment.
    pub covered: u64,
    /// Pixels left out because the plane meets their ray behind the eye or at the horizon, w' <= 0 (X2). Those of an endless
    /// plane above its horizon, and those a rectangle that passes behind the eye would wrongly cover.
    pub behind: u64,
    /// Fragments whose difference has a neighbour off the surface, and that took the analytic gradient instead: next to the
    /// horizon of a plane, at the silhouette of an ellipsoid. 0 when the method is analytic.
    pub gradient_fallbacks: u64,
}

/// The blocks of a scene in pixel order: a lending iterator, so that a frame needs no more memory than a block.
#[derive(Clone, Debug)]
pub struct Blocks {
    surface: Surface,
    method: GradientMethod,
    spans: Spans,
    block: Vec<Fragment>,
    coverage: Coverage,
}

impl Blocks {
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            surface: scene.surface(),
            method: scene.gradient,
            spans: Spans::new(scene.order, scene.size, scene.tile),
            block: Vec::new(),
            coverage: Coverage::default(),
        }
    }

    /// The next fragments; `None` at the end. Blocks are never empty.
    pub fn next_block(&mut self) -> Option<&[Fragment]> {
        self.block.clear();
        while self.block.len() < BLOCK {
            let Some(span) = self.spans.next() else { break };
            self.coverage.pixels += u64::from(span.length);
            self.surface.span(span, self.method, &mut self.block, &mut self.coverage);
        }
        self.coverage.covered += self.block.len() as u64;
        (!self.block.is_empty()).then_some(&self.block)
    }

    /// What the pixels came to, up to the block last handed out.
    #[must_use]
    pub fn coverage(&self) -> Coverage {
        self.coverage
    }
}

/// The fragments of a scene, one by one. [`Scene::for_each_block`] is faster.
#[derive(Clone, Debug)]
pub struct Fragments {
    blocks: Blocks,
    next: usize,
}

impl Fragments {
    pub(super) fn new(scene: &Scene) -> Self {
        Self { blocks: Blocks::new(scene), next: 0 }
    }
}

impl Iterator for Fragments {
    type Item = Fragment;

    fn next(&mut self) -> Option<Fragment> {
        if self.next >= self.blocks.block.len() {
            self.next = 0;
            self.blocks.next_block()?;
        }
        self.next += 1;
        self.blocks.block.get(self.next - 1).copied()
    }
}
