//! What people look at: plots and the page.

pub mod page;
pub mod plot;
pub mod response_plot;
pub mod stack;
pub mod table;
