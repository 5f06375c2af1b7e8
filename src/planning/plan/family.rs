//! The families of lines: vertical planes in one direction (zigzag), and level curves of the tips' surface (waterlines).
//!
//! A family gives every tip a number, the same along a line: its distance across the planes, or its height. Lines are spaced
//! in that number.

use super::prepared::Prepared;
use super::stations::Station;
use super::tangent::Tangent;
use crate::quantity::Angle;

/// A direction of lines seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Heading {
    /// The unit vector along the lines.
    pub(super) along: [f64; 2],
    /// The unit vector across them, to the left.
    pub(super) across: [f64; 2],
}

impl Heading {
    pub(super) fn of(radians: f64) -> Self {
        let (sin, cos) = radians.sin_cos();
        Self { along: [cos, sin], across: [-sin, cos] }
    }

    /// The direction, counted from X.
    pub(super) fn angle(&self) -> Angle {
        Angle::from_radians(self.along[1].atan2(self.along[0]))
    }

    /// The position along and across the lines.
    pub(super) fn of_point(&self, point: [f64; 2]) -> [f64; 2] {
        [self.along[0] * point[0] + self.along[1] * point[1], self.across[0] * point[0] + self.across[1] * point[1]]
    }

    pub(super) fn point(&self, [u, c]: [f64; 2]) -> [f64; 2] {
        [u * self.along[0] + c * self.across[0], u * self.along[1] + c * self.across[1]]
    }
}

/// A family of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Family {
    /// Vertical planes.
    Planes(Heading),
    /// Level curves of the tips' surface.
    Levels,
}

impl Family {
    /// Whether both are planes, or both are levels.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }

    /// The distance across the planes, or the height, of a tip in mm.
    pub(super) fn number(&self, [x, y, z]: [f64; 3]) -> f64 {
        match self {
            Self::Planes(heading) => heading.of_point([x, y])[1],
            Self::Levels => z,
        }
    }

    /// The position of a station along the lines, as far as the family has one, and its number.
    pub(super) fn of_station(&self, station: &Station) -> [f64; 2] {
        match self {
            Self::Planes(heading) => heading.of_point(station.axis),
            Self::Levels => [0.0, station.tip],
        }
    }

    /// The direction of the line on a facet, seen from above.
    pub(super) fn along(&self, tangent: &Tangent) -> [f64; 2] {
        match self {
            Self::Planes(heading) => heading.along,
            Self::Levels => [-tangent.down_hill[1], tangent.down_hill[0]],
        }
    }

    /// The spacing of lines in their number for each mm of step-over along a facet.
    pub(super) fn ratio(&self, tangent: &Tangent) -> f64 {
        match self {
            Self::Planes(heading) => tangent.ratio_squared(tangent.alpha(heading.along).0).sqrt(),
            Self::Levels => tangent.sin,
        }
    }

    /// The squared spacing that a facet allows, in mm^2.
    pub(super) fn squared_spacing(&self, prepared: &Prepared, tangent: &Tangent) -> f64 {
        let (cos_alpha, sin_alpha) = tangent.alpha(self.along(tangent));
        let of_planes = prepared.spacing.squared(tangent, cos_alpha, sin_alpha);
        match self {
            Self::Planes(_) => of_planes,
            // Planes along the level line are cos(S) apart for each mm of step-over, levels sin(S).
            Self::Levels => of_planes * (tangent.sin * tangent.per_cos).powi(2),
        }
    }
}
