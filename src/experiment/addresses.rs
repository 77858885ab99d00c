//! The address stream of a scene alone: what studies of caches need, without a texel being made.

use texunit_hw::{Filter, Format, LodSource, Sampler, Sink, Surface, Unit};

use crate::{
    error::{Error, Result},
    front_end::FrontEnd,
    machine::Machine,
    names::layout_name,
    scene::{Fragment, Scene},
};

/// A filter bound to the memory a scene's texture would take.
#[derive(Debug)]
pub struct AddressBench {
    /// Where the texels would be.
    pub surface: Surface,
    bytes: Vec<u8>,
    sampler: Sampler,
    front_end: FrontEnd,
}

impl AddressBench {
    /// Lays out the texture.
    ///
    /// # Errors
    /// A layout the texture does not fit, a machine that cannot be built.
    pub fn new(scene: &Scene, machine: &Machine, filter: Filter) -> Result<Self> {
        let [width, height] = scene.texture.size();
        let wrong = |problem: String| {
            let layout = layout_name(machine.texture.layout);
            Error::setting("texture.layout", layout, problem, "use tiled-4x4, which takes every texture")
        };
        // Where a decompressor stands before the cache, the cache sees what it makes.
        let format = if machine.texture.decompresses_before_cache() { Format::Rgba8 } else { machine.texture.format };
        let surface = Surface::new(filter.pyramid(), machine.texture.layout, format, width, height)
            .map_err(|error| wrong(error.to_string()))?;
        // Addresses do not depend on texels: memory that is never written takes no room.
        let bytes = vec![0; usize::try_from(surface.bytes).map_err(|_| wrong(format!("{} bytes", surface.bytes)))?];
        let address = scene.texture.wrap;
        let front_end = FrontEnd::new(machine, filter, address, [width, height]).of_shape(machine, |seen| {
            scene.for_each_block(|fragments| seen.add(fragments));
        });
        let bench = Self { surface, bytes, sampler: machine.sampler(filter, address, LodSource::Gradient), front_end };
        bench
            .unit()
            .map_err(|error| Error::setting("machine", &machine.name, error.to_string(), "change the machine"))?;
        Ok(bench)
    }

    fn unit(&self) -> Result<Unit<'_>, texunit_hw::UnitError> {
        Unit::new(&self.sampler, &self.surface, &self.bytes)
    }

    /// Shows `sink` every tap of a scene in pixel order; before each block of fragments it is shown these.
    ///
    /// # Panics
    /// Never: the unit was built once before.
    pub fn run<S: Sink>(&self, scene: &Scene, sink: &mut S, mut block: impl FnMut(&[Fragment], &mut S)) {
        let mut unit = self.unit().expect("it was built in `new`");
        scene.for_each_block(|fragments| {
            block(fragments, sink);
            unit.addresses(&self.front_end.requests(fragments).0, sink);
        });
    }
}
