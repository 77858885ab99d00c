//! A texture in the chip's memory: planes in a format, laid out as bytes (docs/numerics.md, section 10).

use std::borrow::Cow;

use serde::Serialize;
use texunit_hw::{
    Format, Layout, PyramidKind, Surface,
    cache::TexelCache,
    decompression::{decompress, fill_bytes},
    memory::store_plane,
    sat::store_table,
};

use crate::{
    error::{Error, Result},
    machine::Texture,
    names::{Named, layout_name},
    pyramid::Pyramid,
    texel_format::{Stored, srgb},
    texture_file::TextureImage,
};

/// On which side of the cache texels are decoded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Decompress {
    /// The cache holds elements as memory does; every read decodes.
    #[default]
    AfterCache,
    /// The cache holds RGBA8; every fill decodes what it fetched.
    BeforeCache,
}

/// How a texture lies in memory and reaches the filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Storage {
    /// How elements are arranged.
    #[serde(with = "crate::names::layout")]
    pub layout: Layout,
    /// What an element is.
    #[serde(with = "crate::names::by_name")]
    pub format: Format,
    /// Where it is decoded.
    pub decompress: Decompress,
    /// Whether colours are sRGB codes, made linear before they are filtered.
    pub srgb: bool,
}

/// What the unit is bound to.
#[derive(Clone, Debug)]
pub struct TextureMemory {
    /// Where everything lies, as the unit and its cache see it.
    pub surface: Surface,
    /// What lies there.
    pub bytes: Vec<u8>,
    /// Where everything lies in memory, where a decompressor stands between it and the cache.
    pub compressed: Option<Surface>,
}

/// A texture held in memory: what the chip reads, and what the reference is to read.
#[derive(Clone, Debug)]
pub struct Held {
    /// The texels as the filter sees them: decoded outside the chip, and linear if they were sRGB codes.
    pub pyramid: Pyramid,
    /// The chip's memory.
    pub memory: TextureMemory,
}

impl TextureMemory {
    /// Lays out planes.
    ///
    /// # Errors
    /// A layout the planes do not fit, or more memory than there is.
    pub fn new(stored: &Stored, storage: &Storage) -> Result<Self> {
        let planes = stored.planes.iter().map(|plane| plane.elements.as_slice());
        let mut memory = Self::lay_out(stored.kind, [stored.width, stored.height], storage, planes)?;
        memory.surface.palette.clone_from(&stored.palette);
        if storage.decompress == Decompress::BeforeCache && stored.format != Format::Rgba8 {
            let (surface, bytes) =
                decompress(&memory.surface, &memory.bytes).map_err(|error| refused(storage, error.to_string()))?;
            memory = Self { surface, bytes, compressed: Some(memory.surface) };
        }
        Ok(memory)
    }

    fn lay_out<'p>(
        kind: PyramidKind,
        [width, height]: [u32; 2],
        storage: &Storage,
        planes: impl Iterator<Item = &'p [u8]>,
    ) -> Result<Self> {
        let mut memory = Self::empty(kind, [width, height], storage)?;
        memory.surface.srgb = storage.srgb;
        for (number, elements) in planes.enumerate() {
            store_plane(&memory.surface, number, elements, &mut memory.bytes)
                .map_err(|error| refused(storage, error.to_string()))?;
        }
        Ok(memory)
    }

    /// The summed-area table of a pyramid's level 0, whose texels are as the filter sees them.
    fn sums(pyramid: &Pyramid, storage: &Storage) -> Result<Self> {
        let mut memory = Self::empty(PyramidKind::Sat, [pyramid.width, pyramid.height], storage)?;
        store_table(&memory.surface, &pyramid.planes[0].texels, &mut memory.bytes);
        Ok(memory)
    }

    fn empty(kind: PyramidKind, [width, height]: [u32; 2], storage: &Storage) -> Result<Self> {
        let wrong = |problem: String| refused(storage, problem);
        let surface = Surface::new(kind, storage.layout, storage.format, width, height)
            .map_err(|error| wrong(error.to_string()))?;
        let mut bytes = Vec::new();
        usize::try_from(surface.bytes)
            .ok()
            .and_then(|size| bytes.try_reserve_exact(size).ok().map(|()| bytes.resize(size, 0)))
            .ok_or_else(|| wrong(format!("{} bytes of texture memory cannot be had", surface.bytes)))?;
        Ok(Self { surface, bytes, compressed: None })
    }

    /// Whether a decompressor stands between memory and cache.
    #[must_use]
    pub const fn is_decompressed(&self) -> bool {
        self.compressed.is_some()
    }

    /// Bytes of memory the planes take, padding included.
    #[must_use]
    pub fn stored_bytes(&self) -> u64 {
        self.compressed.as_ref().unwrap_or(&self.surface).bytes
    }

    /// The cache in front of this memory: where a decompressor stands between, fills fetch what it reads.
    #[must_use]
    pub fn behind(&self, cache: TexelCache) -> TexelCache {
        match &self.compressed {
            Some(stored) => {
                let fills = fill_bytes(stored, &self.surface, cache.cache().geometry().line);
                cache.with_fill_bytes(fills)
            }
            None => cache,
        }
    }
}

