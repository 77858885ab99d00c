//! Proofs by going through everything: each unit of the chip on every input it can have, against answers that share no arithmetic
//! with it (docs/proof.md).
//!
//! A proof takes the chip as a [`Chip`], so that a test can hand it a broken one and see it caught.

mod address;
mod coordinates;
mod lod;
mod logarithm;
mod weights;

use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::ProgressBar;
use rayon::prelude::*;
use serde::Serialize;
use texunit_hw::{
    AddressMode, Footprint, LevelRounding, Log2, Request, Response, Sampler, Surface, Unit,
    address::AddressUnit,
    coordinate::{Converted, from_f32_bits},
    datapath,
    lod::{LevelRange, raw_level},
};

/// What is proven: every method is a unit of the chip, as built unless overridden.
pub trait Chip: Sync + 'static {
    /// The log2 unit.
    fn raw_level(&self, squared_ratio: u32, log2: Log2) -> i32 {
        raw_level(squared_ratio, log2)
    }
    /// Bias, clamp and rounding of a level with a fraction.
    fn fractional(&self, range: &LevelRange, raw: i32) -> i32 {
        range.fractional(raw)
    }
    /// Bias, clamp and rounding of a whole level.
    fn whole(&self, range: &LevelRange, raw: i32, rounding: LevelRounding) -> i32 {
        range.whole(raw, rounding)
    }
    /// One interpolation of the staged datapath.
    fn lerp(&self, a: u64, b: u64, fraction: u64, bits: u32, half: u64) -> u64 {
        datapath::lerp(a, b, fraction, bits, half)
    }
    /// A bilinear tap on plane 0.
    #[inline(always)]
    fn bilinear(&self, unit: &AddressUnit, u: i64, v: i64) -> Footprint {
        unit.bilinear(0, u, v, 1)
    }
    /// A point tap.
    #[inline(always)]
    fn point(&self, unit: &AddressUnit, plane: usize, u: i64, v: i64) -> Footprint {
        unit.point(plane, u, v, 1)
    }
    /// A float's bits as a coordinate.
    fn convert(&self, bits: u32, mode: AddressMode) -> Converted {
        from_f32_bits(bits, mode)
    }
    /// The whole unit, bound to a texture.
    ///
    /// # Panics
    /// If sampler, surface and bytes do not fit each other: the proofs' own do.
    fn unit<'a>(&self, bound: &Bound<'a>) -> Unit<'a> {
        Unit::new(&bound.sampler, bound.surface, bound.bytes).expect("sampler and texture of a proof fit each other")
    }
    /// Its answers.
    fn answer(&self, unit: &mut Unit<'_>, requests: &[Request], responses: &mut [Response]) {
        unit.run(requests, responses, &mut ());
    }
}

/// The chip as it is built.
#[derive(Clone, Copy, Debug, Default)]
pub struct Built;

impl Chip for Built {}

/// A texture and how it is sampled.
#[derive(Clone, Copy, Debug)]
pub struct Bound<'a> {
    /// The sampler.
    pub sampler: Sampler,
    /// Where texels lie.
    pub surface: &'a Surface,
    /// What lies there.
    pub bytes: &'a [u8],
}

/// What a comparison came to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    /// Inputs compared.
    pub compared: u64,
    /// Inputs whose answer is another than it should be, or breaks a rule.
    pub mismatches: u64,
    /// The first of them, in the order of the inputs.
    pub first: Option<String>,
}

impl Tally {
    /// Counts one input; `told` says what was wrong, once.
    #[inline]
    fn count(&mut self, right: bool, told: impl FnOnce() -> String) {
        self.compared += 1;
        if !right {
            self.mismatches += 1;
            self.first.get_or_insert_with(told);
        }
    }

    /// Both, `self` first.
    #[must_use]
    fn and(self, other: Self) -> Self {
        Self {
            compared: self.compared + other.compared,
            mismatches: self.mismatches + other.mismatches,
            first: self.first.or(other.first),
        }
    }
}

/// How much is done, who is told, and who may stop it.
#[derive(Debug)]
pub struct Work<'w> {
    /// A subset that reaches every rule, instead of everything.
    pub quick: bool,
    /// Moved on with every piece.
    pub bar: ProgressBar,
    /// Ends a proof before its time when set.
    pub stop: &'w AtomicBool,
}

impl Work<'_> {
    /// Every piece, in parallel; the tallies are merged in the order of the pieces, so the result does not depend on the number of
    /// threads. `None` when stopped.
    fn over(&self, pieces: usize, of_piece: impl Fn(usize) -> Tally + Sync) -> Option<Tally> {
        self.bar.inc_length(pieces as u64);
        let piece = |piece| {
            if self.stop.load(Ordering::Relaxed) {
                return None;
            }
            let tally = of_piece(piece);
            self.bar.inc(1);
            Some(tally)
        };
        (0..pieces).into_par_iter().map(piece).try_reduce(Tally::default, |a, b| Some(a.and(b)))
    }
}

/// A proof.
pub struct Proof<C> {
    /// Its name, for `--only`.
    pub name: String,
    /// What is compared with what, over which inputs.
    pub what: String,
    run: Run<C>,
}

type Run<C> = Box<dyn Fn(&C, &Work<'_>) -> Option<Tally>>;

impl<C: Chip> Proof<C> {
    fn new(
        name: impl Into<String>,
        what: impl Into<String>,
        run: impl Fn(&C, &Work<'_>) -> Option<Tally> + 'static,
    ) -> Self {
        Self { name: name.into(), what: what.into(), run: Box::new(run) }
    }

    /// Goes through it; `None` when stopped.
    #[must_use]
    pub fn run(&self, chip: &C, work: &Work<'_>) -> Option<Tally> {
        (self.run)(chip, work)
    }
}

/// Every proof there is, in the order they are run.
///
/// ```
/// use std::sync::atomic::AtomicBool;
/// use texunit::prove::{Built, Work, proofs};
/// let work = Work { quick: true, bar: indicatif::ProgressBar::hidden(), stop: &AtomicBool::new(false) };
/// let lerp = proofs::<Built>().into_iter().find(|proof| proof.name == "lerp").unwrap();
/// let tally = lerp.run(&Built, &work).unwrap();
/// assert_eq!(tally.mismatches, 0);
/// ```
#[must_use]
pub fn proofs<C: Chip>() -> Vec<Proof<C>> {
    [lod::proofs(), weights::proofs(), address::proofs(), coordinates::proofs()].into_iter().flatten().collect()
}
