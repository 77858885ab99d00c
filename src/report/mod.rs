//! What people look at: plots.

pub mod response_plot;
