//! X11 to X14: rows of texels, one texel, sides that are no powers of two, and huge ones.

use texunit_hw::{AddressMode, Filter, Format, I12F20, Layout, LodSource, PyramidKind, Request, Surface};

use super::{
    Case, LEVEL, LSB, Options, Row,
    horizon::careless_level,
    lab::{self, Lab},
};
use crate::{
    error::{Error, Result},
    names::Named,
    scene::Gradient,
};

pub(super) const ROWS: Case = Case {
    name: "X11",
    title: "textures of one row, or few",
    wrong: "a pitch of log2(width) - level wraps once the width is used up; a level from one axis alone misses the other's minification",
    run: rows_of_texels,
};

pub(super) const ONE_TEXEL: Case = Case {
    name: "X12",
    title: "a texture of one texel",
    wrong: "weights that sum to 255 darken it; clip that clamps instead does not fade at its border",
    run: one_texel,
};

pub(super) const ODD: Case = Case {
    name: "X13",
    title: "sides that are no powers of two",
    wrong: "coordinate times 5000 overflows 32 bits; a 2 x 2 box drops the fifth texel of five; a level's index is not the shifted one of level 0",
    run: odd,
};

pub(super) const HUGE: Case = Case {
    name: "X14",
    title: "32768 texels a side and more",
    wrong: "level 0 of 32768 x 32768 RGBA8 is 4 GiB: every address behind it wraps to the beginning in 32 bits",
    run: huge,
};

fn rows_of_texels(_: &Options) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    // Skybox's pitch: log2(width) - level in five bits, and the row shifted by it.
    let lab = Lab::mipmap(&lab::picture([4, 1024], |_, y| (y / 4) as u8))?;
    let sampler = lab::sampler(Filter::NearestMip, AddressMode::Clamp, LodSource::Explicit);
    for level in [1u32, 3, 5, 8] {
        let plane = &lab.pyramid().planes[level as usize];
        // A texel's centre, so that four texels are one.
        let y = 0.7 * f64::from(plane.height);
        let v = (libm::floor(y) + 0.5) / f64::from(plane.height);
        let log2_pitch = 2u32.wrapping_sub(level) & 31;
        let index = (libm::floor(y) as u32).wrapping_shl(log2_pitch) as usize;
        let careless = plane.texels.get(index).map_or(0.0, |texel| f64::from(texel[0]));
        let ([u, v], _) = crate::front_end::coordinates(0.5, v, sampler.address);
        let request = Request { scale: [level << 8, 0], ..Request::at(u, v) };
        let ours = lab::grey(lab.ask_one(&sampler, request)?);
        let ideal = f64::from(plane.texels[libm::floor(y) as usize * plane.width as usize][0]);
        let input = format!("4 x 1024 at level {level}, {} x {} texels", plane.width, plane.height);
        rows.push(Row { input, unit: LSB, careless, ours, ideal, allowed: 0.0 });
    }
    // The level counts both axes, though only one has texels left.
    let row = Lab::mipmap(&lab::row(1024, |i| i as u8))?;
    for (ux, vy) in [(1.0, 16.0), (4.0, 64.0), (1.0, 5000.0)] {
        let ours = row.level(Gradient { ux, vy, ..Gradient::default() })?;
        let ideal = libm::log2(vy).min(10.0);
        let input = format!("1024 x 1, {ux} texels a pixel along u, {vy} along v");
        rows.push(Row {
            input,
            unit: LEVEL,
            careless: careless_level(ux * ux, 10.0),
            ours,
            ideal,
            allowed: 1.0 / 256.0,
        });
    }
    Ok(rows)
}

