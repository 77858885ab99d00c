//! What a unit and its memory may do without for some requests, without changing a bit of an answer.

use texunit_hw::{AddressMode, Format, Layout, PyramidKind, Sampler};

use super::{ImageNeeds, Needs};
use crate::{
    error::Result,
    machine::Texture,
    texture_file::TextureImage,
    texture_memory::{Decompress, TextureMemory},
};

/// Choices made before the first request; valid for the requests they were made for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The sampler to run: the simplest filter that gives the answers, no address mode where nothing leaves the texture, no taps that
    /// change nothing.
    pub sampler: Sampler,
    /// Planes to compute and hold.
    pub planes: Vec<(u8, u8)>,
}

impl Plan {
    /// What `needs` allows of `sampler`, whose requests they are of.
    #[must_use]
    pub fn new(needs: &Needs, sampler: &Sampler) -> Self {
        let filter = needs.stands_for.unwrap_or(sampler.filter);
        let mut address = sampler.address;
        for (mode, needed) in address.iter_mut().zip(needs.address_logic) {
            if !needed {
                *mode = AddressMode::Clamp;
            }
        }
        let read = needs.planes.iter().filter(|plane| plane.taps > 0).map(|plane| plane.halvings);
        let planes = if needs.stands_for.is_some() { vec![(0, 0)] } else { read.collect() };
        // Looking for taps that are not there takes time of this host.
        let skip_empty_taps = needs.stands_for.is_none() && needs.needed_taps < needs.taps;
        Self { sampler: Sampler { filter, address, skip_empty_taps, ..*sampler }, planes }
    }

    /// Makes and stores what is needed: planes, and one channel where the machine stores RGBA8 and all texels are opaque greys.
    ///
    /// # Errors
    /// A kernel or layout that cannot be built for this texture.
    pub fn hold(&self, machine: &Texture, texture: &TextureImage) -> Result<TextureMemory> {
        let kind = self.sampler.filter.pyramid();
        if kind == PyramidKind::Sat {
            // An entry is the sum of all texels before it: there is nothing to leave out.
            return Ok(machine.hold(kind, texture)?.memory);
        }
        // Other colours of one palette come from planes that nobody reads; and a decompressor lays out whole pyramids.
        let base_only = self.planes == [(0, 0)];
        let whole = machine.decompresses_before_cache() || (machine.format == Format::Palette8 && !base_only);
        let pyramid = machine.needed_planes(kind, texture, |lu, lv| whole || self.planes.contains(&(lu, lv)))?;
        if machine.format != Format::Rgba8 {
            return machine.hold_planes(&pyramid, texture);
        }
        let image = ImageNeeds::of(&pyramid.planes);
        // Outside of a clipped texture even opaque greys are transparent.
        let fades = self.sampler.address.contains(&AddressMode::Clip);
        let channels = if fades { 4 } else { image.channels() };
        let one_channel = channels == 1 && machine.layout != Layout::Williams;
        let format = if one_channel { Format::L8 } else { machine.format };
        let machine = Texture { format, decompress: Decompress::AfterCache, ..machine.clone() };
        let memory = machine.hold_planes(&pyramid, texture)?;
        Ok(TextureMemory { channels, ..memory })
    }
}
