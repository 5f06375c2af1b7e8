//! The passes of an answer, point by point.

use super::simulation::Simulation;
use crate::http::wire::answer;
use crate::planning::machined_surface::{MachinedSurface, Stop};
use crate::planning::reach::RestingHeights;
use crate::planning::zigzag::{self, PassPoint, TooManyPoints};
use crate::quantity::Length;

/// The most points of an answer, some 25 MB of JSON.
const MOST_POINTS: usize = 100_000;

/// The cells along each side of the raster on which tips are checked against the whole surface.
const SIDE: usize = 1024;

answer! {
    /// The passes of the recommended plan: columns over all points, in cutting order.
    #[schema(as = Passes)]
    pub(crate) struct PassesAnswer of (passes: zigzag::Passes) {
        /// The index in the columns at which each run begins. Between two runs the cutter moves on a straight link. If a
        /// link on the surface would cut into it, the run before the link ends with raised points along it.
        run_starts: Vec<usize> = passes.run_starts,
        /// The point at which the cutter touches the surface, or, where a pass continues beside a narrow face, the face's
        /// extended plane; null if the tip is raised because the cutter would gouge the surface elsewhere, and on the way over
        /// such places.
        contact_mm: Vec<Option<[f64; 3]>> = column(&passes.points, |point| point.contact),
        /// The unit normal of the surface; while the cutter turns around an edge, that of a face beside it.
        normal: Vec<[f64; 3]> = column(&passes.points, |point| point.normal),
        /// The lowest point of the cutter on its axis.
        tip_mm: Vec<[f64; 3]> = column(&passes.points, |point| point.tip),
        /// The step-over along the surface to the farther of the neighbouring passes.
        step_over_mm: Vec<f64> = column(&passes.points, |point| point.step_over.mm()),
        /// The largest feed per tooth that keeps the scallop height; absent for a cutter without teeth and spindle speed.
        feed_per_tooth_mm?: Vec<f64> = passes.points.iter().map(|point| point.feed_per_tooth.map(Length::mm)).collect(),
        /// The feed rate of that feed per tooth; the machine's feed rate for a cutter without teeth and spindle speed.
        feed_rate_mm_min: Vec<f64> = column(&passes.points, |point| point.feed_rate.mm_min()),
        /// The scallop height by the plan's model; null if the model has none.
        scallop_height_mm: Vec<Option<f64>> = column(&passes.points, |point| point.scallop_height.map(Length::mm)),
        /// The curvature of the surface.
        surface_curvature: CurvatureColumns = CurvatureColumns::of(&passes.points),
        /// The time of all runs and links along the path of the tips. The plan's `machining_time_s` is computed along the
        /// path of the contacts. That path is shorter if the contact moves across the cutter's bottom or tips are raised.
        machining_time_s: f64 [minimum = 0] = passes.time.seconds(),
        /// The largest distance of omitted points from the lines between the given ones; for tips, the distance along the
        /// normal.
        chord_tolerance_mm: f64 [minimum = 0] = passes.chord_tolerance.mm(),
    }

    /// The curvature of a surface in the axes of the feed, in 1/mm, positive where convex.
    #[expect(clippy::struct_field_names, reason = "the wire names, each with its unit")]
    struct CurvatureColumns of (points: &[PassPoint]) {
        /// Along the feed.
        along_per_mm: Vec<f64> = column(points, |point| point.curvature[0]),
        /// Across the feed.
        across_per_mm: Vec<f64> = column(points, |point| point.curvature[1]),
        /// The twist.
        twist_per_mm: Vec<f64> = column(points, |point| point.curvature[2]),
    }
}

impl PassesAnswer {
    /// The passes of the fastest plan; `None` without a plan. Once `stop` returns true, the result must be discarded.
    pub(super) fn new(machined: &MachinedSurface, simulation: &Simulation, stop: Stop) -> Option<Result<Self, TooManyPoints>> {
        let plan = simulation.ranking.plans.first()?;
        let candidate = &simulation.candidates[plan.candidate];
        let resting = RestingHeights::new(&machined.mesh.seen_from_above_until(SIDE, stop));
        let raised = |tip: [f64; 3]| resting.raised(candidate.cutter, tip);
        let passes = zigzag::passes_until(plan, &machined.facets, candidate, &simulation.settings, &raised, MOST_POINTS, stop);
        Some(passes.map(Self::of))
    }
}

fn column<T>(points: &[PassPoint], of: impl FnMut(&PassPoint) -> T) -> Vec<T> {
    points.iter().map(of).collect()
}
