//! Taps that change no answer: those of weight zero, and those that read what another tap of their request reads.
//!
//! The weights of a request sum to a power of two, so leaving out a zero and adding up two weights of equal taps changes no bit
//! in any rounding (docs/leaving-out.md).

use crate::address::Footprint;

/// A tap is compared with so many of those its request has already: no program of equal taps issues more than four.
const COMPARED: usize = 4;

/// Whether both read the same texels at the same fractions.
#[inline]
fn read_the_same(one: &Footprint, other: &Footprint) -> bool {
    one.plane == other.plane
        && one.address == other.address
        && one.fraction == other.fraction
        && one.positions == other.positions
}

/// Moves the taps that count to the front, sets the end of each request, and returns how many taps there are. Requests have `each`
/// taps, or else end where `ends` says.
#[inline]
pub(crate) fn leave_out(taps: &mut [Footprint], ends: &mut [u32], each: Option<usize>) -> usize {
    let (mut read, mut kept) = (0, 0);
    for end in ends {
        let until = match each {
            Some(each) => read + each,
            None => *end as usize,
        };
        let begin = kept;
        for at in read..until {
            let tap = taps[at];
            if tap.weight == 0 {
                continue;
            }
            let known = taps[begin..kept].iter_mut().take(COMPARED).find(|known| read_the_same(known, &tap));
            if let Some(known) = known {
                known.weight += tap.weight;
            } else {
                taps[kept] = tap;
                kept += 1;
            }
        }
        read = until;
        *end = kept as u32;
    }
    kept
}
