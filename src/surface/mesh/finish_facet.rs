//! The facet that planning receives: corners, unit normal, area, and the curvature of the surface.

use crate::numerics::vector::dot;
use crate::quantity::Angle;

/// A facet that is to be finished: visible from above and selected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FinishFacet {
    /// The corners in mm, counter-clockwise seen from above.
    pub corners: [[f64; 3]; 3],
    /// The unit normal that points out of the part; its z is positive.
    pub normal: [f64; 3],
    /// The area in mm^2.
    pub area: f64,
    /// The curvature tensor of the surface in 1/mm, positive where the surface is convex: the symmetric 3 x 3 matrix K
    /// as xx, xy, xz, yy, yz, zz. It maps the normal to 0; the normal curvature along a unit tangent vector t is t'Kt,
    /// the twist of perpendicular tangents t and u is t'Ku.
    pub curvature: [f64; 6],
}

impl FinishFacet {
    /// The angle between the normal and the vertical, from 0 to under 90 deg: atan2(|(n_x, n_y)|, n_z), exact near both
    /// ends.
    #[must_use]
    pub fn slope(&self) -> Angle {
        let [x, y, z] = self.normal;
        Angle::from_radians(x.hypot(y).atan2(z))
    }

    /// t'Ku. If t = u is a unit tangent vector, that is the normal curvature along it; if t and u are perpendicular,
    /// the twist.
    #[must_use]
    pub fn curvature_between(&self, t: [f64; 3], u: [f64; 3]) -> f64 {
        let [xx, xy, xz, yy, yz, zz] = self.curvature;
        let ku = [xx * u[0] + xy * u[1] + xz * u[2], xy * u[0] + yy * u[1] + yz * u[2], xz * u[0] + yz * u[1] + zz * u[2]];
        dot(t, ku)
    }
}
