//! The case everything is measured on: a perspective plane at 1920 x 1080, a 1024 x 1024 RGBA8 texture, trilinear, 4 x 4 tiles, a
//! 16 KiB 4-way LRU cache of 64-byte lines.

use texunit::{
    front_end::FrontEnd,
    machine::{Machine, Texture},
    pyramid::{PlaneImage, Pyramid},
    scene::{Fragment, Gradient},
    texture_memory::{Held, TextureMemory},
};
use texunit_hw::{AddressBatch, AddressMode, Filter, Request, Sink};

/// Columns.
pub const WIDTH: usize = 1920;
/// Rows.
pub const HEIGHT: usize = 1080;
/// Texels on a side.
pub const SIDE: u32 = 1024;

/// The tilted plane `u = (a x + b y + c) / (g x + h y + i)`, texture coordinates in texels.
#[derive(Clone, Copy, Debug)]
pub struct Perspective {
    /// Rows of Herf's matrix: u', v', w'.
    pub rows: [[f32; 3]; 3],
}

impl Perspective {
    /// A floor that recedes: from magnified below to minified by eight above.
    pub const FLOOR: Self = Self { rows: [[900.0, 120.0, 30_000.0], [-60.0, 40.0, 900_000.0], [0.0, 0.85, 130.0]] };

    /// Coordinates and gradient at a pixel, in texels.
    pub fn at(&self, x: f64, y: f64) -> ([f64; 2], [f64; 4]) {
        let [u, v, w] = self.rows.map(|row| f64::from(row[0]) * x + f64::from(row[1]) * y + f64::from(row[2]));
        let [ru, rv, rw] = self.rows.map(|row| row.map(f64::from));
        let square = w * w;
        let gradient = [
            (ru[0] * w - u * rw[0]) / square,
            (ru[1] * w - u * rw[1]) / square,
            (rv[0] * w - v * rw[0]) / square,
            (rv[1] * w - v * rw[1]) / square,
        ];
        ([u / w, v / w], gradient)
    }
}

/// The texture of the case, its planes laid out.
#[derive(Debug)]
pub struct Case {
    /// Plain images.
    pub pyramid: Pyramid,
    /// Bytes in the layout.
    pub memory: TextureMemory,
    /// One request a pixel, scanline by scanline.
    pub requests: Vec<Request>,
    /// The same as floats.
    pub fragments: Vec<Fragment>,
}

impl Case {
    /// Builds it for a filter.
    pub fn new(filter: Filter) -> Self {
        Self::rows(filter, 0..HEIGHT)
    }

    /// The same, these rows only.
    pub fn rows(filter: Filter, rows: std::ops::Range<usize>) -> Self {
        let mut state = 0x2545_F491u32;
        let texels = (0..SIDE * SIDE)
            .map(|_| {
                state ^= state << 13;
                state ^= state >> 17;
                state ^= state << 5;
                state.to_le_bytes()
            })
            .collect();
        let top = PlaneImage::top(SIDE, SIDE, texels);
        let Held { pyramid, memory } =
            Texture::default().hold(filter.pyramid(), &top.into()).expect("RGBA8 in 4 x 4 tiles");
        let front_end = FrontEnd::new(&Machine::default(), filter, [AddressMode::Wrap; 2], [SIDE; 2]);
        let scale = 1.0 / f64::from(SIDE);
        let fragments: Vec<Fragment> = rows
            .flat_map(|y| (0..WIDTH).map(move |x| (x, y)))
            .map(|(x, y)| {
                let ([u, v], [ux, uy, vx, vy]) = Perspective::FLOOR.at(x as f64 + 0.5, y as f64 + 0.5);
                let gradient = Gradient { ux: ux * scale, uy: uy * scale, vx: vx * scale, vy: vy * scale };
                Fragment { x: x as u16, y: y as u16, u: u * scale, v: v * scale, gradient }
            })
            .collect();
        let requests = front_end.requests(&fragments).0;
        Self { pyramid, memory, requests, fragments }
    }
}

/// Collects the address stream.
#[derive(Debug, Default)]
pub struct Addresses(pub Vec<u64>);

impl Sink for Addresses {
    fn take(&mut self, batch: AddressBatch<'_>) {
        batch.for_each_read(|_, address| self.0.push(address));
    }
}
