//! Sweeps: any keys of the machine, filters, scenes and sizes crossed; thousands of machines from one file.
//!
//! A point is one scene of one size through one filter with one setting of every key but `cache.sets` and `cache.ways`: all
//! caches that differ in these alone come out of one pass (see [`texunit_hw::sweep`]) and are the cells of the point.

mod caches;
mod measure;
#[cfg(feature = "parquet")]
mod parquet_file;
mod plan;
mod slurm;
mod store;

pub use caches::Caches;
pub use measure::{Cell, Measure, Measured, traffic};
#[cfg(feature = "parquet")]
pub use parquet_file::write_parquet;
pub use plan::{Plan, Point, StageChoice};
pub use slurm::script;
pub use store::{Store, write_csv};
