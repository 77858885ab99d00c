//! What the eye sees, in numbers: structural similarity, and whether a difference is aliasing or blur.

use std::collections::VecDeque;

use image::RgbaImage;

use super::{Stage, report::Metric};

/// Edge of a window, pixels, and the step from one to the next.
const WINDOW: usize = 8;
const STEP: usize = 4;

/// An image against the ground truth, in luma (ITU-R BT.601), averaged over windows of 8 x 8 pixels, every 4 pixels, that are covered
/// entirely.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImageQuality {
    /// Structural similarity (Wang, Bovik, Sheikh & Simoncelli 2004; flat 8 x 8 windows), 1 for equal images. `None` if no
    /// window is covered.
    pub ssim: Option<f64>,
    /// Variance within a window beyond that of the truth: detail that is not there, LSB squared.
    pub alias_energy: f64,
    /// Variance of the truth beyond that of the image: detail that was lost, LSB squared.
    pub blur_energy: f64,
}

impl ImageQuality {
    /// Compares a picture with the truth of its stage. No more than the rows of a window are looked at a time.
    #[must_use]
    pub fn of(stage: &Stage, picture: &RgbaImage) -> Self {
        let [width, height] = stage.scene.size.map(|side| side as usize);
        let (answers, _) = picture.as_raw().as_chunks();
        // Answer and truth of every pixel; not a number where there is none, and so is every sum over it.
        let luma = |at: usize| {
            if !stage.covered[at] {
                return [f64::NAN; 2];
            }
            [answers[at].map(f64::from), stage.truth.texels[at].map(f64::from)].map(|texel: [f64; 4]| brightness(texel))
        };
        let mut rows: VecDeque<Vec<[f64; 2]>> = VecDeque::with_capacity(WINDOW);
        let (mut windows, mut ssim, mut alias, mut blur) = (0.0, 0.0, 0.0, 0.0);
        for top in (0..(height + 1).saturating_sub(WINDOW)).step_by(STEP) {
            rows.drain(..STEP.min(rows.len()));
            for y in top + rows.len()..top + WINDOW {
                rows.push_back((y * width..(y + 1) * width).map(luma).collect());
            }
            for left in (0..(width + 1).saturating_sub(WINDOW)).step_by(STEP) {
                let Some(window) = Window::of(rows.iter().flat_map(|row| &row[left..left + WINDOW])) else { continue };
                windows += 1.0;
                ssim += window.ssim();
                alias += (window.variance[0] - window.variance[1]).max(0.0);
                blur += (window.variance[1] - window.variance[0]).max(0.0);
            }
        }
        let mean = |sum: f64| if windows > 0.0 { sum / windows } else { 0.0 };
        Self { ssim: (windows > 0.0).then(|| ssim / windows), alias_energy: mean(alias), blur_energy: mean(blur) }
    }

    /// By their names in reports.
    #[must_use]
    pub fn metrics(&self) -> [Metric; 3] {
        [
            Metric { name: "ssim", value: self.ssim, unit: "1" },
            Metric { name: "alias_energy", value: Some(self.alias_energy), unit: "LSB^2" },
            Metric { name: "blur_energy", value: Some(self.blur_energy), unit: "LSB^2" },
        ]
    }
}

fn brightness([red, green, blue, _]: [f64; 4]) -> f64 {
    0.299 * red + 0.587 * green + 0.114 * blue
}

/// Moments of a window of image and truth.
struct Window {
    mean: [f64; 2],
    variance: [f64; 2],
    covariance: f64,
}

impl Window {
    /// `None` where a pixel is not covered.
    fn of<'p>(pixels: impl Iterator<Item = &'p [f64; 2]>) -> Option<Self> {
        let (mut sum, mut squares, mut product) = ([0.0; 2], [0.0; 2], 0.0);
        for pixel in pixels {
            for side in 0..2 {
                sum[side] += pixel[side];
                squares[side] += pixel[side] * pixel[side];
            }
            product += pixel[0] * pixel[1];
        }
        let count = (WINDOW * WINDOW) as f64;
        let mean = sum.map(|sum| sum / count);
        let variance = [0, 1].map(|side| (squares[side] / count - mean[side] * mean[side]).max(0.0));
        let covariance = product / count - mean[0] * mean[1];
        (!product.is_nan()).then_some(Self { mean, variance, covariance })
    }

    fn ssim(&self) -> f64 {
        let (c1, c2) = ((0.01_f64 * 255.0).powi(2), (0.03_f64 * 255.0).powi(2));
        let [x, y] = self.mean;
        (2.0 * x * y + c1) * (2.0 * self.covariance + c2)
            / ((x * x + y * y + c1) * (self.variance[0] + self.variance[1] + c2))
    }
}
