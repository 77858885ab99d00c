//! From fragments in floats to requests in 12.20: the setup stage of a GPU, and the last place where floats are allowed.

use texunit_hw::{AddressMode, Filter, I12F20, Request, coordinate::from_f64_bits};

use crate::{
    lod_rules::polygon::{LevelPer, SeenArea},
    machine::Machine,
    reference::{footprint::Footprint, ideal::Detail},
    scene::{AxisRule, Fragment, Gradient, Norm},
};

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
    /// The level of all pixels, where they share one.
    pub polygon_level: Option<u8>,
}

/// A coordinate pair in 12.20, and how many of the two had no defined place.
#[must_use]
pub fn coordinates(u: f64, v: f64, address: [AddressMode; 2]) -> ([I12F20; 2], u64) {
    let converted = [(u, address[0]), (v, address[1])].map(|(x, mode)| from_f64_bits(x.to_bits(), mode));
    (converted.map(|one| one.value), converted.iter().map(|one| u64::from(one.undefined)).sum())
}

/// A component of a vector in 12.20: to nearest, saturating, not a number to zero.
fn to_fixed_vector(component: f64) -> I12F20 {
    I12F20::from_bits((component * 1_048_576.0 + 0.5).floor() as i32)
}

impl FrontEnd {
    /// That of a machine, for pixels with a level each.
    #[must_use]
    pub fn new(machine: &Machine, filter: Filter, address: [AddressMode; 2], size: [u32; 2]) -> Self {
        let (norm, rule) = (machine.lod.norm, machine.lod.dipmap_rule);
        Self { filter, address, norm, rule, size, polygon_level: None }
    }

    /// The same where the pixels are those of one shape: they share a level if the machine says so.
    #[must_use]
    pub fn of_shape(self, machine: &Machine, look: impl FnOnce(&mut SeenArea)) -> Self {
        let LevelPer::Polygon(rule) = machine.lod.per else { return self };
        let mut seen = SeenArea::of_texture(self.size);
        look(&mut seen);
        Self { polygon_level: Some(seen.level(rule)), ..self }
    }

    /// The request of a fragment, and how many of its coordinates had no defined place.
    #[must_use]
    pub fn request(&self, fragment: &Fragment) -> (Request, u64) {
        let ([u, v], undefined) = coordinates(fragment.u, fragment.v, self.address);
        let texels = fragment.gradient.in_texels(self.size);
        let mut request = Request { u, v, pixel: [fragment.x, fragment.y], ..Request::default() };
        if self.filter == Filter::Sat {
            let Gradient { ux, uy, vx, vy } = fragment.gradient;
            request.axes = [[ux, vx], [uy, vy]].map(|vector| vector.map(to_fixed_vector));
        } else if self.filter.is_anisotropic() {
            (request.scale, request.axes) = self.footprint(fragment.gradient, texels);
        } else if let Some(level) = self.polygon_level {
            // Scales are squared ratios: 4 to the level.
            request.scale = [(f32::powi(4.0, level.into())).to_bits(); 2];
        } else if self.filter.level_per_axis() {
            request.scale = self.rule.squared_ratios(texels).map(f32::to_bits);
        } else if self.filter.uses_level() {
            request.scale[0] = self.norm.squared_ratio(texels).to_bits();
        }
        (request, undefined)
    }

    /// Squared axes of the footprint and the vectors that probes step along (docs/numerics.md, section 9).
    fn footprint(&self, normalised: Gradient, texels: Gradient) -> ([u32; 2], [[I12F20; 2]; 2]) {
        let screen_axes = [[normalised.ux, normalised.vx], [normalised.uy, normalised.vy]];
        let lengths = [texels.ux.powi(2) + texels.vx.powi(2), texels.uy.powi(2) + texels.vy.powi(2)];
        let longer = usize::from(lengths[1] > lengths[0]);
        let determinant = texels.ux * texels.vy - texels.uy * texels.vx;
        let (major, vectors) = match self.filter {
            Filter::Texram => (lengths[longer], [screen_axes[longer], [0.0; 2]]),
            Filter::Feline => {
                // The screen direction that is stretched most: the first eigenvector of the gradient's J^T J.
                let mixed = texels.ux * texels.uy + texels.vx * texels.vy;
                let angle = libm::atan2(2.0 * mixed, lengths[0] - lengths[1]) / 2.0;
                let (sine, cosine) = libm::sincos(angle);
                let semi_axis = [0, 1].map(|i| screen_axes[0][i] * cosine + screen_axes[1][i] * sine);
                (f64::from(Norm::Sigma1.squared_ratio(texels)), [semi_axis, [0.0; 2]])
            }
            _ => (f64::from(Norm::Sigma1.squared_ratio(texels)), [screen_axes[longer], screen_axes[1 - longer]]),
        };
        // X6: the determinant over the major axis, not the difference of two nearly equal squares.
        let minor = if major > 0.0 { determinant / major * determinant } else { 0.0 };
        let scale = [major, minor].map(|squared| (squared as f32).to_bits());
        (scale, vectors.map(|vector| vector.map(to_fixed_vector)))
    }

    /// What the same fragment asks of a filter without widths: the request's own ratios, so that only widths differ, and for
    /// filters that look along the footprint its unrounded vectors.
    #[must_use]
    pub fn ideal_detail(&self, fragment: &Fragment) -> Detail {
        if self.filter.is_anisotropic() || self.filter == Filter::Sat {
            let pixel = [fragment.x, fragment.y];
            return Detail::Footprint(Footprint::new(self.filter, fragment.gradient, self.size, pixel));
        }
        let (request, _) = self.request(fragment);
        Detail::SquaredRatio(request.scale.map(|bits| f64::from(f32::from_bits(bits))))
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
