//! The images on the shapes: procedural ones as in the Dipmap paper, or the user's own file.

use std::{path::PathBuf, sync::Arc};

use image::{Rgba, RgbaImage};
use serde::Serialize;
use texunit_hw::AddressMode;

use super::{natural, noise::unit_hash};
use crate::{
    error::Result,
    names::by_name_per_axis,
    needs::ImageNeeds,
    pyramid::PlaneImage,
    texel_format::Stored,
    texture_file::{self, TextureImage},
};

/// The texture of a scene, and what happens beyond its edges.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Texture {
    /// Where the texels come from.
    #[serde(flatten)]
    pub source: TextureSource,
    /// Address mode along u and along v.
    #[serde(with = "by_name_per_axis")]
    pub wrap: [AddressMode; 2],
}

/// Where the texels come from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TextureSource {
    /// Computed, the same on every machine.
    Procedural(Procedural),
    /// Read from a file.
    File {
        /// The file, as found.
        path: PathBuf,
        /// Its texels.
        #[serde(skip)]
        image: Arc<RgbaImage>,
        /// The levels the file brought, if it is of a kind that does.
        #[serde(skip)]
        own: Option<Arc<Stored>>,
    },
}

/// What a procedural texture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Black and white squares.
    Checkerboard,
    /// Window panes: thin bright bars on darker glass.
    Pane,
    /// A face in fur, in the manner of the baboon: detail at every scale, hairs in every direction.
    Natural,
}

/// A procedural texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Procedural {
    /// What it shows.
    pub pattern: Pattern,
    /// Width and height, texels.
    pub size: [u32; 2],
    /// Texels of a square, of a pane with its bar, or of the largest feature of a natural texture.
    pub cell: u32,
    /// Texels of a bar of a pane.
    pub line: u32,
    /// Chooses among natural textures, and the shades of panes.
    pub seed: u32,
}

impl Texture {
    /// The texels: computed now, or those read when the scene was loaded.
    #[must_use]
    pub fn image(&self) -> Arc<RgbaImage> {
        match &self.source {
            TextureSource::Procedural(procedural) => procedural.image(),
            TextureSource::File { image, .. } => Arc::clone(image),
        }
    }

    /// The texels as a texture to be stored, with the levels its file brought.
    #[must_use]
    pub fn texture_image(&self) -> TextureImage {
        let own = match &self.source {
            TextureSource::Procedural(_) => None,
            TextureSource::File { own, .. } => own.clone(),
        };
        TextureImage { top: PlaneImage::of_image(&self.image()), own }
    }

    /// Which channels of it say something: known of a pattern, looked for in a file.
    #[must_use]
    pub fn image_needs(&self) -> ImageNeeds {
        match &self.source {
            TextureSource::Procedural(Procedural { pattern, .. }) => {
                ImageNeeds { opaque: true, grey: *pattern == Pattern::Checkerboard }
            }
            TextureSource::File { .. } => ImageNeeds::of([&self.texture_image().top]),
        }
    }

    /// Width and height, texels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        match &self.source {
            TextureSource::Procedural(procedural) => procedural.size,
            TextureSource::File { image, .. } => image.dimensions().into(),
        }
    }
}

impl Procedural {
    /// The texels.
    #[must_use]
    pub fn image(&self) -> Arc<RgbaImage> {
        let [width, height] = self.size;
        match self.pattern {
            Pattern::Checkerboard | Pattern::Pane => {
                Arc::new(RgbaImage::from_fn(width, height, |x, y| Rgba(self.texel(x, y))))
            }
            Pattern::Natural => natural::image(self),
        }
    }

    /// One texel of a pattern that is computed texel by texel: all but [`Pattern::Natural`], which is black here.
    #[must_use]
    pub fn texel(&self, x: u32, y: u32) -> [u8; 4] {
        match self.pattern {
            Pattern::Checkerboard if (x / self.cell + y / self.cell).is_multiple_of(2) => [255; 4],
            Pattern::Pane => self.pane(x, y).0,
            Pattern::Checkerboard | Pattern::Natural => [0, 0, 0, 255],
        }
    }

    /// Bars along the top and left of every cell; glass of one dark blue per pane, lighter along one diagonal streak.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "colours stay within 0 to 255")]
    fn pane(&self, x: u32, y: u32) -> Rgba<u8> {
        let (inside_x, inside_y) = (x % self.cell, y % self.cell);
        if inside_x < self.line || inside_y < self.line {
            return Rgba([250, 246, 232, 255]);
        }
        let shade = unit_hash(x / self.cell, y / self.cell, self.seed);
        let across = f64::from(inside_x + inside_y) / f64::from(2 * self.cell);
        let streak = if (0.34..0.42).contains(&across) || (0.46..0.49).contains(&across) { 1.35 } else { 1.0 };
        let light = (0.75 + 0.5 * shade) * (1.1 - 0.35 * across) * streak;
        let [red, green, blue] = [38.0, 66.0, 98.0].map(|channel: f64| (channel * light).min(255.0) as u8);
        Rgba([red, green, blue, 255])
    }
}

impl TextureSource {
    /// A texture from any file [`texture_file::load`] reads.
    ///
    /// # Errors
    /// Its errors.
    pub fn read(path: PathBuf) -> Result<Self> {
        let texture = texture_file::load(&path)?;
        let [width, height] = [texture.top.width, texture.top.height];
        let image = RgbaImage::from_raw(width, height, texture.top.texels.into_flattened());
        Ok(Self::File { path, image: Arc::new(image.expect("width x height texels")), own: texture.own })
    }
}
