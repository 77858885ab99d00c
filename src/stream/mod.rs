//! Requests from elsewhere: another renderer's or simulator's own stream ([`requests_file`]), or the fragments of a mesh
//! ([`mesh`], [`raster`]). Textures and filters may change from request to request; one cache sees them all.

#[cfg(feature = "gltf")]
pub mod gltf;
pub mod mesh;
pub mod obj;
mod placed;
pub mod raster;
pub mod requests_file;
mod run;

use texunit_hw::Filter;

pub use self::run::{PartOutcome, StreamOutcome, StreamRun};
use crate::{scene::Fragment, texture_file::TextureImage};

/// A texture of a stream.
#[derive(Clone, Debug)]
pub struct NamedTexture {
    /// What it is called in the stream.
    pub name: String,
    /// Its texels.
    pub image: TextureImage,
}

/// One request, before a front end has seen it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreamRequest {
    /// Place, coordinates and gradient.
    pub fragment: Fragment,
    /// Which texture of the stream.
    pub texture: usize,
    /// The filter, where the stream says.
    pub filter: Option<Filter>,
}

/// Requests in order, and the textures they ask of.
#[derive(Clone, Debug, Default)]
pub struct Stream {
    /// The textures, in the order they lie in memory.
    pub textures: Vec<NamedTexture>,
    /// The requests, in order.
    pub requests: Vec<StreamRequest>,
    /// Width and height of the picture they make, if they make one.
    pub size: Option<[u32; 2]>,
}
