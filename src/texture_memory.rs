//! A texture in the chip's memory: planes in a format, laid out as bytes (docs/numerics.md, section 10).

use std::{borrow::Cow, sync::Arc};

use serde::Serialize;
use texunit_hw::{
    Format, Layout, PyramidKind, Surface,
    cache::TexelCache,
    decompression::{Decompressed, StoredLines, decompress},
    memory::store_plane,
    sat::store_table,
    surface::planes_of,
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
    /// Channels that have to be filtered: 4, 3 where alpha is opaque everywhere, 1 where all texels are grey as well. Less than 4
    /// only where it was looked for ([`crate::needs::Plan::hold`]).
    pub channels: u8,
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
        let planes: Vec<&[u8]> = stored.planes.iter().map(|plane| plane.elements.as_slice()).collect();
        let mut memory = Self::lay_out(stored.kind, [stored.width, stored.height], storage, &planes)?;
        memory.surface.palette.clone_from(&stored.palette);
        if storage.decompress == Decompress::BeforeCache && stored.format != Format::Rgba8 {
            let (surface, bytes) =
                decompress(&memory.surface, &memory.bytes).map_err(|error| refused(storage, error.to_string()))?;
            memory = Self { surface, bytes, compressed: Some(memory.surface), ..memory };
        }
        Ok(memory)
    }

    /// Elements at their places; planes without any take no memory.
    pub(crate) fn lay_out(
        kind: PyramidKind,
        [width, height]: [u32; 2],
        storage: &Storage,
        planes: &[&[u8]],
    ) -> Result<Self> {
        let halvings = planes_of(kind, width, height);
        let held = |lu, lv| halvings.iter().zip(planes).any(|(plane, held)| *plane == (lu, lv) && !held.is_empty());
        let mut memory = Self::empty(kind, [width, height], storage, held)?;
        memory.surface.srgb = storage.srgb;
        for (number, elements) in planes.iter().enumerate().filter(|(_, elements)| !elements.is_empty()) {
            store_plane(&memory.surface, number, elements, &mut memory.bytes)
                .map_err(|error| refused(storage, error.to_string()))?;
        }
        Ok(memory)
    }

    /// RGBA8 texels laid out as they are.
    fn of_texels(pyramid: &Pyramid, storage: &Storage) -> Result<Self> {
        let planes: Vec<&[u8]> = pyramid.planes.iter().map(|plane| plane.texels.as_flattened()).collect();
        Self::lay_out(pyramid.kind, [pyramid.width, pyramid.height], storage, &planes)
    }

    /// The summed-area table of a pyramid's level 0, whose texels are as the filter sees them.
    fn sums(pyramid: &Pyramid, storage: &Storage) -> Result<Self> {
        let mut memory = Self::empty(PyramidKind::Sat, [pyramid.width, pyramid.height], storage, |_, _| true)?;
        store_table(&memory.surface, &pyramid.planes[0].texels, &mut memory.bytes);
        Ok(memory)
    }

    fn empty(kind: PyramidKind, size: [u32; 2], storage: &Storage, held: impl Fn(u8, u8) -> bool) -> Result<Self> {
        let wrong = |problem: String| refused(storage, problem);
        let surface = Surface::of_planes(kind, storage.layout, storage.format, size, held)
            .map_err(|error| wrong(error.to_string()))?;
        let mut bytes = Vec::new();
        usize::try_from(surface.bytes)
            .ok()
            .and_then(|size| bytes.try_reserve_exact(size).ok().map(|()| bytes.resize(size, 0)))
            .ok_or_else(|| wrong(format!("{} bytes of texture memory cannot be had", surface.bytes)))?;
        Ok(Self { surface, bytes, compressed: None, channels: 4 })
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
                let texture = Decompressed { held: (&self.surface, 0), stored: (stored, 0) };
                let line = cache.cache().geometry().line;
                cache.with_decompressor(Arc::new(StoredLines::new(line, [texture])))
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

    /// The planes of a texture of which `needed(lu, lv)` is true; the others have no texels. Only what is needed is computed.
    ///
    /// # Errors
    /// A kernel that cannot be built for this texture.
    pub fn needed_planes(
        &self,
        kind: PyramidKind,
        texture: &TextureImage,
        needed: impl Fn(u8, u8) -> bool,
    ) -> Result<Pyramid> {
        let own = texture.own.as_deref().filter(|_| kind == PyramidKind::Mipmap);
        let brought = |lu, lv| own.and_then(|own| Some((own, own.plane(lu, lv)?)));
        let mut pyramid =
            self.pyramid.needed_planes(kind, &texture.top, |lu, lv| needed(lu, lv) && brought(lu, lv).is_none())?;
        for plane in &mut pyramid.planes {
            if let Some((own, stored)) = brought(plane.lu, plane.lv).filter(|_| needed(plane.lu, plane.lv)) {
                *plane = own.decode_plane(stored);
            }
        }
        Ok(pyramid)
    }

    /// The memory of such planes as this machine keeps them.
    ///
    /// # Errors
    /// A layout the planes do not fit.
    pub fn hold_planes(&self, pyramid: &Pyramid, texture: &TextureImage) -> Result<TextureMemory> {
        let storage = self.storage();
        if storage.format == Format::Rgba8 && !storage.srgb {
            return TextureMemory::of_texels(pyramid, &storage);
        }
        TextureMemory::new(&self.encode(pyramid, texture), &storage)
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
            let memory = TextureMemory::of_texels(&pyramid, &storage)?;
            return Ok(Held { pyramid, memory });
        }
        Held::new(&self.encode(&pyramid, texture), &storage)
    }

    /// Planes in this machine's format; those that the file brought in it are taken as they are.
    fn encode(&self, pyramid: &Pyramid, texture: &TextureImage) -> Stored {
        let given = texture.own.as_deref().map(|own| {
            // Level 0 belongs to every pyramid, the others to the mipmap.
            let levels = if pyramid.kind == PyramidKind::Mipmap { own.planes.len() } else { 1 };
            if levels == own.planes.len() {
                Cow::Borrowed(own)
            } else {
                Cow::Owned(Stored { planes: own.planes[..levels].to_vec(), ..own.clone() })
            }
        });
        Stored::encode_beside(pyramid, self.format, given.as_deref())
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
