//! Slope, direction and curvature of the surface at one facet, in the axes of its steepest line; and the slopes at which tables
//! have their rows.

use crate::surface::FinishFacet;
use std::sync::LazyLock;

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

/// The sines of the rows' slopes, rising from 0 to 1: slope 0, then from 0.02 deg to 10 deg each a quarter larger than
/// the one before, then every 2.5 deg.
///
/// The square of the step-over is proportional to 1/sin(S) at slopes at which the cutter's corner makes the groove, and
/// constant at those at which its flat does.
static SINES: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let mut degrees = vec![0.0];
    let mut next: f64 = 0.02;
    while next < 9.0 {
        degrees.push(next);
        next *= 1.25;
    }
    degrees.extend((4..=36).map(|step| 2.5 * f64::from(step)));
    degrees.into_iter().map(|slope| if slope >= 90.0 { 1.0 } else { slope.to_radians().sin() }).collect()
});

pub(super) fn sines() -> &'static [f64] {
    &SINES
}

/// A slope between two rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SlopePlace {
    /// The row with the lower slope; not the last one.
    pub(super) row: u32,
    /// The weight of the next row, 0 to 1.
    pub(super) weight: f64,
}

/// The position of a slope between two rows: linear in 1/sin(S), except between the floor and the first row above it,
/// where it is linear in sin(S).
pub(super) fn place_of(sin: f64) -> SlopePlace {
    let sines = sines();
    let row = sines.partition_point(|&row| row <= sin).saturating_sub(1).min(sines.len() - 2);
    let (low, high) = (sines[row], sines[row + 1]);
    let weight = if row == 0 { sin / high } else { (1.0 / low - 1.0 / sin) / (1.0 / low - 1.0 / high) };
    #[expect(clippy::cast_possible_truncation, reason = "some sixty rows")]
    SlopePlace { row: row as u32, weight: weight.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_span_all_slopes() {
        assert_eq!(place_of(0.0), SlopePlace { row: 0, weight: 0.0 });
        for (row, pair) in sines().windows(2).enumerate() {
            assert!(pair[0] < pair[1]);
            let middle = place_of(f64::midpoint(pair[0], pair[1]));
            assert_eq!(middle.row as usize, row);
            assert!(middle.weight > 0.3 && middle.weight < 0.7);
        }
        let wall = place_of(1.0);
        assert_eq!((wall.row as usize, wall.weight), (sines().len() - 2, 1.0));
    }
}
