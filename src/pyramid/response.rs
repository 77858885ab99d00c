//! What a kernel does to frequencies and to an edge, measured on the integer taps that are built with (E19).

use texunit_hw::AddressMode;

use super::{axis::AxisTaps, kernel::Kernel};
use crate::error::Result;

/// Symmetric taps of a 2:1 halving, and what follows from them.
#[derive(Clone, Debug)]
pub struct Response {
    /// The kernel.
    pub kernel: Kernel,
    /// Number of taps.
    pub width: usize,
    /// Weights by rising source index; they sum to 1. The distance of tap `k` from the centre is `k - (width - 1) / 2`
    /// source texels; the point kernel's one tap counts as centred.
    pub taps: Vec<f64>,
}

impl Response {
    /// The taps of one halving, far from any edge.
    ///
    /// # Errors
    /// A width the kernel cannot have.
    pub fn of(kernel: Kernel, width: Option<u8>) -> Result<Self> {
        // Twice the widest kernel, so that nothing meets itself around the edge.
        let axis = AxisTaps::new(kernel, kernel.width(width)?, AddressMode::Wrap, 256, 128);
        let taps: Vec<f64> = axis.of(64).iter().map(|tap| f64::from(tap.weight) / axis.total as f64).collect();
        Ok(Self { kernel, width: taps.len(), taps })
    }

    /// Factor by which a wave of `frequency` cycles per source texel (0 to 1/2) comes out; negative where it comes out
    /// inverted.
    #[must_use]
    pub fn at(&self, frequency: f64) -> f64 {
        let centre = (self.width as f64 - 1.0) / 2.0;
        let turn = 2.0 * std::f64::consts::PI * frequency;
        self.taps.iter().enumerate().map(|(k, tap)| tap * libm::cos(turn * (k as f64 - centre))).sum()
    }

    /// Mean square of what is lost of the frequencies the smaller plane can hold, 0 to 1/4 cycle per source texel.
    #[must_use]
    pub fn pass_loss(&self) -> f64 {
        mean_square(|x| 1.0 - self.at(x / 4.0))
    }

    /// Mean square of what is left of the frequencies it cannot hold, 1/4 to 1/2: all of it comes back as alias.
    #[must_use]
    pub fn stop_leak(&self) -> f64 {
        mean_square(|x| self.at(0.25 + x / 4.0))
    }

    /// Darkest and brightest value beside a step from 0 to 255, before clamping: ringing. `aligned` steps lie between two
    /// texels of the smaller plane (E19 counts those: -2.9 and 257.9); the others cut one in half, and ring far more.
    #[must_use]
    pub fn step_extremes(&self, aligned: bool) -> (f64, f64) {
        // Texel i takes 2 i + 1 - width/2 ..= 2 i + width/2, so an aligned step leaves it width/2 + 1 taps, or some even
        // number more or fewer.
        let parity = usize::from(!aligned) + self.width / 2 + 1;
        let mut bright = 0.0;
        let mut extremes = (0.0_f64, 255.0_f64);
        for (taps, tap) in self.taps.iter().enumerate() {
            bright += 255.0 * tap;
            if (taps + 1) % 2 == parity % 2 {
                extremes = (extremes.0.min(bright), extremes.1.max(bright));
            }
        }
        extremes
    }
}

/// Mean of `f` squared over 0..=1 by Simpson's rule; far finer than the at most 64 waves a kernel has there.
fn mean_square(f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 4096;
    let total: f64 = (0..=STEPS)
        .map(|step| {
            let simpson = match step {
                0 | STEPS => 1.0,
                odd if odd % 2 == 1 => 4.0,
                _ => 2.0,
            };
            simpson * f(f64::from(step) / f64::from(STEPS)).powi(2)
        })
        .sum();
    total / (3.0 * f64::from(STEPS))
}
