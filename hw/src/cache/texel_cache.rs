//! The cache as the texture unit uses it: texels in, counts per plane out.

use alloc::{sync::Arc, vec, vec::Vec};

use crate::{
    address_stream::{AddressBatch, Sink},
    decompression::StoredLines,
};

use super::{
    Cache, Counters, Geometry, GeometryError, LineUse, MissClassifier, Observer, Outcome, PlaneCounters, Policy,
    RunObserver, Runs, Splitter, Told,
    watches::{FullWatch, PlaneRows, SomeWatch},
};

/// Which of the dearer counters to keep. What is not kept costs nothing and reads 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Detail {
    /// Misses by class: about the work of a second cache.
    pub classes: bool,
    /// Bytes used of the lines fetched.
    pub line_use: bool,
}

impl Default for Detail {
    /// Everything.
    fn default() -> Self {
        Self { classes: true, line_use: true }
    }
}

/// A [`Cache`] of texels with its [`Counters`], in all and per plane.
///
/// ```
/// use texunit_hw::cache::{Detail, Geometry, Policy, TexelCache};
/// let geometry = Geometry { sets: 64, ways: 4, line: 64 };
/// let mut cache = TexelCache::new(geometry, Policy::Lru, 4, Detail::default())?;
/// cache.read_all(0, &[0x100, 0x104, 0x110, 0x114]); // the four texels of a bilinear tap on plane 0
/// cache.read(1, 0x4000);
/// let counters = cache.counters();
/// assert_eq!((counters.lookups, counters.misses, counters.compulsory), (5, 2, 2));
/// assert_eq!((counters.bytes_requested, counters.bytes_fetched, counters.bytes_used), (20, 128, 20));
/// assert_eq!(cache.planes()[0].hits, 3);
/// # Ok::<(), texunit_hw::cache::GeometryError>(())
/// ```
#[derive(Clone, Debug)]
pub struct TexelCache {
    cache: Cache,
    texel: u32,
    splitter: Splitter,
    meter: Meter,
    planes: Vec<PlaneCounters>,
}

#[derive(Clone, Debug)]
pub(super) struct Meter {
    pub(super) classifier: Option<MissClassifier>,
    pub(super) line_use: Option<LineUse>,
    pub(super) fills: Option<Fills>,
}

/// What filling each line takes from memory.
#[derive(Clone, Debug)]
pub(super) struct Fills {
    behind: Arc<StoredLines>,
    fetched: u64,
}

impl Fills {
    pub(super) fn fill(&mut self, line: u64) {
        self.fetched += self.behind.bytes(line);
    }
}

/// Lends the meter the row of the plane being read.
struct PlaneMeter<'a> {
    meter: &'a mut Meter,
    row: &'a mut PlaneCounters,
}

impl Observer for PlaneMeter<'_> {
    #[inline(always)]
    fn lookup(&mut self, address: u64, line: u64, outcome: Outcome) {
        if let Some(line_use) = &mut self.meter.line_use {
            line_use.lookup(address, line, outcome);
        }
        if let Some(class) = self.meter.classifier.as_mut().and_then(|classifier| classifier.classify(line, outcome)) {
            self.row.classes.count(class);
        }
        if let (Some(fills), false) = (&mut self.meter.fills, outcome.is_hit()) {
            fills.fill(line);
        }
        self.row.misses += u64::from(!outcome.is_hit());
    }
}

/// Two observers, one after the other.
struct Watched<'a, 'o, O>(PlaneMeter<'a>, &'o mut O);

impl<O: Observer> Observer for Watched<'_, '_, O> {
    #[inline(always)]
    fn lookup(&mut self, address: u64, line: u64, outcome: Outcome) {
        self.0.lookup(address, line, outcome);
        self.1.lookup(address, line, outcome);
    }
}

impl TexelCache {
    /// An empty cache of texels of `texel` bytes (a power of two, at most a line).
    ///
    /// # Errors
    /// What [`Geometry::check`] and [`LineUse::new`] refuse.
    pub fn new(geometry: Geometry, policy: Policy, texel: u32, detail: Detail) -> Result<Self, GeometryError> {
        let cache = Cache::new(geometry, policy)?;
        let line_use = LineUse::new(geometry, texel)?;
        let classifier = if detail.classes { Some(MissClassifier::new(geometry)?) } else { None };
        let meter = Meter { classifier, line_use: detail.line_use.then_some(line_use), fills: None };
        Ok(Self { cache, texel, splitter: Splitter::new(geometry, policy, texel), meter, planes: vec![] })
    }

    /// Has memory behind a decompressor: filling a line fetches what is stored behind it, not a line of bytes.
    #[must_use]
    pub fn with_decompressor(mut self, behind: Arc<StoredLines>) -> Self {
        self.meter.fills = Some(Fills { behind, fetched: 0 });
        self
    }

    /// What is stored behind its lines, where a decompressor stands between.
    pub(crate) fn stored_lines(&self) -> Option<Arc<StoredLines>> {
        self.meter.fills.as_ref().map(|fills| fills.behind.clone())
    }

