//! Property: the same bits, whatever is left out of whatever.

use proptest::prelude::*;
use texunit::{
    machine::Texture,
    names::Named,
    needs::{Needs, Plan, TileMemory},
    pyramid::{Build, From, Kernel, PlaneImage},
    texture_file::TextureImage,
};
use texunit_hw::{AddressMode, Filter, Format, I12F20, Layout, LevelRounding, LodSource, Request, Rounding, Sampler};

use crate::answers;

fn any_of<T: Named + std::fmt::Debug>() -> impl Strategy<Value = T> {
    proptest::sample::select(T::ALL.iter().map(|(_, choice)| *choice).collect::<Vec<_>>())
}

/// Levels in which whole ones, those of one axis only and those below zero are common.
fn level() -> impl Strategy<Value = i32> {
    prop_oneof![Just(0), -700..=0_i32, (0..=5_i32).prop_map(|level| level << 8), 0..=1400_i32]
}

fn place() -> impl Strategy<Value = i32> {
    prop_oneof![0..=0xF_FFFF_i32, 0x4_0000..=0xC_0000_i32, any::<i32>()]
}

fn request() -> impl Strategy<Value = Request> {
    let vector = || prop_oneof![Just([0; 2]), [-0x8000..=0x8000_i32, -0x8000..=0x8000_i32]];
    ([place(), place()], [level(), level()], [vector(), vector()], any::<[u16; 2]>()).prop_map(
        |(at, levels, axes, pixel)| Request {
            scale: levels.map(|level| level as u32),
            axes: axes.map(|axis| axis.map(I12F20::from_bits)),
            pixel,
            ..Request::at(I12F20::from_bits(at[0]), I12F20::from_bits(at[1]))
        },
    )
}

/// A whole scene is often magnified, or lies within the texture: one request alone must not decide.
fn requests() -> impl Strategy<Value = Vec<Request>> {
    (proptest::collection::vec(request(), 0..24), any::<[bool; 3]>()).prop_map(
        |(mut requests, [flat, inside, plain])| {
            for request in &mut requests {
                if flat {
                    request.scale = [(-300_i32) as u32, (-300_i32) as u32];
                    request.axes = [[I12F20::ZERO; 2]; 2];
                }
                if inside {
                    let within = |c: I12F20| I12F20::from_bits(0x7_0000 + (c.to_bits() & 0x1_FFFF));
                    (request.u, request.v) = (within(request.u), within(request.v));
                }
                if plain {
                    request.axes = [[I12F20::ZERO; 2]; 2];
                }
            }
            requests
        },
    )
}

fn sampler() -> impl Strategy<Value = Sampler> {
    (
        any_of::<Filter>(),
        [any_of::<AddressMode>(), any_of::<AddressMode>()],
        (1..=12_u8, 0..=8_u8, 1..=8_u8, 0..=127_u8),
        (any_of::<Rounding>(), any_of::<LevelRounding>()),
        prop_oneof![3 => Just((0_i16, 0, 32 << 8)), 1 => (-600..=600_i16, 0..=300, 0..=1500)],
        any::<bool>(),
    )
        .prop_map(|(filter, address, widths, (rounding, level_rounding), levels, packed)| Sampler {
            filter,
            address,
            filter_bits: if packed { 8 } else { widths.0 },
            lod_bits: widths.1,
            max_anisotropy: widths.2,
            brilinear_threshold: widths.3,
            rounding: if packed { Rounding::Once } else { rounding },
            level_rounding,
            lod_source: LodSource::Explicit,
            bias: levels.0,
            min_lod: levels.1,
            max_lod: levels.2,
            ..Sampler::default()
        })
}

#[derive(Clone, Copy, Debug)]
enum Look {
    Any,
    Opaque,
    Grey,
    OpaqueGrey,
    FewColours,
}

fn texture() -> impl Strategy<Value = TextureImage> {
    let looks = [Look::Any, Look::Opaque, Look::Grey, Look::OpaqueGrey, Look::FewColours];
    let side = || prop_oneof![(0..=5_u32).prop_map(|log2| 1 << log2), 1..=40_u32];
    ([side(), side()], proptest::sample::select(looks.to_vec()), any::<u32>()).prop_map(
        |([width, height], look, seed)| {
            let mut state = seed | 1;
            let texels = (0..width * height).map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let [r, g, b, a] = (state ^ (state >> 15)).to_le_bytes();
                match look {
                    Look::Any => [r, g, b, a],
                    Look::Opaque => [r, g, b, 255],
                    Look::Grey => [g, g, g, a],
                    Look::OpaqueGrey => [g, g, g, 255],
                    Look::FewColours => [b & 0xC0, 30, 90, 255],
                }
            });
            TextureImage { top: PlaneImage::top(width, height, texels.collect()), own: None }
        },
    )
}

