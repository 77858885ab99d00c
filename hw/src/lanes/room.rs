//! The one room where unsafe code may live: loads and stores through pointers, and the door into code compiled for AVX2.
//!
//! Nothing here trusts its caller. A gather takes a table or a picture, not a pointer, and lanes that point past its end read
//! nothing; a store takes a reference to exactly what it fills.
#![allow(unsafe_code)]

use core::{arch::x86_64::*, mem::offset_of};

use alloc::vec::Vec;

use super::{LANES, filter, kernel::Kernel};
use crate::{
    address::Footprint,
    datapath::Texel,
    request::{Request, Response},
};

cpufeatures::new!(avx2, "avx2");

/// Proof that this machine has AVX2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(());

impl Avx2 {
    /// The proof, where it can be had.
    pub(super) fn detect() -> Option<Self> {
        avx2::get().then_some(Self(()))
    }

    /// Runs the kernel; see [`Kernel::run`].
    #[inline]
    pub(super) fn run<const ANSWER: bool, const WRITE: bool>(
        self,
        kernel: &Kernel<'_>,
        requests: &[[Request; LANES]],
        responses: &mut [[Response; LANES]],
        footprints: &mut [Footprint],
    ) {
        // SAFETY: it is unsafe to call only where there is no AVX2, and `self` is the proof that there is.
        unsafe { kernel.run::<ANSWER, WRITE>(requests, responses, footprints) }
    }

    /// Filters taps; see [`filter::of_footprints`].
    #[inline]
    pub(super) fn filter(
        self,
        texels: Texels<'_>,
        taps: &[Footprint],
        ends: impl Iterator<Item = usize>,
        weight_bits: u32,
        answer: impl FnMut(Texel),
    ) {
        // SAFETY: as above.
        unsafe { filter::of_footprints(texels, taps, ends, weight_bits, answer) }
    }
}

/// A table that eight lanes may read at once: two entries at least, fewer than 2^31.
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

    /// The entries at eight indices; an index past the end reads the last entry.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn gather(&self, index: __m256i) -> __m256i {
        let index = _mm256_min_epu32(index, _mm256_set1_epi32((self.0.len() - 1) as i32));
        // SAFETY: each index is at most the last entry's, and below 2^31, so it is not read as a negative number.
        unsafe { _mm256_i32gather_epi32::<4>(self.0.as_ptr().cast(), index) }
    }

    /// The entries at eight indices and the entries that follow them; an index past the end reads the last two.
    ///
    /// One load of 64 bits brings both, so this costs what one gather of eight does.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn gather_pairs(&self, index: __m256i) -> [__m256i; 2] {
        let index = _mm256_min_epu32(index, _mm256_set1_epi32((self.0.len() - 2) as i32));
        // Lanes 0 1 4 5 and 2 3 6 7: the order from which one shuffle a half restores 0 to 7.
        let order = _mm256_permute4x64_epi64::<0b11_01_10_00>(index);
        let entries = self.0.as_ptr().cast();
        // SAFETY: each index is at most the last entry's but one, so 8 bytes from it are in the table, and it is below 2^31. The loads
        // of a gather need no alignment.
        let [low, high] = unsafe {
            [
                _mm256_i32gather_epi64::<4>(entries, _mm256_castsi256_si128(order)),
                _mm256_i32gather_epi64::<4>(entries, _mm256_extracti128_si256::<1>(order)),
            ]
        };
        let [low, high] = [_mm256_castsi256_ps(low), _mm256_castsi256_ps(high)];
        [
            _mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(low, high)),
            _mm256_castps_si256(_mm256_shuffle_ps::<0b11_01_11_01>(low, high)),
        ]
    }
}

/// RGBA8 texels that eight lanes may read at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texels<'m> {
    bytes: &'m [u8],
    /// Whole texels, at least 1 and fewer than 2^31.
    count: u32,
}

impl<'m> Texels<'m> {
    /// The texels of a memory, if their number is right.
    pub(super) fn new(bytes: &'m [u8]) -> Option<Self> {
        let count = bytes.len() / 4;
        (1..1 << 31).contains(&count).then_some(Self { bytes, count: count as u32 })
    }

    /// The texels at eight indices, transparent black past the end.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(super) fn gather(&self, index: __m256i) -> __m256i {
        let last = _mm256_set1_epi32((self.count - 1) as i32);
        let inside = _mm256_cmpeq_epi32(_mm256_min_epu32(index, last), index);
        // SAFETY: only lanes inside are loaded; their four bytes are in the memory, and they are below 2^31. The loads of a gather
        // need no alignment.
        unsafe {
            _mm256_mask_i32gather_epi32::<4>(_mm256_setzero_si256(), self.bytes.as_ptr().cast(), index, inside)
        }
    }
}

/// The first four words of a request: coordinates and scales.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn load_head(request: &Request) -> __m128i {
    // SAFETY: 16 bytes of a request, which is `repr(C)`, all of them integers of four; the load needs no alignment.
    unsafe { _mm_loadu_si128(core::ptr::from_ref(request).cast()) }
}

/// The four addresses of a footprint.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn load_addresses(footprint: &Footprint) -> __m256i {
    // SAFETY: 32 bytes of an array of four words of 64 bits; the load needs no alignment.
    unsafe { _mm256_loadu_si256(footprint.address.as_ptr().cast()) }
}

// The loads above and the stores below take these as words.
const _: () = assert!(offset_of!(Request, u) == 0 && offset_of!(Request, v) == 4 && offset_of!(Request, scale) == 8);
const _: () = assert!(size_of::<Response>() == 8 && size_of::<Footprint>() == 48);

/// Fills eight responses: the texel, and the two levels as the halves of a word.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn store_responses(responses: &mut [Response; 8], texel: __m256i, lod: __m256i) {
    let [low, high] = [_mm256_unpacklo_epi32(texel, lod), _mm256_unpackhi_epi32(texel, lod)];
    let to: *mut __m256i = responses.as_mut_ptr().cast();
    // SAFETY: eight responses are the 64 bytes of these two stores, which need no alignment, and any bits are a response: `repr(C)`, four
    // bytes and two words of 16 bits.
    unsafe {
        _mm256_storeu_si256(to, _mm256_permute2x128_si256::<0x20>(low, high));
        _mm256_storeu_si256(to.add(1), _mm256_permute2x128_si256::<0x31>(low, high));
    }
}

/// Fills one footprint: the four addresses, and the 16 bytes after them.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn store_footprint(footprint: &mut Footprint, addresses: __m256i, rest: __m128i) {
    let to: *mut __m256i = core::ptr::from_mut(footprint).cast();
    // SAFETY: a footprint is the 48 bytes of these two stores, which need no alignment, and any bits are a footprint: `repr(C)`, integers
    // only, padding in the last four bytes.
    unsafe {
        _mm256_storeu_si256(to, addresses);
        _mm_storeu_si128(to.add(1).cast(), rest);
    }
}
