//! What the unit calls.

use super::{
    LANES,
    kernel::Kernel,
    room::{Avx2, Avx512, Texels},
};
use crate::{
    address::Footprint,
    address_stream::TapRows,
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
            writes: kernel.is_some() && always && !sampler.skip_empty_taps,
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

    /// Whether taps can be written.
    pub(crate) const fn writes(&self) -> bool {
        self.writes
    }

    /// Answers what requests it can, or writes their taps if it [can](Self::writes), or both; returns how many, from the first.
    pub(crate) fn run(
        &self,
        requests: &[Request],
        mut responses: Option<&mut [Response]>,
        mut rows: Option<&mut TapRows>,
    ) -> usize {
        let Some(kernel) = &self.kernel else { return 0 };
        // The widest first; what fills no register of it is left to the narrower.
        let mut done = 0;
        if let Some(machine) = self.wide {
            machine.run(kernel, requests, responses.as_deref_mut(), rows.as_deref_mut(), 0);
            done = requests.len() / 16 * 16;
        }
        let responses = responses.map(|responses| &mut responses[done..]);
        self.machine.run(kernel, &requests[done..], responses, rows, done * kernel.taps());
        requests.len() / LANES * LANES
    }

    /// Filters requests whose taps are made: bilinear ones, `ends` where those of each request end, from the first.
    pub(crate) fn filter(&self, taps: &[Footprint], ends: impl Iterator<Item = usize>, answer: impl FnMut(Texel)) {
        self.machine.filter(self.texels, taps, ends, self.weight_bits, answer);
    }
}
