//! The chip against the reference over everything that can be combined.

use rayon::prelude::*;
use texunit_hw::{
    AddressMode, Filter, Format, I12F20, Layout, LevelRounding, LodSource, Log2, Request, Response, Rounding, Unit,
};

use super::Mismatch;
use crate::{
    error::{Error, Result},
    front_end::FrontEnd,
    machine::Machine,
    names::{Named, layout_name},
    pyramid::{PlaneImage, Pyramid, planes_of},
    reference::Reference,
    scene::{Fragment, Scene},
    texel_format::{Stored, StoredPlane, plane_bytes},
    texture_memory::{Decompress, Held, Storage},
};

/// What a combination draws its requests from.
#[derive(Clone, Debug)]
pub enum Stream {
    /// The fragments of a scene.
    Scene(Vec<Fragment>),
    /// Uniform over every bit of a request, from a seed.
    Random {
        /// Requests a combination.
        count: usize,
        /// First state of the generator.
        seed: u64,
    },
}

/// A texture and the requests made of it.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Name for messages.
    pub name: String,
    /// The texture.
    pub top: PlaneImage,
    /// The requests.
    pub stream: Stream,
}

impl Subject {
    /// Requests it holds.
    #[must_use]
    pub fn requests(&self) -> usize {
        match &self.stream {
            Stream::Scene(fragments) => fragments.len(),
            Stream::Random { count, .. } => *count,
        }
    }
}

/// One setting of every knob that the chip and the reference both have.
#[derive(Clone, Copy, Debug)]
pub struct Combination {
    /// Filter.
    pub filter: Filter,
    /// Address modes of u and v.
    pub address: [AddressMode; 2],
    /// Rounding of the datapath.
    pub rounding: Rounding,
    /// Layout, format, where it is decoded, and what colours mean.
    pub storage: Storage,
    /// Log2 unit.
    pub log2: Log2,
    /// Rounding of whole levels.
    pub level_rounding: LevelRounding,
    /// Bits of the bilinear fraction.
    pub filter_bits: u8,
    /// Bits of the level fraction.
    pub lod_bits: u8,
}

/// What a comparison found.
#[derive(Clone, Debug)]
pub struct Finding {
    /// Which combination.
    pub combination: Combination,
    /// Which texture.
    pub subject: String,
    /// Answers compared.
    pub compared: u64,
    /// Answers that differ.
    pub mismatches: u64,
    /// The first of them.
    pub first: Option<Mismatch>,
}

impl std::fmt::Display for Combination {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} {}/{} {} {} {}{}{} log2={} level-rounding={} filter-bits={} lod-bits={}",
            self.filter.name(),
            self.address[0].name(),
            self.address[1].name(),
            self.rounding.name(),
            layout_name(self.storage.layout),
            self.storage.format.name(),
            if self.storage.decompress == Decompress::BeforeCache { " decompress=before-cache" } else { "" },
            if self.storage.srgb { " srgb" } else { "" },
            self.log2.name(),
            self.level_rounding.name(),
            self.filter_bits,
            self.lod_bits
        )
    }
}

/// Layouts that are verified, each against textures of every shape.
pub const LAYOUTS: [Layout; 5] = [
    Layout::Tiled { log2_width: 2, log2_height: 2 },
    Layout::RowMajor,
    Layout::Morton,
    Layout::Tiled { log2_width: 3, log2_height: 2 },
    Layout::Blocked { block: [2, 2], superblock: [4, 4] },
];

/// Every filter x address mode x rounding, each with its own pick of the other knobs: the picks go round with periods that share no
/// factor with each other, so that over all combinations every pair of settings meets. A `format` given is the only one.
#[must_use]
pub fn combinations(filters: &[Filter], format: Option<Format>) -> Vec<Combination> {
    let mut list = Vec::new();
    for &filter in filters {
        for (_, wrap) in AddressMode::ALL {
            for (_, rounding) in Rounding::ALL {
                let turn = list.len();
                let pick = |count: usize, period: usize| turn % period % count;
                let default_widths = turn % 3 == 0;
                list.push(Combination {
                    filter,
                    address: [*wrap, if turn % 7 == 6 { AddressMode::ALL[turn / 7 % 4].1 } else { *wrap }],
                    rounding: *rounding,
                    storage: Storage {
                        layout: LAYOUTS[pick(LAYOUTS.len(), 5)],
                        format: format.unwrap_or(Format::ALL[pick(Format::ALL.len(), 19)].1),
                        decompress: Decompress::ALL[pick(2, 23)].1,
                        srgb: pick(4, 29) == 3,
                    },
                    log2: Log2::ALL[pick(Log2::ALL.len(), 11)].1,
                    level_rounding: LevelRounding::ALL[pick(3, 13)].1,
                    filter_bits: if default_widths { 8 } else { 1 + pick(12, 12) as u8 },
                    lod_bits: if default_widths { 8 } else { pick(9, 17) as u8 },
                });
            }
        }
    }
    list
}

