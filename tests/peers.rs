//! The arithmetic of other machines: against their rules in f64, against their golden traces, and against what others measured of it.

use std::{fs, path::PathBuf};

use texunit::{
    experiment::verify::SplitMix,
    machine::Machine,
    peers::{CONVENTIONS, Mipmap, PUBLISHED_TAPS, coordinate, keeps_flat_fields, level_error, tap_error},
    pyramid::{Build, PlaneImage, Pyramid},
    texel_format::Stored,
    texture_memory::{Held, Storage},
};
use texunit_hw::{
    AddressMode, Filter, I12F20, LodSource, PyramidKind, Request, Response, Unit,
    peers::{Arithmetic, COORDINATE_BITS, MACHINES},
};

const MODES: [AddressMode; 4] = [AddressMode::Wrap, AddressMode::Clamp, AddressMode::Clip, AddressMode::Mirror];
const RECORDS: u64 = 96;

/// One question.
#[derive(Clone, Copy, Debug)]
struct Question {
    at: [i64; 2],
    ratio: f32,
    address: [AddressMode; 2],
}

fn texture() -> Pyramid {
    let mut random = SplitMix(7);
    let top = PlaneImage::top(16, 8, (0..128).map(|_| (random.draw() as u32).to_le_bytes()).collect());
    Build::default().pyramid(PyramidKind::Mipmap, &top).unwrap()
}

