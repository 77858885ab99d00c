//! Yardsticks: the same work written by hand, once, for one case, with nothing to configure. The model is measured against
//! them in the same run, because the machines it runs on are shared and their speed drifts.

pub mod contest;
pub mod workload;
pub mod yardstick;
