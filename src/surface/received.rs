//! A surface that is being received, from a file or from JSON: the sums for its shape, and its facets.

use super::mesh::MeshBuilder;
use super::{SampledSurface, Sink};
use crate::cancellation::CancelFlag;

/// The largest number of facets of a surface; more are merged on a raster.
pub(crate) const MOST_FACETS: usize = 500_000;

/// A surface that is being received: the sums for its shape, and its facets.
#[derive(Debug, Default)]
pub(crate) struct ReceivedSurface {
    pub(crate) sampled: SampledSurface,
    pub(crate) mesh: MeshBuilder,
}

impl ReceivedSurface {
    /// An empty surface. Once `cancel` is set, receiving ends early, and the surface must be discarded.
    pub(crate) fn until(cancel: &CancelFlag) -> Self {
        Self { sampled: SampledSurface::new(), mesh: MeshBuilder::with_facet_limit(MOST_FACETS).with_cancel_flag(cancel) }
    }

    /// Leaves out facets that have the same corners as another one, as [`MeshBuilder::leave_out_duplicates`].
    pub(crate) fn leave_out_duplicates(&mut self) {
        let Self { sampled, mesh } = self;
        mesh.leave_out_duplicates(|corners| sampled.leave_out(corners));
    }
}

impl Sink for ReceivedSurface {
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
