//! Rounding down.

/// The largest whole number not above a finite one. What `f64::floor` says, without the call it is where the processor's own
/// rounding cannot be assumed: this is asked for every sub-sample and every hair.
#[inline(always)]
pub fn whole(number: f64) -> f64 {
    // Adding 2^52 leaves no bits for a fraction; from there on every number is whole.
    const WHOLE: f64 = 4_503_599_627_370_496.0;
    let nearest = ((number.abs() + WHOLE) - WHOLE).copysign(number);
    let below = if nearest > number { nearest - 1.0 } else { nearest };
    if number.abs() < WHOLE { below } else { number }
}
