//! The common case in eight lanes: texels of RGBA8, 8 fraction bits, one rounding, on a machine with AVX2.
//!
//! The scalar units say what is right; these say the same faster, and a test compares every filter, address mode and layout bit for bit.
//! Whatever is not the common case stays with them, as does the end of a run that fills no eight lanes.

mod run_shape;

#[cfg(target_arch = "x86_64")]
mod address;
#[cfg(target_arch = "x86_64")]
mod banks;
#[cfg(target_arch = "x86_64")]
mod changes;
#[cfg(target_arch = "x86_64")]
mod compress;
#[cfg(target_arch = "x86_64")]
mod filter;
#[cfg(target_arch = "x86_64")]
mod footprints;
#[cfg(target_arch = "x86_64")]
mod kernel;
#[cfg(target_arch = "x86_64")]
mod level;
#[cfg(target_arch = "x86_64")]
mod machine;
#[cfg(target_arch = "x86_64")]
mod room;
#[cfg(target_arch = "x86_64")]
mod runs;
#[cfg(target_arch = "x86_64")]
mod unit;
#[cfg(target_arch = "x86_64")]
mod uses;

#[cfg(not(target_arch = "x86_64"))]
mod elsewhere;
#[cfg(not(target_arch = "x86_64"))]
use elsewhere::{self as banks, self as changes, self as runs, self as unit, self as uses};

pub(crate) use banks::BankLanes;
pub(crate) use changes::ChangeLanes;
pub(crate) use run_shape::RunShape;
pub(crate) use runs::{PLACES, RunLanes};
pub(crate) use unit::Lanes;
pub(crate) use uses::UseLanes;

/// Requests, or taps, at a time.
pub(crate) const LANES: usize = 8;

/// Addresses of a stream at a time.
pub(crate) const BLOCK: usize = 256;

/// Room for a block of addresses, and for what a register has more.
pub(crate) type Kept = [u64; BLOCK + 8];
