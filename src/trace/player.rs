//! Playing requests on the machine of a trace.

use std::{io::Write, path::Path};

use texunit_hw::{
    Request, Response, Sampler, Unit,
    address_stream::{AddressBatch, Sink},
    cache::Cache,
};

use super::{Profile, Record, memory_image};
use crate::{
    error::{Error, Result},
    reference::Reference,
    texture_file::TextureImage,
    texture_memory::Held,
};

/// The machine of a profile, bound to its texture.
#[derive(Clone, Debug)]
pub struct Player {
    sampler: Sampler,
    held: Held,
    cache: Cache,
}

/// Sums over records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Reads of memory.
    pub reads: u64,
    /// Those that missed.
    pub misses: u64,
}

impl Totals {
    /// Of records.
    #[must_use]
    pub fn of(records: &[Record]) -> Self {
        records.iter().fold(Self::default(), |sum, record| Self {
            reads: sum.reads + u64::from(record.reads),
            misses: sum.misses + u64::from(record.misses),
        })
    }
}

impl Player {
    /// Makes the texture a profile names. `trace` is the file the profile was read from.
    ///
    /// # Errors
    /// A texture that is not there or is not the one recorded; a machine that cannot be built.
    pub fn new(profile: &Profile, trace: &Path) -> Result<Self> {
        Self::with_texture(profile, &profile.texture.load(trace)?)
    }

    /// The same with a texture at hand.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn with_texture(profile: &Profile, texture: &TextureImage) -> Result<Self> {
        let machine = &profile.machine;
        machine.check()?;
        let held = machine.texture.hold(profile.filter.pyramid(), texture)?;
        // The texel cache proper refuses what a plain one cannot know: texels larger than a line.
        let cache = crate::experiment::cache(machine, held.memory.surface.bytes_per_read())?.cache().clone();
        Ok(Self { sampler: profile.sampler(), held, cache })
    }

    /// The memory the addresses of this machine point into, in bytes.
    #[must_use]
    pub const fn memory_bytes(&self) -> u64 {
        self.held.memory.surface.bytes
    }

    /// Writes the texture memory the addresses point into, with its planes and `profile`, which this player was made of
    /// (docs/trace-format.md).
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_memory(&self, profile: &Profile, out: &mut dyn Write) -> std::io::Result<()> {
        memory_image::write(profile, &self.held.memory, out)
    }

    fn unit(&self) -> Result<Unit<'_>> {
        Unit::new(&self.sampler, &self.held.memory.surface, &self.held.memory.bytes)
            .map_err(|error| Error::setting("machine", error, "it cannot be built", "see texunit explain"))
    }

    /// What the chip answers, from an empty cache.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn chip(&self, requests: &[Request]) -> Result<Vec<Record>> {
        let mut responses = vec![Response::default(); requests.len()];
        let mut meter = RequestMeter { cache: self.cache.clone(), counts: Vec::with_capacity(requests.len()) };
        self.unit()?.run(requests, &mut responses, &mut meter);
        let answered = requests.iter().zip(responses).zip(meter.counts);
        Ok(answered
            .map(|((request, response), [reads, misses])| Record { request: *request, response, reads, misses })
            .collect())
    }

    /// What the float reference answers.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn reference(&self, requests: &[Request]) -> Result<Vec<Response>> {
        let reference = Reference::new(&self.held.pyramid, &self.sampler)?;
        Ok(requests.iter().map(|request| reference.sample(request)).collect())
    }

    /// Calls `read` with the byte address of each read of memory, in order of issue.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn addresses(&self, requests: &[Request], read: impl FnMut(u64)) -> Result<()> {
        self.unit()?.addresses(requests, &mut Reads(read));
        Ok(())
    }
}

/// Counts reads and misses of each request.
struct RequestMeter {
    cache: Cache,
    counts: Vec<[u16; 2]>,
}

impl Sink for RequestMeter {
    fn take(&mut self, batch: AddressBatch<'_>) {
        let Self { cache, counts } = self;
        let before = counts.len();
        counts.resize(before + batch.len(), [0; 2]);
        batch.for_each_tap(|request, _, addresses| {
            let [reads, misses] = &mut counts[before + request];
            *reads += addresses.len() as u16;
            *misses += addresses.iter().filter(|&&address| !cache.access(address).is_hit()).count() as u16;
        });
    }
}

/// Hands on addresses.
struct Reads<F>(F);

impl<F: FnMut(u64)> Sink for Reads<F> {
    fn take(&mut self, batch: AddressBatch<'_>) {
        batch.for_each_read(|_, address| (self.0)(address));
    }
}
