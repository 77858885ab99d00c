#![no_std]
//! The chip.
