//! Acceptance by promised precision: the judge against cases worked by hand, the chip against the judge.

use std::process::{Command, Output};

use proptest::prelude::*;
use texunit::{
    conform::{Judge, Precision, Sample, Sampling, Verdict, largest},
    machine::Machine,
    pyramid::{PlaneImage, Pyramid},
};
use texunit_hw::{AddressMode, Filter, PyramidKind};

fn texunit(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_texunit")).args(arguments).output().unwrap()
}

fn mipmap(width: u32, texels: &[u8]) -> Pyramid {
    let top = PlaneImage::top(width, texels.len() as u32 / width, texels.iter().map(|&grey| [grey; 4]).collect());
    texunit::pyramid::Build::default().pyramid(PyramidKind::Mipmap, &top).unwrap()
}

fn sampling(filter: Filter, mode: AddressMode) -> Sampling {
    Sampling { filter, address: [mode; 2], bias: 0.0, min_lod: 0.0, max_lod: 32.0 }
}

/// Which greys are allowed.
fn allowed(judge: &Judge<'_>, at: [f64; 2], level: f64) -> Vec<u8> {
    let verdict = |grey: u8| judge.verdict(&Sample { at, level: [level; 2], texel: [grey; 4] });
    (0..=255).filter(|&grey| verdict(grey) == Verdict::Allowed).collect()
}

#[test]
fn the_allowed_greys_are_those_worked_out_by_hand() {
    let ramp = mipmap(2, &[0, 255]);
    let judge = |precision| Judge::new(&ramp, sampling(Filter::Bilinear, AddressMode::Clamp), precision).unwrap();
    // Half way, give or take 1/256 of a texel and 2^-21 of 0.5: 127.5 +- 0.997, and half of the last bit.
    assert_eq!(allowed(&judge(Precision::default()), [0.5, 0.5], 0.0), [126, 127, 128, 129]);
    // Four bits: 127.5 +- 15.9, and half.
    let four = Precision { subtexel: 4, ..Precision::default() };
    assert_eq!(allowed(&judge(four), [0.5, 0.5], 0.0), (112..=143).collect::<Vec<_>>());
    // Without tolerance and with a hundredth of the interval only what is nearly there.
    let sharp = Precision { subtexel: 20, tolerance: 0.5, coordinate: 40, ..Precision::default() };
    assert_eq!(allowed(&judge(sharp), [0.5, 0.5], 0.0), [127, 128]);
}

#[test]
fn a_point_may_take_either_texel_at_their_border_only() {
    let ramp = mipmap(4, &[0, 50, 100, 150]);
    let judge = Judge::new(&ramp, sampling(Filter::Point, AddressMode::Wrap), Precision::default()).unwrap();
    assert_eq!(allowed(&judge, [0.5, 0.5], 0.0), [50, 100]);
    assert_eq!(allowed(&judge, [0.6, 0.5], 0.0), [100]);
    assert_eq!(allowed(&judge, [1.0, 0.5], 0.0), [0, 150]);
}

#[test]
fn levels_may_be_off_by_their_last_bit_and_the_nearest_is_free_half_way() {
    // Black and white columns: level 1 is 128 grey all over (127.5 to even).
    let columns = mipmap(2, &[0, 255, 0, 255]);
    let of = |filter| Judge::new(&columns, sampling(filter, AddressMode::Clamp), Precision::default()).unwrap();
    // On the centre of a black texel: 0 +- 1 of level 0; a quarter of the way to 128.
    assert_eq!(allowed(&of(Filter::Trilinear), [0.25, 0.25], 0.25), [31, 32, 33]);
    let half_way = allowed(&of(Filter::NearestMip), [0.25, 0.25], 0.5);
    assert_eq!(half_way, [0, 1, 128]);
    assert_eq!(allowed(&of(Filter::NearestMip), [0.25, 0.25], 0.51), [128]);
    // Beyond the last level there is none.
    assert_eq!(allowed(&of(Filter::Trilinear), [0.25, 0.25], 9.0), [128]);
}

