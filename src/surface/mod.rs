//! Surfaces given by sample points or facets: file readers, moments, principal axes, shape and meshes.

mod bezier;
mod grid;
pub mod mesh;
mod moments;
pub mod read;
mod received;
mod sampled;
mod shape;
mod triangulation;

pub use bezier::{Bezier, BezierError};
pub use grid::{Grid, GridError};
pub use mesh::{FinishFacet, Mesh, MeshBuilder, MeshError};
pub use moments::{Bounds, Moments, PrincipalAxes};
pub(crate) use received::{MOST_FACETS, ReceivedSurface};
pub use sampled::{Facing, SampledSurface};
pub use shape::{Basis, Shape, ShapeError};
pub use triangulation::LONG_EDGE;

/// The largest magnitude of a coordinate, in its own unit: the fourth powers in moments stay below 1e50, so that no sum
/// over a surface can overflow.
pub const LARGEST_COORDINATE: f64 = 1e12;

/// A receiver of the points or facets of a surface, one by one. Readers pass them to a sink, so that a file of any size
/// is read without being stored.
pub trait Sink {
    /// A point of the surface, not part of any facet.
    fn point(&mut self, point: [f64; 3]);
    /// A triangle of the surface, its corners counter-clockwise when seen from outside the part.
    fn facet(&mut self, corners: [[f64; 3]; 3]);
    /// Reverses the outer side of every facet; to be called after the last facet. Does nothing in a sink that ignores
    /// sides.
    fn turn_over(&mut self) {}
}

/// The unit of a surface's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// 1 mm
    #[default]
    Millimetre,
    /// 10 mm
    Centimetre,
    /// 1000 mm
    Metre,
    /// 25.4 mm
    Inch,
    /// 0.001 mm
    Micrometre,
    /// 304.8 mm
    Foot,
}

impl Unit {
    /// The unit in mm.
    #[must_use]
    pub fn mm(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Metre => 1000.0,
            Self::Inch => 25.4,
            Self::Micrometre => 1e-3,
            Self::Foot => 304.8,
        }
    }
}
