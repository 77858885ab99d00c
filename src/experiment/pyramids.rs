//! The pyramids that some filters need of one texture.

use rayon::prelude::*;
use texunit_hw::{Filter, PyramidKind};

use crate::{
    error::Result,
    machine::Machine,
    pyramid::Pyramid,
    texture_file::TextureImage,
    texture_memory::{Held, TextureMemory},
};

/// Pyramids of one texture, each made and laid out once.
#[derive(Debug, Default)]
pub struct Pyramids {
    made: Vec<(PyramidKind, Held)>,
}

impl Pyramids {
    /// Makes the pyramids that some filters need.
    ///
    /// # Errors
    /// A kernel or layout that cannot be built for this texture.
    pub fn for_filters(machine: &Machine, texture: &TextureImage, filters: &[Filter]) -> Result<Self> {
        let mut kinds: Vec<PyramidKind> = Vec::new();
        for kind in filters.iter().map(|filter| filter.pyramid()) {
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        let made = kinds.into_par_iter().map(|kind| Ok((kind, machine.texture.hold(kind, texture)?)));
        Ok(Self { made: made.collect::<Result<_>>()? })
    }

    /// The pyramid of a filter that was named when they were made.
    ///
    /// # Panics
    /// If it was not.
    #[must_use]
    pub fn of(&self, filter: Filter) -> (&Pyramid, &TextureMemory) {
        let kind = filter.pyramid();
        let (_, held) = self.made.iter().find(|(known, _)| *known == kind).expect("made for this filter");
        (&held.pyramid, &held.memory)
    }
}