#[test]
fn channels_must_agree_on_one_place() {
    // Red rises where green falls: 64 and 64 are each allowed somewhere, but nowhere both.
    let top = PlaneImage::top(2, 1, vec![[0, 255, 0, 255], [255, 0, 0, 255]]);
    let pyramid = Pyramid { kind: PyramidKind::Mipmap, width: 2, height: 1, planes: vec![top] };
    let judge = Judge::new(
        &pyramid,
        sampling(Filter::Bilinear, AddressMode::Clamp),
        Precision { subtexel: 2, ..Precision::default() },
    );
    let judge = judge.unwrap();
    let verdict = |texel| judge.verdict(&Sample { at: [0.5, 0.5], level: [0.0; 2], texel });
    assert_eq!(verdict([64, 191, 0, 255]), Verdict::Allowed);
    assert_eq!(verdict([191, 64, 0, 255]), Verdict::Allowed);
    let words = judge.explain(&Sample { at: [0.5, 0.5], level: [0.0; 2], texel: [64, 64, 0, 255] }).unwrap();
    // The nearest is half way, (127.5, 127.5): 63.5 off.
    assert!(matches!(verdict([64, 64, 0, 255]), Verdict::Refused { off, .. } if (off - 63.5).abs() < 0.1), "{words}");
    assert!(words.contains("63.5") && words.contains("between texels 0 and 1"), "{words}");
}

#[test]
fn what_has_no_place_or_no_bits_left_is_left_undecided() {
    let ramp = mipmap(4, &[0, 50, 100, 150]);
    let judge = Judge::new(&ramp, sampling(Filter::Bilinear, AddressMode::Wrap), Precision::default()).unwrap();
    for u in [f64::NAN, f64::INFINITY, 1e9] {
        let sample = Sample { at: [u, 0.0], level: [0.0; 2], texel: [7; 4] };
        assert_eq!(judge.verdict(&sample), Verdict::Undecided, "{u}");
    }
}

