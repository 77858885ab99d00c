//! The datapath in lanes (see `datapath`): 8 fraction bits, one rounding.
//!
//! Every sum is exact. The horizontal step works in words of 16 bits, where 255 * 256 fits. The vertical one is a multiply-add of signed
//! words, so 2^15 is taken from every horizontal sum, which takes 2^23 from the vertical one; the last step gives it back. The step
//! between levels is taken modulo 2^32, and its result is below that.

use super::{address::Taps, machine::Machine, room::Texels};

/// What the vertical step lacks of the weighted sum of a tap.
pub(super) const LACK: i32 = 1 << 23;

/// Weighted sums of bilinear taps, less [`LACK`]: of red and blue in turns, then of green and alpha; in each, taps 0 and 1 of every four,
/// then taps 2 and 3.
#[derive(Clone, Copy)]
pub(super) struct Sums<M: Machine>(pub(super) [M::Words; 4]);

/// A weight a tap, in the order of [`Sums`].
#[inline(always)]
fn spread<M: Machine>(m: M, weight: M::Words) -> [M::Words; 2] {
    [m.unpack_low(weight, weight), m.unpack_high(weight, weight)]
}

/// Two columns of red and blue, or of green and alpha, made one; `start` is the left column times 256, less 2^15, and so is the result.
#[inline(always)]
fn horizontal<M: Machine>(m: M, start: M::Words, left: M::Words, right: M::Words, fraction: M::Words) -> M::Words {
    m.add16(start, m.mul16(m.sub16(right, left), fraction))
}

/// A row of two texels: red and blue, green and alpha.
#[inline(always)]
fn row<M: Machine>(m: M, left: M::Words, right: M::Words, fraction: M::Words) -> [M::Words; 2] {
    let low = m.splat16(0xFF);
    // A channel less 128, as its bits are: flipping the top one subtracts.
    let less = m.xor(left, m.splat16(0x8080u16.cast_signed()));
    [
        horizontal(m, m.shl16(less, 8), m.and(left, low), m.and(right, low), fraction),
        horizontal(m, m.and_not(low, less), m.shr16(left, 8), m.shr16(right, 8), fraction),
    ]
}

/// Weighted sums of taps.
#[inline(always)]
pub(super) fn bilinear<M: Machine>(m: M, texels: Texels<'_>, taps: &Taps<M>) -> Sums<M> {
    let [c00, c10, c01, c11] = taps.corners;
    let [f, g] = taps.fractions;
    let fraction = m.or(f, m.shl(f, 16));
    let top = row(m, m.texels(texels, c00), m.texels(texels, c10), fraction);
    let bottom = row(m, m.texels(texels, c01), m.texels(texels, c11), fraction);
    // 256 - g for the top, g for the bottom.
    let weights = m.sub(m.add(m.shl(g, 16), m.splat(256)), g);
    let [low, high] = spread(m, weights);
    Sums([
        m.multiply_add16(m.unpack_low16(top[0], bottom[0]), low),
        m.multiply_add16(m.unpack_high16(top[0], bottom[0]), high),
        m.multiply_add16(m.unpack_low16(top[1], bottom[1]), low),
        m.multiply_add16(m.unpack_high16(top[1], bottom[1]), high),
    ])
}

/// Texels from their channels, words of 32 bits.
#[inline(always)]
fn packed<M: Machine>(m: M, [rb_low, rb_high, ga_low, ga_high]: [M::Words; 4]) -> M::Words {
    let red_blue = m.pack(rb_low, rb_high);
    let green_alpha = m.pack(ga_low, ga_high);
    m.or(red_blue, m.shl16(green_alpha, 8))
}

/// One word a channel and two taps: which half of a spread weight goes with each.
const HALF: [usize; 4] = [0, 1, 0, 1];

/// Texels of one tap each.
#[inline(always)]
pub(super) fn one<M: Machine>(m: M, sums: Sums<M>) -> M::Words {
    let mut channels = sums.0;
    for channel in &mut channels {
        *channel = m.shr(m.add(*channel, m.splat(LACK + (1 << 15))), 16);
    }
    packed(m, channels)
}

/// 256 times the way from one tap to the other, `t` of 256, less 256 times [`LACK`].
#[inline(always)]
fn between<M: Machine>(m: M, from: Sums<M>, to: Sums<M>, t: M::Words) -> [M::Words; 4] {
    let t = spread(m, t);
    let mut channels = from.0;
    for (number, channel) in channels.iter_mut().enumerate() {
        let way = m.mul(m.sub(to.0[number], *channel), t[HALF[number]]);
        *channel = m.add(m.shl(*channel, 8), way);
    }
    channels
}

/// Texels of two taps each.
#[inline(always)]
pub(super) fn two<M: Machine>(m: M, from: Sums<M>, to: Sums<M>, t: M::Words) -> M::Words {
    let mut channels = between(m, from, to, t);
    for channel in &mut channels {
        let sum = m.add(*channel, m.splat(((LACK as u32) << 8).wrapping_add(1 << 23).cast_signed()));
        *channel = m.shr(sum, 24);
    }
    packed(m, channels)
}

/// Texels of two pairs of taps each, both pairs weighing the same.
#[inline(always)]
pub(super) fn mean_of_two<M: Machine>(m: M, [(a, b, t), (c, d, u)]: [(Sums<M>, Sums<M>, M::Words); 2]) -> M::Words {
    let (mut channels, others) = (whole(m, between(m, a, b, t)), whole(m, between(m, c, d, u)));
    for (number, channel) in channels.iter_mut().enumerate() {
        // Half of the sum, without its carry.
        let (both, either) = (m.and(*channel, others[number]), m.xor(*channel, others[number]));
        let half = m.add(both, m.shr(either, 1));
        *channel = m.shr(m.add(half, m.splat(1 << 23)), 24);
    }
    packed(m, channels)
}

/// Texels of two pairs of taps each: the first weight within the pairs, the second from one pair to the other.
#[inline(always)]
pub(super) fn four<M: Machine>(m: M, [a, b, c, d]: [Sums<M>; 4], [t, between_pairs]: [M::Words; 2]) -> M::Words {
    let (mut channels, others) = (whole(m, between(m, a, b, t)), whole(m, between(m, c, d, t)));
    let t = spread(m, between_pairs);
    let s = spread(m, m.sub(m.splat(256), between_pairs));
    let half = m.splat64(1 << 31);
    for (number, channel) in channels.iter_mut().enumerate() {
        let (s, t) = (s[HALF[number]], t[HALF[number]]);
        // Both lanes of 32 bits in a lane of 64 are channels of one tap: their weights are the same.
        let even = m.add64(m.mul_even_unsigned(*channel, s), m.mul_even_unsigned(others[number], t));
        let odd =
            m.add64(m.mul_even_unsigned(m.shr64(*channel, 32), s), m.mul_even_unsigned(m.shr64(others[number], 32), t));
        let even = m.shr64(m.add64(even, half), 32);
        *channel = m.alternate(even, m.add64(odd, half));
    }
    packed(m, channels)
}

/// Gives back what the sums lack.
#[inline(always)]
fn whole<M: Machine>(m: M, mut channels: [M::Words; 4]) -> [M::Words; 4] {
    for channel in &mut channels {
        *channel = m.add(*channel, m.splat(((LACK as u32) << 8).cast_signed()));
    }
    channels
}