fn one_texel(_: &Options) -> Result<Vec<Row>> {
    const GREY: u8 = 200;
    // (a (255 - f) + a f) >> 8, twice.
    let careless = (0..256u32)
        .map(|f| {
            let lerp = |a: u32| (a * (255 - f.min(255)) + a * f) >> 8;
            lerp(lerp(GREY.into()))
        })
        .min()
        .unwrap_or(0);
    let mut worst = f64::from(GREY);
    for (_, filter) in Filter::ALL {
        let lab = Lab::new(filter.pyramid(), &lab::row(1, |_| GREY))?;
        for mode in [AddressMode::Wrap, AddressMode::Clamp, AddressMode::Mirror] {
            let sampler = lab::sampler(*filter, mode, LodSource::Gradient);
            let bits = [0, 1, -1, 0x7FFFF, i32::MAX, i32::MIN, 123_456_789];
            let ratios = [0, 1, 0x3F80_0000, 0x7F7F_FFFF, 0x7F80_0000, 0x7FC0_0000, 0xFFC0_0000];
            let requests: Vec<Request> = bits
                .iter()
                .flat_map(|&u| ratios.map(|ratio| (u, ratio)))
                .map(|(u, ratio)| {
                    let [at, across] = [u, u.wrapping_mul(3)].map(I12F20::from_bits);
                    Request { scale: [ratio, ratio / 2], axes: [[across, at]; 2], ..Request::at(at, across) }
                })
                .collect();
            for response in lab.ask(&sampler, &requests)? {
                let found = lab::grey(response);
                if (found - f64::from(GREY)).abs() > (worst - f64::from(GREY)).abs() {
                    worst = found;
                }
            }
        }
    }
    let input = "every filter, wrap, clamp and mirror, odd places, ratios up to infinity and NaN: the worst".into();
    let ideal = f64::from(GREY);
    let mut rows = vec![Row { input, unit: LSB, careless: f64::from(careless), ours: worst, ideal, allowed: 0.0 }];
    let lab = Lab::mipmap(&lab::row(1, |_| GREY))?;
    let [clip, clamp] =
        [AddressMode::Clip, AddressMode::Clamp].map(|mode| lab::sampler(Filter::Bilinear, mode, LodSource::Gradient));
    for (name, u) in [("at its border", 0.0), ("a quarter inside", 0.25), ("a quarter outside", -0.25)] {
        rows.push(Row {
            input: format!("clip, {name}, against clamp"),
            unit: LSB,
            careless: lab::grey(lab.at(&clamp, u, 0.5)?),
            ours: lab::grey(lab.at(&clip, u, 0.5)?),
            ideal: lab.ideal_at(&clip, u, 0.5)?,
            allowed: 0.5,
        });
    }
    Ok(rows)
}

fn odd(_: &Options) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    let wide = Lab::mipmap(&lab::row(5000, |i| (i * 255 / 4999) as u8))?;
    let sampler = lab::sampler(Filter::Point, AddressMode::Wrap, LodSource::Gradient);
    for u in [0.9999999, 0.5001, 0.2101] {
        let fixed = libm::floor(u * 1_048_576.0) as u32;
        // 36 bits are needed.
        let texel = fixed.wrapping_mul(5000) >> 20;
        let careless = f64::from(wide.pyramid().planes[0].texels[texel as usize][0]);
        let (ours, ideal) = (lab::grey(wide.at(&sampler, u, 0.0)?), wide.ideal_at(&sampler, u, 0.0)?);
        let input = format!("5000 texels, u = {u}, against 32 bits");
        rows.push(Row { input, unit: LSB, careless, ours, ideal, allowed: 0.0 });
    }
    // Five texels become two: 2 2 1 and 1 2 2 of five, so that each counts alike.
    let texels = [0, 0, 0, 0, 255u8];
    let five = Lab::mipmap(&lab::row(5, |i| texels[i as usize]))?;
    let mean = |texels: &mut dyn ExactSizeIterator<Item = f64>| {
        let count = texels.len() as f64;
        texels.sum::<f64>() / count
    };
    let halved = &five.pyramid().planes[1].texels;
    let pairs: Vec<f64> = texels.chunks_exact(2).map(|pair| f64::midpoint(pair[0].into(), pair[1].into())).collect();
    rows.push(Row {
        input: "mean of 0 0 0 0 255 after one halving, against pairs".into(),
        unit: LSB,
        careless: mean(&mut pairs.into_iter()),
        ours: mean(&mut halved.iter().map(|texel| f64::from(texel[0]))),
        ideal: 51.0,
        allowed: 0.5,
    });
    // Each level has its own width.
    let nearest = lab::sampler(Filter::NearestMip, AddressMode::Clamp, LodSource::Explicit);
    let u = 0.9;
    let shifted = libm::floor(u * 5.0) as usize >> 1;
    let ([fixed, v], _) = crate::front_end::coordinates(u, 0.5, nearest.address);
    let ours = lab::grey(five.ask_one(&nearest, Request { scale: [256, 0], ..Request::at(fixed, v) })?);
    rows.push(Row {
        input: "level 1 of five texels at u = 0.9, against the shifted index".into(),
        unit: LSB,
        careless: halved.get(shifted).map_or(0.0, |texel| f64::from(texel[0])),
        ours,
        ideal: f64::from(halved[1][0]),
        allowed: 0.0,
    });
    Ok(rows)
}

