//! A surface known by sample points or facets: readers of the files that CAD systems write, moments, principal axes, shape.

mod bezier;
mod bounds;
mod facets;
mod grid;
mod lanes;
pub mod mesh;
mod moments;
mod piece;
mod principal_axes;
pub mod read;
mod sampled;
mod shape;
mod slope;
mod triangulation;

pub use bezier::{Bezier, BezierError};
pub use bounds::Bounds;
pub use grid::{Grid, GridError};
pub use mesh::{FinishFacet, Mesh, MeshBuilder, MeshError};
pub use moments::Moments;
pub use principal_axes::PrincipalAxes;
pub use sampled::{Basis, Facing, SampledSurface, Unit};
pub use shape::{Shape, ShapeError};
pub use triangulation::LONG_EDGE;

/// The largest magnitude of a coordinate, in the unit in which it is given: the fourth powers that moments need stay below 1e50, so that no
/// sum over a surface can overflow.
pub const LARGEST_COORDINATE: f64 = 1e12;

/// Takes the pieces of which a surface is made, one after the other, and keeps of them what it needs. Readers are written against
/// this, so that a file of any size passes through without being held.
pub trait Sink {
    /// A point of the surface, not part of any facet.
    fn point(&mut self, point: [f64; 3]);
    /// A triangle of the surface, its corners counter-clockwise when seen from outside the part.
    fn facet(&mut self, corners: [[f64; 3]; 3]);
    /// Takes the other side of every facet for the outer one; to be called after the last facet. Does nothing where sides do not count.
    fn turn_over(&mut self) {}
}
