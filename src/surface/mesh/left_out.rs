//! Facets and points that a mesh leaves out: facets without area, and coordinates out of bounds.

use super::twice_area;
use crate::surface::LARGEST_COORDINATE;

/// The facets and points that a mesh, or a part of one, has left out so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LeftOut {
    /// The number of facets without area.
    pub(super) degenerate: u64,
    /// Whether a coordinate was out of bounds; such a surface has no mesh.
    pub(super) is_out_of_range: bool,
}

impl LeftOut {
    /// Whether a point belongs to the mesh. A point out of bounds is recorded.
    pub(super) fn accepts_point(&mut self, point: [f64; 3]) -> bool {
        let is_in_range = in_range(point);
        self.is_out_of_range |= !is_in_range;
        is_in_range
    }

    /// Whether a facet belongs to the mesh. A facet out of bounds or without area is recorded.
    #[inline]
    pub(super) fn accepts_facet(&mut self, corners: [[f64; 3]; 3]) -> bool {
        if !corners.into_iter().all(in_range) {
            self.is_out_of_range = true;
            return false;
        }
        let [a, b, c] = corners;
        let [x, y, z] = twice_area(a, b, c);
        let has_area = x != 0.0 || y != 0.0 || z != 0.0;
        self.degenerate += u64::from(!has_area);
        has_area
    }
}

/// Whether all coordinates are numbers of at most [`LARGEST_COORDINATE`] in magnitude.
pub(super) fn in_range(point: [f64; 3]) -> bool {
    point.iter().all(|coordinate| coordinate.abs() <= LARGEST_COORDINATE)
}
