//! A cache read tap by tap: what is known of neighbours saves lookups, and changes no outcome.
//!
//! Texels of a tap in one line are looked up once: the second and later ones hit whatever the policy, and change no order. And a
//! request whose texels lie in the very lines of the request before, one by one, hits throughout and leaves the cache as it
//! was: its order of use is that of the last uses, which repeat.

use super::{Cache, Engine, Outcome, Policy};
use crate::address::{Footprint, is_outside};

/// What watches a cache that is read tap by tap.
pub(crate) trait TapObserver {
    /// A tap on this plane begins, of so many texels that are read.
    fn tap(&mut self, plane: u16, texels: u64);
    /// Texels of one line were read, one after the other; `outcome` is that of the first, the others hit.
    fn run<const TEXELS: usize>(&mut self, addresses: &[u64; TEXELS], line: u64, outcome: Outcome);
    /// The same, of a request that repeats the one before: a hit in `slot` that changes no order of use.
    fn again<const TEXELS: usize>(&mut self, addresses: &[u64; TEXELS], line: u64, slot: u32);
}

impl TapObserver for () {
    #[inline(always)]
    fn tap(&mut self, _: u16, _: u64) {}
    #[inline(always)]
    fn run<const TEXELS: usize>(&mut self, _: &[u64; TEXELS], _: u64, _: Outcome) {}
    #[inline(always)]
    fn again<const TEXELS: usize>(&mut self, _: &[u64; TEXELS], _: u64, _: u32) {}
}

/// One after the other.
impl<A: TapObserver, B: TapObserver> TapObserver for (&mut A, &mut B) {
    #[inline(always)]
    fn tap(&mut self, plane: u16, texels: u64) {
        self.0.tap(plane, texels);
        self.1.tap(plane, texels);
    }
    #[inline(always)]
    fn run<const TEXELS: usize>(&mut self, addresses: &[u64; TEXELS], line: u64, outcome: Outcome) {
        self.0.run(addresses, line, outcome);
        self.1.run(addresses, line, outcome);
    }
    #[inline(always)]
    fn again<const TEXELS: usize>(&mut self, addresses: &[u64; TEXELS], line: u64, slot: u32) {
        self.0.again(addresses, line, slot);
        self.1.again(addresses, line, slot);
    }
}

/// Most taps of a request that is held against the one before.
const TAPS: usize = 4;

/// Whoever takes the runs of a tap.
trait Runs {
    fn run<const TEXELS: usize>(&mut self, addresses: &[u64; TEXELS], line: u64);
}

/// Takes the runs of texels of one line of a tap of four, in order; `keeps_last` where a line just used is no victim.
#[inline(always)]
fn runs_of(tap: &Footprint, shift: u32, keeps_last: impl Fn(u64, u64) -> bool, runs: &mut impl Runs) {
    let [a, b, c, d] = tap.address;
    let lines = [a >> shift, b >> shift, c >> shift, d >> shift];
    let one_column = lines[0] == lines[1] && lines[2] == lines[3];
    let one_row = lines[0] == lines[2] && lines[1] == lines[3];
    if one_column && one_row {
        runs.run(&tap.address, lines[0]);
    } else if one_column {
        runs.run(&[a, b], lines[0]);
        runs.run(&[c, d], lines[2]);
    } else if one_row && keeps_last(lines[0], lines[1]) {
        // Left, right, left, right: the second round finds and leaves everything as the first left it.
        runs.run(&[a, c], lines[0]);
        runs.run(&[b, d], lines[1]);
    } else {
        for (address, line) in tap.address.into_iter().zip(lines) {
            runs.run(&[address], line);
        }
    }
}

/// What a request did, as far as the next one may repeat it.
#[derive(Default)]
struct Done {
    runs: usize,
    misses: u64,
    slots: [u32; 4 * TAPS],
}

struct LookedUp<'a, F, O> {
    access: F,
    done: &'a mut Done,
    observer: &'a mut O,
}

