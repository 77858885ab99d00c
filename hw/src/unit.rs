//! The unit: the stages wired together, a batch of requests at a time.
//!
//! Addresses are made first, then seen by whoever counts (a cache, a trace, nobody), then filtered: each stage is a loop of its
//! own over the batch, so a run pays only for the stages it asks for.

use alloc::{boxed::Box, vec, vec::Vec};
use core::mem::take;

use crate::{
    address::Footprint,
    address_stream::{AddressBatch, BATCH_TAPS, Places, Sink, TapRows},
    batch::{Batch, Requests},
    datapath::{TexelSource, filter, filter_packed},
    empty_taps,
    lanes::Lanes,
    memory::with_source,
    one_channel,
    request::{Request, Response},
    sampler::{Filter, Rounding, Sampler, SamplerError},
    sat,
    surface::Surface,
    taps::{Program, TapUnit, most_taps, weight_bits, with_program},
};

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
    lanes: Option<Lanes<'m>>,
    /// Requests of a batch.
    batch: usize,
    footprints: Vec<Footprint>,
    /// The taps that lanes write.
    rows: Option<Box<TapRows>>,
    ends: Vec<u32>,
    lods: Vec<[u16; 2]>,
}

impl<'m> Unit<'m> {
    /// Binds a sampler and a texture.
    ///
    /// # Errors
    /// See [`UnitError`].
    pub fn new(sampler: &Sampler, surface: &'m Surface, bytes: &'m [u8]) -> Result<Self, UnitError> {
        if bytes.len() as u64 != surface.bytes {
            return Err(UnitError::Memory);
        }
        let unit = Self::without_memory(sampler, surface)?;
        let lanes = Lanes::new(sampler, &unit.taps, surface, bytes);
        let rows = lanes.as_ref().filter(|lanes| lanes.writes()).map(|_| Box::new(TapRows::new()));
        Ok(Self { bytes, lanes, rows, ..unit })
    }

    /// Binds a sampler and the places of a texture that is not there: for [`Unit::addresses`], [`Unit::inspect`] and
    /// [`Unit::run_from`].
    ///
    /// # Errors
    /// See [`UnitError`].
    pub fn without_memory(sampler: &Sampler, surface: &'m Surface) -> Result<Self, UnitError> {
        sampler.check().map_err(UnitError::Sampler)?;
        if sampler.filter.pyramid() != surface.kind {
            return Err(UnitError::Pyramid);
        }
        let (most_taps, always) = most_taps(sampler.filter);
        let batch = (BATCH_TAPS / most_taps).max(1);
        let taps = TapUnit::new(sampler, surface);
        Ok(Self {
            sampler: *sampler,
            surface,
            bytes: &[],
            lanes: None,
            taps,
            batch,
            footprints: vec![Footprint::default(); batch * most_taps],
            rows: None,
            ends: vec![0; if always && !sampler.skip_empty_taps { 0 } else { batch }],
            lods: vec![[0; 2]; batch],
        })
    }

    /// The same unit without the lanes of the machine it runs on: what they are compared with.
    #[must_use]
    pub fn scalar(self) -> Self {
        Self { lanes: None, rows: None, ..self }
    }

    /// The same unit in eight lanes at most: what machines without AVX-512 have.
    #[must_use]
    pub fn eight_lanes(self) -> Self {
        Self { lanes: self.lanes.map(Lanes::eight), ..self }
    }

    /// Requests that this machine answers at a time: 1 where its lanes do not serve (see [`Self::scalar`]).
    #[must_use]
    pub const fn lanes(&self) -> usize {
        match &self.lanes {
            Some(lanes) => lanes.lanes(),
            None => 1,
        }
    }

    /// Answers requests; `sink` sees every tap on the way.
    ///
    /// # Panics
    /// If the two slices differ in length, and where a request reads a plane that has no memory.
    pub fn run<S: Sink>(&mut self, requests: &[Request], responses: &mut [Response], sink: &mut S) {
        self.run_batches(requests, responses, S::LOOKS, &mut |batch| sink.take(batch));
    }

