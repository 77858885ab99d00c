//! Planes of 32 bits a channel for a model that reads 8: filters are sums, so the four bytes of a channel, filtered as if they were
//! four channels, add up to the channel filtered.

use texunit_hw::PyramidKind;

use crate::{
    error::Result,
    pyramid::{Build, PlaneImage, Pyramid, halved, planes_of},
};

/// Unrounded planes: for each channel of the texture a pyramid whose four channels are its bytes, highest first.
#[derive(Debug)]
pub(super) struct Unrounded {
    channels: Vec<Pyramid>,
}

/// A filtered channel from its filtered bytes.
pub(super) fn value([whole, a, b, c]: [f64; 4]) -> f64 {
    whole + (a + (b + c / 256.0) / 256.0) / 256.0
}

impl Unrounded {
    pub(super) fn new(build: &Build, kind: PyramidKind, top: &PlaneImage) -> Result<Self> {
        let planes = build.unrounded(kind, top)?;
        let of_channel = |channel: usize| {
            let plane = |((lu, lv), texels): ((u8, u8), &Vec<[u32; 4]>)| PlaneImage {
                lu,
                lv,
                width: halved(top.width, lu),
                height: halved(top.height, lv),
                texels: texels.iter().map(|texel| texel[channel].to_be_bytes()).collect(),
            };
            let planes = planes_of(kind, top.width, top.height).into_iter().zip(&planes).map(plane).collect();
            Pyramid { kind, width: top.width, height: top.height, planes }
        };
        Ok(Self { channels: (0..super::CHANNELS).map(of_channel).collect() })
    }

    pub(super) fn kind(&self) -> PyramidKind {
        self.channels[0].kind
    }

    pub(super) fn channels(&self) -> impl Iterator<Item = &Pyramid> {
        self.channels.iter()
    }
}