/// Textures of awkward shapes with random texels, and random requests.
#[must_use]
pub fn random_subjects(count: usize) -> Vec<Subject> {
    [[1, 1], [1, 16], [32, 1], [5, 3], [64, 64], [37, 61], [256, 32], [7, 128], [100, 100]]
        .into_iter()
        .enumerate()
        .map(|(number, [width, height])| {
            let seed = 0x7E78_0001 + number as u64;
            let mut random = SplitMix(seed);
            let texels = (0..width * height).map(|_| (random.draw() as u32).to_le_bytes()).collect();
            Subject {
                name: format!("random {width} x {height}"),
                top: PlaneImage { lu: 0, lv: 0, width, height, texels },
                stream: Stream::Random { count, seed },
            }
        })
        .collect()
}

/// The textures and fragments of scenes.
#[must_use]
pub fn scene_subjects(scenes: &[Scene]) -> Vec<Subject> {
    scenes
        .par_iter()
        .map(|scene| Subject {
            name: scene.name.clone(),
            top: PlaneImage::of_image(&scene.texture.image()),
            stream: Stream::Scene(scene.fragments().collect()),
        })
        .collect()
}

/// Compares all combinations on one subject, in order; `done` is told the number of answers compared.
///
/// # Errors
/// A pyramid or memory that cannot be built.
pub fn compare(
    machine: &Machine,
    subject: &Subject,
    combinations: &[Combination],
    done: impl Fn(u64) + Sync,
) -> Result<Vec<Finding>> {
    let mut pyramids: Vec<Pyramid> = Vec::new();
    for combination in combinations {
        let kind = combination.filter.pyramid();
        if pyramids.iter().all(|pyramid| pyramid.kind != kind) {
            pyramids.push(machine.texture.pyramid.pyramid(kind, &subject.top)?);
        }
    }
    let mut wanted = Vec::new();
    for Combination { filter, storage, .. } in combinations {
        if !wanted.contains(&(filter.pyramid(), storage.format)) {
            wanted.push((filter.pyramid(), storage.format));
        }
    }
    let stored: Vec<Stored> = wanted
        .par_iter()
        .map(|&(kind, format)| {
            let pyramid = pyramids.iter().find(|pyramid| pyramid.kind == kind).expect("made above");
            match format {
                Format::Rgba8 => Stored::encode(pyramid, format),
                _ => random_elements(pyramid, format),
            }
        })
        .collect();
    combinations
        .par_iter()
        .enumerate()
        .map(|(number, combination)| {
            let key = (combination.filter.pyramid(), combination.storage.format);
            let stored = stored.iter().find(|stored| (stored.kind, stored.format) == key).expect("made above");
            let finding = compare_one(machine, subject, stored, combination, number as u64)?;
            done(finding.compared);
            Ok(finding)
        })
        .collect()
}

