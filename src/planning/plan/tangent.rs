//! Slope, direction and curvature of the surface at one facet, in the axes of its steepest line.

use super::slopes::{SlopePlace, place_of};
use crate::surface::FinishFacet;

/// Slope and curvature of one facet, in the axes of its steepest line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tangent {
    /// The horizontal unit vector down the slope; +X on a level facet.
    pub(super) down_hill: [f64; 2],
    /// S in rad, and its sine and cosine.
    pub(super) slope: f64,
    pub(super) sin: f64,
    pub(super) cos: f64,
    /// 1/cos(S)
    pub(super) per_cos: f64,
    /// Curvature along the steepest line, the mixed one, and that along the level line, in 1/mm, positive where convex.
    pub(super) curvature: [f64; 3],
    /// The position of the slope in the tables of spacings.
    pub(super) place: SlopePlace,
}

impl Tangent {
    pub(super) fn of(facet: &FinishFacet) -> Self {
        let [x, y, z] = facet.normal;
        let horizontal = x.hypot(y);
        let length = horizontal.hypot(z);
        let (sin, cos) = (horizontal / length, z / length);
        let down_hill = if horizontal > 0.0 { [x / horizontal, y / horizontal] } else { [1.0, 0.0] };
        let steepest = [down_hill[0] * cos, down_hill[1] * cos, -sin];
        let level = [-down_hill[1], down_hill[0], 0.0];
        let curvature =
            [facet.curvature_between(steepest, steepest), facet.curvature_between(steepest, level), facet.curvature_between(level, level)];
        Self { down_hill, slope: sin.atan2(cos), sin, cos, per_cos: length / z, curvature, place: place_of(sin) }
    }

    /// cos(alpha) and sin(alpha) of a direction seen from above, alpha counted from the steepest line down the slope.
    pub(super) fn alpha(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let [u, v] = self.down_hill;
        (x * u + y * v, y * u - x * v)
    }

    /// cos^2(S) + sin^2(S) cos^2(alpha), the square of the ratio of spacing seen from above to spacing along the
    /// surface.
    pub(super) fn ratio_squared(&self, cos_alpha: f64) -> f64 {
        self.cos * self.cos + (self.sin * cos_alpha) * (self.sin * cos_alpha)
    }
}
