//! What a cache of texels has counted while it is read run by run: as much as is wanted, each in a loop of its own.

use super::{LineUse, Marks, MissClassifier, PlaneCounters, Run, RunHits, RunObserver, ShadowHits, texel_cache::Meter};

/// The counters of planes, by the taps whose runs are read. On their own: misses, and nothing else.
pub(super) struct PlaneRows<'a> {
    pub(super) planes: &'a mut [PlaneCounters],
    /// By tap.
    pub(super) plane_of: &'a [u32],
}

impl PlaneRows<'_> {
    /// Those of the plane that a run is of.
    #[inline(always)]
    fn of(&mut self, run: &Run) -> &mut PlaneCounters {
        &mut self.planes[self.plane_of[run.tap()] as usize]
    }
}

impl RunObserver for PlaneRows<'_> {
    type Hits<'h>
        = ()
    where
        Self: 'h;

    #[inline(always)]
    fn hits(&mut self) {}
    #[inline(always)]
    fn hit(&mut self, _: &mut Run, _: u32) {}

    #[inline(always)]
    fn miss(&mut self, run: &mut Run, _: u32, _: Option<u64>) {
        self.of(run).misses += 1;
    }
}

/// Every counter, without asking each time which are wanted.
pub(super) struct FullWatch<'a> {
    pub(super) classifier: &'a mut MissClassifier,
    pub(super) marks: Marks<'a, true>,
    pub(super) planes: PlaneRows<'a>,
}

/// Hits of a stretch: their marks, and the shadow's part of them.
pub(super) struct FullHits<'h> {
    marks: Marks<'h, true>,
    shadow: ShadowHits<'h>,
}

impl RunHits for FullHits<'_> {
    #[inline(always)]
    fn hit(&mut self, run: &mut Run, slot: u32) -> bool {
        self.marks.hit(run.texels, slot);
        self.shadow.hit(slot as usize)
    }

    #[inline(always)]
    fn close(self) {
        self.shadow.close();
    }
}

impl RunObserver for FullWatch<'_> {
    type Hits<'h>
        = FullHits<'h>
    where
        Self: 'h;

    #[inline(always)]
    fn hits(&mut self) -> FullHits<'_> {
        FullHits { marks: self.marks.lent(), shadow: self.classifier.hits() }
    }

    #[inline(always)]
    fn hit(&mut self, run: &mut Run, slot: u32) {
        self.marks.hit(run.texels, slot);
        self.classifier.hit(run.line, slot);
    }

    #[inline(always)]
    fn miss(&mut self, run: &mut Run, slot: u32, evicted: Option<u64>) {
        self.marks.miss(run.texels, slot, evicted);
        let class = self.classifier.miss(run.line, slot);
        let row = self.planes.of(run);
        row.classes.count(class);
        row.misses += 1;
    }
}

/// Some counters.
pub(super) struct SomeWatch<'a> {
    pub(super) meter: &'a mut Meter,
    pub(super) planes: PlaneRows<'a>,
}

/// The same, of what is wanted.
pub(super) struct SomeHits<'h> {
    marks: Option<Marks<'h, false>>,
    shadow: Option<ShadowHits<'h>>,
}

impl RunHits for SomeHits<'_> {
    #[inline(always)]
    fn hit(&mut self, run: &mut Run, slot: u32) -> bool {
        if let Some(marks) = &mut self.marks {
            marks.hit(run.texels, slot);
        }
        self.shadow.as_mut().is_none_or(|shadow| shadow.hit(slot as usize))
    }

    #[inline(always)]
    fn close(self) {
        if let Some(shadow) = self.shadow {
            shadow.close();
        }
    }
}

impl RunObserver for SomeWatch<'_> {
    type Hits<'h>
        = SomeHits<'h>
    where
        Self: 'h;

    #[inline(always)]
    fn hits(&mut self) -> SomeHits<'_> {
        let Meter { classifier, line_use, .. } = &mut *self.meter;
        SomeHits { marks: line_use.as_mut().map(LineUse::marks), shadow: classifier.as_mut().map(MissClassifier::hits) }
    }

    #[inline(always)]
    fn hit(&mut self, run: &mut Run, slot: u32) {
        if let Some(line_use) = &mut self.meter.line_use {
            line_use.marks::<false>().hit(run.texels, slot);
        }
        if let Some(classifier) = &mut self.meter.classifier {
            classifier.hit(run.line, slot);
        }
    }

    #[inline(always)]
    fn miss(&mut self, run: &mut Run, slot: u32, evicted: Option<u64>) {
        if let Some(line_use) = &mut self.meter.line_use {
            line_use.marks::<false>().miss(run.texels, slot, evicted);
        }
        let row = self.planes.of(run);
        if let Some(classifier) = &mut self.meter.classifier {
            row.classes.count(classifier.miss(run.line, slot));
        }
        if let Some(fills) = &mut self.meter.fills {
            fills.fill(run.line);
        }
        row.misses += 1;
    }
}
