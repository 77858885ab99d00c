//! texunit: the open golden model of a GPU texture unit. The chip is the crate [`texunit_hw`]; this crate is the
//! laboratory around it: pyramids, scenes, the float reference, traces and reports.

pub mod address_trace;
pub mod annotated;
pub mod area;
pub mod cli;
pub mod energy;
pub mod error;
pub mod experiment;
pub mod flicker;
pub mod front_end;
pub mod lod_rules;
pub mod machine;
pub mod names;
pub mod needs;
pub mod output;
pub mod pareto;
pub mod pyramid;
pub mod reference;
pub mod report;
pub mod reuse;
pub mod scene;
pub mod stream;
pub mod sweep;
pub mod texel_format;
pub mod text_lines;
pub mod texture_file;
pub mod texture_memory;
pub mod timed_run;
pub mod timing_output;
pub mod timing_settings;
pub mod trace;
