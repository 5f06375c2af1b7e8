//! The shape of a surface for the choice of a cutter: the size, elongation and slope of an equivalent inclined
//! rectangle.

use super::moments::Piece;
use super::{Bounds, LARGEST_COORDINATE, PrincipalAxes, Unit};
use crate::quantity::{Angle, Area, FormFactor};
use nalgebra::Matrix3;
use std::fmt;

/// The elements from which a shape was computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// Its points; there are no facets.
    Points,
    /// Its facets that point up.
    FacetsUp,
    /// Its facets that point down, because none point up. The surface is turned over.
    FacetsTurnedOver,
    /// Its vertical facets, because there are no others.
    Walls,
    /// All its facets.
    AllFacets,
}

/// The shape of a surface, from the principal axes of its points or facets [Herraz et al. 2020, section 5].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Shape {
    /// The elements from which the shape was computed.
    pub basis: Basis,
    /// The number of these points or facets.
    pub elements: u64,
    /// The covariance matrix of the coordinates, in mm^2 [eq. 15]. Symmetric.
    pub covariance: [[f64; 3]; 3],
    /// The eigenvalues l1 >= l2 >= l3 of the covariance matrix [eq. 16].
    pub eigenvalues: [Area; 3],
    /// The unit eigenvectors e1, e2 = e3 x e1 and e3. e3 points up, e1 to the half plane y > 0.
    pub eigenvectors: [[f64; 3]; 3],
    /// mu = sqrt(l1/l2), the ratio of sides of the rectangle with the same variances [eq. 17].
    pub form_factor: FormFactor,
    /// chi = 12 sqrt(l1 l2), the area of that rectangle [eq. 18].
    pub characteristic_size: Area,
    /// s, the angle between the best-fit plane and the horizontal, 0 to pi/2: acos(|e3_z|) [eq. 20, misprinted].
    pub slope: Angle,
    /// The direction of e1 seen from above, a line in [0, pi) from X; `None` if the surface extends equally in every
    /// direction, or most along the vertical.
    pub principal_direction: Option<Angle>,
    /// The direction of e3 seen from above, a line in [0, pi) from X; `None` if the surface is level.
    pub steepest_direction: Option<Angle>,
    /// The angle between the principal and the steepest direction, 0 to pi/2; `None` if one of them is missing.
    pub direction_gap: Option<Angle>,
    /// sqrt(l3/l1): 0 for a plane.
    pub flatness: f64,
    /// The area, in mm^2; `None` for points alone.
    pub area: Option<Area>,
    /// The mean of the slopes of all elements, each with its weight in the moments: facets by area, samples of a patch
    /// equally [eq. 19].
    pub mean_slope: Option<Angle>,
    /// The centroid, in mm.
    pub centroid: [f64; 3],
    /// The box around these elements, in mm.
    pub bounds: Bounds,
}

/// The reason why points or facets have no shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShapeError {
    /// Fewer than three points.
    TooFewPoints {
        /// The number received.
        count: u64,
    },
    /// Facets, but none with an area.
    OnlyDegenerateFacets {
        /// The number received.
        count: u64,
    },
    /// All points are equal.
    AllPointsEqual,
    /// All points lie on one line.
    Collinear,
    /// A coordinate is not finite, or beyond [`LARGEST_COORDINATE`].
    CoordinateOutOfRange,
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewPoints { count } => write!(f, "a surface needs at least 3 points, or facets; there are {count} points"),
            Self::OnlyDegenerateFacets { count } => write!(f, "none of the {count} facets has an area"),
            Self::AllPointsEqual => f.write_str("all points are equal; a surface must spread in two directions"),
            Self::Collinear => f.write_str("all points lie on one line; a surface must spread in two directions"),
            Self::CoordinateOutOfRange => write!(f, "coordinates must be finite numbers of at most {LARGEST_COORDINATE:e} in magnitude"),
        }
    }
}

impl std::error::Error for ShapeError {}

/// The largest l2/l1 of collinear points: that of a strip a million times as long as wide. The covariance has a
/// rounding error of about 1e-15 of l1, a thousandth of this.
const COLLINEAR: f64 = 1e-12;

