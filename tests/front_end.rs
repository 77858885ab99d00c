//! The conversion of floats to 12.20 against docs/numerics.md, section 1.1.

use proptest::prelude::*;
use texunit::reference::front_end::to_fixed;
use texunit_hw::AddressMode::{self, Clamp, Clip, Mirror, Wrap};

const MODES: [AddressMode; 4] = [Wrap, Mirror, Clamp, Clip];

#[test]
fn special_values_convert_as_the_table_says() {
    let tiny = f64::exp2(-20.0);
    // wrap and mirror; clamp and clip.
    let rows = [
        (0.0, (0, false), (0, false)),
        (-0.0, (0, false), (0, false)),
        (-f64::exp2(-26.0), (-1, false), (-1, false)),
        (-f64::from_bits(1), (-1, false), (-1, false)),
        (f64::from_bits(1), (0, false), (0, false)),
        (1.0 - f64::exp2(-24.0), (0xf_ffff, false), (0xf_ffff, false)),
        (2048.0 - tiny, (i32::MAX, false), (i32::MAX, false)),
        (2048.0, (i32::MIN, false), (i32::MAX, false)),
        (-2048.0, (i32::MIN, false), (i32::MIN, false)),
        (-2048.0 - tiny, (i32::MAX, false), (i32::MIN, false)),
        (4096.5, (0x8_0000, false), (i32::MAX, false)),
        (-4096.5, (-0x8_0000, false), (i32::MIN, false)),
        (f64::MAX, (0, false), (i32::MAX, false)),
        (f64::MIN, (0, false), (i32::MIN, false)),
        (f64::INFINITY, (0, true), (i32::MAX, false)),
        (f64::NEG_INFINITY, (0, true), (i32::MIN, false)),
        (f64::NAN, (0, true), (0, true)),
    ];
    for (x, repeating, saturating) in rows {
        for (mode, expected) in MODES.into_iter().zip([repeating, repeating, saturating, saturating]) {
            assert_eq!(to_fixed(x, mode), expected, "{mode:?} of {x:e}");
        }
    }
}

/// `floor(x * 2^20)` of a finite f64 from its fields: whole, if it fits 128 bits, and modulo 2^32.
fn by_bits(x: f64) -> (Option<i128>, u32) {
    let bits = x.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, i128::from(bits & ((1 << 52) - 1)));
    let magnitude = if field == 0 { fraction } else { fraction | 1 << 52 };
    let signed = if bits >> 63 == 1 { -magnitude } else { magnitude };
    match field.max(1) - 1075 + 20 {
        74.. => (None, 0),
        shift @ 0.. => (Some(signed << shift), (signed << shift) as u32),
        shift => (Some(signed >> (-shift).min(127)), (signed >> (-shift).min(127)) as u32),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn every_float_converts_by_floor(
        x in prop_oneof![
            any::<u64>().prop_map(f64::from_bits),
            any::<u32>().prop_map(|bits| f64::from(f32::from_bits(bits))),
            -5000.0..5000.0,
            -1e30..1e30,
            any::<i64>().prop_map(|k| k as f64 / 1_048_576.0),
        ],
    ) {
        prop_assume!(x.is_finite());
        let (whole, low) = by_bits(x);
        let far = if x > 0.0 { i128::MAX } else { i128::MIN };
        let saturated = whole.unwrap_or(far).clamp(i32::MIN.into(), i32::MAX.into()) as i32;
        for mode in [Wrap, Mirror] {
            prop_assert_eq!(to_fixed(x, mode), (low as i32, false));
        }
        for mode in [Clamp, Clip] {
            prop_assert_eq!(to_fixed(x, mode), (saturated, false));
        }
    }
}
