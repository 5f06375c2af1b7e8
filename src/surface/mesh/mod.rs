//! Triangle meshes of surfaces: building, visibility from above, connected pieces, selection and curvature.

mod builder;
mod facet_curvature;
mod merge;
mod pieces;
mod selection;
#[cfg(test)]
pub(super) mod shapes;
#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction where compared for equality
mod tests;
mod thinning;
mod visibility;

pub use builder::{MeshBuilder, MeshSize};
pub use facet_curvature::CREASE_ANGLE_DEG;
pub use pieces::{Closure, Pieces};
use selection::FileOrder;
pub use selection::{FinishFacet, Selection, SelectionError};
pub use visibility::{AreaShares, FacetClass, NO_FACET, ViewFromAbove, Visibility};

use super::{Bounds, Sink};
use crate::numerics::vector::{cross, difference, dot, length};
use std::fmt;

/// A facet is a wall if |n_z| of its unit normal is at most this, as in the sums over a surface: within 0.006 deg of
/// vertical. Single precision rounds corners by 6e-8 of their coordinates, which turns the normal of a 1 mm facet half
/// a metre from the origin by 3e-5.
const WALL: f64 = 1e-4;

/// Squares over this have no part that underflows.
const LEAST_SQUARED: f64 = 1e-200;

/// A triangle mesh: points in mm, and triangles as the numbers of their points. There is at least one triangle, and all
/// have an area.
#[derive(Debug, Clone)]
pub struct Mesh {
    points: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    bounds: Bounds,
    degenerate: u64,
    merged_cell: Option<f64>,
    from_points: bool,
    /// The order of the facets in the file; `None` for facets that were made here, from points or on a lattice.
    order: Option<FileOrder>,
}

/// The reason why facets or points do not make a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshError {
    /// A coordinate is not finite, or beyond [`LARGEST_COORDINATE`](super::LARGEST_COORDINATE).
    CoordinateOutOfRange,
    /// None of the facets has an area.
    OnlyDegenerateFacets {
        /// The number of facets.
        count: u64,
    },
    /// Fewer than three points, or all in one vertical plane.
    NoTriangulation {
        /// The number of points received.
        points: u64,
    },
    /// The facets were merged on a lattice because they are too many, and none covers a node: all are walls.
    NothingFromAbove,
    /// A triangle of an index list refers to a missing point.
    IndexOutOfRange {
        /// The triangle, from 0.
        triangle: usize,
        /// Its corner, from 0.
        corner: usize,
        /// The number of the missing point.
        index: u64,
        /// The number of points.
        points: usize,
    },
    /// A point of an index list has a coordinate that is not finite, or out of bounds.
    PointOutOfRange {
        /// The point, from 0.
        point: usize,
    },
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let largest = super::LARGEST_COORDINATE;
        match self {
            Self::CoordinateOutOfRange => write!(f, "coordinates must be finite numbers of at most {largest:e} in magnitude"),
            Self::OnlyDegenerateFacets { count } => write!(f, "none of the {count} facets has an area"),
            Self::NoTriangulation { points } => {
                write!(f, "a surface needs at least 3 points that are not on one line when seen from above; there are {points} points")
            }
            Self::NothingFromAbove => f.write_str("no facet can be seen from above; all are vertical"),
            Self::IndexOutOfRange { triangle, corner, index, points } => {
                write!(f, "corner {corner} of triangle {triangle} names point {index}, but there are {points} points, counted from 0")
            }
            Self::PointOutOfRange { point } => {
                write!(f, "point {point} must have finite coordinates of at most {largest:e} in magnitude")
            }
        }
    }
}

impl std::error::Error for MeshError {}