/// The smallest horizontal part of a unit vector, and the smallest (l1 - l2)/l1, for which a direction is defined.
/// Coordinates in single precision have relative errors of 6e-8, so that below 1e-6 the rounding errors would determine
/// the direction.
const DIRECTIONLESS: f64 = 1e-6;

impl Shape {
    pub(super) fn of(basis: Basis, piece: &Piece, unit: Unit) -> Result<Self, ShapeError> {
        let magnitude = piece.bounds.largest_magnitude();
        if basis == Basis::Points && piece.count < 3 {
            return Err(ShapeError::TooFewPoints { count: piece.count });
        }
        let (Some(covariance), Some(centroid)) = (piece.moments.covariance(), piece.moments.centroid()) else {
            return Err(ShapeError::AllPointsEqual);
        };
        let axes = PrincipalAxes::of(covariance);
        let [l1, l2, _] = axes.variances();
        // Far from the origin, the coordinates have rounding errors of EPSILON/2 of their magnitude.
        let rounding = (2.0 * f64::EPSILON * magnitude).powi(2);
        if l1 <= rounding {
            return Err(ShapeError::AllPointsEqual);
        }
        if l2 <= rounding.max(COLLINEAR * l1) {
            return Err(ShapeError::Collinear);
        }
        Ok(Self::from_axes(axes, covariance, basis, piece, centroid, unit.mm()))
    }

    fn from_axes(axes: PrincipalAxes, covariance: Matrix3<f64>, basis: Basis, piece: &Piece, centroid: [f64; 3], mm: f64) -> Self {
        let [l1, l2, l3] = axes.variances();
        let [e1, _, e3] = axes.directions();
        let is_level = e3[0].hypot(e3[1]) <= DIRECTIONLESS;
        let has_long_axis = (l1 - l2) > DIRECTIONLESS * l1 && e1[0].hypot(e1[1]) > DIRECTIONLESS;
        let principal_direction = if has_long_axis { Angle::of_line(e1[0], e1[1]) } else { None };
        let steepest_direction = if is_level { None } else { Angle::of_line(e3[0], e3[1]) };
        let has_area = piece.area > 0.0;
        Self {
            basis,
            elements: piece.count,
            covariance: without_noise((covariance * mm * mm).into(), l1 * mm * mm),
            eigenvectors: without_noise(axes.directions(), 1.0),
            eigenvalues: [l1, l2, l3].map(|variance| Area::computed(variance * mm * mm)),
            form_factor: FormFactor::computed((l1 / l2).sqrt()),
            // The product of the roots, because the product of the variances can overflow or underflow.
            characteristic_size: Area::computed(12.0 * l1.sqrt() * l2.sqrt() * mm * mm),
            slope: Angle::of_line(e3[2], e3[0].hypot(e3[1])).unwrap_or(Angle::ZERO),
            principal_direction,
            steepest_direction,
            direction_gap: principal_direction.zip(steepest_direction).map(|(one, other)| gap(one, other)),
            flatness: (l3 / l1).sqrt(),
            area: has_area.then(|| Area::computed(piece.area * mm * mm)),
            mean_slope: has_area.then(|| Angle::from_radians(piece.slope_by_weight / piece.moments.weight())),
            centroid: centroid.map(|c| c * mm),
            bounds: piece.bounds.scaled(mm),
        }
    }
}

/// The matrix with 0 for entries that are only the rounding errors of sums of this magnitude.
fn without_noise(matrix: [[f64; 3]; 3], magnitude: f64) -> [[f64; 3]; 3] {
    matrix.map(|row| row.map(|entry| if entry.abs() < 1e-13 * magnitude { 0.0 } else { entry }))
}

/// The angle between two lines, 0 to pi/2, from the sine and cosine of their difference.
fn gap(one: Angle, other: Angle) -> Angle {
    let cos = one.cos() * other.cos() + one.sin() * other.sin();
    let sin = one.sin() * other.cos() - one.cos() * other.sin();
    Angle::of_vector(cos.abs(), sin.abs()).unwrap_or(Angle::ZERO)
}
