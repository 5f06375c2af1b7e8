//! The curvature of the surface at the contact, in every direction of the tangent plane.

use crate::quantity::{Angle, Length, OutOfRange};
use std::fmt;

/// The curvature of the surface at the contact, a symmetric 2 x 2 form in the axes of the feed: x along the feed F, y
/// along T = n x F, which points to the left of the feed seen from outside.
///
/// To second order the surface is w = -1/2 (k_F x^2 + 2 k_FT x y + k_T y^2) over the tangent plane, w along the normal
/// n. A component is 1/radius in 1/mm: positive where the surface is convex (it falls away from the tangent plane),
/// negative where it is concave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceCurvature {
    along: f64,
    across: f64,
    twist: f64,
}

/// The component of a [`SurfaceCurvature`] that is outside its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurvatureComponent {
    /// k_F, along the feed.
    Along,
    /// k_T, across the feed.
    Across,
    /// k_FT, the twist.
    Twist,
    /// The first principal curvature.
    FirstPrincipal,
    /// The second principal curvature.
    SecondPrincipal,
}

/// A curvature that is larger than [`SurfaceCurvature::LARGEST_PER_MM`], or not a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvatureOutOfRange {
    /// The component.
    pub component: CurvatureComponent,
    /// The bounds of that component, in 1/mm.
    pub bounds: OutOfRange,
}

impl fmt::Display for CurvatureOutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let component = match self.component {
            CurvatureComponent::Along => "the curvature along the feed",
            CurvatureComponent::Across => "the curvature across the feed",
            CurvatureComponent::Twist => "the twist",
            CurvatureComponent::FirstPrincipal => "the first principal curvature",
            CurvatureComponent::SecondPrincipal => "the second principal curvature",
        };
        write!(f, "{component} {} per mm", self.bounds)
    }
}

impl std::error::Error for CurvatureOutOfRange {}

impl SurfaceCurvature {
    /// A plane.
    pub const PLANE: Self = Self { along: 0.0, across: 0.0, twist: 0.0 };
    /// The smallest radius that is accepted, in mm.
    pub const SMALLEST_RADIUS: f64 = Length::SMALLEST;
    /// The largest radius that is accepted, in mm. A surface with a larger radius is a plane for any machine tool.
    pub const LARGEST_RADIUS: f64 = 1e12;
    /// The largest component that is accepted, in 1/mm, that of [`SurfaceCurvature::SMALLEST_RADIUS`].
    pub const LARGEST_PER_MM: f64 = 1.0 / Length::SMALLEST;

    /// A surface with the radius rho in mm across the feed, positive if convex and negative if concave, and straight
    /// along the feed.
    ///
    /// # Errors
    /// [`OutOfRange`] with the bounds of |rho|, for a radius that is 0, beyond them, or not a number.
    pub fn from_radius_mm(radius: f64) -> Result<Self, OutOfRange> {
        OutOfRange::check(radius.abs(), Self::SMALLEST_RADIUS, Self::LARGEST_RADIUS)?;
        Ok(Self { across: radius.recip(), ..Self::PLANE })
    }

    /// From k_F, k_T and k_FT in 1/mm.
    ///
    /// # Errors
    /// [`CurvatureOutOfRange`] for the first component whose magnitude exceeds [`SurfaceCurvature::LARGEST_PER_MM`].
    pub fn from_components_per_mm(along: f64, across: f64, twist: f64) -> Result<Self, CurvatureOutOfRange> {
        Ok(Self {
            along: within_bounds(along, CurvatureComponent::Along)?,
            across: within_bounds(across, CurvatureComponent::Across)?,
            twist: within_bounds(twist, CurvatureComponent::Twist)?,
        })
    }

    /// From the principal curvatures k1 and k2 in 1/mm; `angle` is that from the feed to the direction of k1,
    /// counter-clockwise seen from outside:
    ///
    /// k_F = k1 cos^2 + k2 sin^2, k_T = k1 sin^2 + k2 cos^2, k_FT = (k1 - k2) sin cos
    ///
    /// # Errors
    /// [`CurvatureOutOfRange`] for the first one whose magnitude exceeds [`SurfaceCurvature::LARGEST_PER_MM`].
    pub fn from_principal_per_mm(principal: [f64; 2], angle: Angle) -> Result<Self, CurvatureOutOfRange> {
        let first = within_bounds(principal[0], CurvatureComponent::FirstPrincipal)?;
        let second = within_bounds(principal[1], CurvatureComponent::SecondPrincipal)?;
        let (sin, cos) = (angle.sin(), angle.cos());
        Ok(Self {
            along: first * cos * cos + second * sin * sin,
            across: first * sin * sin + second * cos * cos,
            twist: (first - second) * sin * cos,
        })
    }

