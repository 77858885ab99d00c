//! The chip: a GPU texture unit in integers only, one file per unit, in the order the data flows.
//!
//! Requests of 12.20 coordinates come in, exact texels go out; between the address unit and the datapath the address
//! stream passes whoever counts it. Every width and rounding is stated in docs/numerics.md.
//!
//! There is no float arithmetic here, no input or output, and no clock but its own: floats enter as the bits of their
//! `u32` or `u64`.
#![no_std]
// One module may hold unsafe code: `lanes::room` (docs/decisions/0005-one-room-for-unsafe.md).
#![deny(unsafe_code)]
#![deny(clippy::float_arithmetic, clippy::float_cmp)]

extern crate alloc;

pub mod request;
pub mod sampler;

pub mod coordinate;
mod empty_taps;
pub mod lod;
mod log2_table;
mod probe_tables;
mod probes;
pub mod sat;
pub mod taps;

pub mod address;
pub mod address_stream;
mod bc7;
mod block_compression;
pub mod format;
pub mod layout;
pub mod srgb;
pub mod surface;

pub mod cache;
pub mod sweep;

pub mod datapath;
pub mod memory;
mod one_channel;

mod lanes;

pub mod decompression;

pub mod peers;

pub mod timing;

pub mod batch;
pub mod unit;

pub use address::Footprint;
pub use address_stream::{AddressBatch, Sink};
pub use batch::{Batch, Requests};
pub use cache::{Geometry, Policy};
pub use coordinate::AddressMode;
pub use datapath::Texel;
pub use fixed::types::I12F20;
pub use format::{Format, Palette};
pub use layout::Layout;
pub use request::{LodSource, Request, Response};
pub use sampler::{FILTERS, Filter, LevelRounding, Log2, PyramidKind, Rounding, Sampler, SamplerError};
pub use surface::{Surface, SurfaceError};
pub use unit::{Unit, UnitError};
