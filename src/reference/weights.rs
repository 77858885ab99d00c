//! The weights of the probes of a request.

use super::coordinate::Grid;

/// Feline's weights of `count` probes, which sum to 1, on a grid or as they are.
#[must_use]
pub fn gaussian(count: usize, grid: Option<Grid>) -> Vec<f64> {
    let weights = gaussian_ratios(count);
    let Some(grid) = grid else { return weights };
    let mut weights: Vec<f64> = weights.into_iter().map(|weight| grid.nearest(weight)).collect();
    let missing = 1.0 - weights.iter().sum::<f64>();
    // The same probe twice where their number is odd.
    weights[(count - 1) / 2] += missing / 2.0;
    weights[count / 2] += missing / 2.0;
    weights
}

/// The same before they are rounded.
#[must_use]
pub fn gaussian_ratios(count: usize) -> Vec<f64> {
    let height = |probe: usize| {
        let radius = (2.0 * probe as f64 + 1.0 - count as f64) / (count as f64 + 1.0);
        libm::exp(-2.0 * radius * radius)
    };
    let total: f64 = (0..count).map(height).sum();
    (0..count).map(|probe| height(probe) / total).collect()
}

/// FAST's weights of `count` samples, which sum to 1: equal, as far as the grid allows.
#[must_use]
pub fn shares(count: usize, grid: Option<Grid>) -> Vec<f64> {
    let Some(grid) = grid else { return vec![1.0 / count as f64; count] };
    let until = |sample: usize| grid.floor(sample as f64 / count as f64);
    (0..count).map(|sample| until(sample + 1) - until(sample)).collect()
}