    /// k_F, the curvature along the feed, in 1/mm.
    #[must_use]
    pub fn along_per_mm(self) -> f64 {
        self.along
    }

    /// k_T, the curvature across the feed, in 1/mm.
    #[must_use]
    pub fn across_per_mm(self) -> f64 {
        self.across
    }

    /// k_FT, the twist, in 1/mm.
    #[must_use]
    pub fn twist_per_mm(self) -> f64 {
        self.twist
    }

    /// Whether the surface is a plane.
    #[must_use]
    pub fn is_plane(self) -> bool {
        self == Self::PLANE
    }

    /// The principal curvatures in 1/mm, the larger first: (k_F + k_T)/2 +- sqrt(((k_F - k_T)/2)^2 + k_FT^2).
    #[must_use]
    pub fn principal_per_mm(self) -> [f64; 2] {
        eigenvalues(self.along, self.across, self.twist)
    }

    /// The same surface in axes of the tangent plane turned from those of the feed by `angle`, counter-clockwise seen
    /// from outside.
    pub(super) fn turned(self, sin: f64, cos: f64) -> Self {
        let (along, across, twist) = (self.along, self.across, self.twist);
        Self {
            along: along * cos * cos + 2.0 * twist * sin * cos + across * sin * sin,
            across: along * sin * sin - 2.0 * twist * sin * cos + across * cos * cos,
            twist: (across - along) * sin * cos + twist * (cos - sin) * (cos + sin),
        }
    }

    /// A surface of the same shape with both principal curvatures multiplied by `factor`.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { along: factor * self.along, across: factor * self.across, twist: factor * self.twist }
    }
}

/// The eigenvalues of [[a, c], [c, b]], the larger first.
pub(super) fn eigenvalues(a: f64, b: f64, c: f64) -> [f64; 2] {
    let (mean, spread) = (f64::midpoint(a, b), ((a - b) / 2.0).hypot(c));
    [mean + spread, mean - spread]
}

fn within_bounds(value: f64, component: CurvatureComponent) -> Result<f64, CurvatureOutOfRange> {
    let largest = SurfaceCurvature::LARGEST_PER_MM;
    // Adding 0 removes the sign of a negative zero.
    OutOfRange::check(value, -largest, largest).map(|value| value + 0.0).map_err(|bounds| CurvatureOutOfRange { component, bounds })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn principal_curvatures_come_back_from_the_components() {
        for degrees in [0.0, 30.0, 90.0, -55.0, 200.0] {
            let angle = Angle::from_degrees(degrees).unwrap();
            let surface = SurfaceCurvature::from_principal_per_mm([0.012, -0.005], angle).unwrap();
            let [first, second] = surface.principal_per_mm();
            assert_abs_diff_eq!(first, 0.012, epsilon = 1e-17);
            assert_abs_diff_eq!(second, -0.005, epsilon = 1e-17);
            // In the axes of the principal directions there is no twist.
            let turned = surface.turned(angle.sin(), angle.cos());
            assert_abs_diff_eq!(turned.along_per_mm(), 0.012, epsilon = 1e-17);
            assert_abs_diff_eq!(turned.twist_per_mm(), 0.0, epsilon = 1e-17);
        }
    }

    #[test]
    fn a_component_out_of_bounds_is_named() {
        let component = |[along, across, twist]: [f64; 3]| {
            SurfaceCurvature::from_components_per_mm(along, across, twist).map_err(|error| error.component).unwrap_err()
        };
        assert_eq!(component([f64::NAN, 2e6, 0.0]), CurvatureComponent::Along);
        assert_eq!(component([0.0, 2e6, 0.0]), CurvatureComponent::Across);
        assert_eq!(component([0.0, 0.0, f64::NEG_INFINITY]), CurvatureComponent::Twist);
        let error = SurfaceCurvature::from_principal_per_mm([0.0, -1e7], Angle::ZERO).unwrap_err();
        assert_eq!(error.to_string(), "the second principal curvature must be from -1000000 to 1000000 per mm");
    }
}
