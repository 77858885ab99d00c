//! What a scene needs, and what may be left out (docs/leaving-out.md).
//!
//! [`Needs`] is one pass over the requests that reads no texel; a [`Plan`] is what the unit, its memory and the pyramid may do
//! without, the answers being the same to the bit; [`LeftOut`] says what that saved. What would change the picture is a proposal
//! ([`Fit`]) and never done.

mod fit;
mod image_needs;
mod left_out;
mod observed;
mod pixels;
mod plan;
pub mod report;
mod tiles;

pub use fit::{Candidate, Fit, Loss};
pub use image_needs::ImageNeeds;
pub use left_out::{Cost, LeftOut};
pub use observed::{CoordinateBits, Needs, PlaneNeeds};
pub use pixels::PixelNeeds;
pub use plan::Plan;
pub use tiles::{LazyTexture, PpmFile, TILE, TileMemory, TileSet};

use texunit_hw::{Filter, Request};

use crate::{front_end::FrontEnd, machine::Machine, scene::Scene};

/// The requests a scene makes of a filter, in pixel order.
#[must_use]
pub fn requests(scene: &Scene, machine: &Machine, filter: Filter) -> Vec<Request> {
    requests_of_size(scene, machine, filter, scene.texture.size())
}

/// The same of a texture of another size.
#[must_use]
pub fn requests_of_size(scene: &Scene, machine: &Machine, filter: Filter, size: [u32; 2]) -> Vec<Request> {
    let front_end = FrontEnd::new(machine, filter, scene.texture.wrap, size).of_shape(machine, |seen| {
        scene.for_each_block(|fragments| seen.add(fragments));
    });
    let mut requests = Vec::new();
    scene.for_each_block(|fragments| requests.extend(front_end.requests(fragments).0));
    requests
}
