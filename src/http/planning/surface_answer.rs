//! Wire object of the surface in an answer: its shape and facets.

use super::candidates::line_degrees;
use crate::http::wire::{Source, answer};
use crate::planning::machined_surface::MachinedSurface;
use crate::quantity::{Angle, Area};
use crate::surface::{Basis, Shape};

answer! {
    /// The shape of a surface. Directions are lines seen from above, from +X counter-clockwise, in [0, 180).
    #[schema(as = SurfaceShape)]
    pub(super) struct SurfaceAnswer of (shape: &Shape, source: Source, machined: Option<&MachinedSurface>) {
        /// The form in which the surface was sent; for a file, the format detected by its content.
        source: Source = source,
        /// The number of points from which the shape was computed; 0 if it was computed from facets.
        points: u64 = if shape.basis == Basis::Points { shape.elements } else { 0 },
        /// The number of facets from which the shape was computed; for points or a patch, the number of facets formed from
        /// them.
        facets: u64 = facets(shape, machined),
        /// The angle between the best-fit plane and the horizontal.
        slope_deg: f64 [minimum = 0, maximum = 90] = shape.slope.degrees(),
        /// The mean of the slopes of all facets or samples; for points, of the facets formed from them. Absent in method
        /// rectangle for points that span no facets.
        mean_slope_deg?: f64 [minimum = 0, maximum = 90] = mean_slope(shape, machined).map(Angle::degrees),
        /// mu, the long side over the short side of the equivalent rectangle, which has the same variances.
        form_factor: f64 [minimum = 1] = shape.form_factor.ratio(),
        /// chi, the area of the equivalent rectangle.
        characteristic_size_mm2: f64 [minimum = 0] = shape.characteristic_size.mm2(),
        /// The direction along which the surface extends most. Absent if it extends equally in every direction, or most
        /// along the vertical.
        principal_direction_deg?: f64 [minimum = 0, exclusive_maximum = 180] = shape.principal_direction.map(line_degrees),
        /// The steepest direction of the best-fit plane. Absent if that plane is level.
        steepest_direction_deg?: f64 [minimum = 0, exclusive_maximum = 180] = shape.steepest_direction.map(line_degrees),
        /// The angle between these two directions, which the published method assumes to be 90. Absent if one of them is
        /// absent.
        direction_gap_deg?: f64 [minimum = 0, maximum = 90] = shape.direction_gap.map(Angle::degrees),
        /// sqrt(l3/l1) of the eigenvalues: 0 for a plane.
        flatness: f64 [minimum = 0, maximum = 1] = shape.flatness,
        /// The covariance matrix of the coordinates, in rows: of the points or samples, or integrated over the facets.
        covariance_mm2: [[f64; 3]; 3] [min_items = 3, max_items = 3] = shape.covariance,
        /// The unit eigenvectors e1, e2 and e3 of the covariance matrix. e3 is the normal of the best-fit plane and points up,
        /// e1 points to the half plane y > 0, and e2 = e3 x e1.
        eigenvectors: [[f64; 3]; 3] [min_items = 3, max_items = 3] = shape.eigenvectors,
        /// The eigenvalues l1 >= l2 >= l3 of the covariance matrix.
        eigenvalues_mm2: [f64; 3] [min_items = 3, max_items = 3] = shape.eigenvalues.map(Area::mm2),
        /// The centroid [x, y, z].
        centroid_mm: [f64; 3] [min_items = 3, max_items = 3] = shape.centroid,
        /// The box around the points or facets from which the shape was computed.
        bounds_mm: BoundsAnswer = BoundsAnswer { min: shape.bounds.min, max: shape.bounds.max },
        /// The area. Absent in method rectangle for points that span no facets.
        area_mm2?: f64 [minimum = 0] = shape.area.map(Area::mm2).or(machined.map(|machined| machined.facets.visibility.area())),
        /// The share of the area of all facets that is seen from above.
        visible_area_share?: f64 [minimum = 0, maximum = 1] = machined.map(|machined| machined.facets.visible_area_share()),
        /// The share of the area of all facets that is seen from above and steeper than `max_slope_deg`, walls included.
        steep_area_share?: f64 [minimum = 0, maximum = 1] = machined.map(|machined| machined.facets.visibility.shares().steep),
        /// The number of connected pieces of the surface.
        pieces?: u32 [minimum = 1] = machined.map(|machined| machined.facets.pieces.count()),
    }

    /// A box with sides along the axes.
    #[schema(as = Bounds)]
    struct BoundsAnswer {
        /// The smallest x, y and z.
        min: [f64; 3] [min_items = 3, max_items = 3],
        /// The largest x, y and z.
        max: [f64; 3] [min_items = 3, max_items = 3],
    }
}

/// The mean slope of the elements of the shape or, without such, of the facets that were made of the points.
fn mean_slope(shape: &Shape, machined: Option<&MachinedSurface>) -> Option<Angle> {
    shape.mean_slope.or_else(|| machined.map(|machined| machined.workpiece.figures().mean_slope))
}

/// The number of facets from which the shape was computed or, without such, of those that were made of the points.
fn facets(shape: &Shape, machined: Option<&MachinedSurface>) -> u64 {
    let made = machined.map_or(0, |machined| machined.facets.mesh.triangles().len() as u64);
    if shape.basis == Basis::Points || shape.elements == 0 { made } else { shape.elements }
}
