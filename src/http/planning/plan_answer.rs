//! The answer of a plan of one or several operations.

use super::candidates::line_degrees;
use super::plan_figures::{LinksAnswer, ScallopAnswer, SpacingAnswer};
use crate::http::wire::{NamedCandidate, answer};
use crate::planning::plan::{CandidatePlan, FinishFigures, Lines, MilledFigures, OperationPlan, OperationsPlan, Pattern};
use crate::quantity::{Angle, Time};
use serde::Serialize;
use utoipa::ToSchema;

answer! {
    /// The fastest plan of the allowed number of operations, milled. It is the recommended one alone where several are not faster.
    #[schema(as = OperationsPlan)]
    pub(crate) struct PlanAnswer {
        /// The time of all operations and tool changes.
        machining_time_s: f64 [minimum = 0],
        /// The number of tool changes between operations, each of the machine's `tool_change_s`.
        tool_changes: usize,
        /// The operations in their order.
        operations: Vec<OperationAnswer> [min_items = 1],
        /// The height that all together leave, tooth marks included, over the area that some of their cutters can reach.
        scallop_height_mm: ScallopAnswer,
        /// The share of the area that some cutter can reach and that is left more than 2 % over the scallop height.
        over_tolerance_share: f64 [minimum = 0, maximum = 1],
        /// The share of the area that is left over the scallop height because no cutter fits.
        uncut_share: f64 [minimum = 0, maximum = 1],
        /// The deepest cut into the part, links and lifts included.
        gouge_mm: f64 [minimum = 0],
        /// The share of the area that is left with at least half of the scallop height.
        used_share: f64 [minimum = 0, maximum = 1],
    }

    /// One operation. Its figures are over the area that it machines.
    #[schema(as = Operation)]
    struct OperationAnswer of (parts: &OperationParts<'_>) {
        /// The position of the cutter in the request, from 0; cutters of libraries follow.
        cutter: usize = parts.cutter,
        /// The cutter's name, if it has one.
        name?: String = parts.candidates[parts.cutter].name.clone(),
        /// How its passes run.
        family: FamilyName = FamilyName::of(parts.lines),
        /// The line of the passes seen from above, from +X counter-clockwise, in [0, 180); in one_way their direction, in
        /// [0, 360). Absent for waterlines.
        direction_deg?: f64 [minimum = 0, exclusive_maximum = 360] = direction_of(parts.lines),
        /// What it machines.
        region: RegionAnswer = RegionAnswer::of(parts),
        /// The time of its passes and links.
        machining_time_s: f64 [minimum = 0] = parts.figures.tour.seconds,
        /// The number of lines of passes, or of levels.
        passes: usize = parts.figures.lines,
        /// The length of all passes and links.
        path_length_mm: f64 [minimum = 0] = parts.figures.tour.run_length + parts.figures.tour.link_length,
        /// The distances between passes, seen from above. Absent for waterlines.
        step_over_xy_mm?: SpacingAnswer = (parts.lines != Lines::Waterline).then(|| SpacingAnswer::of(&parts.figures.step_over)),
        /// The heights between waterlines. Absent for others.
        step_down_mm?: SpacingAnswer = (parts.lines == Lines::Waterline).then(|| SpacingAnswer::of(&parts.figures.step_over)),
        /// The mean feed rate of the passes: their length over the time they would take without stops.
        feed_rate_mm_min: f64 [minimum = 0] = parts.figures.feed_rate.mm_min(),
        /// The links between runs.
        links: LinksAnswer = LinksAnswer::of(&parts.figures.tour),
        /// The height that the operation alone leaves, tooth marks included, over what its cutter can reach.
        scallop_height_mm: ScallopAnswer = ScallopAnswer::of(&parts.figures.finish),
        /// The share of its area that its cutter can reach and that it alone leaves more than 2 % over the scallop height.
        over_tolerance_share: f64 [minimum = 0, maximum = 1] = parts.figures.finish.far_over_share,
        /// Its deepest cut into the part.
        gouge_mm: f64 [minimum = 0] = parts.figures.finish.gouge.mm(),
    }

    /// What an operation machines.
    #[schema(as = OperationRegion)]
    struct RegionAnswer of (parts: &OperationParts<'_>) {
        /// The least and the largest slope of its facets. Neighbouring operations overlap by a step-over.
        slope_deg: [f64; 2] [min_items = 2, max_items = 2] = parts.slopes.map(Angle::degrees),
        /// The last of the operations, by its position, whose leftovers it machines; absent if it machines all of its facets.
        after?: usize = parts.after,
        /// The share of the surface's area that it machines.
        area_share: f64 [minimum = 0, maximum = 1] = parts.area_share,
    }
}

/// How passes run: `zigzag`, in vertical planes to and fro; `one_way`, in such planes in one direction; `waterline`, along level
/// curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = PassFamily)]
enum FamilyName {
    Zigzag,
    OneWay,
    Waterline,
}

impl FamilyName {
    fn of(lines: Lines) -> Self {
        match lines {
            Lines::Zigzag(_) => Self::Zigzag,
            Lines::OneWay(_) => Self::OneWay,
            Lines::Waterline => Self::Waterline,
        }
    }
}

fn direction_of(lines: Lines) -> Option<f64> {
    match lines {
        Lines::Zigzag(direction) => Some(line_degrees(direction)),
        Lines::OneWay(direction) => Some(direction.degrees().rem_euclid(360.0)),
        Lines::Waterline => None,
    }
}

/// What the answer of an operation is made from.
struct OperationParts<'a> {
    candidates: &'a [NamedCandidate],
    cutter: usize,
    lines: Lines,
    slopes: [Angle; 2],
    after: Option<usize>,
    area_share: f64,
    figures: &'a MilledFigures,
}

impl PlanAnswer {
    /// The plan of several operations.
    pub(super) fn of_several(plan: &OperationsPlan, candidates: &[NamedCandidate]) -> Self {
        let operation = |operation: &OperationPlan| {
            OperationAnswer::of(&OperationParts {
                candidates,
                cutter: operation.candidate,
                lines: operation.lines,
                slopes: operation.slopes,
                after: operation.after,
                area_share: operation.area_share,
                figures: &operation.figures,
            })
        };
        Self::new(plan.time, plan.tool_changes, plan.operations.iter().map(operation).collect(), &plan.finish)
    }

    /// The plan of one operation; `None` if it was not milled.
    pub(super) fn of_one(plan: &CandidatePlan, pattern: Pattern, max_slope: Angle, candidates: &[NamedCandidate]) -> Option<Self> {
        let figures = plan.milled.as_ref()?;
        let lines = match pattern {
            Pattern::Zigzag => Lines::Zigzag(plan.direction),
            Pattern::OneWay => Lines::OneWay(plan.direction),
        };
        let (cutter, slopes) = (plan.candidate, [Angle::ZERO, max_slope]);
        let parts = OperationParts { candidates, cutter, lines, slopes, after: None, area_share: 1.0, figures };
        Some(Self::new(plan.time, 0, vec![OperationAnswer::of(&parts)], &figures.finish))
    }

    fn new(time: Time, tool_changes: usize, operations: Vec<OperationAnswer>, finish: &FinishFigures) -> Self {
        Self {
            machining_time_s: time.seconds(),
            tool_changes,
            operations,
            scallop_height_mm: ScallopAnswer::of(finish),
            over_tolerance_share: finish.far_over_share,
            uncut_share: finish.uncut_share,
            gouge_mm: finish.gouge.mm(),
            used_share: finish.used_share,
        }
    }
}