fn refused(storage: &Storage, problem: String) -> Error {
    let value = format!("{} ({})", layout_name(storage.layout), storage.format.name());
    Error::setting("texture.layout", value, problem, "use tiled-4x4, which takes every texture")
}

impl Texture {
    /// Whether the cache holds other bytes than the memory.
    #[must_use]
    pub fn decompresses_before_cache(&self) -> bool {
        self.decompress == Decompress::BeforeCache && self.format != Format::Rgba8
    }

    /// What of this says how planes are stored.
    #[must_use]
    pub const fn storage(&self) -> Storage {
        Storage { layout: self.layout, format: self.format, decompress: self.decompress, srgb: self.srgb }
    }

    /// The planes of a texture. The mipmap takes the levels its file brought, other planes are made from level 0.
    ///
    /// # Errors
    /// A kernel that cannot be built for this texture.
    pub fn planes(&self, kind: PyramidKind, texture: &TextureImage) -> Result<Pyramid> {
        let mut pyramid = self.pyramid.pyramid(kind, &texture.top)?;
        if let (PyramidKind::Mipmap, Some(own)) = (kind, &texture.own) {
            for (plane, own_plane) in pyramid.planes.iter_mut().zip(&own.planes) {
                *plane = own.decode_plane(own_plane);
            }
        }
        Ok(pyramid)
    }

    /// A texture in memory as this machine keeps it. Planes that its file brought in the machine's format are taken as they are, all
    /// others are encoded.
    ///
    /// # Errors
    /// A kernel or layout that cannot be built for this texture.
    pub fn hold(&self, kind: PyramidKind, texture: &TextureImage) -> Result<Held> {
        let pyramid = self.planes(kind, texture)?;
        let storage = self.storage();
        if storage.format == Format::Rgba8 && !storage.srgb {
            if kind == PyramidKind::Sat {
                let memory = TextureMemory::sums(&pyramid, &storage)?;
                return Ok(Held { pyramid, memory });
            }
            let planes = pyramid.planes.iter().map(|plane| plane.texels.as_flattened());
            let memory = TextureMemory::lay_out(kind, [pyramid.width, pyramid.height], &storage, planes)?;
            return Ok(Held { pyramid, memory });
        }
        let given = texture.own.as_deref().map(|own| {
            // Level 0 belongs to every pyramid, the others to the mipmap.
            let levels = if kind == PyramidKind::Mipmap { own.planes.len() } else { 1 };
            if levels == own.planes.len() {
                Cow::Borrowed(own)
            } else {
                Cow::Owned(Stored { planes: own.planes[..levels].to_vec(), ..own.clone() })
            }
        });
        let stored = Stored::encode_beside(&pyramid, storage.format, given.as_deref());
        Held::new(&stored, &storage)
    }
}

impl Held {
    /// Stored planes in memory, and what they mean.
    ///
    /// # Errors
    /// A layout the planes do not fit.
    pub fn new(stored: &Stored, storage: &Storage) -> Result<Self> {
        let mut pyramid = stored.decode();
        if storage.srgb {
            pyramid.planes.iter_mut().for_each(srgb::make_linear);
        }
        let memory = match stored.kind {
            PyramidKind::Sat => TextureMemory::sums(&pyramid, storage)?,
            _ => TextureMemory::new(stored, storage)?,
        };
        Ok(Self { pyramid, memory })
    }
}
