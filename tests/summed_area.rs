//! The summed-area unit through its public face: against the reference that adds texels up, and the reads it makes.

use texunit::{
    experiment::verify::SplitMix,
    machine::Texture,
    pyramid::{PlaneImage, Pyramid},
    reference::Reference,
    texture_memory::TextureMemory,
};
use texunit_hw::{
    AddressBatch, AddressMode, Filter, Format, I12F20, Layout, PyramidKind, Request, Response, Sampler, Sink, Unit,
};

const MODES: [AddressMode; 4] = [AddressMode::Wrap, AddressMode::Clamp, AddressMode::Clip, AddressMode::Mirror];

fn noise(width: u32, height: u32) -> Pyramid {
    let mut random = SplitMix(7);
    let texels = (0..width * height).map(|_| (random.draw() as u32).to_le_bytes()).collect();
    Pyramid { kind: PyramidKind::Sat, width, height, planes: vec![PlaneImage::top(width, height, texels)] }
}

fn sampler(mode: AddressMode) -> Sampler {
    Sampler { filter: Filter::Sat, address: [mode; 2], ..Sampler::default() }
}

fn memory(pyramid: &Pyramid, layout: Layout, format: Format) -> TextureMemory {
    let texture = Texture { layout, format, ..Texture::default() };
    texture.hold(PyramidKind::Sat, &pyramid.planes[0].clone().into()).unwrap().memory
}

/// A box of `size` texels (of `of`) around a place in turns.
fn request(at: [f64; 2], size: [f64; 2], of: [f64; 2]) -> Request {
    let turns = |texels: f64, of: f64| I12F20::from_num(texels / of);
    Request {
        axes: [[turns(size[0], of[0]), I12F20::ZERO], [I12F20::ZERO, turns(size[1], of[1])]],
        ..Request::at(I12F20::from_num(at[0]), I12F20::from_num(at[1]))
    }
}

/// Addresses read, request by request.
#[derive(Default)]
struct Reads(Vec<Vec<u64>>);

impl Sink for Reads {
    fn take(&mut self, batch: AddressBatch<'_>) {
        let before = self.0.len();
        self.0.resize(before + batch.len(), Vec::new());
        batch.for_each_tap(|request, _, addresses| self.0[before + request].extend(addresses));
    }
}

fn run(sampler: &Sampler, memory: &TextureMemory, requests: &[Request]) -> (Vec<Response>, Vec<Vec<u64>>) {
    let mut responses = vec![Response::default(); requests.len()];
    let mut reads = Reads::default();
    Unit::new(sampler, &memory.surface, &memory.bytes).unwrap().run(requests, &mut responses, &mut reads);
    (responses, reads.0)
}

#[test]
fn every_box_is_the_mean_of_its_texels_in_every_mode_and_shape() {
    let mut random = SplitMix(3);
    for (width, height) in [(1, 1), (1, 9), (5, 3), (16, 16), (33, 12)] {
        let pyramid = noise(width, height);
        for mode in MODES {
            let sampler = sampler(mode);
            let reference = Reference::new(&pyramid, &sampler).unwrap();
            let requests: Vec<Request> = (0..2000)
                .map(|number| {
                    let mut bits = |shift: u32| I12F20::from_bits((random.draw() as i32) >> shift);
                    // Boxes from a texel to many textures, near the texture and at the ends of the coordinates.
                    let (reach, size) = (if number % 4 == 0 { 0 } else { 9 }, 8 + number % 16);
                    Request {
                        axes: [[bits(size), bits(size)], [bits(size), bits(size)]],
                        ..Request::at(bits(reach), bits(reach))
                    }
                })
                .collect();
            let memory = memory(&pyramid, Layout::default(), Format::Rgba8);
            let (responses, reads) = run(&sampler, &memory, &requests);
            for ((request, response), reads) in requests.iter().zip(responses).zip(reads) {
                assert_eq!(response, reference.sample(request), "{width} x {height} {mode:?} {request:?}");
                assert!(reads.len() <= 9 && reads.iter().all(|address| address + 16 <= memory.surface.bytes));
            }
        }
    }
}

#[test]
fn a_box_inside_takes_four_reads_at_its_corners() {
    let pyramid = noise(16, 16);
    let memory = memory(&pyramid, Layout::RowMajor, Format::Rgba8);
    // Texels 4..8 by 6..10: corners are the entries before the first and at the last texel.
    let inside = request([6.0 / 16.0, 0.5], [4.0, 4.0], [16.0, 16.0]);
    for mode in MODES {
        let (_, reads) = run(&sampler(mode), &memory, &[inside]);
        let corner = |x: u64, y: u64| 16 * (16 * y + x);
        assert_eq!(reads, [[corner(3, 5), corner(7, 5), corner(3, 9), corner(7, 9)]], "{mode:?}");
    }
}

#[test]
fn borders_cost_reads_and_position_zero_saves_them() {
    let pyramid = noise(16, 16);
    let memory = memory(&pyramid, Layout::default(), Format::Rgba8);
    let around_origin = request([0.0, 0.0], [4.0, 4.0], [16.0, 16.0]);
    let at_origin = request([2.0 / 16.0, 2.0 / 16.0], [4.0, 4.0], [16.0, 16.0]);
    let far_away = request([5.5, 0.5], [4.0, 4.0], [16.0, 16.0]);
    let counts =
        |mode| run(&sampler(mode), &memory, &[around_origin, at_origin, far_away]).1.iter().map(Vec::len).collect();
    let expected: [(AddressMode, Vec<usize>); 4] = [
        (AddressMode::Wrap, vec![9, 1, 4]),
        (AddressMode::Clamp, vec![4, 1, 4]),
        (AddressMode::Clip, vec![1, 1, 0]),
        (AddressMode::Mirror, vec![1, 1, 4]),
    ];
    for (mode, expected) in expected {
        let found: Vec<usize> = counts(mode);
        assert_eq!(found, expected, "{mode:?}");
    }
}

#[test]
fn only_differences_of_the_table_count_so_it_may_wrap_around() {
    let pyramid = noise(16, 16);
    let mut memory = memory(&pyramid, Layout::default(), Format::Rgba8);
    let inside = request([0.5, 0.4], [5.0, 3.0], [16.0, 16.0]);
    let sampler = sampler(AddressMode::Clamp);
    let (before, _) = run(&sampler, &memory, &[inside]);
    // As if another 4 G of light lay above and to the left.
    for word in memory.bytes.chunks_exact_mut(4) {
        let moved = u32::from_le_bytes([word[0], word[1], word[2], word[3]]).wrapping_add(0xFFFF_F123);
        word.copy_from_slice(&moved.to_le_bytes());
    }
    assert_eq!(run(&sampler, &memory, &[inside]).0, before);
}

#[test]
fn a_table_takes_four_times_the_memory_of_its_texture_whatever_the_format() {
    let pyramid = noise(16, 16);
    for format in [Format::Rgba8, Format::L8, Format::Bc1] {
        let table = memory(&pyramid, Layout::RowMajor, format);
        assert_eq!(table.surface.bytes, 16 * 16 * 16);
        assert_eq!(table.surface.bytes_per_read(), 16);
    }
}
