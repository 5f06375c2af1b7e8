//! Where and how the cutter touches the surface: slope and feed direction, from angles or from vectors.

use crate::quantity::{Angle, OutOfRange};
use nalgebra::Vector3;
use std::fmt;

/// A contact between cutter and surface: the slope S, and the feed's direction as two angles to the line of steepest slope.
///
/// - `alpha` is measured in the horizontal XY plane,
/// - `theta` in the tangent plane, tan(theta) = tan(alpha) cos(S).
///
/// Formulas written for one are wrong for the other, so both are kept. On a vertical wall all feeds but the vertical one have
/// `alpha` = 90 deg, and only `theta` tells them apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    slope: Angle,
    alpha: Angle,
    theta: Angle,
}

/// Why two vectors, or two angles, do not describe a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactError {
    /// The slope is outside 0 to 90 deg.
    Slope(OutOfRange),
    /// The feed angle is not a finite number.
    FeedAngle(OutOfRange),
    /// The normal has no length, or a component that is not finite.
    NormalWithoutDirection,
    /// The normal points down: a cutter from above cannot touch there.
    NormalPointsDown,
    /// The feed has no length, or a component that is not finite.
    FeedWithoutDirection,
    /// The feed runs along the normal, so it has no direction in the surface.
    FeedAlongNormal,
}

impl fmt::Display for ContactError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slope(bounds) => write!(f, "the slope {bounds} deg"),
            Self::FeedAngle(_) => f.write_str("the feed angle must be a finite number of degrees"),
            Self::NormalWithoutDirection => f.write_str("the normal must have a length; it points out of the part"),
            Self::NormalPointsDown => f.write_str(
                "the normal points down (z < 0), where a cutter from above cannot touch; give the normal that points out of the part",
            ),
            Self::FeedWithoutDirection => f.write_str("the feed vector must have a length"),
            Self::FeedAlongNormal => {
                f.write_str("the feed runs along the normal and has no direction in the surface; give a feed that follows the surface")
            }
        }
    }
}

impl std::error::Error for ContactError {}

/// Sine of the angle between feed and normal under which the feed counts as running along the normal: vectors are commonly
/// printed with six digits, so a smaller angle is their rounding.
const ALONG_NORMAL: f64 = 1e-6;

impl Contact {
    /// A contact from the slope S and the angle alpha between feed and steepest slope, seen from above.
    ///
    /// alpha and alpha + 180 deg are the same feed line, and so are alpha and -alpha by symmetry. At S = 0 alpha has no meaning.
    /// At S = 90 deg, alpha = 90 deg is the feed along the wall and every other alpha the vertical feed.
    ///
    /// # Errors
    /// [`ContactError::Slope`] unless 0 <= S <= 90 deg, [`ContactError::FeedAngle`] for an alpha that is not finite.
    pub fn from_degrees(slope: f64, alpha: f64) -> Result<Self, ContactError> {
        OutOfRange::check(slope, 0.0, 90.0).map_err(ContactError::Slope)?;
        let slope = Angle::from_degrees(slope).map_err(ContactError::Slope)?;
        let alpha = Angle::from_degrees(alpha).map_err(ContactError::FeedAngle)?;
        let theta = Angle::of_vector(alpha.cos(), alpha.sin() * slope.cos());
        Ok(Self { slope, alpha, theta: theta.unwrap_or(alpha) })
    }

    /// A contact on a slope from 0 to pi/2, fed along its steepest direction.
    pub(crate) fn up_the_slope(slope: Angle) -> Self {
        debug_assert!(slope.sin() >= 0.0 && slope.cos() >= 0.0, "a slope lies between floor and wall");
        Self { slope, alpha: Angle::ZERO, theta: Angle::ZERO }
    }

    /// A contact from the surface's normal, pointing out of the part, and the feed vector, both of any length.
    ///
    /// Only the feed's part in the tangent plane counts. With n at slope S, D its horizontal direction and Z up, the tangent
    /// plane is spanned by the steepest descent u = (D cos S, -sin S) and the level direction v = Z x D; theta is the angle
    /// of the feed from u towards v, and alpha that of its projection on the XY plane from D.
    ///
    /// # Errors
    /// The [`ContactError`] that says which vector has no direction, points down, or follows the normal.
    pub fn from_vectors(normal: [f64; 3], feed: [f64; 3]) -> Result<Self, ContactError> {
        let normal = direction(normal).ok_or(ContactError::NormalWithoutDirection)?;
        let feed = direction(feed).ok_or(ContactError::FeedWithoutDirection)?;
        if normal.z < 0.0 {
            return Err(ContactError::NormalPointsDown);
        }
        let slope = Angle::of_vector(normal.z, normal.x.hypot(normal.y)).ok_or(ContactError::NormalWithoutDirection)?;
        // On a floor every horizontal direction is as steep as any other.
        let down_hill = Angle::of_vector(normal.x, normal.y).unwrap_or(Angle::ZERO);
        let steepest = Vector3::new(down_hill.cos() * slope.cos(), down_hill.sin() * slope.cos(), -slope.sin());
        let level = Vector3::new(-down_hill.sin(), down_hill.cos(), 0.0);
        let (along_steepest, along_level) = (feed.dot(&steepest), feed.dot(&level));
        if along_steepest.hypot(along_level) <= ALONG_NORMAL {
            return Err(ContactError::FeedAlongNormal);
        }
        let theta = Angle::of_vector(along_steepest, along_level).ok_or(ContactError::FeedAlongNormal)?;
        let alpha = Angle::of_vector(theta.cos() * slope.cos(), theta.sin()).unwrap_or(Angle::ZERO);
        Ok(Self { slope, alpha, theta })
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

    /// theta, the angle between the feed and the steepest slope in the tangent plane.
    #[must_use]
    pub fn theta(self) -> Angle {
        self.theta
    }

    /// The ratio d/s between the distance of the passes seen from above and along the surface,
    /// sqrt(1 - sin^2(S) sin^2(alpha)): 0 where passes lie above each other on a wall.
    ///
    /// Without cancellation: 1 - sin^2(S) sin^2(alpha) = cos^2(alpha) + sin^2(alpha) cos^2(S).
    #[must_use]
    pub fn spacing_ratio(self) -> f64 {
        self.alpha.cos().hypot(self.alpha.sin() * self.slope.cos())
    }

    /// The angle at which the feed climbs or falls, exact: sin = sin(S) |cos(theta)|, from 0 to pi/2.
    #[must_use]
    pub fn climb(self) -> Angle {
        let sin = self.slope.sin() * self.theta.cos().abs();
        // cos^2 = 1 - sin^2(S) cos^2(theta) = cos^2(S) + sin^2(S) sin^2(theta)
        let cos = self.slope.cos().hypot(self.slope.sin() * self.theta.sin());
        Angle::of_vector(cos, sin).unwrap_or(Angle::ZERO)
    }
}

/// The unit vector along `v`, scaled first so that no component over- or underflows.
fn direction(v: [f64; 3]) -> Option<Vector3<f64>> {
    let v = Vector3::from(v);
    let largest = v.amax();
    (largest > 0.0 && largest.is_finite() && v.iter().all(|c| c.is_finite())).then(|| (v / largest).normalize())
}
