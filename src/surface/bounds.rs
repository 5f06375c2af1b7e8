//! The box around a set of points.

/// The smallest box with sides along the axes around all points that were added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The smallest x, y and z.
    pub min: [f64; 3],
    /// The largest x, y and z.
    pub max: [f64; 3],
}

impl Bounds {
    /// The empty box.
    pub(super) const NONE: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// Enlarges the box to contain a point.
    #[inline]
    pub(super) fn include(&mut self, point: [f64; 3]) {
        for (axis, coordinate) in point.into_iter().enumerate() {
            // A comparison is one instruction. `f64::min` also tests for NaN, which would add a tenth to the time for a
            // facet.
            self.min[axis] = if coordinate < self.min[axis] { coordinate } else { self.min[axis] };
            self.max[axis] = if coordinate > self.max[axis] { coordinate } else { self.max[axis] };
        }
    }

    /// Enlarges the box to contain the other box.
    pub(super) fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            self.min[axis] = self.min[axis].min(other.min[axis]);
            self.max[axis] = self.max[axis].max(other.max[axis]);
        }
    }

    /// The box with its coordinates times `factor`.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { min: self.min.map(|c| c * factor), max: self.max.map(|c| c * factor) }
    }

    /// The largest magnitude of a coordinate in the box; 0 for the empty box.
    pub(super) fn largest_magnitude(&self) -> f64 {
        if self.min[0] > self.max[0] {
            return 0.0;
        }
        self.min.iter().chain(&self.max).fold(0.0, |largest, c| c.abs().max(largest))
    }
}
