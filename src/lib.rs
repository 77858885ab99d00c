//! texunit
