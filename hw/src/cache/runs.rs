//! The texel reads of a batch as runs: texels of a tap in one line are looked up once, and no outcome changes.
//!
//! The second and later texels of a line hit whatever the policy, and change no order. Taps are divided into runs in a loop of its
//! own, which asks nothing of the cache, so that it needs no branch that a host could guess wrong; the lookups are the next loop.

use alloc::vec::Vec;

use super::{Cache, Engine, Geometry, Outcome, PlaneCounters, Policy};
use crate::{
    address::is_outside,
    address_stream::{AddressBatch, Places, PlanePairs},
    lanes::{LANES, PLACES, RunLanes, RunShape},
};

/// Texels of a tap that lie in one line. The first decides; the others hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub(crate) struct Run {
    /// Number of the line.
    pub(crate) line: u64,
    /// Which texels of it, as [`Told`] says.
    pub(super) texels: u32,
    /// Number of the tap in its batch, and the bit [`REPEATED`](Self::REPEATED); once it has been looked up, what an observer noted in its place.
    tap: u32,
}

impl Run {
    /// Another run of the tap may be of the same line.
    const REPEATED: u32 = 1 << 31;

    pub(crate) const fn tap(&self) -> usize {
        (self.tap & !Self::REPEATED) as usize
    }

    pub(crate) const fn is_repeated(&self) -> bool {
        self.tap & Self::REPEATED != 0
    }

    /// Notes what came of the lookup. Of which tap the run is, is forgotten.
    #[inline(always)]
    pub(crate) const fn note(&mut self, outcome: u32) {
        self.tap = outcome;
    }

    /// What was noted.
    #[inline(always)]
    pub(crate) const fn noted(&self) -> u32 {
        self.tap
    }
}

/// The runs of taps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Runs<'s> {
    /// All of them, tap by tap.
    pub(crate) runs: &'s [Run],
    pub(crate) taps: TapsOfRuns<'s>,
    /// More than the number of any plane read so far.
    pub(crate) planes: usize,
}

/// What is known of the taps that runs are of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TapsOfRuns<'s> {
    /// How many runs each has, and the bit [`REPEATED`](Self::REPEATED).
    pub(crate) counts: &'s [u8],
    /// Storage index of the plane of each.
    pub(crate) planes: &'s [u32],
    /// The same two by two.
    pub(crate) pairs: &'s PlanePairs,
}

impl TapsOfRuns<'_> {
    /// Runs of the tap may be of one line.
    pub(crate) const REPEATED: u8 = 1 << 7;
}

/// How the texels of a run are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Told {
    /// A bit each, of lines of at most 32 texels.
    Bits,
    /// The numbers of four, eight bits each, which may be of one texel, of lines of at most 256.
    Four,
    /// The number of the only one.
    One,
}

impl Told {
    /// Of lines of so many texels.
    pub(super) const fn of(texels: u64) -> Self {
        match texels {
            0..=32 => Self::Bits,
            33..=256 => Self::Four,
            _ => Self::One,
        }
    }

    /// One texel, of this number.
    #[inline(always)]
    pub(super) const fn one(self, number: u32) -> u32 {
        match self {
            Self::Bits => 1 << number,
            Self::Four => number * 0x0101_0101,
            Self::One => number,
        }
    }

    /// Texels of these numbers, which are four at most, and not told by the number of only one.
    #[inline(always)]
    fn all(self, numbers: &[u32]) -> u32 {
        match self {
            Self::Bits => numbers.iter().fold(0, |texels, number| texels | 1 << number),
            _ => (0..4).fold(0, |texels, place| texels | numbers[place % numbers.len()] << (8 * place)),
        }
    }
}

/// What watches a cache that is read run by run.
pub(crate) trait RunObserver {
    /// What takes the hits of a stretch of runs without a miss.
    type Hits<'h>: RunHits
    where
        Self: 'h;

    /// A stretch begins.
    fn hits(&mut self) -> Self::Hits<'_>;
    /// A run was read, and its line was there.
    fn hit(&mut self, run: &mut Run, slot: u32);
    /// A run was read, and its line was not there; `evicted` is the line that had to leave.
    fn miss(&mut self, run: &mut Run, slot: u32, evicted: Option<u64>);
}

/// Hits one after the other. What is needed for them is laid open for as long, so that a host can have it in registers.
pub(crate) trait RunHits {
    /// A run was read, and its line was there; false if the observer must be told instead.
    fn hit(&mut self, run: &mut Run, slot: u32) -> bool;
    /// The stretch ends.
    fn close(self);
}

impl RunObserver for () {
    type Hits<'h> = ();

    #[inline(always)]
    fn hits(&mut self) {}
    #[inline(always)]
    fn hit(&mut self, _: &mut Run, _: u32) {}
    #[inline(always)]
    fn miss(&mut self, _: &mut Run, _: u32, _: Option<u64>) {}
}

