//! texunit: the open golden model of a GPU texture unit. The chip is the crate [`texunit_hw`]; this crate is the
//! laboratory around it: pyramids, scenes, the float reference, traces and reports.

pub mod cli;
pub mod error;
pub mod names;
pub mod output;
pub mod pyramid;
pub mod report;
