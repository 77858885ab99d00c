//! From fragments in floats to requests in 12.20: the setup stage of a GPU, and the last place where floats are allowed.

use texunit_hw::{AddressMode, Filter, I12F20, Request, coordinate::from_f64_bits};

use crate::scene::{AxisRule, Fragment, Norm};

/// Makes requests for one filter on one texture.
#[derive(Clone, Copy, Debug)]
pub struct FrontEnd {
    /// Which filter: decides what the scales of a request hold.
    pub filter: Filter,
    /// Address modes: decide what happens to coordinates beyond 12.20.
    pub address: [AddressMode; 2],
    /// The measure that selects the level of filters with one.
    pub norm: Norm,
    /// The measures that select the levels of filters with one an axis.
    pub rule: AxisRule,
    /// Texels of level 0.
    pub size: [u32; 2],
}

/// A coordinate pair in 12.20, and how many of the two had no defined place.
#[must_use]
pub fn coordinates(u: f64, v: f64, address: [AddressMode; 2]) -> ([I12F20; 2], u64) {
    let converted = [(u, address[0]), (v, address[1])].map(|(x, mode)| from_f64_bits(x.to_bits(), mode));
    (converted.map(|one| one.value), converted.iter().map(|one| u64::from(one.undefined)).sum())
}

impl FrontEnd {
    /// The request of a fragment, and how many of its coordinates had no defined place.
    #[must_use]
    pub fn request(&self, fragment: &Fragment) -> (Request, u64) {
        let ([u, v], undefined) = coordinates(fragment.u, fragment.v, self.address);
        let texels = fragment.gradient.in_texels(self.size);
        let scale = if self.filter.level_per_axis() {
            self.rule.squared_ratios(texels).map(f32::to_bits)
        } else if self.filter.uses_level() {
            [self.norm.squared_ratio(texels).to_bits(), 0]
        } else {
            [0; 2]
        };
        (Request { u, v, scale, pixel: [fragment.x, fragment.y], ..Request::default() }, undefined)
    }

    /// The requests of a scene, in its order.
    #[must_use]
    pub fn requests(&self, fragments: &[Fragment]) -> (Vec<Request>, u64) {
        let mut undefined = 0;
        let requests = fragments
            .iter()
            .map(|fragment| {
                let (request, without_place) = self.request(fragment);
                undefined += without_place;
                request
            })
            .collect();
        (requests, undefined)
    }
}
