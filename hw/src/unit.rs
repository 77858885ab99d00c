//! The unit: the stages wired together, a batch of requests at a time.
//!
//! Addresses are made first, then seen by whoever counts (a cache, a trace, nobody), then filtered: each stage is a loop of its
//! own over the batch, so a run pays only for the stages it asks for.

use alloc::{vec, vec::Vec};

use crate::{
    address::{Footprint, is_outside},
    datapath::{TexelSource, filter, filter_packed},
    memory::with_source,
    request::{Request, Response},
    sampler::{Rounding, Sampler, SamplerError},
    surface::Surface,
    taps::{Program, TapUnit, with_program},
};

/// Requests whose footprints are kept at a time: few enough to stay in the first-level cache of the host.
const BATCH: usize = 128;

/// The taps of a batch of requests, in order of issue.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'b> {
    /// All taps, request by request.
    pub taps: &'b [Footprint],
    /// Taps of one request.
    pub taps_per_request: usize,
    /// Texels of one tap, 1 or 4: how many addresses of a [`Footprint`] count.
    pub texels_per_tap: usize,
    /// What the addresses are addresses of.
    pub surface: &'b Surface,
}

impl Batch<'_> {
    /// Calls `read` for each read of memory, in order of issue, with the storage index of the plane: once a texel, or once a
    /// channel where the layout keeps channels apart; not at all for a texel outside the texture.
    #[inline]
    pub fn for_each_read(&self, mut read: impl FnMut(usize, u64)) {
        let channels_apart = self.surface.reads_per_texel() > 1;
        for tap in self.taps {
            let plane = usize::from(tap.plane);
            for &address in tap.address[..self.texels_per_tap].iter().filter(|&&address| !is_outside(address)) {
                read(plane, address);
                if channels_apart {
                    for distance in self.surface.planes[plane].channels {
                        read(plane, address + distance);
                    }
                }
            }
        }
    }
}

/// Whoever looks at the address stream between the address unit and the datapath.
pub trait Sink {
    /// Takes the next batch.
    fn take(&mut self, batch: Batch<'_>);
}

/// Nobody looks.
impl Sink for () {
    #[inline]
    fn take(&mut self, _batch: Batch<'_>) {}
}

/// Why a unit cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitError {
    /// A sampler setting out of range.
    Sampler(SamplerError),
    /// The filter reads another pyramid than the surface holds.
    Pyramid,
    /// The memory has not the surface's number of bytes.
    Memory,
}

impl core::fmt::Display for UnitError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Sampler(error) => error.fmt(f),
            Self::Pyramid => f.write_str("the filter reads another pyramid than the surface holds"),
            Self::Memory => f.write_str("the memory is not as large as the surface says"),
        }
    }
}

impl core::error::Error for UnitError {}

/// A texture unit bound to one sampler and one texture.
#[derive(Clone, Debug)]
pub struct Unit<'m> {
    sampler: Sampler,
    surface: &'m Surface,
    bytes: &'m [u8],
    taps: TapUnit,
    footprints: Vec<Footprint>,
}

impl<'m> Unit<'m> {
    /// Binds a sampler and a texture.
    ///
    /// # Errors
    /// See [`UnitError`].
    pub fn new(sampler: &Sampler, surface: &'m Surface, bytes: &'m [u8]) -> Result<Self, UnitError> {
        sampler.check().map_err(UnitError::Sampler)?;
        if sampler.filter.pyramid() != surface.kind {
            return Err(UnitError::Pyramid);
        }
        if bytes.len() as u64 != surface.bytes {
            return Err(UnitError::Memory);
        }
        let most_taps = with_program!(sampler.filter, P => <P as Program>::TAPS);
        Ok(Self {
            sampler: *sampler,
            surface,
            bytes,
            taps: TapUnit::new(sampler, surface),
            footprints: vec![Footprint::default(); BATCH * most_taps],
        })
    }

    /// Answers requests; `sink` sees every tap on the way.
    ///
    /// # Panics
    /// If the two slices differ in length.
    pub fn run(&mut self, requests: &[Request], responses: &mut [Response], sink: &mut impl Sink) {
        assert_eq!(requests.len(), responses.len(), "one response a request");
        with_program!(self.sampler.filter, P => with_source!(self.surface, self.bytes, source => {
            for (requests, responses) in requests.chunks(BATCH).zip(responses.chunks_mut(BATCH)) {
                let lods = responses.iter_mut().map(|response| &mut response.lod);
                let batch = expand::<P>(&self.taps, self.surface, requests, &mut self.footprints, lods);
                sink.take(batch);
                answer::<P>(&self.sampler, &source, batch, responses);
            }
        }));
    }

    /// Makes addresses only: what a cache study needs.
    pub fn addresses(&mut self, requests: &[Request], sink: &mut impl Sink) {
        with_program!(self.sampler.filter, P => {
            for requests in requests.chunks(BATCH) {
                let mut lods = [[0u16; 2]; BATCH];
                sink.take(expand::<P>(&self.taps, self.surface, requests, &mut self.footprints, lods.iter_mut()));
            }
        });
    }
}

fn expand<'b, 'l, P: Program>(
    unit: &TapUnit,
    surface: &'b Surface,
    requests: &[Request],
    footprints: &'b mut [Footprint],
    lods: impl Iterator<Item = &'l mut [u16; 2]>,
) -> Batch<'b> {
    for ((request, taps), lod) in requests.iter().zip(footprints.chunks_exact_mut(P::TAPS)).zip(lods) {
        *lod = P::expand(unit, request, taps);
    }
    Batch {
        taps: &footprints[..requests.len() * P::TAPS],
        taps_per_request: P::TAPS,
        texels_per_tap: P::TEXELS,
        surface,
    }
}

fn answer<P: Program>(sampler: &Sampler, source: &impl TexelSource, batch: Batch<'_>, responses: &mut [Response]) {
    let answers = batch.taps.chunks_exact(P::TAPS).zip(responses);
    if sampler.rounding == Rounding::Once && sampler.filter_bits == 8 {
        for (taps, response) in answers {
            response.texel = filter_packed(source, taps, P::TEXELS, P::WEIGHT_BITS);
        }
    } else {
        let bits = sampler.filter_bits.into();
        for (taps, response) in answers {
            response.texel = filter(source, taps, P::TEXELS, bits, P::WEIGHT_BITS, sampler.rounding);
        }
    }
}
