//! The one room where unsafe code may live: the machine's vector instructions, loads and stores through pointers, and the doors into code
//! compiled for them.
//!
//! Nothing here trusts its caller. That a machine has an instruction is proved by a value that only detection makes. A gather takes a table
//! or a memory, not a pointer, and lanes that point past its end read nothing; a store takes a reference to exactly what it fills.
#![allow(unsafe_code)]

use core::{arch::x86_64::*, mem::offset_of};

use alloc::vec::Vec;

use super::{
    Kept, LANES,
    banks::{self, Banks},
    changes::{self, EIGHT},
    footprints,
    kernel::Kernel,
    run_shape::RunShape,
    runs, uses,
};
use crate::{
    address::Footprint,
    address_stream::{Places, TapRows},
    cache::Run,
    datapath::Texel,
    request::{Request, Response},
};

mod avx2;
mod avx512;

pub(super) use avx2::Avx2;
pub(super) use avx512::Avx512;

/// [`Kernel::run`] in code compiled for a machine: a `#[target_feature]` takes no features of a generic parameter.
macro_rules! compiled_for {
    ($machine:ident, $features:literal) => {
        impl $machine {
            /// [`Kernel::run`] in code compiled for this machine.
            pub(super) fn run(
                self,
                kernel: &Kernel<'_>,
                requests: &[Request],
                responses: Option<&mut [Response]>,
                rows: Option<&mut TapRows>,
                first: usize,
            ) {
                #[target_feature(enable = $features)]
                fn compiled(
                    m: $machine,
                    kernel: &Kernel<'_>,
                    requests: &[Request],
                    responses: Option<&mut [Response]>,
                    rows: Option<&mut TapRows>,
                    first: usize,
                ) {
                    kernel.run(m, requests, responses, rows, first);
                }
                // SAFETY: it is unsafe to call only where one of these is missing, and `self` is the proof that none is.
                unsafe { compiled(self, kernel, requests, responses, rows, first) }
            }
        }
    };
}

compiled_for!(Avx2, "avx2");
compiled_for!(Avx512, "avx2,avx512f,avx512bw");

impl Avx2 {
    /// [`footprints::filter`] in code compiled for AVX2.
    #[inline]
    pub(super) fn filter(
        self,
        texels: Texels<'_>,
        taps: &[Footprint],
        ends: impl Iterator<Item = usize>,
        weight_bits: u32,
        answer: impl FnMut(Texel),
    ) {
        // SAFETY: it is unsafe to call only where there is no AVX2, and `self` is the proof that there is.
        unsafe { footprints::filter(self, texels, taps, ends, weight_bits, answer) }
    }

    /// [`runs::write`] in code compiled for AVX2.
    #[inline(always)]
    pub(super) fn write_runs(
        self,
        taps: Places<'_>,
        first: usize,
        shape: RunShape,
        runs: &mut [Run],
        counts: &mut [[u8; LANES]],
    ) -> (usize, usize) {
        // SAFETY: as above.
        unsafe { runs::write(self, taps, first, shape, runs, counts) }
    }

    /// [`changes::keep_fours`] in code compiled for AVX2.
    #[inline(always)]
    pub(super) fn keep_changes(self, addresses: &[[u64; EIGHT]], last: u64, line_shift: u32, kept: &mut Kept) -> usize {
        // SAFETY: as above.
        unsafe { changes::keep_fours(self, addresses, last, line_shift, kept) }
    }

    /// [`uses::move_last`] in code compiled for AVX2.
    #[inline(always)]
    pub(super) fn move_last_uses(self, log: &mut [u32], first: usize, last: &[u32]) -> (usize, usize) {
        // SAFETY: as above.
        unsafe { uses::move_last(self, log, first, last) }
    }

    /// [`banks::look`] in code compiled for AVX2.
    #[inline(always)]
    pub(super) fn look_at_banks(
        self,
        taps: Places<'_>,
        first: usize,
        banks: [Banks; 2],
        clashes: &mut [[u8; LANES]],
    ) -> (usize, bool) {
        // SAFETY: as above.
        unsafe { banks::look(self, taps, first, banks, clashes) }
    }
}

impl Avx512 {
    /// [`changes::keep_eights`] in code compiled for this machine.
    #[inline(always)]
    pub(super) fn keep_changes(self, addresses: &[[u64; EIGHT]], last: u64, line_shift: u32, kept: &mut Kept) -> usize {
        // SAFETY: it is unsafe to call only where one of its features is missing, and `self` is the proof that none is.
        unsafe { changes::keep_eights(self, addresses, last, line_shift, kept) }
    }

    /// Eight words of 64 bits.
    #[inline(always)]
    pub(super) fn load_eight(self, words: &[u64; EIGHT]) -> __m512i {
        // SAFETY: `self` proves the instruction; 64 bytes of an array of as many; the load needs no alignment.
        unsafe { _mm512_loadu_si512(words.as_ptr().cast()) }
    }

    /// Fills eight words of 64 bits.
    #[inline(always)]
    pub(super) fn store_eight(self, words: &mut [u64; EIGHT], register: __m512i) {
        // SAFETY: `self` proves the instruction; 64 bytes of an array of as many; the store needs no alignment.
        unsafe { _mm512_storeu_si512(words.as_mut_ptr().cast(), register) }
    }
}

/// A table that all lanes may read at once: two entries at least, fewer than 2^31.
#[derive(Clone, Debug)]
pub(super) struct Table(Vec<u32>);

impl Table {
    /// A table of these entries, if their number is right.
    pub(super) fn new(entries: Vec<u32>) -> Option<Self> {
        (2..1 << 31).contains(&entries.len()).then_some(Self(entries))
    }

