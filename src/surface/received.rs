//! A surface that is being received, from a file or from JSON: the sums for its shape, and its facets.

use super::mesh::{MeshBuilder, MeshPart};
use super::{PartedSink, SampledSurface, Sink};
use crate::cancellation::CancelFlag;

/// The largest number of facets of a surface; more are merged on a raster.
pub(crate) const MOST_FACETS: usize = 500_000;

/// A surface or a part of one that is being received: the sums for its shape, and its facets in `M`.
#[derive(Debug, Default)]
pub(crate) struct Received<M> {
    pub(crate) sampled: SampledSurface,
    pub(crate) mesh: M,
}

/// A whole surface.
pub(crate) type ReceivedSurface = Received<MeshBuilder>;

/// A part of a surface, which one thread fills.
pub(crate) type ReceivedPart = Received<MeshPart>;

impl ReceivedSurface {
    /// An empty surface. Once `cancel` is set, receiving ends early, and the surface must be discarded.
    pub(crate) fn until(cancel: &CancelFlag) -> Self {
        Self { sampled: SampledSurface::new(), mesh: MeshBuilder::with_facet_limit(MOST_FACETS).with_cancel_flag(cancel) }
    }
}

impl ReceivedSurface {
    /// Leaves out facets that have the same corners as another one, as [`MeshBuilder::leave_out_duplicates`].
    pub(crate) fn leave_out_duplicates(&mut self) {
        let Self { sampled, mesh } = self;
        mesh.leave_out_duplicates(|corners| sampled.leave_out(corners));
    }
}

impl<M: Sink> Sink for Received<M> {
    fn point(&mut self, point: [f64; 3]) {
        self.sampled.point(point);
        self.mesh.point(point);
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        self.sampled.facet(corners);
        self.mesh.facet(corners);
    }

    fn turn_over(&mut self) {
        self.sampled.turn_over();
        self.mesh.turn_over();
    }
}

impl PartedSink for ReceivedSurface {
    type Part = ReceivedPart;

    fn part(&self) -> ReceivedPart {
        ReceivedPart { sampled: SampledSurface::new(), mesh: self.mesh.part() }
    }

    fn append(&mut self, part: ReceivedPart) {
        self.sampled.merge(&part.sampled);
        self.mesh.append(part.mesh);
    }
}
