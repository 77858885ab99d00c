//! A texture in the chip's memory with the ideal filter beside it.

use texunit_hw::{AddressMode, Filter, Format, LodSource, PyramidKind, Request, Response, Sampler, Unit};

use crate::{
    error::{Error, Result},
    front_end::{FrontEnd, coordinates},
    machine::Machine,
    pyramid::{Build, PlaneImage, Pyramid},
    reference::ideal::{Detail, Ideal, IdealSampler},
    scene::{Fragment, Gradient},
    texel_format::Stored,
    texture_memory::{Held, Storage},
};

pub(super) struct Lab {
    pub held: Held,
}

/// One row of texels, all channels alike.
pub(super) fn row(width: u32, grey: impl Fn(u32) -> u8) -> PlaneImage {
    PlaneImage::top(width, 1, (0..width).map(|i| [grey(i); 4]).collect())
}

/// A texture of rows and columns, all channels alike.
pub(super) fn picture(size: [u32; 2], grey: impl Fn(u32, u32) -> u8) -> PlaneImage {
    let [width, height] = size;
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| [grey(x, y); 4]).collect();
    PlaneImage::top(width, height, texels)
}

pub(super) fn sampler(filter: Filter, address: AddressMode, lod_source: LodSource) -> Sampler {
    Sampler { filter, address: [address; 2], lod_source, ..Sampler::default() }
}

impl Lab {
    /// RGBA8 in 4 x 4 tiles, box from the top: the default machine.
    pub fn new(kind: PyramidKind, top: &PlaneImage) -> Result<Self> {
        let pyramid = Build::default().pyramid(kind, top)?;
        Ok(Self { held: Held::new(&Stored::encode(&pyramid, Format::Rgba8), &Storage::default())? })
    }

    pub fn mipmap(top: &PlaneImage) -> Result<Self> {
        Self::new(PyramidKind::Mipmap, top)
    }

    pub fn pyramid(&self) -> &Pyramid {
        &self.held.pyramid
    }

    fn size(&self) -> [u32; 2] {
        [self.held.pyramid.width, self.held.pyramid.height]
    }

    /// The chip's answers.
    pub fn ask(&self, sampler: &Sampler, requests: &[Request]) -> Result<Vec<Response>> {
        let memory = &self.held.memory;
        let mut unit = Unit::new(sampler, &memory.surface, &memory.bytes).map_err(|error| {
            Error::setting("case", "a unit", error.to_string(), "report this: it should be possible")
        })?;
        let mut responses = vec![Response::default(); requests.len()];
        unit.run(requests, &mut responses, &mut ());
        Ok(responses)
    }

    /// The chip's answer to one request.
    pub fn ask_one(&self, sampler: &Sampler, request: Request) -> Result<Response> {
        Ok(self.ask(sampler, &[request])?[0])
    }

    /// The chip at a coordinate in floats, through the front end's conversion; filters that read no level.
    pub fn at(&self, sampler: &Sampler, u: f64, v: f64) -> Result<Response> {
        let ([u, v], _) = coordinates(u, v, sampler.address);
        self.ask_one(sampler, Request::at(u, v))
    }

    /// The ideal filter there.
    pub fn ideal_at(&self, sampler: &Sampler, u: f64, v: f64) -> Result<f64> {
        let ideal = Ideal::new(self.pyramid(), IdealSampler::from(sampler))?;
        Ok(ideal.sample([u, v], Detail::Level([0.0; 2])).texel[0])
    }

    /// The front end of this texture.
    pub fn front_end(&self, filter: Filter) -> FrontEnd {
        FrontEnd::new(&Machine::default(), filter, [AddressMode::Wrap; 2], self.size())
    }

    /// The level trilinear uses for a gradient in texels: front end and chip.
    pub fn level(&self, texels: Gradient) -> Result<f64> {
        let [width, height] = self.size().map(f64::from);
        let Gradient { ux, uy, vx, vy } = texels;
        let gradient = Gradient { ux: ux / width, uy: uy / width, vx: vx / height, vy: vy / height };
        let fragment = Fragment { x: 0, y: 0, u: 0.3, v: 0.3, gradient };
        let (request, _) = self.front_end(Filter::Trilinear).request(&fragment);
        self.level_of(request)
    }

    /// The level trilinear uses for a request.
    pub fn level_of(&self, request: Request) -> Result<f64> {
        let sampler = sampler(Filter::Trilinear, AddressMode::Wrap, LodSource::Gradient);
        Ok(levels(self.ask_one(&sampler, request)?))
    }
}

/// The level of a response.
pub(super) fn levels(response: Response) -> f64 {
    f64::from(response.lod[0]) / 256.0
}

/// The first channel of a response.
pub(super) fn grey(response: Response) -> f64 {
    f64::from(response.texel[0])
}