impl MeshBuilder {
    /// Adds the triangles of an index list, with points numbered from 0.
    ///
    /// # Errors
    /// [`MeshError::PointOutOfRange`] for a coordinate out of bounds, [`MeshError::IndexOutOfRange`] for the number of
    /// a missing point.
    pub fn indexed(&mut self, points: &[[f64; 3]], triangles: &[[u64; 3]]) -> Result<(), MeshError> {
        if let Some(point) = points.iter().position(|&point| !builder::in_range(point)) {
            return Err(MeshError::PointOutOfRange { point });
        }
        for (number, triangle) in triangles.iter().enumerate() {
            let mut corners = [[0.0; 3]; 3];
            for (corner, &index) in triangle.iter().enumerate() {
                let point = usize::try_from(index).ok().and_then(|index| points.get(index));
                corners[corner] = *point.ok_or(MeshError::IndexOutOfRange { triangle: number, corner, index, points: points.len() })?;
            }
            self.facet(corners);
        }
        Ok(())
    }
}

impl Mesh {
    fn assembled(points: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>, degenerate: u64, merged_cell: Option<f64>, from_points: bool) -> Self {
        let mut bounds = Bounds::NONE;
        triangles.iter().flatten().for_each(|&index| bounds.include(points[index as usize]));
        Self { points, triangles, bounds, degenerate, merged_cell, from_points, order: None }
    }

    /// Appends the facets of another mesh; they have no place in the order of the file.
    ///
    /// # Panics
    /// Never: the bounds on facets keep the numbers of points within 32 bits.
    pub fn append(&mut self, other: &Self) {
        let shift = u32::try_from(self.points.len()).expect("points are numbered with 32 bits");
        self.points.extend_from_slice(&other.points);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|corner| corner + shift)));
        other.points.iter().for_each(|point| self.bounds.include(*point));
    }

    /// The number of triangles and points.
    #[must_use]
    pub fn size(&self) -> MeshSize {
        MeshSize { facets: self.triangles.len(), points: self.points.len() }
    }

    /// The points, in mm.
    #[must_use]
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// The triangles, each three numbers of points, counter-clockwise seen from outside the part.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The box around all triangles, in mm.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The number of facets without area, which are left out.
    #[must_use]
    pub fn degenerate_facets(&self) -> u64 {
        self.degenerate
    }

    /// The spacing in mm of the lattice on which the surface was merged because it had too many facets or points;
    /// `None` if it was not merged.
    #[must_use]
    pub fn merged_cell(&self) -> Option<f64> {
        self.merged_cell
    }

    /// Whether the triangles are a triangulation of single points.
    #[must_use]
    pub fn from_points(&self) -> bool {
        self.from_points
    }

    /// The corners of a triangle.
    #[must_use]
    pub fn corners(&self, facet: usize) -> [[f64; 3]; 3] {
        self.triangles[facet].map(|index| self.points[index as usize])
    }

    fn centroid(&self, facet: usize) -> [f64; 3] {
        let [a, b, c] = self.corners(facet);
        [0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0)
    }

    /// The unit normal of a triangle, by the order of its corners, and its area in mm^2; both are 0 if rounding left no
    /// area.
    #[must_use]
    pub fn normal_and_area(&self, facet: usize) -> ([f64; 3], f64) {
        let [a, b, c] = self.corners(facet);
        let normal = twice_area(a, b, c);
        let squared = dot(normal, normal);
        if squared > LEAST_SQUARED {
            let length = squared.sqrt();
            return (normal.map(|part| part / length), 0.5 * length);
        }
        // Scaled by the largest component, so that squares of tiny components do not underflow.
        let largest = normal.iter().fold(0.0_f64, |largest, part| largest.max(part.abs()));
        // A facet as thin as a rounding error may lose its area in the conversion to mm.
        if largest == 0.0 {
            return ([0.0; 3], 0.0);
        }
        let scaled = normal.map(|part| part / largest);
        let length = length(scaled);
        (scaled.map(|part| part / length), 0.5 * length * largest)
    }
}

/// (b - a) x (c - a), a vector along the normal with twice the area as its length.
fn twice_area(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [f64; 3] {
    cross(difference(b, a), difference(c, a))
}