impl RunHits for () {
    #[inline(always)]
    fn hit(&mut self, _: &mut Run, _: u32) -> bool {
        true
    }
    #[inline(always)]
    fn close(self) {}
}

/// Only the first of them may leave a hit to be told otherwise.
impl<A: RunHits, B: RunHits> RunHits for (A, B) {
    #[inline(always)]
    fn hit(&mut self, run: &mut Run, slot: u32) -> bool {
        self.0.hit(run, slot) && self.1.hit(run, slot)
    }
    #[inline(always)]
    fn close(self) {
        self.0.close();
        self.1.close();
    }
}

/// One after the other.
impl<A: RunObserver, B: RunObserver> RunObserver for (&mut A, &mut B) {
    type Hits<'h>
        = (A::Hits<'h>, B::Hits<'h>)
    where
        Self: 'h;

    #[inline(always)]
    fn hits(&mut self) -> Self::Hits<'_> {
        (self.0.hits(), self.1.hits())
    }
    #[inline(always)]
    fn hit(&mut self, run: &mut Run, slot: u32) {
        self.0.hit(run, slot);
        self.1.hit(run, slot);
    }
    #[inline(always)]
    fn miss(&mut self, run: &mut Run, slot: u32, evicted: Option<u64>) {
        self.0.miss(run, slot, evicted);
        self.1.miss(run, slot, evicted);
    }
}

/// Which set a line is in.
#[derive(Clone, Copy, Debug)]
pub(super) struct SetOf {
    sets: u64,
    /// Sets less one where they are a power of two; else all ones.
    mask: u64,
}

impl SetOf {
    pub(super) fn new(geometry: Geometry) -> Self {
        let sets = u64::from(geometry.sets);
        Self { sets, mask: if sets.is_power_of_two() { sets - 1 } else { u64::MAX } }
    }

    #[inline(always)]
    pub(super) fn set(self, line: u64) -> usize {
        (if self.mask == u64::MAX { line % self.sets } else { line & self.mask }) as usize
    }
}

/// Divides taps into runs.
#[derive(Clone, Debug)]
pub(super) struct Splitter {
    line_shift: u32,
    texel_shift: u32,
    /// Texels of a line, less one.
    texel_mask: u64,
    set_of: SetOf,
    /// A line just used is not the next victim, unless it is the only one of its set.
    protects: bool,
    told: Told,
    lanes: Option<(RunLanes, RunShape)>,
    runs: Vec<Run>,
    /// How many each tap has.
    counts: Vec<u8>,
    /// Storage index of the plane of each tap, where lanes have not written it.
    planes: Vec<u32>,
    pairs: PlanePairs,
}

impl Splitter {
    pub(super) fn new(geometry: Geometry, policy: Policy, texel: u32) -> Self {
        let (line_shift, texel_shift) = (geometry.line.trailing_zeros(), texel.trailing_zeros());
        let protects = geometry.ways > 1 && matches!(policy, Policy::Lru | Policy::Plru);
        let set_mask = if protects { None } else { Some(geometry.sets.wrapping_sub(1)) };
        let shape = RunShape { line_shift, texel_shift, set_mask };
        let told = Told::of((geometry.line / texel).into());
        let suits = told == Told::Bits && (protects || geometry.sets.is_power_of_two());
        Self {
            line_shift,
            texel_shift,
            texel_mask: u64::from(geometry.line / texel - 1),
            set_of: SetOf::new(geometry),
            protects,
            told,
            lanes: RunLanes::detect().filter(|_| suits).map(|lanes| (lanes, shape)),
            runs: Vec::new(),
            counts: Vec::new(),
            planes: Vec::new(),
            pairs: PlanePairs::default(),
        }
    }

