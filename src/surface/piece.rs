//! The sums over a set of points or facets of a surface: moments, bounds and slopes.

use super::{Bounds, Moments};
use crate::numerics::vector::length;

/// The sums over some points or facets of a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) count: u64,
    pub(super) moments: Moments,
    pub(super) bounds: Bounds,
    pub(super) area: f64,
    /// The sum of the slopes, in rad, each multiplied by its weight in the moments.
    pub(super) slope_by_weight: f64,
}

impl Piece {
    pub(super) fn about(shift: [f64; 3]) -> Self {
        Self { count: 0, moments: Moments::about(shift), bounds: Bounds::NONE, area: 0.0, slope_by_weight: 0.0 }
    }

    #[inline]
    pub(super) fn add_point(&mut self, point: [f64; 3]) {
        self.count += 1;
        self.moments.add_point(point);
        self.bounds.include(point);
    }

    /// Adds a point that represents an element of area with this normal.
    pub(super) fn add_sample(&mut self, point: [f64; 3], normal: [f64; 3], area: f64) {
        self.add_point(point);
        self.area += area;
        self.slope_by_weight += slope(normal);
    }

    /// Adds a facet of this area; `normal` may have any length.
    #[inline]
    pub(super) fn add_facet(&mut self, corners: [[f64; 3]; 3], normal: [f64; 3], area: f64) {
        self.count += 1;
        self.moments.add_triangle(corners, area);
        for corner in corners {
            self.bounds.include(corner);
        }
        self.area += area;
        self.slope_by_weight += area * slope(normal);
    }

    /// Takes a facet out of the sums. The box stays.
    pub(super) fn remove_facet(&mut self, corners: [[f64; 3]; 3], normal: [f64; 3], area: f64) {
        self.count -= 1;
        self.moments.add_triangle(corners, -area);
        self.area -= area;
        self.slope_by_weight -= area * slope(normal);
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.moments.merge(&other.moments);
        self.bounds.merge(&other.bounds);
        self.area += other.area;
        self.slope_by_weight += other.slope_by_weight;
    }
}

/// The angle between a normal and the vertical, whether it points up or down: 0 to pi/2, exact near both ends.
#[inline]
fn slope(normal: [f64; 3]) -> f64 {
    length([normal[0], normal[1]]).atan2(normal[2].abs())
}
