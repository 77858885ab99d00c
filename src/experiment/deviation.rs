//! How far answers are from what they should be.

/// Sum of the differences of red, green and blue, in units of the 8-bit channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    channels: u64,
    sum: f64,
    squares: f64,
    worst: f64,
}

impl Deviation {
    /// Adds one pixel.
    pub fn add(&mut self, answer: [f64; 4], truth: [f64; 4]) {
        for channel in 0..3 {
            let difference = answer[channel] - truth[channel];
            self.sum += difference;
            self.squares += difference * difference;
            self.worst = self.worst.max(difference.abs());
        }
        self.channels += 3;
    }

    /// Both together.
    #[must_use]
    pub fn merge(self, other: Self) -> Self {
        Self {
            channels: self.channels + other.channels,
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
            worst: self.worst.max(other.worst),
        }
    }

    /// Mean difference: the drift, signed.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.sum / self.channels.max(1) as f64
    }

    /// Root of the mean square.
    #[must_use]
    pub fn rmse(&self) -> f64 {
        (self.squares / self.channels.max(1) as f64).sqrt()
    }

    /// Largest difference of any channel of any pixel.
    #[must_use]
    pub const fn worst(&self) -> f64 {
        self.worst
    }

    /// Peak signal to noise, dB against 255; `None` without any difference.
    #[must_use]
    pub fn psnr(&self) -> Option<f64> {
        (self.squares > 0.0).then(|| 20.0 * libm::log10(255.0 / self.rmse()))
    }
}