    /// The entries.
    #[inline]
    pub(super) fn entries(&self) -> &[u32] {
        &self.0
    }

    /// Where they are, and the index of the last, at least 1.
    #[inline(always)]
    fn entries_and_last(&self) -> (*const i32, i32) {
        (self.0.as_ptr().cast(), (self.0.len() - 1) as i32)
    }
}

/// RGBA8 texels that all lanes may read at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texels<'m> {
    bytes: &'m [u8],
    /// Index of the last whole texel, below 2^30: its address is a number of 32 bits, which is what lanes look at.
    last: i32,
}

impl<'m> Texels<'m> {
    /// The texels of a memory, if their number is right.
    pub(super) fn new(bytes: &'m [u8]) -> Option<Self> {
        let count = bytes.len() / 4;
        (1..=1 << 30).contains(&count).then(|| Self { bytes, last: (count - 1) as i32 })
    }

    /// Where they are, and the index of the last.
    #[inline(always)]
    fn first_and_last(self) -> (*const i32, i32) {
        (self.bytes.as_ptr().cast(), self.last)
    }
}

// Loads and stores below, and those of the machines, take these as words.
const _: () = assert!(offset_of!(Request, u) == 0 && offset_of!(Request, v) == 4 && offset_of!(Request, scale) == 8);
const _: () = assert!(size_of::<Response>() == 8);
const _: () = assert!(size_of::<Run>() == 16);

/// Asks for what is so many bytes after this, as many bytes as this has: a hint, of nothing that need exist.
#[inline(always)]
pub(super) fn ask_ahead<T>(now: &[T], distance: usize) {
    let first: *const i8 = now.as_ptr().cast();
    for line in (0..size_of_val(now)).step_by(64) {
        // SAFETY: a prefetch reads nothing and traps on nothing; every machine with vectors has it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(distance + line)) }
    }
}

/// The first four words of a request: coordinates and scales.
#[inline(always)]
fn load_head(request: &Request) -> __m128i {
    // SAFETY: 16 bytes of a request, which is `repr(C)`, all of them integers of four; the load needs no alignment.
    unsafe { _mm_loadu_si128(core::ptr::from_ref(request).cast()) }
}

impl Avx2 {
    /// The four addresses of a footprint.
    #[inline(always)]
    pub(super) fn load_addresses(self, footprint: &Footprint) -> __m256i {
        // SAFETY: `self` proves the instruction; 32 bytes of an array of four words of 64 bits; the load needs no alignment.
        unsafe { _mm256_loadu_si256(footprint.address.as_ptr().cast()) }
    }

    /// The words at some indices; an index past the end reads the last word.
    ///
    /// # Panics
    /// If there is no word, or 2^31 or more.
    #[inline(always)]
    pub(super) fn gather_words(self, words: &[u32], index: __m256i) -> __m256i {
        assert!((1..=1 << 31).contains(&words.len()), "an index is a number of 31 bits");
        let last = (words.len() - 1) as i32;
        // SAFETY: `self` proves the instructions; each index is at most the last word's, and below 2^31, so it is not read as a negative
        // number. The loads of a gather need no alignment.
        unsafe {
            let within = _mm256_min_epu32(index, _mm256_set1_epi32(last));
            _mm256_i32gather_epi32::<4>(words.as_ptr().cast(), within)
        }
    }

    /// Four words of 64 bits.
    #[inline(always)]
    pub(super) fn load_four(self, words: &[u64; 4]) -> __m256i {
        // SAFETY: `self` proves the instruction; 32 bytes of an array of as many; the load needs no alignment.
        unsafe { _mm256_loadu_si256(words.as_ptr().cast()) }
    }

    /// Eight words.
    #[inline(always)]
    pub(super) fn load_words(self, words: &[u32; LANES]) -> __m256i {
        // SAFETY: as above.
        unsafe { _mm256_loadu_si256(words.as_ptr().cast()) }
    }

    /// Four words.
    #[inline(always)]
    pub(super) fn load_four_words(self, words: &[u32; 4]) -> __m128i {
        // SAFETY: `self` proves the instruction; 16 bytes of an array of as many; the load needs no alignment.
        unsafe { _mm_loadu_si128(words.as_ptr().cast()) }
    }

    /// Fills four words.
    #[inline(always)]
    pub(super) fn store_four_words(self, words: &mut [u32; 4], register: __m128i) {
        // SAFETY: `self` proves the instruction; 16 bytes of an array of as many; the store needs no alignment.
        unsafe { _mm_storeu_si128(words.as_mut_ptr().cast(), register) }
    }

    /// Fills four words of 64 bits.
    #[inline(always)]
    pub(super) fn store_four(self, words: &mut [u64; 4], register: __m256i) {
        // SAFETY: `self` proves the instruction; 32 bytes of an array of as many; the store needs no alignment.
        unsafe { _mm256_storeu_si256(words.as_mut_ptr().cast(), register) }
    }

    /// Fills four runs, the halves of registers: the line in two words, the texels, the tap.
    #[inline(always)]
    pub(super) fn store_runs(self, runs: &mut [Run; 4], [low, high]: [__m256i; 2]) {
        let to: *mut __m256i = runs.as_mut_ptr().cast();
        // SAFETY: `self` proves the instructions. Four runs are the 64 bytes of these stores, which need no alignment, and any bits are a run:
        // `repr(C)`, integers only.
        unsafe {
            _mm256_storeu_si256(to, low);
            _mm256_storeu_si256(to.add(1), high);
        }
    }
}
