//! How much of each fetched line is ever used.

use bitvec::{bitvec, order::Lsb0, vec::BitVec};

use super::{Geometry, GeometryError, Observer, Outcome, Told};

/// Marks the texels read of every line in a cache, of which it must see every lookup from the first on.
///
/// ```
/// use texunit_hw::cache::{Cache, Geometry, LineUse, Policy};
/// let geometry = Geometry { sets: 1, ways: 1, line: 64 };
/// let mut cache = Cache::new(geometry, Policy::Lru)?;
/// let mut line_use = LineUse::new(geometry, 4)?;
/// cache.access_all(&[0, 4, 4, 7, 64], &mut line_use); // two texels of line 0, one of line 1
/// assert_eq!(line_use.bytes_used(), 12);
/// # Ok::<(), texunit_hw::cache::GeometryError>(())
/// ```
#[derive(Clone, Debug)]
pub struct LineUse {
    texel_shift: u32,
    /// Texels of a line, less one.
    texel_mask: u64,
    /// Words of marks per slot.
    words: usize,
    /// One bit a texel, `64 * words` a slot.
    marks: BitVec<u64, Lsb0>,
    /// Texels used of lines that have left.
    left: u64,
}

impl LineUse {
    /// For a new cache of this shape, read in aligned pieces of `texel` bytes (a power of two, at most a line): whoever
    /// reads a byte of a piece uses all of it.
    ///
    /// # Errors
    /// What [`Geometry::check`] refuses, and texels that are no power of two or do not fit a line.
    pub fn new(geometry: Geometry, texel: u32) -> Result<Self, GeometryError> {
        geometry.check()?;
        if !texel.is_power_of_two() || texel > geometry.line {
            return Err(GeometryError {
                key: "texel",
                value: texel,
                problem: "texels are a power of two of bytes and never straddle lines",
                remedy: "give a line size of at least one texel",
            });
        }
        let texels = geometry.line / texel;
        let words = texels.div_ceil(64) as usize;
        Ok(Self {
            texel_shift: texel.trailing_zeros(),
            texel_mask: u64::from(texels - 1),
            words,
            marks: bitvec![u64, Lsb0; 0; geometry.lines() as usize * words * 64],
            left: 0,
        })
    }

    /// Bytes used of all lines fetched so far, whether they are still there or not; a byte counts once per fetch.
    #[must_use]
    pub fn bytes_used(&self) -> u64 {
        let resident: u64 = self.marks.as_raw_slice().iter().map(|word| u64::from(word.count_ones())).sum();
        (self.left + resident) << self.texel_shift
    }

    /// How a [`Run`](super::Run) tells the texels of a line.
    pub(super) const fn told(&self) -> Told {
        Told::of(self.texel_mask + 1)
    }

    /// The marks, laid open once for many lookups.
    #[inline(always)]
    pub(super) fn marks<const MARKED: bool>(&mut self) -> Marks<'_, MARKED> {
        let told = self.told();
        debug_assert!(told == Told::Bits || !MARKED);
        Marks { words: self.words, told, marks: self.marks.as_raw_mut_slice(), left: &mut self.left }
    }
}

/// The marks of a [`LineUse`] as words; texels are told by a bit each for certain if `MARKED`.
pub(super) struct Marks<'a, const MARKED: bool> {
    words: usize,
    told: Told,
    marks: &'a mut [u64],
    left: &'a mut u64,
}

impl<const MARKED: bool> Marks<'_, MARKED> {
    /// The same marks for a while.
    #[inline(always)]
    pub(super) fn lent(&mut self) -> Marks<'_, MARKED> {
        Marks { words: self.words, told: self.told, marks: self.marks, left: self.left }
    }

    /// Marks texels of the line in `slot`, told as a [`Run`](super::Run) tells them.
    #[inline(always)]
    pub(super) fn hit(&mut self, texels: u32, slot: u32) {
        let first = slot as usize * if MARKED { 1 } else { self.words };
        let mut mark = |number: u32| self.marks[first + (number / 64) as usize] |= 1 << (number % 64);
        match if MARKED { Told::Bits } else { self.told } {
            Told::Bits => self.marks[first] |= u64::from(texels),
            Told::Four => texels.to_le_bytes().into_iter().for_each(|number| mark(number.into())),
            Told::One => mark(texels),
        }
    }

    /// The same of a line that has just come to `slot`.
    #[inline(always)]
    pub(super) fn miss(&mut self, texels: u32, slot: u32, evicted: Option<u64>) {
        if evicted.is_some() {
            let (first, words) = (slot as usize * self.words, if MARKED { 1 } else { self.words });
            *self.left += take_marks(&mut self.marks[first..first + words]);
        }
        self.hit(texels, slot);
    }
}

/// The number of marks, which are gone then.
#[inline(always)]
fn take_marks(words: &mut [u64]) -> u64 {
    words.iter_mut().map(|word| u64::from(core::mem::take(word).count_ones())).sum()
}

impl Observer for LineUse {
    #[inline(always)]
    fn lookup(&mut self, address: u64, _: u64, outcome: Outcome) {
        let number = (address >> self.texel_shift & self.texel_mask) as u32;
        let texels = self.told().one(number);
        match outcome {
            Outcome::Hit { slot } => self.marks::<false>().hit(texels, slot),
            Outcome::Miss { slot, evicted } => self.marks::<false>().miss(texels, slot, evicted),
        }
    }
}
