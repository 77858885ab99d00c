//! The chip: a GPU texture unit in integers only.
#![no_std]
#![forbid(unsafe_code)]
#![deny(clippy::float_arithmetic, clippy::float_cmp)]

extern crate alloc;

pub mod coordinate;
pub mod request;
pub mod sampler;

pub use coordinate::AddressMode;
pub use fixed::types::I12F20;
pub use request::{LodSource, Request, Response};
pub use sampler::{Filter, LevelRounding, Log2, PyramidKind, Rounding, Sampler, SamplerError};
