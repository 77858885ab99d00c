//! Coordinates: conversion by floor, address modes, and the half texel.

use proptest::prelude::*;
use texunit_hw::{
    AddressMode,
    coordinate::{from_f32_bits, from_f64_bits, resolve, texel_pair, texel_under},
};

const MODES: [AddressMode; 4] = [AddressMode::Wrap, AddressMode::Clamp, AddressMode::Clip, AddressMode::Mirror];

fn fixed(x: f64, mode: AddressMode) -> i32 {
    from_f64_bits(x.to_bits(), mode).value.to_bits()
}

#[test]
fn conversion_is_floor_so_a_tiny_negative_is_minus_one_and_almost_one_is_not_one() {
    for mode in MODES {
        assert_eq!(fixed(-(2f64.powi(-26)), mode), -1); // X9
        assert_eq!(fixed(1.0 - 2f64.powi(-24), mode), 0xF_FFFF);
        assert_eq!(fixed(-f64::MIN_POSITIVE, mode), -1);
        assert_eq!(fixed(5e-324, mode), 0);
        assert_eq!(fixed(-0.0, mode), 0);
    }
}

#[test]
fn periodic_modes_are_exact_modulo_one_and_the_others_saturate() {
    assert_eq!(fixed(2048.25, AddressMode::Wrap) & 0xF_FFFF, 0x4_0000); // X7
    assert_eq!(fixed(1e15 + 0.25, AddressMode::Wrap) & 0xF_FFFF, 0x4_0000);
    assert_eq!(fixed(-1e15 - 0.25, AddressMode::Wrap) & 0xF_FFFF, 0xC_0000);
    assert_eq!(fixed(f64::MAX, AddressMode::Mirror), 0);
    for mode in [AddressMode::Clamp, AddressMode::Clip] {
        assert_eq!([2048.0, 1e300, f64::INFINITY].map(|x| fixed(x, mode)), [i32::MAX; 3]);
        assert_eq!([-2048.0, -2048.1, -1e300, f64::NEG_INFINITY].map(|x| fixed(x, mode)), [i32::MIN; 4]);
    }
}

#[test]
fn what_has_no_place_is_zero_and_says_so() {
    for mode in MODES {
        let nan = from_f64_bits(f64::NAN.to_bits(), mode);
        assert_eq!((nan.value.to_bits(), nan.undefined), (0, true));
        let periodic = matches!(mode, AddressMode::Wrap | AddressMode::Mirror);
        assert_eq!(from_f32_bits(f32::INFINITY.to_bits(), mode).undefined, periodic);
        assert!(!from_f32_bits(f32::MAX.to_bits(), mode).undefined);
    }
}

proptest! {
    #[test]
    fn an_f32_converts_as_the_f64_of_the_same_value(bits: u32, mode in 0..4usize) {
        let wide = f64::from(f32::from_bits(bits));
        prop_assert_eq!(from_f32_bits(bits, MODES[mode]), from_f64_bits(wide.to_bits(), MODES[mode]));
    }

    #[test]
    fn conversion_agrees_with_float_floor(x in -5000.0..5000.0f64, scale in -60..12i32, mode in 0..4usize) {
        let x = x * 2f64.powi(scale);
        let floor = (x * 1_048_576.0).floor(); // exact: a power of two, far from overflow
        let expected = match MODES[mode] {
            AddressMode::Wrap | AddressMode::Mirror => floor.rem_euclid(4_294_967_296.0) as u32 as i32,
            AddressMode::Clamp | AddressMode::Clip => floor as i32, // saturates
        };
        prop_assert_eq!(fixed(x, MODES[mode]), expected);
    }

    #[test]
    fn a_power_of_two_axis_is_herfs_shift(c in 0..1i64 << 20, log2 in 0..20u32, bits in 1..=12u32) {
        let pair = texel_pair(c, 1 << log2, bits);
        let shifted = (c << log2) - (1 << 19);
        prop_assert_eq!(pair.lower, shifted >> 20);
        prop_assert_eq!(i64::from(pair.fraction), (shifted >> (20 - bits)) & ((1 << bits) - 1));
        prop_assert_eq!(texel_under(c, 1 << log2), c >> (20 - log2));
    }
}

#[test]
fn the_first_half_texel_blends_with_texel_minus_one() {
    for size in [1, 2, 5, 256, 4096] {
        let pair = texel_pair(0, size, 8);
        assert_eq!((pair.lower, pair.fraction), (-1, 128)); // E21
    }
}

#[test]
fn address_modes_answer_a_table_of_indices() {
    let row = |mode| [-7, -6, -1, 0, 4, 5, 9, 10, 11].map(|index| resolve(index, 5, mode));
    assert_eq!(row(AddressMode::Wrap), [3, 4, 4, 0, 4, 0, 4, 0, 1].map(Some));
    assert_eq!(row(AddressMode::Clamp), [0, 0, 0, 0, 4, 4, 4, 4, 4].map(Some));
    assert_eq!(row(AddressMode::Mirror), [3, 4, 0, 0, 4, 4, 0, 0, 1].map(Some));
    assert_eq!(row(AddressMode::Clip), [None, None, None, Some(0), Some(4), None, None, None, None]);
}
