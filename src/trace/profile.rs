//! The head of a trace: everything an answer depends on beside the request.

use std::path::Path;

use serde::{Deserialize, Serialize};
use texunit_hw::{AddressMode, Filter, LodSource, Sampler};

use super::TracedTexture;
use crate::{
    error::Result,
    front_end::FrontEnd,
    machine::Machine,
    names::{by_name, by_name_per_axis},
    scene::Scene,
    texture_file::TextureImage,
};

/// The sections of a machine that no answer depends on.
pub const WITHOUT_EFFECT: [&str; 3] = ["timing", "memory", "energy"];

/// A machine with its [`WITHOUT_EFFECT`] at their defaults.
fn answering(machine: &Machine) -> Machine {
    let Machine { timing, memory, energy, .. } = Machine::default();
    Machine { timing, memory, energy, ..machine.clone() }
}

/// Machine, sampler and texture of a trace.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Profile {
    /// The scene the requests come from: for people, nothing depends on it.
    #[serde(default)]
    pub scene: String,
    /// The filter.
    #[serde(with = "by_name")]
    pub filter: Filter,
    /// Address modes of u and v.
    #[serde(with = "by_name_per_axis")]
    pub wrap: [AddressMode; 2],
    /// How `scale` is read.
    #[serde(with = "by_name")]
    pub lod_source: LodSource,
    /// What the texture is.
    pub texture: TracedTexture,
    /// The machine: widths, roundings, layout, cache. A key that is not said has the value of the default machine, so that
    /// traces stay readable when machines learn more. [`WITHOUT_EFFECT`] is at its default and not said.
    pub machine: Machine,
}

impl Profile {
    /// For the requests a scene with this texture makes of a filter, in a trace that lies in `folder`.
    ///
    /// # Errors
    /// A texture file that is there no more.
    pub fn of_scene(
        scene: &Scene,
        texture: &TextureImage,
        machine: &Machine,
        filter: Filter,
        wrap: [AddressMode; 2],
        folder: &Path,
    ) -> Result<Self> {
        Ok(Self {
            scene: scene.name.clone(),
            filter,
            wrap,
            lod_source: LodSource::Gradient,
            texture: TracedTexture::new(&scene.texture, texture, folder)?,
            machine: answering(machine),
        })
    }

    /// The sampler state.
    #[must_use]
    pub fn sampler(&self) -> Sampler {
        self.machine.sampler(self.filter, self.wrap, self.lod_source)
    }

    /// What makes requests of fragments.
    #[must_use]
    pub fn front_end(&self) -> FrontEnd {
        FrontEnd::new(&self.machine, self.filter, self.wrap, self.texture.size)
    }
}
