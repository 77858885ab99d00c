//! A scene with everything that does not depend on the filter.

use std::sync::Arc;

use image::RgbaImage;

use crate::{
    scene::{Coverage, Fragment, GroundTruth, Scene},
    texel_format::srgb,
    texture_file::TextureImage,
};

/// Requests compared at a time by one thread: few, and each slice a job of its own, for those of the rows at a horizon take the longest.
pub(super) const SLICE: usize = 1 << 10;

/// Fragments kept at a time: slices for many threads.
pub const BATCH: usize = SLICE << 6;

/// A scene with everything that does not depend on the filter. Its fragments are not kept: they would take far more memory than all images, and are
/// drawn anew faster than a filter answers them.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The scene.
    pub scene: Scene,
    /// How many pixels its fragments cover.
    pub coverage: Coverage,
    /// Which, by rows.
    pub covered: Vec<bool>,
    /// Its texture.
    pub texture: TextureImage,
    /// What an unlimited filter would show.
    pub truth: GroundTruth,
}

impl Stage {
    /// Rasterizes a scene and renders its ground truth.
    #[must_use]
    pub fn new(scene: Scene) -> Self {
        Self::in_light(scene, false)
    }

    /// The same; with `srgb` the ground truth is that of a texture of sRGB codes: linear light, as the filters answer then.
    #[must_use]
    pub fn in_light(scene: Scene, srgb: bool) -> Self {
        let mut image = scene.texture.image();
        let texture = scene.texture.texture_image();
        if srgb {
            for pixel in Arc::make_mut(&mut image).pixels_mut() {
                pixel.0 = srgb::linear_texel(pixel.0);
            }
        }
        let truth = GroundTruth::render(&scene, &image);
        let [width, height] = scene.size.map(|side| side as usize);
        let mut covered = vec![false; width * height];
        let coverage = scene.for_each_block(|block| {
            block.iter().for_each(|fragment| covered[usize::from(fragment.y) * width + usize::from(fragment.x)] = true);
        });
        Self { texture, scene, coverage, covered, truth }
    }

    /// Shows `visit` the fragments in pixel order, [`BATCH`] at a time.
    pub fn for_each_batch(&self, mut visit: impl FnMut(&[Fragment])) {
        let mut batch = Vec::with_capacity(BATCH);
        self.scene.for_each_block(|mut block| {
            while !block.is_empty() {
                let (now, after) = block.split_at(block.len().min(BATCH - batch.len()));
                batch.extend_from_slice(now);
                block = after;
                if batch.len() == BATCH {
                    visit(&batch);
                    batch.clear();
                }
            }
        });
        if !batch.is_empty() {
            visit(&batch);
        }
    }

    /// A picture without an answer: what no fragment covers stays transparent black, as in the paper.
    #[must_use]
    pub fn empty_picture(&self) -> RgbaImage {
        RgbaImage::new(self.scene.size[0], self.scene.size[1])
    }
}

/// Puts the answers of fragments where they belong in a picture.
pub fn paint(picture: &mut RgbaImage, fragments: &[Fragment], texels: impl Iterator<Item = [u8; 4]>) {
    for (fragment, texel) in fragments.iter().zip(texels) {
        picture.put_pixel(fragment.x.into(), fragment.y.into(), image::Rgba(texel));
    }
}
