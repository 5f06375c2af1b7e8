//! The contact between cutter and surface: slope and feed direction relative to the tool axis, from angles or from
//! vectors.

use crate::numerics::hypotenuse;
use crate::quantity::{Angle, Direction, OutOfRange};
use nalgebra::Vector3;
use std::fmt;

/// A contact between cutter and surface: the slope S, and the feed's direction as two angles from the line of steepest
/// slope.
///
/// - `alpha` is measured in the plane normal to the tool axis (the horizontal plane), from the line of steepest slope
///   to the feed, counter-clockwise seen from above. Its period is 180 deg, so the uphill and the downhill end of the
///   line are equivalent;
/// - `omega` is the same in the tangent plane, counter-clockwise seen from outside: tan(omega) = tan(alpha) cos(S).
///
/// Formulas for one angle are wrong for the other, so both are stored. On a vertical wall all feeds except the vertical
/// one have `alpha` = 90 deg, and only `omega` distinguishes them. The signs matter only if the surface has twist in
/// the axes of the feed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    slope: Angle,
    alpha: Angle,
    omega: Direction,
}

/// The reason why angles or vectors do not describe a contact. Each variant identifies the faulty input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactError {
    /// The slope is outside 0 to 90 deg.
    Slope(OutOfRange),
    /// The feed angle is not a finite number.
    FeedAngle(OutOfRange),
    /// The normal has no length, or a component that is not finite.
    NormalWithoutDirection,
    /// The normal points away from the tool axis by more than 90 deg: the cutter cannot touch there.
    NormalPointsDown,
    /// The feed has no length, or a component that is not finite.
    FeedWithoutDirection,
    /// The feed runs along the normal, so it has no direction in the surface.
    FeedAlongNormal,
    /// The tool axis has no length, or a component that is not finite.
    ToolAxisWithoutDirection,
}

impl fmt::Display for ContactError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slope(bounds) => write!(f, "the slope {bounds} deg"),
            Self::FeedAngle(_) => f.write_str("the feed angle must be a finite number of degrees"),
            Self::NormalWithoutDirection => f.write_str("the normal must have a length; it points out of the part"),
            Self::NormalPointsDown => f.write_str(
                "the normal points away from the tool axis (normal . tool_axis < 0, the axis being +Z unless stated), so the cutter cannot touch the surface there; give the normal that points out of the part",
            ),
            Self::ToolAxisWithoutDirection => f.write_str("the tool axis must have a length; it points from the tip to the spindle"),
            Self::FeedWithoutDirection => f.write_str("the feed vector must have a length"),
            Self::FeedAlongNormal => {
                f.write_str("the feed runs along the normal and has no direction in the surface; give a feed that follows the surface")
            }
        }
    }
}

impl std::error::Error for ContactError {}

/// The feed counts as parallel to the normal if the sine of their angle is at most this. Vectors are usually printed
/// with six digits, so a smaller angle is a rounding error.
const ALONG_NORMAL: f64 = 1e-6;

/// The largest rounding error of normal . axis for unit vectors: three products and their sums, each rounded to half an
/// epsilon.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

impl Contact {
    /// A contact from the slope S and the angle alpha from the steepest line to the feed, counter-clockwise seen from
    /// above.
    ///
    /// alpha and alpha + 180 deg are the same feed line; alpha and -alpha differ only if the surface is twisted. At S =
    /// 0, alpha has no meaning. At S = 90 deg, alpha = 90 deg is the feed along the wall, and every other alpha is the
    /// vertical feed.
    ///
    /// # Errors
    /// [`ContactError::Slope`] unless 0 <= S <= 90 deg, [`ContactError::FeedAngle`] for an alpha that is not finite.
    pub fn from_degrees(slope: f64, alpha: f64) -> Result<Self, ContactError> {
        let slope = Self::checked_slope_deg(slope).and_then(Angle::from_degrees).map_err(ContactError::Slope)?;
        let alpha = Angle::from_degrees(alpha).map_err(ContactError::FeedAngle)?;
        let omega = Direction::of_vector(alpha.cos(), alpha.sin() * slope.cos());
        Ok(Self { slope, alpha, omega: omega.unwrap_or(alpha.into()) })
    }

    /// The angle in degrees if it is a slope: from 0 (floor) to 90 (wall).
    ///
    /// # Errors
    /// These bounds.
    pub const fn checked_slope_deg(degrees: f64) -> Result<f64, OutOfRange> {
        OutOfRange::check(degrees, 0.0, 90.0)
    }

