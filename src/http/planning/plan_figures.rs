//! Figures that plans and their operations have in common.

use crate::http::wire::answer;
use crate::planning::plan::{FinishFigures, SpacingFigures, TourFigures};

answer! {
    /// Distances between passes.
    #[derive(Clone, Copy)]
    #[schema(as = StepOverRange)]
    pub(super) struct SpacingAnswer of (spacing: &SpacingFigures) {
        /// The smallest.
        pub(super) min: f64 [minimum = 0] = spacing.min.mm(),
        /// The median.
        pub(super) median: f64 [minimum = 0] = spacing.median.mm(),
        /// The largest.
        pub(super) max: f64 [minimum = 0] = spacing.max.mm(),
    }

    /// The links between runs.
    #[derive(Clone, Copy)]
    #[schema(as = Links)]
    pub(super) struct LinksAnswer of (tour: &TourFigures) {
        /// The number of links.
        count: usize = tour.links,
        /// The length of all links.
        length_mm: f64 [minimum = 0] = tour.link_length,
        /// The number of links over the clearance height.
        lifts: usize = tour.lifts,
    }

    /// Scallop heights over the area.
    #[derive(Clone, Copy)]
    #[schema(as = ScallopHeights)]
    pub(super) struct ScallopAnswer of (heights: &FinishFigures) {
        /// The median.
        p50: f64 [minimum = 0] = heights.p50.mm(),
        /// The 90th percentile.
        p90: f64 [minimum = 0] = heights.p90.mm(),
        /// The 99th percentile.
        p99: f64 [minimum = 0] = heights.p99.mm(),
        /// The largest.
        max: f64 [minimum = 0] = heights.max.mm(),
    }
}
