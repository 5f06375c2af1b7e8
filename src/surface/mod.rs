//! A surface known by sample points or facets: readers of the files that CAD systems write, moments, principal axes, shape.

pub mod read;

/// Takes the pieces of which a surface is made, one after the other, and keeps of them what it needs. Readers are written against
/// this, so that a file of any size passes through without being held.
pub trait Sink {
    /// A point of the surface, not part of any facet.
    fn point(&mut self, point: [f64; 3]);
    /// A triangle of the surface, its corners counter-clockwise when seen from outside the part.
    fn facet(&mut self, corners: [[f64; 3]; 3]);
}