impl<F: FnMut(u64) -> Outcome, O: TapObserver> Runs for LookedUp<'_, F, O> {
    #[inline(always)]
    fn run<const TEXELS: usize>(&mut self, addresses: &[u64; TEXELS], line: u64) {
        let outcome = (self.access)(line);
        self.done.misses += u64::from(!outcome.is_hit());
        self.done.slots[self.done.runs % (4 * TAPS)] = outcome.slot();
        self.done.runs += 1;
        self.observer.run(addresses, line, outcome);
    }
}

struct Repeated<'a, O> {
    slots: core::slice::Iter<'a, u32>,
    observer: &'a mut O,
}

impl<O: TapObserver> Runs for Repeated<'_, O> {
    #[inline(always)]
    fn run<const TEXELS: usize>(&mut self, addresses: &[u64; TEXELS], line: u64) {
        let slot = self.slots.next().copied().unwrap_or_default();
        self.observer.again(addresses, line, slot);
    }
}

/// Whether every texel lies in the line of its counterpart, and none outside.
#[inline(always)]
fn in_the_same_lines(before: &[Footprint], now: &[Footprint], shift: u32) -> bool {
    let differing = before.iter().zip(now).fold(0, |differing, (before, now)| {
        (0..4).fold(differing, |differing, i| differing | before.address[i] ^ now.address[i])
    });
    differing >> shift == 0
}

impl Cache {
    /// Looks up the texels of taps in order of issue, `taps_per_request` of them a request where all have as many.
    #[inline(always)]
    pub(super) fn access_taps(
        &mut self,
        taps: &[Footprint],
        texels: usize,
        taps_per_request: Option<usize>,
        observer: &mut impl TapObserver,
    ) {
        let shift = self.geometry.line.trailing_zeros();
        let sets = u64::from(self.geometry.sets);
        let mask = if sets.is_power_of_two() { sets - 1 } else { u64::MAX };
        let set_of = |line: u64| if mask == u64::MAX { line % sets } else { line & mask } as usize;
        // A line just used is not the next victim of these policies, unless it is the only one.
        let ways = self.geometry.ways as usize;
        let protects = ways > 1 && matches!(self.policy, Policy::Lru | Policy::Plru);
        let keeps_last = |left: u64, right: u64| protects || set_of(left) != set_of(right);
        // Of so many runs, LRU still holds every line.
        let held = if self.policy == Policy::Lru { ways } else { 0 };
        let period = taps_per_request.filter(|&taps| taps <= TAPS && texels == 4);
        let (mut lookups, mut misses) = (0, 0);
        let mut done = Done::default();
        let mut before: Option<&[Footprint]> = None;
        with_engine!(&mut self.engine, tags => for request in taps.chunks(period.unwrap_or(taps.len()).max(1)) {
            if let Some(before) = before && in_the_same_lines(before, request, shift) {
                let mut repeated = Repeated { slots: done.slots.iter(), observer: &mut *observer };
                for tap in request {
                    repeated.observer.tap(tap.plane, 4);
                    runs_of(tap, shift, keeps_last, &mut repeated);
                }
                lookups += 4 * request.len() as u64;
                continue;
            }
            done.runs = 0;
            done.misses = 0;
            let mut inside = true;
            for tap in request {
                let access = |line: u64| tags.access(set_of(line), line);
                let [a, b, c, d] = tap.address;
                if texels == 1 || is_outside(a | b | c | d) {
                    inside = false;
                    let read = tap.address[..texels].iter().filter(|&&address| !is_outside(address));
                    observer.tap(tap.plane, read.clone().count() as u64);
                    let mut looked_up = LookedUp { access, done: &mut done, observer: &mut *observer };
                    for &address in read {
                        lookups += 1;
                        looked_up.run(&[address], address >> shift);
                    }
                } else {
                    lookups += 4;
                    observer.tap(tap.plane, 4);
                    let mut looked_up = LookedUp { access, done: &mut done, observer: &mut *observer };
                    runs_of(tap, shift, keeps_last, &mut looked_up);
                }
            }
            misses += done.misses;
            let stays = inside && (done.misses == 0 || done.runs <= held);
            before = (stays && period.is_some()).then_some(request);
        });
        self.lookups += lookups;
        self.misses += misses;
    }
}
