//! From floats to 12.20 (docs/numerics.md, sections 1.1 and 9): the oracle of the chip's integer conversion and of the front
//! end's vectors.

use texunit_hw::AddressMode;

use super::coordinate::TURN;

/// The range of a 32-bit word.
const WORD: f64 = 4_294_967_296.0;

/// A coordinate of any size as the 12.20 integer of a request, and whether it was undefined and so became zero.
///
/// Takes an f32 as `f64::from`, which is exact.
///
/// ```
/// use texunit::reference::front_end::to_fixed;
/// use texunit_hw::AddressMode::{Clamp, Wrap};
/// assert_eq!(to_fixed(-(2.0_f64.powi(-26)), Wrap), (-1, false)); // floor, not truncation
/// assert_eq!(to_fixed(1e300, Clamp), (i32::MAX, false));
/// assert_eq!(to_fixed(f64::NAN, Clamp), (0, true));
/// ```
#[must_use]
pub fn to_fixed(x: f64, mode: AddressMode) -> (i32, bool) {
    if x.is_nan() {
        return (0, true);
    }
    match mode {
        AddressMode::Wrap | AddressMode::Mirror if x.is_infinite() => (0, true),
        AddressMode::Wrap | AddressMode::Mirror => {
            // fmod is exact and leaves the sign of x, so multiplying by 2^20 cannot overflow and the floor sees every bit.
            let k = (libm::fmod(x, WORD / TURN) * TURN).floor();
            let unsigned = k - WORD * (k / WORD).floor();
            let signed = if unsigned >= WORD / 2.0 { unsigned - WORD } else { unsigned };
            (signed as i32, false)
        }
        // Overflow to infinity and the infinities themselves saturate.
        AddressMode::Clamp | AddressMode::Clip => {
            ((x * TURN).floor().clamp(-WORD / 2.0, WORD / 2.0 - 1.0) as i32, false)
        }
    }
}

/// A component of a footprint axis as the 12.20 integer of a request: to nearest, half up, saturating.
///
/// ```
/// use texunit::reference::front_end::vector_to_fixed;
/// assert_eq!(vector_to_fixed(-0.5 / 1_048_576.0), 0);
/// assert_eq!(vector_to_fixed(-1e300), i32::MIN);
/// assert_eq!(vector_to_fixed(f64::NAN), 0);
/// ```
#[must_use]
pub fn vector_to_fixed(x: f64) -> i32 {
    let units = x * TURN;
    let below = units.floor();
    // Adding one half before the floor could round up what is just below a half. A cast saturates, and makes 0 of NaN.
    (if units - below >= 0.5 { below + 1.0 } else { below }) as i32
}
