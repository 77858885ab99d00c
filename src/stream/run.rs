//! A stream through the unit: one cache, one clock, many textures.

use std::{collections::BTreeMap, sync::Arc};

use rayon::prelude::*;
use texunit_hw::{
    AddressMode, Filter, Layout, LodSource, PyramidKind, Request, Response, Sampler, Unit,
    cache::{Counters, PlaneCounters},
    decompression::{Decompressed, StoredLines},
    timing::{Timing, TimingCounters},
};

use super::{Stream, placed::Placed};
use crate::{
    error::{Error, Result},
    experiment::{Deviation, cache},
    front_end::FrontEnd,
    machine::Machine,
    reference::Reference,
    scene::{Supersampling, footprint_average},
    texture_memory::Held,
};

/// Planes begin at multiples of this, whatever texture they are of.
const TEXTURE_ALIGNMENT: u64 = 4096;

/// One texture through one filter.
#[derive(Clone, Debug)]
pub struct PartOutcome {
    /// Which texture of the stream.
    pub texture: usize,
    /// The filter.
    pub filter: Filter,
    /// Its requests.
    pub requests: u64,
    /// Its lookups, hits and misses.
    pub traffic: PlaneCounters,
}

/// What a stream came to.
#[derive(Clone, Debug)]
pub struct StreamOutcome {
    /// The answers, in order.
    pub responses: Vec<Response>,
    /// In all.
    pub counters: Counters,
    /// Apart, by texture and filter.
    pub parts: Vec<PartOutcome>,
    /// Clocks and stalls.
    pub timing: TimingCounters,
    /// Bytes of all pyramids, padding included.
    pub memory: u64,
    /// Coordinates that had no defined place.
    pub undefined: u64,
    /// Answers that differ from the reference.
    pub mismatches: u64,
    /// Deviation from the mean of the unfiltered texture over each request's parallelogram.
    pub against_truth: Deviation,
}

/// A pyramid where it lies.
#[derive(Debug)]
struct Placing {
    held: Held,
    /// Where it begins for the cache, and in memory, which differ where a decompressor stands between.
    base: u64,
    stored_base: u64,
}

/// One texture through one filter, ready to run.
#[derive(Debug)]
struct Part {
    texture: usize,
    filter: Filter,
    placing: usize,
    sampler: Sampler,
    requests: u64,
    /// Number of its first plane in what is counted: two filters on one pyramid are told apart.
    first_plane: u16,
}

/// A stream bound to a machine.
#[derive(Debug)]
pub struct StreamRun<'s> {
    stream: &'s Stream,
    machine: &'s Machine,
    placings: Vec<Placing>,
    parts: Vec<Part>,
    /// Which part each request belongs to, and what it asks.
    requests: Vec<(usize, Request)>,
    undefined: u64,
    memory: u64,
}

impl<'s> StreamRun<'s> {
    /// Lays out textures and makes requests; `filter` answers where the stream names none.
    ///
    /// # Errors
    /// A layout that cannot be built, or cannot be shared.
    pub fn new(stream: &'s Stream, machine: &'s Machine, filter: Filter, wrap: [AddressMode; 2]) -> Result<Self> {
        if machine.texture.layout == Layout::Williams {
            let problem = "its channels lie apart, and a stream of many textures reads texels whole";
            return Err(Error::setting("texture.layout", "williams", problem, "use tiled-4x4"));
        }
        let mut run = Self {
            stream,
            machine,
            placings: Vec::new(),
            parts: Vec::new(),
            requests: Vec::with_capacity(stream.requests.len()),
            undefined: 0,
            memory: 0,
        };
        let mut known: BTreeMap<(usize, Filter), (usize, FrontEnd)> = BTreeMap::new();
        let mut placed: BTreeMap<(usize, PyramidKind), usize> = BTreeMap::new();
        let (mut base, mut stored_base, mut planes) = (0, 0, 0);
        for request in &stream.requests {
            let filter = request.filter.unwrap_or(filter);
            let key = (request.texture, filter);
            let (part, front_end) = match known.get(&key) {
                Some(known) => *known,
                None => {
                    let placing = match placed.get(&(request.texture, filter.pyramid())) {
                        Some(&placing) => placing,
                        None => {
                            let held =
                                machine.texture.hold(filter.pyramid(), &stream.textures[request.texture].image)?;
                            let placing = run.placings.len();
                            let [bytes, stored] = [held.memory.surface.bytes, held.memory.stored_bytes()];
                            run.memory += stored;
                            run.placings.push(Placing { held, base, stored_base });
                            base = (base + bytes).next_multiple_of(TEXTURE_ALIGNMENT);
                            stored_base = (stored_base + stored).next_multiple_of(TEXTURE_ALIGNMENT);
                            placed.insert((request.texture, filter.pyramid()), placing);
                            placing
                        }
                    };
                    let pyramid = &run.placings[placing].held.pyramid;
                    let front_end = FrontEnd::new(machine, filter, wrap, [pyramid.width, pyramid.height]);
                    let sampler = machine.sampler(filter, wrap, LodSource::Gradient);
                    let first_plane = planes;
                    planes = u16::try_from(usize::from(planes) + pyramid.planes.len()).map_err(|_| {
                        let problem = "more than 65535 planes over all textures and filters";
                        Error::setting("--texture", stream.textures.len(), problem, "split the stream")
                    })?;
                    run.parts.push(Part {
                        texture: request.texture,
                        filter,
                        placing,
                        sampler,
                        requests: 0,
                        first_plane,
                    });
                    known.insert(key, (run.parts.len() - 1, front_end));
                    (run.parts.len() - 1, front_end)
                }
            };
            let (made, undefined) = front_end.request(&request.fragment);
            run.undefined += undefined;
            run.parts[part].requests += 1;
            run.requests.push((part, made));
        }
        let reads = |part: &Part| run.placings[part.placing].held.memory.surface.bytes_per_read();
        if run.parts.iter().any(|part| reads(part) != reads(&run.parts[0])) {
            let problem = "its entries are wider than texels, and a cache has reads of one width";
            return Err(Error::setting("filter", "sat", problem, "give its requests a stream of their own"));
        }
        Ok(run)
    }