fn compare_one(
    machine: &Machine,
    subject: &Subject,
    stored: &Stored,
    combination: &Combination,
    number: u64,
) -> Result<Finding> {
    let mut sampler = machine.sampler(combination.filter, combination.address, LodSource::Gradient);
    sampler.rounding = combination.rounding;
    sampler.log2 = combination.log2;
    sampler.level_rounding = combination.level_rounding;
    sampler.filter_bits = combination.filter_bits;
    sampler.lod_bits = combination.lod_bits;
    let requests: Vec<Request> = match &subject.stream {
        Stream::Scene(fragments) => {
            let size = [stored.width, stored.height];
            let front_end = FrontEnd::new(machine, combination.filter, combination.address, size);
            front_end.of_shape(machine, |seen| seen.add(fragments)).requests(fragments).0
        }
        Stream::Random { count, seed } => {
            // Explicit levels every second time, with bias and level limits of their own.
            let mut random = SplitMix(seed ^ number << 32);
            sampler.lod_source = if number.is_multiple_of(2) { LodSource::Gradient } else { LodSource::Explicit };
            sampler.bias = (random.draw() % 8193) as i16 - 4096;
            let limits = [0, 0].map(|_: i32| (random.draw() % (12 << 8)) as i32);
            if number % 3 == 1 {
                [sampler.min_lod, sampler.max_lod] = limits;
            }
            (0..*count).map(|_| random_request(&mut random, sampler.lod_source)).collect()
        }
    };
    let Held { pyramid, memory } = Held::new(stored, &combination.storage)?;
    let mut unit = Unit::new(&sampler, &memory.surface, &memory.bytes)
        .map_err(|error| Error::setting("combination", combination, error.to_string(), "report this"))?;
    let reference = Reference::new(&pyramid, &sampler)?;
    let mut responses = vec![Response::default(); requests.len()];
    unit.run(&requests, &mut responses, &mut ());
    let mut differing = requests.iter().zip(&responses).filter_map(|(request, hw)| {
        let reference = reference.sample(request);
        (reference != *hw).then_some(Mismatch { request: *request, hw: *hw, reference })
    });
    let first = differing.next();
    let mismatches = u64::from(first.is_some()) + differing.count() as u64;
    Ok(Finding {
        combination: *combination,
        subject: subject.name.clone(),
        compared: requests.len() as u64,
        mismatches,
        first,
    })
}

/// Planes of the sizes of a pyramid with every bit of every element, and of the palette, free: what a decoder is to be tried with, and
/// no encoder would write.
fn random_elements(pyramid: &Pyramid, format: Format) -> Stored {
    let Pyramid { kind, width, height, .. } = *pyramid;
    let mut random = SplitMix(u64::from(width) << 32 | u64::from(height));
    let palette =
        (format == Format::Palette8).then(|| Box::new(std::array::from_fn(|_| (random.draw() as u32).to_le_bytes())));
    let planes = planes_of(kind, width, height)
        .into_iter()
        .map(|(lu, lv)| {
            let [width, height] = [(width >> lu).max(1), (height >> lv).max(1)];
            let bytes = plane_bytes(format, width, height) as usize;
            let elements = std::iter::repeat_with(|| random.draw().to_le_bytes()).flatten().take(bytes).collect();
            StoredPlane { lu, lv, width, height, elements }
        })
        .collect();
    Stored { kind, width, height, format, palette, planes }
}

/// A request with every bit free; half of the coordinates near the texture, half of the ratios of a usual size.
fn random_request(random: &mut SplitMix, source: LodSource) -> Request {
    let bits = random.draw();
    let shape = random.draw();
    let place =
        |bits: u32, near: bool| I12F20::from_bits(if near { bits.cast_signed() >> 10 } else { bits.cast_signed() });
    let scale = |bits: u64, usual: bool| match source {
        LodSource::Explicit => (bits as i32 >> if usual { 19 } else { 8 }).cast_unsigned(),
        LodSource::Gradient if usual => (120 << 23) + (bits as u32 % (34 << 23)),
        LodSource::Gradient => bits as u32,
    };
    Request {
        u: place(bits as u32, shape & 1 == 0),
        v: place((bits >> 32) as u32, shape & 2 == 0),
        scale: [scale(random.draw(), shape & 4 == 0), scale(random.draw(), shape & 8 == 0)],
        axes: [0, 1].map(|_| {
            let bits = random.draw();
            [bits as u32, (bits >> 32) as u32].map(|half| I12F20::from_bits(half.cast_signed() >> (shape >> 8 & 15)))
        }),
        pixel: [(shape >> 16) as u16, (shape >> 32) as u16],
    }
}

/// Steele, Lea & Flood 2014: enough randomness for tests, the same everywhere.
#[derive(Clone, Debug)]
pub struct SplitMix(pub u64);

impl SplitMix {
    /// The next 64 bits.
    pub fn draw(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }
}
