//! Machines without lanes.

use core::marker::PhantomData;

use super::{Kept, RunShape};
use crate::{
    address::Footprint,
    address_stream::{Places, TapRows},
    cache::Run,
    datapath::Texel,
    request::{Request, Response},
    sampler::Sampler,
    surface::Surface,
    taps::TapUnit,
};

/// Nothing of this kind exists.
#[derive(Clone, Debug)]
pub(crate) struct Lanes<'m> {
    none: core::convert::Infallible,
    memory: PhantomData<&'m [u8]>,
}

impl<'m> Lanes<'m> {
    pub(crate) fn new(_: &Sampler, _: &TapUnit, _: &Surface, _: &'m [u8]) -> Option<Self> {
        None
    }

    pub(crate) const fn lanes(&self) -> usize {
        match self.none {}
    }

    pub(crate) fn eight(self) -> Self {
        match self.none {}
    }

    pub(crate) const fn writes(&self) -> bool {
        match self.none {}
    }

    pub(crate) fn run(&self, _: &[Request], _: Option<&mut [Response]>, _: Option<&mut TapRows>) -> usize {
        match self.none {}
    }

    pub(crate) fn filter(&self, _: &[Footprint], _: impl Iterator<Item = usize>, _: impl FnMut(Texel)) {
        match self.none {}
    }
}

/// Nor of this.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunLanes(core::convert::Infallible);

/// Lanes write no runs.
pub(crate) const PLACES: usize = 0;

impl RunLanes {
    pub(crate) fn detect() -> Option<Self> {
        None
    }

    pub(crate) fn write(self, _: Places<'_>, _: usize, _: RunShape, _: &mut [Run], _: &mut [u8]) -> (usize, usize) {
        match self.0 {}
    }
}

/// Nor of this.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChangeLanes(core::convert::Infallible);

impl ChangeLanes {
    pub(crate) fn detect() -> Option<Self> {
        None
    }

    pub(crate) fn narrow(self) -> Self {
        match self.0 {}
    }

    pub(crate) fn keep(self, _: &[[u64; 8]], _: u64, _: u32, _: &mut Kept) -> usize {
        match self.0 {}
    }
}

/// Nor of this.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UseLanes(core::convert::Infallible);

impl UseLanes {
    pub(crate) fn detect() -> Option<Self> {
        None
    }

    pub(crate) fn move_last(self, _: &mut [u32], _: usize, _: &[u32]) -> (usize, usize) {
        match self.0 {}
    }
}

/// Nor of this.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BankLanes(core::convert::Infallible);

impl BankLanes {
    pub(crate) fn new(_: [u32; 2], _: [u32; 2]) -> Option<Self> {
        None
    }

    pub(crate) fn look(self, _: Places<'_>, _: usize, _: &mut [u8]) -> (usize, bool) {
        match self.0 {}
    }
}