    /// Everything at once.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn measure(&self) -> Result<StreamOutcome> {
        let wrong = |problem: String| Error::setting("machine", &self.machine.name, problem, "change the machine");
        let first = &self.placings[self.parts[0].placing].held.memory;
        let bytes = first.surface.bytes_per_read();
        let planes = self.parts.iter().map(|part| self.placings[part.placing].held.memory.surface.planes.len()).sum();
        let mut counted = cache(self.machine, bytes)?.with_planes(planes);
        if first.is_decompressed() {
            let textures = self.placings.iter().filter_map(|Placing { held, base, stored_base }| {
                let stored = held.memory.compressed.as_ref()?;
                Some(Decompressed { held: (&held.memory.surface, *base), stored: (stored, *stored_base) })
            });
            counted = counted.with_decompressor(Arc::new(StoredLines::new(self.machine.cache.line, textures)));
        }
        let mut parameters = self.machine.timing.parameters();
        parameters.data_bank_bytes = parameters.data_bank_bytes.max(bytes.next_power_of_two());
        let memory = self.machine.memory.parameters();
        let mut timing =
            Timing::new(&parameters, &memory, counted.clone(), 4, ()).map_err(|error| wrong(error.to_string()))?;
        let mut units = Vec::new();
        for part in &self.parts {
            let memory = &self.placings[part.placing].held.memory;
            let unit = Unit::new(&part.sampler, &memory.surface, &memory.bytes);
            units.push(unit.map_err(|error| wrong(error.to_string()))?);
        }
        let mut responses = vec![Response::default(); self.requests.len()];
        let (mut taps, mut same, mut begin) = (Vec::new(), Vec::new(), 0);
        for run in self.requests.chunk_by(|(part, _), (next, _)| part == next) {
            let (part, end) = (run[0].0, begin + run.len());
            let Part { placing, first_plane, .. } = self.parts[part];
            let base = self.placings[placing].base;
            same.clear();
            same.extend(run.iter().map(|(_, request)| *request));
            let mut sink = Placed { inner: &mut counted, base, first_plane, taps: &mut taps };
            units[part].run(&same, &mut responses[begin..end], &mut sink);
            let mut sink = Placed { inner: &mut timing, base, first_plane, taps: &mut taps };
            units[part].addresses(&same, &mut sink);
            begin = end;
        }
        Ok(StreamOutcome {
            counters: counted.counters(),
            parts: self.parts_of(&counted.planes()),
            timing: timing.counters(),
            memory: self.memory,
            undefined: self.undefined,
            mismatches: self.mismatches(&responses)?,
            against_truth: self.against_truth(&responses),
            responses,
        })
    }

    fn parts_of(&self, planes: &[PlaneCounters]) -> Vec<PartOutcome> {
        let part = |part: &Part| {
            let count = self.placings[part.placing].held.memory.surface.planes.len();
            let mut traffic = PlaneCounters::default();
            for row in planes.iter().skip(part.first_plane.into()).take(count) {
                traffic.lookups += row.lookups;
                traffic.hits += row.hits;
                traffic.misses += row.misses;
            }
            PartOutcome { texture: part.texture, filter: part.filter, requests: part.requests, traffic }
        };
        self.parts.iter().map(part).collect()
    }

    fn mismatches(&self, responses: &[Response]) -> Result<u64> {
        let references: Vec<Reference<'_>> = self
            .parts
            .iter()
            .map(|part| Reference::new(&self.placings[part.placing].held.pyramid, &part.sampler))
            .collect::<Result<_>>()?;
        let differs = |((part, request), response): (&(usize, Request), &Response)| {
            u64::from(references[*part].sample(request) != *response)
        };
        Ok(self.requests.par_iter().zip(responses).map(differs).sum())
    }

    fn against_truth(&self, responses: &[Response]) -> Deviation {
        let sampling = Supersampling { samples: 8, jitter: false };
        let truths: Vec<[f32; 4]> = self
            .stream
            .requests
            .par_iter()
            .zip(&self.requests)
            .map(|(request, (part, _))| {
                let top = &self.placings[self.parts[*part].placing].held.pyramid.planes[0];
                let texel = |x: u32, y: u32| top.texels[y as usize * top.width as usize + x as usize];
                let wrap = self.parts[*part].sampler.address;
                footprint_average(sampling, texel, [top.width, top.height], wrap, &request.fragment)
            })
            .collect();
        let mut sum = Deviation::default();
        for (response, truth) in responses.iter().zip(truths) {
            sum.add(response.texel.map(f64::from), truth.map(f64::from));
        }
        sum
    }
}
