//! The plans of all candidates on a part; the answer of a plan of one or several operations, and its passes, point by point.

use super::candidates::line_degrees;
use super::parameters::Parameters;
use crate::http::wire::{NamedCandidate, answer};
use crate::milling::Model;
use crate::path::MoveKind;
use crate::planning::machined_surface::{MachinedSurface, Stop};
use crate::planning::plan::{
    self, CandidatePlan, CutPoint, FinishFigures, Lines, MilledFigures, OperationPlan, OperationsPlan, PassPoint, Pattern, PlanSettings,
    Ranking, SpacingFigures, TourFigures, rank,
};
use crate::quantity::{Angle, Length, Time};
use crate::surface::Shape;
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

answer! {
    /// The path of the plan of several operations, where there is one, else of the recommended plan: columns over all points. Played in order they are the whole path, from the clearance
    /// height over the first run to the clearance height over the last, links and lifts included.
    #[schema(as = Passes)]
    pub(crate) struct PassesAnswer of (passes: plan::Passes) {
        /// The index in the columns of each run's first point. The first run of an operation begins with the operation's approach from
        /// the clearance height. Between two operations the tool changes.
        run_starts: Vec<usize> = passes.run_starts,
        /// The operation of each run, its position in `plan.operations`; 0 without a plan of several. All points from the run's start to
        /// the next one's are made with its cutter.
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
pub(super) fn passes_of_best(machined: &MachinedSurface, simulation: &Simulation, stop: Stop) -> Option<plan::Passes> {
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

/// All candidates planned on a part.
pub(super) struct Simulation {
    pub(super) settings: PlanSettings,
    pub(super) ranking: Ranking,
}

impl Simulation {
    /// Plans the candidates at these positions in the request. Returns `None` once `stop` returns true.
    pub(super) fn run(
        machined: &MachinedSurface,
        parameters: &Parameters,
        places: &[usize],
        shape: &Shape,
        model: Model,
        stop: Stop,
    ) -> Option<Self> {
        let settings = parameters.settings(shape, model);
        let candidates: Vec<_> = places.iter().map(|&place| parameters.candidates[place].candidate).collect();
        let ranking = rank(&machined.workpiece, &candidates, &settings, machined.facets.evidence(), stop)?;
        Some(Self { settings, ranking })
    }
}
