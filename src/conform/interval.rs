//! What lies between two numbers.

/// A closed interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

impl Interval {
    /// Zero and nothing else.
    pub const ZERO: Self = Self { low: 0.0, high: 0.0 };

    /// The part of it within `[cell, cell + 1]`, counted from `cell`.
    pub fn within(self, cell: f64) -> Self {
        Self { low: (self.low - cell).clamp(0.0, 1.0), high: (self.high - cell).clamp(0.0, 1.0) }
    }

    /// Half way.
    pub fn middle(self) -> f64 {
        f64::midpoint(self.low, self.high)
    }
}
