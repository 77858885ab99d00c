//! How much of each fetched line is ever used.

use bitvec::{bitvec, order::Lsb0, vec::BitVec};

use super::{Geometry, GeometryError, Observer, Outcome};

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

    /// The marks, laid open once for many lookups.
    #[inline(always)]
    pub(super) fn marks(&mut self) -> Marks<'_> {
        let Self { texel_shift, texel_mask, words, .. } = *self;
        Marks { texel_shift, texel_mask, words, marks: self.marks.as_raw_mut_slice(), left: &mut self.left }
    }
}

/// The marks of a [`LineUse`] as words.
pub(super) struct Marks<'a> {
    texel_shift: u32,
    texel_mask: u64,
    words: usize,
    marks: &'a mut [u64],
    left: &'a mut u64,
}

impl Marks<'_> {
    /// Marks texels of one line, which is where `outcome` says.
    #[inline(always)]
    pub(super) fn run<const TEXELS: usize>(&mut self, addresses: &[u64; TEXELS], outcome: Outcome) {
        let slot = outcome.slot() as usize;
        if matches!(outcome, Outcome::Miss { evicted: Some(_), .. }) {
            self.refill(slot);
        }
        self.again(addresses, slot);
    }

    /// The same for a line that is in `slot`.
    #[inline(always)]
    pub(super) fn again<const TEXELS: usize>(&mut self, addresses: &[u64; TEXELS], slot: usize) {
        let texels = addresses.map(|address| address >> self.texel_shift & self.texel_mask);
        if self.words == 1 {
            self.marks[slot] |= texels.iter().fold(0, |marks, texel| marks | 1 << texel);
        } else {
            for texel in texels {
                self.marks[slot * self.words + (texel / 64) as usize] |= 1 << (texel % 64);
            }
        }
    }

    #[inline(never)]
    fn refill(&mut self, slot: usize) {
        for word in &mut self.marks[slot * self.words..(slot + 1) * self.words] {
            *self.left += u64::from(word.count_ones());
            *word = 0;
        }
    }
}

impl Observer for LineUse {
    #[inline(always)]
    fn lookup(&mut self, address: u64, _: u64, outcome: Outcome) {
        self.marks().run(&[address], outcome);
    }
}