#[test]
fn filters_no_api_promises_bits_for_are_refused() {
    let ramp = mipmap(2, &[0, 255]);
    assert!(Judge::new(&ramp, sampling(Filter::Feline, AddressMode::Wrap), Precision::default()).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever place and level within the intervals an honest machine takes, its rounded answer is allowed; and one that is off by
    /// more than the intervals and the tolerance together can explain is not.
    #[test]
    fn an_honest_answer_is_allowed_and_a_far_one_is_not(
        texels in prop::collection::vec(any::<[u8; 4]>(), 64), u in -2.0..2.0_f64, v in -2.0..2.0_f64,
        level in 0.0..3.0_f64, error in prop::array::uniform3(-0.99..0.99_f64), mode in 0..4_usize,
    ) {
        let mode = [AddressMode::Wrap, AddressMode::Clamp, AddressMode::Clip, AddressMode::Mirror][mode];
        let top = PlaneImage::top(8, 8, texels);
        let pyramid = texunit::pyramid::Build::default().pyramid(PyramidKind::Mipmap, &top).unwrap();
        let machine = Machine::default();
        let ideal = {
            use texunit::reference::ideal::{Detail, Ideal, IdealSampler};
            let sampler = machine.sampler(Filter::Trilinear, [mode; 2], texunit_hw::LodSource::Explicit);
            // An error of the coordinate that no level's texels are finer than.
            let at = [u + error[0] / 2048.0, v + error[1] / 2048.0];
            let level = (level + error[2] / 256.0).max(0.0);
            Ideal::new(&pyramid, IdealSampler::from(&sampler)).unwrap().sample(at, Detail::Level([level; 2])).texel
        };
        let judge = Judge::new(&pyramid, sampling(Filter::Trilinear, mode), Precision::default()).unwrap();
        let texel = ideal.map(|channel| (channel + 0.5).floor() as u8);
        let sample = Sample { at: [u, v], level: [level; 2], texel };
        prop_assert_eq!(judge.verdict(&sample), Verdict::Allowed);
        // Two levels of four texels: 2/256 of u, of v and of the level can move a channel by 6 of 255, twice that from end to end.
        let far = texel.map(|channel| if channel < 128 { channel + 14 } else { channel - 14 });
        let refused = matches!(judge.verdict(&Sample { texel: far, ..sample }), Verdict::Refused { .. });
        prop_assert!(refused);
    }
}

#[test]
fn the_default_machine_conforms_at_eight_and_eight_bits() {
    let out = texunit(&["conform", "floor", "rectangle-natural", "magnified", "--size", "200x150"]);
    let text = String::from_utf8_lossy(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{text}{}", String::from_utf8_lossy(&out.stderr));
    assert!(text.contains("8 sub-texel and 8 level bits, 0 refused"), "{text}");
}

#[test]
fn four_filter_bits_do_not_conform_at_eight_and_the_failure_is_said_in_words() {
    let four = ["conform", "rectangle-natural", "--size", "200x150", "--set", "filter.bits=4"];
    let out = texunit(&four);
    assert_eq!(out.status.code(), Some(1));
    let words = String::from_utf8_lossy(&out.stderr);
    for part in [
        "rectangle-natural, bilinear, pixel (",
        "the answer is [",
        "allowed: between texels",
        "nearest allowed colour",
        "off",
    ] {
        assert!(words.contains(part), "{part} is not in: {words}");
    }
    // They are what they are: four bits.
    let out = texunit(&[&four[..], &["--subtexel", "4"]].concat());
    assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
}

#[test]
fn a_linear_logarithm_does_not_conform_at_eight_level_bits_and_does_at_four() {
    let herf = ["conform", "floor", "-f", "trilinear", "--size", "200x150", "--set", "lod.log2=herf", "--json"];
    let out = texunit(&herf);
    assert_eq!(out.status.code(), Some(1));
    let report: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let refused = report["refused"].as_u64().unwrap();
    assert!(refused > 0);
    let explained = report["findings"][0]["explained"][0].as_str().unwrap();
    assert!(explained.contains("is right"), "{explained}");
    assert_eq!(texunit(&[&herf[..], &["--mipmap", "4"]].concat()).status.code(), Some(0));
    // The suite's own freedom begins at the largest component: on an axis-aligned gradient it has none below.
    let out = texunit(&[&herf[..], &["--any-norm"]].concat());
    let report: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!((1..refused).contains(&report["refused"].as_u64().unwrap()));
}

#[test]
fn the_arithmetic_of_other_machines_can_be_judged_by_name() {
    let d3d11 = ["conform", "floor", "--size", "120x90", "--arithmetic", "d3d11"];
    let out = texunit(&d3d11);
    let text = String::from_utf8_lossy(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{text}{}", String::from_utf8_lossy(&out.stderr));
    assert!(text.contains("trilinear") && text.contains("d3d11"), "{text}");
    let voodoo = ["conform", "floor", "--size", "120x90", "--arithmetic", "voodoo-1"];
    let out = texunit(&voodoo);
    assert_eq!(out.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&out.stderr).contains("bilinear of voodoo-1, pixel ("));
    let out = texunit(&[&voodoo[..], &["-f", "trilinear"]].concat());
    assert_eq!(out.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&out.stderr).contains("it blends no levels"));
    assert!(String::from_utf8_lossy(&texunit(&["conform", "--arithmetic", "nv1"]).stderr).contains("playstation-2"));
}

#[test]
fn other_filters_are_refused_with_the_ones_there_are() {
    let out = texunit(&["conform", "floor", "-f", "feline"]);
    assert_eq!(out.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&out.stderr).contains("nearest-mip or trilinear"));
}

#[test]
fn twelve_and_twenty_bits_conform_up_to_4096_texels() {
    for filter in [Filter::Bilinear, Filter::Trilinear] {
        let found = largest::of_machine(&Machine::default(), filter, Precision::default()).unwrap();
        assert_eq!(found.power_of_two, Some(4096), "{found:?}");
    }
    // Vortex has 8 sub-texel bits at any size it knows.
    let vortex = texunit_hw::peers::Arithmetic::named("vortex").unwrap();
    let tolerant = Precision { tolerance: 1.5, ..Precision::default() };
    let found = largest::of_peer(vortex, Filter::Bilinear, tolerant).unwrap().unwrap();
    assert_eq!(found.power_of_two, Some(1 << largest::SIZES.end()), "{found:?}");
    assert_eq!(largest::of_peer(vortex, Filter::Point, tolerant).unwrap(), None);
}