    /// [`Self::run`], compiled once and not for every sink: a call a batch costs nothing beside the batch.
    fn run_batches(
        &mut self,
        requests: &[Request],
        responses: &mut [Response],
        looks: bool,
        take: &mut dyn FnMut(AddressBatch<'_>),
    ) {
        assert_eq!(requests.len(), responses.len(), "one response a request");
        let size = self.batch;
        let bytes = self.bytes;
        if self.sampler.filter == Filter::Sat {
            // Sums are no texels: another datapath.
            return self.run_through(requests, responses, take, |batch, responses| {
                for (response, taps) in responses.iter_mut().zip(batch.per_request()) {
                    response.texel = sat::mean(bytes, taps);
                }
            });
        }
        if one_channel::suffices(&self.sampler, self.surface) {
            let widths = [self.sampler.filter_bits.into(), weight_bits(self.sampler.filter)];
            return self.run_through(requests, responses, take, |batch, responses| {
                one_channel::answer(bytes, widths, batch, responses);
            });
        }
        let done = match &self.lanes {
            Some(lanes) if !looks => lanes.run(requests, Some(&mut *responses), None),
            _ => 0,
        };
        let (requests, responses) = (&requests[done..], &mut responses[done..]);
        // Taken out for as long as the rest of the unit is borrowed to make taps.
        let (lanes, mut rows) = (self.lanes.take(), self.rows.take());
        let sampler = self.sampler;
        with_program!(self.sampler.filter, P => with_source!(self.surface, self.bytes, source => {
            for (requests, responses) in requests.chunks(size).zip(responses.chunks_mut(size)) {
                let answered = match &lanes {
                    Some(lanes) => lanes.run(requests, Some(&mut *responses), rows.as_deref_mut()),
                    None => 0,
                };
                let written = if rows.is_some() { answered } else { 0 };
                let (batch, lods) = self.expand::<P>(&requests[written..]);
                for (response, lod) in responses[written..].iter_mut().zip(lods).skip(answered - written) {
                    response.lod = *lod;
                }
                take(after_rows::<P>(rows.as_deref_mut(), written, batch));
                answer::<P>(&sampler, lanes.as_ref(), &source, batch, answered - written, &mut responses[written..]);
            }
        }));
        (self.lanes, self.rows) = (lanes, rows);
    }

    /// The same from texels that lie elsewhere than in bytes of one piece: a memory of tiles.
    ///
    /// # Panics
    /// If the two slices differ in length, or for [`Filter::Sat`], whose entries are no texels.
    pub fn run_from(
        &mut self,
        source: &impl TexelSource,
        requests: &[Request],
        responses: &mut [Response],
        sink: &mut impl Sink,
    ) {
        assert_eq!(requests.len(), responses.len(), "one response a request");
        assert_ne!(self.sampler.filter, Filter::Sat, "sums are no texels");
        let Sampler { filter: program, filter_bits, rounding, .. } = self.sampler;
        let take = &mut |batch: AddressBatch<'_>| sink.take(batch);
        self.run_through(requests, responses, take, |batch, responses| {
            let (texels, weight_bits) = (batch.texels_per_tap, weight_bits(program));
            for (taps, response) in batch.per_request().zip(responses) {
                response.texel = filter(source, taps, texels, filter_bits.into(), weight_bits, rounding);
            }
        });
    }

    /// Answers requests a batch at a time in a datapath that takes its widths as they come.
    fn run_through(
        &mut self,
        requests: &[Request],
        responses: &mut [Response],
        take_batch: &mut dyn FnMut(AddressBatch<'_>),
        mut answer: impl FnMut(Batch<'_>, &mut [Response]),
    ) {
        let mut rest = responses;
        self.inspect(requests, &mut |batch, lods| {
            let (responses, after) = take(&mut rest).split_at_mut(batch.len());
            rest = after;
            for (response, lod) in responses.iter_mut().zip(lods) {
                response.lod = *lod;
            }
            take_batch(batch.into());
            answer(batch, responses);
        });
    }

    /// Makes taps and levels only, and shows them with the levels of each request: what an analysis of requests needs.
    pub fn inspect(&mut self, requests: &[Request], look: &mut dyn FnMut(Batch<'_>, &[[u16; 2]])) {
        let size = self.batch;
        with_program!(self.sampler.filter, P => {
            for requests in requests.chunks(size) {
                let (batch, lods) = self.expand::<P>(requests);
                look(batch, &lods[..batch.len()]);
            }
        });
    }

    /// Makes addresses only: what a cache study needs.
    pub fn addresses(&mut self, requests: &[Request], sink: &mut impl Sink) {
        self.address_batches(requests, &mut |batch| sink.take(batch));
    }

    fn address_batches(&mut self, requests: &[Request], take: &mut dyn FnMut(AddressBatch<'_>)) {
        let size = self.batch;
        let (lanes, mut rows) = (self.lanes.take(), self.rows.take());
        with_program!(self.sampler.filter, P => {
            for requests in requests.chunks(size) {
                let written = match (&lanes, &mut rows) {
                    (Some(lanes), Some(rows)) => lanes.run(requests, None, Some(rows)),
                    _ => 0,
                };
                let (batch, _) = self.expand::<P>(&requests[written..]);
                take(after_rows::<P>(rows.as_deref_mut(), written, batch));
            }
        });
        (self.lanes, self.rows) = (lanes, rows);
    }

    /// The taps and levels of at most one batch of requests.
    #[inline]
    fn expand<P: Program>(&mut self, requests: &[Request]) -> (Batch<'_>, &[[u16; 2]]) {
        let mut end = 0;
        for (number, (request, lod)) in requests.iter().zip(&mut self.lods).enumerate() {
            let taps = &mut self.footprints[end..end + P::MOST_TAPS];
            let (count, levels) = P::expand(&self.taps, request, taps);
            *lod = levels;
            if P::ALWAYS {
                end += P::MOST_TAPS;
            } else {
                end += count;
                self.ends[number] = end as u32;
            }
        }
        if self.sampler.skip_empty_taps {
            let each = if P::ALWAYS { Some(P::MOST_TAPS) } else { None };
            end = empty_taps::leave_out(&mut self.footprints, &mut self.ends[..requests.len()], each);
        }
        let divided = if P::ALWAYS && !self.sampler.skip_empty_taps {
            Requests::Each(P::MOST_TAPS)
        } else {
            Requests::Ends(&self.ends[..requests.len()])
        };
        let taps = &self.footprints[..end];
        (Batch { taps, requests: divided, texels_per_tap: P::TEXELS, surface: self.surface }, &self.lods)
    }
}

/// The addresses of so many requests whose taps lanes have written, and of a batch after them.
fn after_rows<'b, P: Program>(rows: Option<&'b mut TapRows>, written: usize, batch: Batch<'b>) -> AddressBatch<'b> {
    match rows {
        Some(rows) if written > 0 => {
            let before = written * P::MOST_TAPS;
            rows.add(before, batch.taps);
            AddressBatch { taps: Places::Rows(rows, before + batch.taps.len()), ..batch.into() }
        }
        _ => batch.into(),
    }
}

/// Filters the batch's requests from the one numbered `first`.
fn answer<P: Program>(
    sampler: &Sampler,
    lanes: Option<&Lanes<'_>>,
    source: &impl TexelSource,
    batch: Batch<'_>,
    first: usize,
    responses: &mut [Response],
) {
    let responses = &mut responses[first..];
    if let (Some(lanes), Requests::Ends(ends)) = (lanes, batch.requests) {
        let (done, ends) = ends.split_at(first);
        let begin = done.last().map_or(0, |&end| end as usize);
        let mut responses = responses.iter_mut();
        lanes.filter(&batch.taps[begin..], ends.iter().map(|&end| end as usize - begin), |texel| {
            if let Some(response) = responses.next() {
                response.texel = texel;
            }
        });
        return;
    }
    let packed = sampler.rounding == Rounding::Once && sampler.filter_bits == 8;
    let bits = sampler.filter_bits.into();
    if packed && P::WEIGHT_BITS <= 8 {
        for (taps, response) in batch.per_request().skip(first).zip(responses) {
            response.texel = filter_packed(source, taps, P::TEXELS, P::WEIGHT_BITS);
        }
    } else {
        for (taps, response) in batch.per_request().skip(first).zip(responses) {
            response.texel = filter(source, taps, P::TEXELS, bits, P::WEIGHT_BITS, sampler.rounding);
        }
    }
}
