//! Rules that choose a level, in floats and outside the chip: what the papers print, measured and compared.
//!
//! [`ladder`] measures the log2 units of the chip; [`polygon`] has the levels a whole polygon shares (Herf 1999, draft;
//! Flavell 1998); [`edge`] is Flavell's per-pixel formula with its terms taken out of the inner loop.

pub mod edge;
pub mod ladder;
pub mod polygon;
