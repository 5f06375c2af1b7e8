//! The direction of passes, and coordinates along and across them.

use crate::quantity::Angle;

/// A direction of passes: e along the passes, q across them to the left, both seen from above.
#[derive(Debug, Clone, Copy)]
pub(super) struct Heading {
    pub(super) e: [f64; 2],
}

impl Heading {
    pub(super) fn new(direction: Angle) -> Self {
        Self { e: [direction.cos(), direction.sin()] }
    }

    /// The coordinate along the passes.
    pub(super) fn along(&self, x: f64, y: f64) -> f64 {
        self.e[0] * x + self.e[1] * y
    }

    /// The coordinate across the passes.
    pub(super) fn across(&self, x: f64, y: f64) -> f64 {
        self.e[0] * y - self.e[1] * x
    }
}