fn huge(_: &Options) -> Result<Vec<Row>> {
    let failed = |error: texunit_hw::SurfaceError| Error::setting("X14", "a surface", error.to_string(), "report this");
    let mut rows = Vec::new();
    let side = 32768u32;
    let mut address = |input: String, ours: u64, exact: u128| {
        // The same sum in 32 bits.
        let careless = f64::from(exact as u32);
        rows.push(Row { input, unit: "byte address", careless, ours: ours as f64, ideal: exact as f64, allowed: 0.0 });
    };
    let mipmap = Surface::new(PyramidKind::Mipmap, Layout::RowMajor, Format::Rgba8, side, side).map_err(failed)?;
    let (wide, last) = (u128::from(side), side - 1);
    address("the last texel of 32768 x 32768".into(), mipmap.planes[0].address(last, last), 4 * (wide * wide - 1));
    address("the first texel of its level 1".into(), mipmap.planes[1].base, 4 * wide * wide);
    address(
        "the last texel of its level 1".into(),
        mipmap.planes[1].address(last / 2, last / 2),
        4 * wide * wide + wide * wide - 4,
    );
    let table = Surface::new(PyramidKind::Sat, Layout::RowMajor, Format::Rgba8, side, side).map_err(failed)?;
    address(
        "the last entry of its summed-area table".into(),
        table.planes[0].address(last, last),
        16 * (wide * wide - 1),
    );
    let ripmap = Surface::new(PyramidKind::Ripmap, Layout::RowMajor, Format::Rgba8, side, side).map_err(failed)?;
    let exact: u128 = 4 * (2 * wide - 1) * (2 * wide - 1);
    // Planes start at multiples of 256 bytes.
    let padding = ripmap.planes.len() as f64 * 256.0;
    let ours = ripmap.bytes as f64;
    let input = "bytes of its ripmap, padding included".into();
    rows.push(Row {
        input,
        unit: "byte",
        careless: f64::from(exact as u32),
        ours,
        ideal: exact as f64,
        allowed: padding,
    });
    // And the index: 20 bits of coordinate times 15 of size.
    let row = Lab::mipmap(&lab::row(side, |i| (i / 128) as u8))?;
    let sampler = lab::sampler(Filter::Point, AddressMode::Clamp, LodSource::Gradient);
    for u in [0.99999, 0.3] {
        let fixed = libm::floor(u * 1_048_576.0) as u32;
        let careless = f64::from(fixed.wrapping_mul(side) >> 20) / 128.0;
        let ours = lab::grey(row.at(&sampler, u, 0.0)?);
        let ideal = row.ideal_at(&sampler, u, 0.0)?;
        let input = format!("32768 x 1, u = {u}, against a product of 32 bits");
        rows.push(Row { input, unit: LSB, careless: libm::floor(careless), ours, ideal, allowed: 0.0 });
    }
    Ok(rows)
}