    /// The runs of a batch, to be looked up, what is known of its taps, and the number of texels read; `counters` counts those of each plane.
    pub(super) fn split<'s>(
        &'s mut self,
        batch: AddressBatch<'s>,
        counters: &mut [PlaneCounters],
    ) -> (&'s mut [Run], TapsOfRuns<'s>, u64) {
        let (taps, number_of_taps, texels) = (batch.taps, batch.taps(), batch.texels_per_tap);
        // As many as there can be, and what eight taps may write to.
        let most = 4 * number_of_taps + PLACES;
        if self.runs.len() < most {
            self.runs.resize(most, Run::default());
        }
        self.counts.resize(number_of_taps, 0);
        let (mut runs, mut counts) = (core::mem::take(&mut self.runs), core::mem::take(&mut self.counts));
        let whole = texels == 4 && self.told != Told::One;
        let planes = match taps {
            Places::Rows(rows, taps) => &rows.planes[..taps],
            Places::Footprints(taps) => {
                self.planes.clear();
                self.planes.extend(taps.iter().map(|tap| u32::from(tap.plane)));
                &self.planes
            }
        };
        self.pairs.count(planes);
        self.pairs.for_each(|of, times| {
            of.iter().for_each(|&plane| counters[plane as usize].lookups += times * texels as u64);
        });
        let (mut number, mut count, mut outside) = (0, 0, 0);
        while number < number_of_taps {
            let mut next = number;
            if let Some((lanes, shape)) = self.lanes.filter(|_| whole) {
                // Mostly all of them.
                let (found, written) =
                    lanes.write(taps, number / LANES, shape, &mut runs[count..], &mut counts[number..]);
                next += found * LANES;
                count += written;
            }
            // What lanes leave, eight at most.
            number = number_of_taps.min(next + LANES);
            for number in next..number {
                let (before, addresses) = (count, taps.addresses(number));
                if let Some((pair, runs_of_tap)) = if whole { self.pair(number, addresses) } else { None } {
                    runs[count..count + 2].copy_from_slice(&pair);
                    count += runs_of_tap;
                } else {
                    let singles = self.one_by_one(number, &addresses[..texels], &mut runs[count..]);
                    count += singles;
                    outside += texels - singles;
                    counters[planes[number] as usize].lookups -= (texels - singles) as u64;
                }
                let repeated = runs[before..count].iter().any(Run::is_repeated);
                counts[number] = (count - before) as u8 | if repeated { TapsOfRuns::REPEATED } else { 0 };
            }
        }
        let lookups = number_of_taps * texels - outside;
        (self.runs, self.counts) = (runs, counts);
        let of_taps = TapsOfRuns { counts: &self.counts, planes, pairs: &self.pairs };
        (&mut self.runs[..count], of_taps, lookups as u64)
    }

    /// One or two runs that four texels make, and how many; `None` if they make more, or some are outside.
    fn pair(&self, number: usize, addresses: [u64; 4]) -> Option<([Run; 2], usize)> {
        let [a, b, c, d] = addresses;
        let lines = addresses.map(|address| address >> self.line_shift);
        let in_rows = lines[0] == lines[1] && lines[2] == lines[3];
        // Left, right, left, right: the second round finds and leaves everything as the first left it.
        let in_columns = lines[0] == lines[2]
            && lines[1] == lines[3]
            && (in_rows || self.protects || self.set_of.set(lines[0]) != self.set_of.set(lines[1]));
        if is_outside(a | b | c | d) || !(in_rows || in_columns) {
            return None;
        }
        let [a, b, c, d] = addresses.map(|address| (address >> self.texel_shift & self.texel_mask) as u32);
        let run = |line, texels: &[u32]| Run { line, texels: self.told.all(texels), tap: number as u32 };
        Some(match (in_rows, in_columns) {
            (true, true) => ([run(lines[0], &[a, b, c, d]); 2], 1),
            (true, false) => ([run(lines[0], &[a, b]), run(lines[2], &[c, d])], 2),
            _ => ([run(lines[0], &[a, c]), run(lines[1], &[b, d])], 2),
        })
    }

    /// A run for every texel inside the texture; how many.
    #[inline(never)]
    fn one_by_one(&self, number: usize, addresses: &[u64], runs: &mut [Run]) -> usize {
        let mut count = 0;
        for (&address, run) in addresses.iter().filter(|&&address| !is_outside(address)).zip(&mut *runs) {
            let texel = (address >> self.texel_shift & self.texel_mask) as u32;
            *run = Run { line: address >> self.line_shift, texels: self.told.one(texel), tap: number as u32 };
            count += 1;
        }
        let runs = &mut runs[..count];
        if (1..count).any(|number| runs[..number].iter().any(|before| before.line == runs[number].line)) {
            runs.iter_mut().for_each(|run| run.tap |= Run::REPEATED);
        }
        count
    }
}

impl Cache {
    /// Looks up runs of `lookups` texels in all.
    #[inline(always)]
    pub(super) fn access_runs(&mut self, runs: &mut [Run], lookups: u64, observer: &mut impl RunObserver) {
        let mut misses = 0;
        // A loop for each way to find a set, and in it nothing that would keep a host from holding all it needs in registers.
        macro_rules! access {
            ($tags:ident, $set:expr) => {{
                let mut runs = runs.iter_mut();
                loop {
                    let mut hits = observer.hits();
                    let told = $tags.access_until(&mut runs, $set, |run, outcome| match outcome {
                        Outcome::Hit { slot } => hits.hit(run, slot),
                        Outcome::Miss { .. } => false,
                    });
                    hits.close();
                    match told {
                        None => break,
                        Some((run, Outcome::Hit { slot })) => observer.hit(run, slot),
                        Some((run, Outcome::Miss { slot, evicted })) => {
                            misses += 1;
                            observer.miss(run, slot, evicted);
                        }
                    }
                }
            }};
        }
        let power_of_two = self.geometry.sets.is_power_of_two();
        with_engine!(&mut self.engine, tags => if power_of_two {
            access!(tags, |line, sets| line as usize & (sets - 1))
        } else {
            access!(tags, |line, sets| (line % sets as u64) as usize)
        });
        self.lookups += lookups;
        self.misses += misses;
    }
}