    /// Counts `planes` planes from the start: more than a batch's surface has, where several textures share the cache and their
    /// planes are numbered on.
    #[must_use]
    pub fn with_planes(mut self, planes: usize) -> Self {
        self.planes.resize(planes, PlaneCounters::default());
        self
    }

    /// Reads one texel of a plane by its byte address.
    #[inline]
    pub fn read(&mut self, plane: usize, address: u64) -> Outcome {
        let line = self.cache.geometry().line_number(address);
        let outcome = self.cache.access(address);
        let mut meter = Self::plane(&mut self.planes, &mut self.meter, plane);
        meter.lookup(address, line, outcome);
        meter.row.lookups += 1;
        outcome
    }

    /// Reads texels of a plane one after the other: a tap, a footprint, or a whole row of them.
    #[inline]
    pub fn read_all(&mut self, plane: usize, addresses: &[u64]) {
        let mut meter = Self::plane(&mut self.planes, &mut self.meter, plane);
        meter.row.lookups += addresses.len() as u64;
        self.cache.access_all(addresses, &mut meter);
    }

    /// The same, with someone watching every lookup.
    #[inline]
    pub fn read_observed(&mut self, plane: usize, addresses: &[u64], observer: &mut impl Observer) {
        let meter = Self::plane(&mut self.planes, &mut self.meter, plane);
        meter.row.lookups += addresses.len() as u64;
        self.cache.access_all(addresses, &mut Watched(meter, observer));
    }

    /// Bytes of one read.
    #[must_use]
    pub const fn bytes_per_read(&self) -> u32 {
        self.texel
    }

    #[inline(always)]
    fn plane<'a>(planes: &'a mut Vec<PlaneCounters>, meter: &'a mut Meter, plane: usize) -> PlaneMeter<'a> {
        if plane >= planes.len() {
            planes.resize(plane + 1, PlaneCounters::default());
        }
        PlaneMeter { meter, row: &mut planes[plane] }
    }

    /// Totals so far. Lines still in the cache count as used as far as they were used until now.
    #[must_use]
    pub fn counters(&self) -> Counters {
        let (lookups, misses) = (self.cache.lookups(), self.cache.misses());
        let classes = self.meter.classifier.as_ref().map(MissClassifier::classes).unwrap_or_default();
        let bytes_filled = misses * u64::from(self.cache.geometry().line);
        Counters {
            lookups,
            hits: lookups - misses,
            misses,
            compulsory: classes.compulsory,
            capacity: classes.capacity,
            conflict: classes.conflict,
            fills: misses,
            evictions: self.cache.evictions(),
            bytes_requested: lookups * u64::from(self.texel),
            bytes_fetched: self.meter.fills.as_ref().map_or(bytes_filled, |fills| fills.fetched),
            bytes_filled,
            bytes_used: self.meter.line_use.as_ref().map_or(0, LineUse::bytes_used),
        }
    }

    /// The same per plane, up to the highest plane read so far.
    #[must_use]
    pub fn planes(&self) -> Vec<PlaneCounters> {
        self.planes.iter().map(|row| PlaneCounters { hits: row.lookups - row.misses, ..*row }).collect()
    }

    /// The cache within.
    #[must_use]
    pub const fn cache(&self) -> &Cache {
        &self.cache
    }
}

impl TexelCache {
    /// Reads the taps of a batch, of a layout that keeps a texel together, with someone watching. The answer is the runs it read.
    #[inline]
    pub(crate) fn take_observed<'s>(
        &'s mut self,
        batch: AddressBatch<'s>,
        observer: &mut impl RunObserver,
    ) -> Runs<'s> {
        let planes = batch.surface.planes.len();
        if self.planes.len() < planes {
            self.planes.resize(planes, PlaneCounters::default());
        }
        let planes = &mut self.planes[..];
        let (runs, taps, lookups) = self.splitter.split(batch, planes);
        let mut planes = PlaneRows { planes, plane_of: taps.planes };
        match &mut self.meter {
            Meter { classifier: Some(classifier), line_use: Some(line_use), fills: None }
                if line_use.told() == Told::Bits =>
            {
                let watch = &mut FullWatch { classifier, marks: line_use.marks(), planes };
                self.cache.access_runs(runs, lookups, &mut (watch, observer));
            }
            Meter { classifier: None, line_use: None, fills: None } => {
                self.cache.access_runs(runs, lookups, &mut (&mut planes, observer));
            }
            meter => {
                let watch = &mut SomeWatch { meter, planes };
                self.cache.access_runs(runs, lookups, &mut (watch, observer));
            }
        }
        Runs { runs, taps, planes: self.planes.len() }
    }
}

impl Sink for TexelCache {
    /// Reads the taps of a batch, texel by texel, in order of issue.
    #[inline]
    fn take(&mut self, batch: AddressBatch<'_>) {
        if batch.surface.reads_per_texel() > 1 {
            return batch.for_each_read(|plane, address| {
                self.read(plane, address);
            });
        }
        self.take_observed(batch, &mut ());
    }
}
