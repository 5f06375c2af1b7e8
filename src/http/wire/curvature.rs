//! The surface's curvature at a contact.

use crate::http::reading::{Quantity, members};
use crate::milling::SurfaceCurvature;

const RADIUS: Quantity<SurfaceCurvature> = Quantity::new(SurfaceCurvature::from_radius_mm, 120.0)
    .down_to(-SurfaceCurvature::LARGEST_RADIUS, "; the bounds are those of its magnitude; leave the field out for a plane");

members! {
    /// The members of a curvature.
    pub(super) plain struct CurvatureMembers / CurvatureSlots {
        radius: optional SURFACE_RADIUS: Quantity<SurfaceCurvature> = ("surface_radius_mm", RADIUS,
            "the surface's radius of curvature across the feed: positive convex, negative concave, absent = plane; at least 1e-6 in magnitude"),
    }
}