fn question(random: &mut SplitMix, number: u64) -> Question {
    let mut unit = || (random.draw() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut at = [4.0 * unit() - 2.0, 4.0 * unit() - 2.0];
    if number.is_multiple_of(8) {
        at = at.map(|x| (x * 32.0).floor() / 32.0); // borders and centres of texels
    }
    let ratio = libm::exp2(7.0 * unit() - 1.5) as f32;
    let ratio = if number % 8 == 1 { ratio.floor() } else { ratio };
    let address = [0, 1].map(|_| MODES[(random.draw() % 4) as usize]);
    Question { at: at.map(coordinate), ratio, address }
}

// The rules, in f64 and from peers.md (b1), a machine at a time.

fn texel(plane: &PlaneImage, i: f64, j: f64, address: [AddressMode; 2]) -> [f64; 4] {
    let index = |i: f64, size: u32, mode: AddressMode| {
        let size = f64::from(size);
        let period = |i: f64, period: f64| i - period * (i / period).floor();
        match mode {
            AddressMode::Wrap => Some(period(i, size)),
            AddressMode::Mirror => Some(period(i, 2.0 * size)).map(|i| if i < size { i } else { 2.0 * size - 1.0 - i }),
            AddressMode::Clamp => Some(i.max(0.0).min(size - 1.0)),
            AddressMode::Clip => Some(i).filter(|i| (0.0..size).contains(i)),
        }
    };
    match (index(i, plane.width, address[0]), index(j, plane.height, address[1])) {
        (Some(i), Some(j)) => plane.texels[j as usize * plane.width as usize + i as usize].map(f64::from),
        _ => [0.0; 4],
    }
}

/// The coordinate in texels, fractions as the register holds them.
fn register(machine: &str, u: f64, n: f64) -> f64 {
    let cut = |x: f64, steps: f64| (x * steps).floor() / steps;
    match machine {
        "herf-12.20" => cut(u, 1_048_576.0) * n - 0.5,
        "vortex" => cut(u, 8_388_608.0) * n - 0.5,
        "swiftshader" => cut(u, 65536.0) * n - 0.5,
        "d3d11" | "vulkan-roadmap-2022" | "llvmpipe" => (u * n * 256.0 + 0.5).floor() / 256.0 - 0.5,
        "voodoo-1" | "voodoo-2" => cut(u * n, 256.0) - 0.5,
        "n64" => cut(u * n, 32.0),
        "gamecube" => cut(u * n, 128.0) - 0.5,
        "playstation-2" => cut(u * n, 65536.0) - 0.5,
        "milkymist" => cut(u * n, 64.0) - 0.5,
        "gplgpu" => cut(u * n, 512.0) - 0.5,
        other => panic!("{other} has no rule here"),
    }
}

/// Steps of the fraction.
fn steps(machine: &str) -> f64 {
    match machine {
        "voodoo-1" | "playstation-2" => 16.0,
        "n64" => 32.0,
        "milkymist" => 64.0,
        "gamecube" => 128.0,
        "gplgpu" => 512.0,
        "swiftshader" => 65536.0,
        _ => 256.0,
    }
}

/// Two values, the fraction in whole steps.
fn lerp(machine: &str, a: f64, b: f64, k: f64, steps: f64) -> f64 {
    match machine {
        "vortex" => ((a * (255.0 - k) + b * k) / 255.0 + 0.5).floor(),
        "gplgpu" if steps == 512.0 && k > 0.0 => ((a * (511.0 - k) + b * k) / 512.0 + 0.5).floor(),
        "swiftshader" => (a * (65535.0 - k) / 65536.0).floor() + (b * k / 65536.0).floor(),
        "playstation-2" | "gamecube" => ((a * (steps - k) + b * k) / steps).floor(),
        _ => ((a * (steps - k) + b * k) / steps + 0.5).floor(),
    }
}

/// One channel of one level; none for machines that round both levels at once.
fn tap(machine: &str, [c00, c10, c01, c11]: [f64; 4], f: f64, g: f64) -> f64 {
    let steps = steps(machine);
    let (kf, kg) = ((f * steps).floor(), (g * steps).floor());
    let (f, g) = (kf / steps, kg / steps);
    let exact = (c00 * (1.0 - f) + c10 * f) * (1.0 - g) + (c01 * (1.0 - f) + c11 * f) * g;
    match machine {
        "herf-12.20" | "d3d11" | "vulkan-roadmap-2022" => exact,
        "voodoo-1" | "voodoo-2" | "gamecube" | "milkymist" => exact.floor(),
        "n64" if kf + kg < 32.0 => (c00 + f * (c10 - c00) + g * (c01 - c00) + 0.5).floor(),
        "n64" => (c11 + (1.0 - f) * (c01 - c11) + (1.0 - g) * (c10 - c11) + 0.5).floor(),
        "swiftshader" => {
            let weights = [(65535.0 - kf) * (65535.0 - kg), kf * (65535.0 - kg), (65535.0 - kf) * kg, kf * kg];
            let parts = weights.map(|weight| (weight / 65536.0).floor());
            [c00, c10, c01, c11].iter().zip(parts).map(|(c, weight)| (c * 257.0 * weight / 65536.0).floor()).sum()
        }
        _ => {
            let top = lerp(machine, c00, c10, kf, steps);
            let bottom = lerp(machine, c01, c11, kf, steps);
            lerp(machine, top, bottom, kg, steps)
        }
    }
}

fn level(machine: &str, ratio: f32) -> f64 {
    let cut = |x: f64, steps: f64| (x * steps).floor() / steps;
    let squared = (f64::from(ratio) * f64::from(ratio)) as f32;
    let linear = |x: f32| {
        let (half, exponent) = libm::frexp(f64::from(x));
        f64::from(exponent) - 1.0 + (2.0 * half - 1.0)
    };
    // Logarithms come rounded to the 23 bits of a level.
    let exact = |x: f32| (libm::log2(f64::from(x)) * 8_388_608.0 + 0.5).floor() / 8_388_608.0;
    match machine {
        "herf-12.20" | "d3d11" => (exact(squared) / 2.0 * 256.0 + 0.5).floor() / 256.0,
        "vulkan-roadmap-2022" => (exact(squared) / 2.0 * 64.0 + 0.5).floor() / 64.0,
        "vortex" => libm::log2(f64::from(ratio)).floor(),
        "voodoo-1" | "voodoo-2" => {
            let (half, exponent) = libm::frexp(f64::from(squared));
            let entry = ((2.0 * half - 1.0) * 128.0).floor() / 128.0;
            cut((f64::from(exponent) - 1.0 + cut(libm::log2(1.0 + entry), 256.0)) / 2.0, 256.0)
        }
        "n64" => cut(linear(ratio), 256.0),
        "gamecube" => cut(linear(ratio), 16.0),
        "playstation-2" => cut(exact(ratio), 65536.0),
        "milkymist" => 0.0,
        "gplgpu" => cut(linear(ratio), 64.0),
        "swiftshader" => cut(linear((f64::from(squared) * f64::from(squared)) as f32) / 4.0, 65536.0),
        "llvmpipe" => cut(linear(squared) / 2.0, 256.0),
        other => panic!("{other} has no rule here"),
    }
}

fn reference(machine: &str, pyramid: &Pyramid, question: Question) -> [f64; 4] {
    let last = pyramid.planes.len() as f64 - 1.0;
    let level = level(machine, question.ratio).max(0.0).min(last);
    let on = |level: f64| -> [f64; 4] {
        let plane = &pyramid.planes[level as usize];
        let place = |axis: usize, size: u32| {
            let u = question.at[axis] as f64 / libm::exp2(f64::from(COORDINATE_BITS));
            let place = register(machine, u, f64::from(size));
            (place.floor(), place - place.floor())
        };
        let ((i, f), (j, g)) = (place(0, plane.width), place(1, plane.height));
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
            .map(|(di, dj)| texel(plane, i + di, j + dj, question.address));
        [0, 1, 2, 3].map(|channel| tap(machine, corners.map(|corner| corner[channel]), f, g))
    };
    let whole = level.floor();
    let [a, b] = [on(whole), on((whole + 1.0).min(last))];
    let t = level - whole;
    [0, 1, 2, 3].map(|channel| {
        let (a, b) = (a[channel], b[channel]);
        let at = |steps: f64| lerp(machine, a, b, (t * steps).floor(), steps);
        match machine {
            "herf-12.20" | "d3d11" | "vulkan-roadmap-2022" => (a * (1.0 - t) + b * t + 0.5).floor(),
            "voodoo-1" | "voodoo-2" | "milkymist" => a,
            "gamecube" | "playstation-2" => at(16.0),
            "swiftshader" => at(65536.0),
            _ => at(256.0),
        }
    })
}

#[test]
fn every_machine_answers_as_its_rule_in_real_numbers_says() {
    let pyramid = texture();
    for machine in MACHINES {
        let mut random = SplitMix(11);
        for number in 0..20_000 {
            let question = question(&mut random, number);
            let answer = machine.sample(&Mipmap(&pyramid), question.at, question.ratio.to_bits(), question.address);
            let expected = reference(machine.name, &pyramid, question);
            assert_eq!(answer.map(f64::from), expected, "{}, number {number}: {question:?}", machine.name);
        }
    }
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("traces/peers")
}

/// The golden trace of a machine.
fn recorded(machine: &Arithmetic, pyramid: &Pyramid) -> String {
    let mut random = SplitMix(3);
    let mut text = format!(
        "// texunit trace 1\n// unit peers.{}\n// texture texture.hex\n\
         // fields u:48 v:48 ratio:32 wrap_u:4 wrap_v:4 red:16 green:16 blue:16 alpha:16\n// count {RECORDS}\n",
        machine.name
    );
    for number in 0..RECORDS {
        let Question { at, ratio, address } = question(&mut random, number);
        let [red, green, blue, alpha] = machine.sample(&Mipmap(pyramid), at, ratio.to_bits(), address);
        let [u, v] = at.map(|c| c & 0xFFFF_FFFF_FFFF);
        let [wrap_u, wrap_v] = address.map(|mode| MODES.iter().position(|known| *known == mode).unwrap());
        text += &format!(
            "{u:012x}_{v:012x}_{:08x}_{wrap_u:x}_{wrap_v:x}_{red:04x}_{green:04x}_{blue:04x}_{alpha:04x}\n",
            ratio.to_bits()
        );
    }
    text
}

fn texture_hex(pyramid: &Pyramid) -> String {
    let mut text = String::new();
    for plane in &pyramid.planes {
        text += &format!("// {} x {}\n", plane.width, plane.height);
        for texel in &plane.texels {
            text += &format!("{:08x}\n", u32::from_be_bytes(*texel));
        }
    }
    text
}

#[test]
fn every_machine_has_a_golden_trace_that_the_integers_and_its_rule_agree_with() {
    let pyramid = texture();
    let bless = std::env::var_os("TEXUNIT_BLESS").is_some();
    let mut files = vec![("texture.hex".to_owned(), texture_hex(&pyramid))];
    files.extend(MACHINES.iter().map(|machine| (format!("{}.trace", machine.name), recorded(machine, &pyramid))));
    for (name, expected) in &files {
        let path = folder().join(name);
        if bless {
            fs::write(&path, expected).unwrap();
        }
        let golden = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(golden == *expected, "{name} is not what the machine records");
    }
    assert_eq!(fs::read_dir(folder()).unwrap().count(), files.len(), "a file too many in {}", folder().display());

    // What lies in the files, by the rules alone.
    for machine in MACHINES {
        let golden = fs::read_to_string(folder().join(format!("{}.trace", machine.name))).unwrap();
        let mut records = 0;
        for line in golden.lines().filter(|line| !line.starts_with("//")) {
            let field: Vec<u64> = line.split('_').map(|digits| u64::from_str_radix(digits, 16).unwrap()).collect();
            let at = [field[0], field[1]].map(|c| (c << 16).cast_signed() >> 16);
            let address = [field[3], field[4]].map(|mode| MODES[mode as usize]);
            let question = Question { at, ratio: f32::from_bits(field[2] as u32), address };
            let answer = [5, 6, 7, 8].map(|channel| field[channel] as f64);
            assert_eq!(answer, reference(machine.name, &pyramid, question), "{}: {line}", machine.name);
            records += 1;
        }
        assert_eq!(records, RECORDS, "{}", machine.name);
    }
}

#[test]
fn the_row_of_this_unit_is_this_unit() {
    let pyramid = texture();
    let machine = Machine::default();
    let stored = Stored::encode(&pyramid, texunit_hw::Format::Rgba8);
    let Held { memory, .. } = Held::new(&stored, &Storage::default()).unwrap();
    let own = Arithmetic::named("herf-12.20").unwrap();
    let mut random = SplitMix(5);
    for number in 0..5_000 {
        let Question { at, address, .. } = question(&mut random, number);
        let sampler = machine.sampler(Filter::Bilinear, address, LodSource::Gradient);
        let mut unit = Unit::new(&sampler, &memory.surface, &memory.bytes).unwrap();
        let [u, v] = at.map(|c| I12F20::from_bits((c >> (COORDINATE_BITS - 20)) as i32));
        let mut chip = [Response::default()];
        unit.run(&[Request::at(u, v)], &mut chip, &mut ());
        let chip = chip[0].texel.map(u32::from);
        assert_eq!(own.sample(&Mipmap(&pyramid), at, 1.0_f32.to_bits(), address), chip, "number {number}");
    }
}

#[test]
fn the_division_by_255_of_vortex_is_a_right_rounding_of_every_lerp() {
    let vortex = Arithmetic::named("vortex").unwrap();
    for f in 0..=255 {
        for a in 0..=255_u8 {
            for b in (0..=255_u8).step_by(3) {
                let [found, ..] = vortex.tap([[a; 4], [b; 4], [a; 4], [b; 4]], [f, 0]);
                let sum = u32::from(a) * (255 - f) + u32::from(b) * f;
                assert_eq!(found, (2 * sum + 255) / 510, "{a} to {b} at {f}");
            }
        }
    }
}

#[test]
fn taps_are_as_far_off_as_was_published() {
    for published in PUBLISHED_TAPS {
        let mut machine = *Arithmetic::named(published.machine).unwrap();
        if published.machine == "llvmpipe" {
            machine.coordinate.nearest = false; // as it was modelled there
        }
        let found = tap_error(&machine);
        let name = published.machine;
        // Means and shares of 2 million samples are sharp; extremes are the luck of the draw, by a tenth or so.
        assert!((found.exact.mean - published.mean).abs() < 0.003, "{name}: mean {:?}", found.exact);
        assert!((found.exact.least / published.least - 1.0).abs() < 0.13, "{name}: least {:?}", found.exact);
        let greatest = (found.exact.greatest - published.greatest).abs();
        assert!(greatest < 0.13 * published.greatest.abs() + 0.001, "{name}: greatest {:?}", found.exact);
        if let Some(right) = published.right {
            assert!((found.right - right).abs() < 0.002, "{name}: right {}", found.right);
        }
    }
}

#[test]
fn logarithms_are_as_far_off_as_was_published() {
    for convention in CONVENTIONS {
        let found = level_error(&convention.unit);
        // The last digit printed; the finest of them is given to 5 places.
        let digit = if convention.published.greatest == 0.00001 { 0.51e-5 } else { 0.51e-4 };
        let pairs = [
            (found.least, convention.published.least),
            (found.greatest, convention.published.greatest),
            (found.mean, convention.published.mean),
        ];
        for (found, published) in pairs {
            assert!((found - published).abs() < digit, "{}: {found} for {published}", convention.name);
        }
    }
}

#[test]
fn flat_fields_are_kept_by_all_but_swiftshader() {
    for machine in MACHINES {
        assert_eq!(keeps_flat_fields(machine), machine.name != "swiftshader", "{}", machine.name);
    }
}
