//! The datapath of grey textures: one channel is filtered, the others are copies of it, and alpha is opaque.

use crate::{
    batch::Batch,
    coordinate::AddressMode,
    format::Format,
    layout::Layout,
    request::Response,
    sampler::{Filter, Rounding, Sampler},
    surface::Surface,
};

/// Whether one channel says everything: L8 that is not made linear, read where nothing is outside (clip fades alpha too).
pub(crate) fn suffices(sampler: &Sampler, surface: &Surface) -> bool {
    surface.format == Format::L8
        && surface.layout != Layout::Williams
        && !surface.srgb
        && sampler.filter != Filter::Sat
        && sampler.rounding == Rounding::Once
        && !sampler.address.contains(&AddressMode::Clip)
}

/// Filters a batch; `widths` are the bits of a bilinear fraction and of a weight.
pub(crate) fn answer(bytes: &[u8], [filter_bits, weight_bits]: [u32; 2], batch: Batch<'_>, responses: &mut [Response]) {
    let point = batch.texels_per_tap == 1;
    let (one, shift) = if point { (1, weight_bits) } else { (1u64 << filter_bits, 2 * filter_bits + weight_bits) };
    let half = (1u64 << shift) >> 1;
    for (taps, response) in batch.per_request().zip(responses) {
        let mut sum = half;
        for tap in taps {
            let texel = |number: usize| u64::from(bytes[tap.address[number] as usize]);
            let value = if point {
                texel(0)
            } else {
                let [f, g] = tap.fraction.map(u64::from);
                let top = texel(0) * (one - f) + texel(1) * f;
                let bottom = texel(2) * (one - f) + texel(3) * f;
                top * (one - g) + bottom * g
            };
            sum += value * u64::from(tap.weight);
        }
        let grey = (sum >> shift) as u8;
        response.texel = [grey, grey, grey, 255];
    }
}