fn stored() -> impl Strategy<Value = Texture> {
    let layouts = vec![
        Layout::RowMajor,
        Layout::Morton,
        Layout::default(),
        Layout::Blocked { block: [2, 2], superblock: [3, 3] },
    ];
    let format = prop_oneof![3 => Just(Format::Rgba8), 2 => any_of::<Format>()];
    let kernels = vec![(Kernel::Box, None), (Kernel::Tent, None), (Kernel::Lanczos, Some(6)), (Kernel::Point, None)];
    (proptest::sample::select(layouts), format, any::<[bool; 2]>(), proptest::sample::select(kernels)).prop_map(
        |(layout, format, [above, srgb], (kernel, width))| Texture {
            layout,
            format,
            srgb,
            pyramid: Build { kernel, width, from: if above { From::Above } else { From::Top }, ..Build::default() },
            ..Texture::default()
        },
    )
}

fn bits(coordinate: I12F20, bits: texunit::needs::CoordinateBits) -> I12F20 {
    let kept = coordinate.to_bits() >> (20 - bits.fraction) << (20 - bits.fraction);
    let width = 20 + u32::from(bits.integer);
    I12F20::from_bits(if bits.integer == 0 { kept & 0xF_FFFF } else { kept << (32 - width) >> (32 - width) })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn every_answer_is_the_same_to_the_bit_with_and_without_what_is_not_needed(
        sampler in sampler(),
        requests in requests(),
        texture in texture(),
        stored in stored(),
    ) {
        let whole = stored.hold(sampler.filter.pyramid(), &texture).unwrap();
        let expected = answers(&sampler, &whole.memory, &requests);
        let size = [texture.top.width, texture.top.height];
        let needs = Needs::of(&requests, &sampler, size).unwrap();
        let plan = Plan::new(&needs, &sampler);
        let memory = plan.hold(&stored, &texture).unwrap();
        prop_assert_eq!(&answers(&plan.sampler, &memory, &requests), &expected, "{:?} {:?}", plan, memory.channels);
        prop_assert!(memory.stored_bytes() <= whole.memory.stored_bytes());
        prop_assert!(needs.needed_taps <= needs.taps);

        // The bits that are said not to matter do not.
        let fewer: Vec<Request> = requests
            .iter()
            .map(|request| Request {
                u: bits(request.u, needs.coordinate_bits[0]),
                v: bits(request.v, needs.coordinate_bits[1]),
                ..*request
            })
            .collect();
        prop_assert_eq!(&answers(&sampler, &whole.memory, &fewer), &expected, "{:?}", needs.coordinate_bits);

        // Tiles of planes made from the top give the same texels as planes.
        let plain = Texture { format: Format::Rgba8, srgb: false, ..stored };
        let opaque = texture.top.texels.iter().all(|texel| texel[3] == 255);
        if sampler.filter != Filter::Sat && plain.pyramid.from == From::Top && opaque {
            let whole = plain.hold(sampler.filter.pyramid(), &texture).unwrap();
            let tiles = TileMemory::new(&needs, &plain.pyramid, &texture.top).unwrap();
            let expected = answers(&sampler, &whole.memory, &requests);
            prop_assert_eq!(&tiles.run(&sampler, size, &requests).unwrap(), &expected);
        }
    }
}

/// Both probes fall where a bilinear tap would, so the filter stands for bilinear here; but one is a step of 2^-20 aside, and of a
/// coordinate cut to the bits bilinear needs that step takes the carry.
#[test]
fn a_probe_beside_the_coordinate_needs_the_bits_below_those_of_its_filter() {
    let sampler = Sampler {
        filter: Filter::Texram,
        address: [AddressMode::Clip, AddressMode::Wrap],
        filter_bits: 1,
        lod_bits: 0,
        lod_source: LodSource::Explicit,
        max_anisotropy: 2,
        ..Sampler::default()
    };
    let at = I12F20::from_num(0.4375);
    let step = [I12F20::from_bits(-1), I12F20::ZERO];
    let request = Request { scale: [128, 0], axes: [step, [I12F20::ZERO; 2]], ..Request::at(at, at) };
    let texture = TextureImage { top: PlaneImage::top(1, 1, vec![[124, 32, 136, 60]]), own: None };
    let held = Texture::default().hold(sampler.filter.pyramid(), &texture).unwrap();
    let needs = Needs::of(&[request], &sampler, [1, 1]).unwrap();
    let [u, v] = needs.coordinate_bits;
    let fewer = Request { u: bits(request.u, u), v: bits(request.v, v), ..request };
    assert_eq!(answers(&sampler, &held.memory, &[fewer]), answers(&sampler, &held.memory, &[request]));
}
