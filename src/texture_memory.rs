//! A pyramid in the chip's memory: planes laid out as bytes.

use texunit_hw::{Format, Layout, PyramidKind, Surface, memory::store_plane, sat::store_table};

use crate::{
    error::{Error, Result},
    pyramid::Pyramid,
};

/// What the unit is bound to.
#[derive(Clone, Debug)]
pub struct TextureMemory {
    /// Where everything lies.
    pub surface: Surface,
    /// What lies there.
    pub bytes: Vec<u8>,
}

impl TextureMemory {
    /// Lays out a pyramid.
    ///
    /// # Errors
    /// A layout the pyramid does not fit, or more memory than there is.
    pub fn new(pyramid: &Pyramid, layout: Layout, format: Format) -> Result<Self> {
        let name = crate::names::layout_name(layout);
        let wrong = |problem: String| {
            Error::setting("texture.layout", &name, problem, "use tiled-4x4, which takes every texture")
        };
        let surface = Surface::new(pyramid.kind, layout, format, pyramid.width, pyramid.height)
            .map_err(|error| wrong(error.to_string()))?;
        let mut bytes = Vec::new();
        usize::try_from(surface.bytes)
            .ok()
            .and_then(|size| bytes.try_reserve_exact(size).ok().map(|()| bytes.resize(size, 0)))
            .ok_or_else(|| wrong(format!("{} bytes of texture memory cannot be had", surface.bytes)))?;
        if pyramid.kind == PyramidKind::Sat {
            store_table(&surface, &pyramid.planes[0].texels, &mut bytes);
            return Ok(Self { surface, bytes });
        }
        for (number, plane) in pyramid.planes.iter().enumerate() {
            store_plane(&surface, number, &plane.texels, &mut bytes).map_err(|error| wrong(error.to_string()))?;
        }
        Ok(Self { surface, bytes })
    }
}