    /// A contact on a slope from 0 to pi/2, fed along its steepest direction.
    pub(crate) fn up_the_slope(slope: Angle) -> Self {
        debug_assert!(slope.sin() >= 0.0 && slope.cos() >= 0.0, "a slope lies between floor and wall");
        Self { slope, alpha: Angle::ZERO, omega: Direction::ZERO }
    }

    /// A contact from the surface's normal n, which points out of the part, the feed vector, and the tool axis a, which
    /// points from the tip to the spindle. `None` for the tool axis is +Z. All vectors may have any length.
    ///
    /// Only the feed's component in the tangent plane is used. The tangent plane is spanned by the level direction v =
    /// a x n / |a x n| and the steepest descent u = v x n. omega is the angle of the feed from u towards v, and alpha
    /// that of its projection on the plane normal to the axis. If n is parallel to the axis, every direction is level,
    /// and u is the projection of X, or of Y if the axis is parallel to X.
    ///
    /// # Errors
    /// The [`ContactError`] of a vector that has no direction, points down, or is parallel to the normal.
    pub fn from_vectors(normal: [f64; 3], feed: [f64; 3], tool_axis: Option<[f64; 3]>) -> Result<Self, ContactError> {
        let normal = direction(normal).ok_or(ContactError::NormalWithoutDirection)?;
        let feed = direction(feed).ok_or(ContactError::FeedWithoutDirection)?;
        let axis = tool_axis.map_or(Some(Vector3::z()), direction).ok_or(ContactError::ToolAxisWithoutDirection)?;
        let up = match normal.dot(&axis) {
            up if up >= 0.0 => up,
            up if up >= -ROUNDING && tool_axis.is_some() => 0.0,
            _ => return Err(ContactError::NormalPointsDown),
        };
        let level = axis.cross(&normal);
        let slope = Angle::of_vector(up, level.norm()).ok_or(ContactError::NormalWithoutDirection)?;
        let level = direction(level.into()).unwrap_or_else(|| {
            let reference = if axis.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
            axis.cross(&reference).normalize()
        });
        let steepest = level.cross(&normal);
        let (along_steepest, along_level) = (feed.dot(&steepest), feed.dot(&level));
        if along_steepest.hypot(along_level) <= ALONG_NORMAL {
            return Err(ContactError::FeedAlongNormal);
        }
        let omega = Direction::of_vector(along_steepest, along_level).ok_or(ContactError::FeedAlongNormal)?;
        let alpha = Angle::of_vector(omega.cos() * slope.cos(), omega.sin()).unwrap_or(Angle::ZERO);
        Ok(Self { slope, alpha, omega })
    }

    /// S, the angle between the surface's normal and the tool axis, 0 (floor) to pi/2 (wall).
    #[must_use]
    pub fn slope(self) -> Angle {
        self.slope
    }

    /// alpha, the angle between the feed and the steepest slope, both seen from above.
    #[must_use]
    pub fn alpha(self) -> Angle {
        self.alpha
    }

    /// omega, the angle between the feed and the steepest slope in the tangent plane.
    #[must_use]
    pub fn omega(self) -> Direction {
        self.omega
    }

    /// d/s, the ratio of the distance of the passes seen from above to that along the surface: sqrt(1 - sin^2(S)
    /// sin^2(alpha)). It is 0 if passes are above each other on a wall.
    ///
    /// Without cancellation: 1 - sin^2(S) sin^2(alpha) = cos^2(alpha) + sin^2(alpha) cos^2(S).
    #[must_use]
    pub fn spacing_ratio(self) -> f64 {
        hypotenuse(self.alpha.cos(), self.alpha.sin() * self.slope.cos())
    }

    /// The angle at which the feed climbs or falls, exact: sin = sin(S) |cos(omega)|, from 0 to pi/2.
    #[must_use]
    pub fn climb(self) -> Direction {
        let sin = self.slope.sin() * self.omega.cos().abs();
        // cos^2 = 1 - sin^2(S) cos^2(omega) = cos^2(S) + sin^2(S) sin^2(omega)
        let cos = hypotenuse(self.slope.cos(), self.slope.sin() * self.omega.sin());
        Direction::of_vector(cos, sin).unwrap_or(Direction::ZERO)
    }
}

/// The unit vector along `v`, scaled first so that no component over- or underflows.
fn direction(v: [f64; 3]) -> Option<Vector3<f64>> {
    let v = Vector3::from(v);
    let largest = v.amax();
    (largest > 0.0 && largest.is_finite() && v.iter().all(|c| c.is_finite())).then(|| (v / largest).normalize())
}
