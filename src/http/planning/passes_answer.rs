//! The passes of an answer, point by point.

use super::simulation::Simulation;
use crate::http::wire::answer;
use crate::path::MoveKind;
use crate::planning::machined_surface::{MachinedSurface, Stop};
use crate::planning::plan::{self, CutPoint, PassPoint};
use crate::quantity::Length;
use serde::Serialize;
use utoipa::ToSchema;

answer! {
    /// The path of the plan of several operations, where there is one, else of the recommended plan: columns over all points. Played in order they are the whole path, from the clearance
    /// height over the first run to the clearance height over the last, links and lifts included.
    #[schema(as = Passes)]
    pub(crate) struct PassesAnswer of (passes: plan::Passes) {
        /// The index in the columns at which each run begins.
        run_starts: Vec<usize> = passes.run_starts,
        /// The operation of each run, its position in `plan.operations`; 0 without a plan of several.
        operation: Vec<usize> = passes.operations,
        /// How the tool gets to each point.
        #[serde(rename = "move")]
        kind: Vec<MoveName> = column(&passes.points, |point| point.kind.into()),
        /// The lowest point of the cutter on its axis.
        tip_mm: Vec<[f64; 3]> = column(&passes.points, |point| point.tip),
        /// The point at which the cutter touches what is machined; null on links, on rapid moves, over gaps and beyond borders.
        contact_mm: Vec<Option<[f64; 3]>> = cut_column(&passes.points, |cut| Some(cut.contact)),
        /// The unit normal of the facet that is finished, to which the step-over, the scallop height and the curvature belong. Null
        /// without a contact.
        normal: Vec<Option<[f64; 3]>> = cut_column(&passes.points, |cut| Some(cut.normal)),
        /// The step-over along the surface to the farther of the neighbouring passes; null without a contact.
        step_over_mm: Vec<Option<f64>> = cut_column(&passes.points, |cut| Some(cut.step_over.mm())),
        /// The feed per tooth of the move to the point; absent for a cutter without teeth and spindle speed.
        feed_per_tooth_mm?: Vec<f64> = passes.points.iter().map(|point| point.feed_per_tooth.map(Length::mm)).collect(),
        /// The feed rate of the move to the point: the rapid rate on rapid moves, the machine's feed rate for a cutter without
        /// teeth and spindle speed.
        feed_rate_mm_min: Vec<f64> = column(&passes.points, |point| point.feed_rate.mm_min()),
        /// The scallop height by the plan's model at that step-over and feed; null without a contact, or if the model has none.
        scallop_height_mm: Vec<Option<f64>> = cut_column(&passes.points, |cut| cut.scallop_height.map(Length::mm)),
        /// The curvature of the surface; null without a contact.
        surface_curvature: CurvatureColumns = CurvatureColumns::of(&passes.points),
    }

    /// The curvature of a surface in the axes of the feed, in 1/mm, positive where convex.
    #[expect(clippy::struct_field_names, reason = "the wire names, each with its unit")]
    struct CurvatureColumns of (points: &[PassPoint]) {
        /// Along the feed.
        along_per_mm: Vec<Option<f64>> = cut_column(points, |cut| Some(cut.curvature[0])),
        /// Across the feed.
        across_per_mm: Vec<Option<f64>> = cut_column(points, |cut| Some(cut.curvature[1])),
        /// The twist.
        twist_per_mm: Vec<Option<f64>> = cut_column(points, |cut| Some(cut.curvature[2])),
    }
}

/// How the tool gets to a point: `cut`, along a pass; `link`, at the feed rate on the surface or down to it; `rapid`, up from
/// it, across, or down to a millimetre over it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MoveKind)]
enum MoveName {
    Cut,
    Link,
    Rapid,
}

impl From<MoveKind> for MoveName {
    fn from(kind: MoveKind) -> Self {
        match kind {
            MoveKind::Cut => Self::Cut,
            MoveKind::Link => Self::Link,
            MoveKind::Rapid => Self::Rapid,
        }
    }
}

/// The path of the plan of several operations, else of the first plan; `None` without a milled plan. Once `stop` returns true,
/// the result must be discarded.
pub(super) fn of_best(machined: &MachinedSurface, simulation: &Simulation, stop: Stop) -> Option<plan::Passes> {
    let Simulation { ranking, settings, .. } = simulation;
    match &ranking.operations {
        Some(operations) => Some(plan::passes_of_all(&machined.workpiece, operations, settings, stop)),
        None => plan::passes(&machined.workpiece, ranking.plans.first()?, settings, stop),
    }
}

fn column<T>(points: &[PassPoint], of: impl FnMut(&PassPoint) -> T) -> Vec<T> {
    points.iter().map(of).collect()
}

fn cut_column<T>(points: &[PassPoint], of: impl Fn(&CutPoint) -> Option<T>) -> Vec<Option<T>> {
    points.iter().map(|point| point.cut.as_ref().and_then(&of)).collect()
}
