//! What the unit calls.

use super::{
    LANES,
    kernel::Kernel,
    room::{Avx2, Avx512, Texels},
};
use crate::{
    address::Footprint,
    datapath::Texel,
    format::Format,
    layout::Layout,
    request::{Request, Response},
    sampler::{Filter, PyramidKind, Rounding, Sampler},
    surface::Surface,
    taps::{TapUnit, most_taps, weight_bits},
};

/// A unit's lanes.
#[derive(Clone, Debug)]
pub(crate) struct Lanes<'m> {
    machine: Avx2,
    wide: Option<Avx512>,
    texels: Texels<'m>,
    weight_bits: u32,
    /// For the filters whose requests have the same taps each.
    kernel: Option<Kernel<'m>>,
    /// Whether the kernel's taps are those of the scalar unit, down to their number.
    writes: bool,
}

impl<'m> Lanes<'m> {
    /// The lanes of a unit, if the machine has them and this is the common case.
    pub(crate) fn new(sampler: &Sampler, unit: &TapUnit, surface: &Surface, bytes: &'m [u8]) -> Option<Self> {
        let common = surface.kind != PyramidKind::Sat
            && surface.layout != Layout::Williams
            && surface.format == Format::Rgba8
            && !surface.srgb
            && sampler.filter_bits == 8
            && sampler.rounding == Rounding::Once;
        if !common {
            return None;
        }
        let (_, always) = most_taps(sampler.filter);
        let kernel =
            if always || sampler.filter == Filter::Brilinear { Kernel::new(sampler, unit, bytes) } else { None };
        Some(Self {
            machine: Avx2::detect()?,
            wide: Avx512::detect(),
            texels: Texels::new(bytes)?,
            weight_bits: weight_bits(sampler.filter),
            writes: kernel.is_some() && always,
            kernel,
        })
    }

    /// Requests at a time.
    pub(crate) const fn lanes(&self) -> usize {
        if self.wide.is_some() { 16 } else { LANES }
    }

    /// The same lanes, eight of them.
    pub(crate) fn eight(self) -> Self {
        Self { wide: None, ..self }
    }

    /// Answers what requests it can; returns how many, from the first.
    pub(crate) fn answer(&self, requests: &[Request], responses: &mut [Response]) -> usize {
        match &self.kernel {
            Some(kernel) => self.run::<true, false>(kernel, requests, responses, &mut []),
            None => 0,
        }
    }

    /// The same, writing their taps too.
    pub(crate) fn answer_and_write(
        &self,
        requests: &[Request],
        responses: &mut [Response],
        footprints: &mut [Footprint],
    ) -> usize {
        match self.writer() {
            Some(kernel) => self.run::<true, true>(kernel, requests, responses, footprints),
            None => 0,
        }
    }

    /// Writes the taps of what requests it can; returns how many, from the first.
    pub(crate) fn write(&self, requests: &[Request], footprints: &mut [Footprint]) -> usize {
        match self.writer() {
            Some(kernel) => self.run::<false, true>(kernel, requests, &mut [], footprints),
            None => 0,
        }
    }

    fn run<const ANSWER: bool, const WRITE: bool>(
        &self,
        kernel: &Kernel<'_>,
        requests: &[Request],
        responses: &mut [Response],
        footprints: &mut [Footprint],
    ) -> usize {
        // The widest first; what fills no register of it is left to the narrower.
        let mut done = 0;
        if let Some(machine) = self.wide {
            machine.run::<ANSWER, WRITE>(kernel, requests, responses, footprints);
            done = requests.len() / 16 * 16;
        }
        let responses = if ANSWER { &mut responses[done..] } else { responses };
        let footprints = if WRITE { &mut footprints[done * kernel.taps()..] } else { footprints };
        self.machine.run::<ANSWER, WRITE>(kernel, &requests[done..], responses, footprints);
        requests.len() / LANES * LANES
    }

    fn writer(&self) -> Option<&Kernel<'m>> {
        self.kernel.as_ref().filter(|_| self.writes)
    }

    /// Filters requests whose taps are made: bilinear ones, `ends` where those of each request end, from the first.
    pub(crate) fn filter(&self, taps: &[Footprint], ends: impl Iterator<Item = usize>, answer: impl FnMut(Texel)) {
        self.machine.filter(self.texels, taps, ends, self.weight_bits, answer);
    }
}
