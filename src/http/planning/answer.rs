//! The answer of a cutter recommendation.

use super::candidates::{ComparedCutter, line_degrees};
use super::confidence::ConfidenceAnswer;
use super::map::MapAnswer;
use super::parameters::Method;
use super::passes::PassesAnswer;
use super::shape::SurfaceAnswer;
use crate::http::codes::same_names;
use crate::http::wire::{NamedCandidate, NotRanked, Warning};
use crate::milling::CutterKind;
use crate::planning::RectanglePlan;
use crate::planning::zigzag::ZigzagPlan;
use crate::quantity::{Angle, Length, Speed, Time};
use serde::Serialize;
use utoipa::ToSchema;

/// The cutter that finishes the surface soonest, its plan, and the reliability of the recommendation.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct RecommendationAnswer {
    /// The method of the plans.
    pub(super) method: Method,
    /// The model by which passes are spaced: `analytic` or `envelope`.
    #[schema(example = "envelope")]
    pub(super) model: &'static str,
    /// The fastest cutter, in its direction.
    pub(super) recommended: RecommendedCutter,
    /// All cutters that can be ranked, fastest first.
    #[schema(min_items = 1)]
    pub(super) candidates: Vec<RankedCandidate>,
    /// The cutters that cannot be ranked, in the order of the request, and then the faulty tools of libraries.
    pub(super) not_ranked: Vec<NotRanked>,
    /// The surface.
    pub(super) surface: SurfaceAnswer,
    /// The slope below which the toroidal cutter is faster on the surface's equivalent rectangle; 90 if it is faster on
    /// every slope, 0 if the ball-end cutter is. Only if one toroidal and one ball-end cutter are compared and the
    /// published method has an answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, maximum = 90)]
    pub(super) critical_slope_deg: Option<f64>,
    /// The cutter that is faster on every slope of that rectangle; absent if there is a critical slope.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(super) always_faster: Option<ComparedCutter>,
    /// The form factor below which the toroidal cutter is faster on a rectangle of this size and slope. Only with
    /// `critical_slope_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 1)]
    pub(super) critical_form_factor: Option<f64>,
    /// The surface as a raster, for drawing; only if `include` names it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(super) map: Option<MapAnswer>,
    /// The passes of the recommended plan; only if `include` names them.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(super) passes: Option<PassesAnswer>,
    /// The reliability of the recommendation.
    pub(super) confidence: ConfidenceAnswer,
    /// Facts that need attention.
    pub(super) warnings: Vec<Warning>,
}

/// The recommended cutter and its plan.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct RecommendedCutter {
    /// The position of the cutter in the request, from 0; cutters of libraries follow.
    cutter: usize,
    /// The cutter's name, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    name: Option<String>,
    /// The preset of the tool library from which spindle speed and feed per tooth were taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    preset: Option<String>,
    /// The line of the passes seen from above, from +X counter-clockwise, in [0, 180). Absent in method rectangle if
    /// the surface has no such direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, exclusive_maximum = 180)]
    direction_deg: Option<f64>,
    /// The time of all passes and links, stops included.
    #[schema(minimum = 0)]
    machining_time_s: f64,
    /// The median distance between passes, seen from above.
    #[schema(minimum = 0)]
    step_over_xy_mm: f64,
    /// The mean feed rate of the passes.
    #[schema(minimum = 0)]
    feed_rate_mm_min: f64,
}

/// A cutter with its fastest plan.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(super) struct RankedCandidate {
    /// The position of the cutter in the request, from 0; cutters of libraries follow.
    pub(super) cutter: usize,
    /// The cutter's name, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    name: Option<String>,
    /// The preset of the tool library from which spindle speed and feed per tooth were taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    preset: Option<String>,
    /// The kind of cutter.
    #[serde(rename = "type")]
    kind: CutterKindName,
    /// The line of the passes seen from above, from +X counter-clockwise, in [0, 180). Absent in method rectangle if
    /// the surface has no such direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, exclusive_maximum = 180)]
    direction_deg: Option<f64>,
    /// The time of all passes and links, stops included.
    #[schema(minimum = 0)]
    pub(super) machining_time_s: f64,
    /// The number of planes that contain the passes; in method rectangle the model's quotient, not rounded.
    #[schema(minimum = 0)]
    passes: f64,
    /// The length of all passes and links.
    #[schema(minimum = 0)]
    path_length_mm: f64,
    /// The distances between passes, seen from above.
    step_over_xy_mm: SpacingAnswer,
    /// The mean feed rate of the passes: their length over the time they would take without stops.
    #[schema(minimum = 0)]
    feed_rate_mm_min: f64,
    /// The mean feed per tooth; only for cutters with teeth and spindle speed, in method surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    feed_per_tooth_mm: Option<f64>,
    /// The figures of the simulation; only in method surface.
    #[serde(flatten)]
    #[schema(value_type = SimulatedFigures)]
    simulated: Option<SimulatedFigures>,
}

/// The figures of a plan that was simulated on the surface.
#[derive(Debug, Clone, Serialize, ToSchema)]
struct SimulatedFigures {
    /// The links between runs.
    #[schema(required = false)]
    links: LinksAnswer,
    /// The scallop height over the area, by model `envelope` with the curvature of the surface.
    #[schema(required = false)]
    scallop_height_mm: ScallopAnswer,
    /// The share of the area whose scallop height exceeds `scallop_height_mm`, or that has none, because
    /// the cutter gouges there or leaves uncut material between its passes.
    #[schema(required = false, minimum = 0, maximum = 1)]
    over_tolerance_share: f64,
    /// The share of the area that the cutter leaves uncut because it does not fit.
    #[schema(required = false, minimum = 0, maximum = 1)]
    uncut_share: f64,
    /// The largest height that the cutter leaves there.
    #[schema(required = false, minimum = 0)]
    uncut_height_mm: f64,
    /// The error of that height, due to the raster on which it was computed.
    #[schema(required = false, minimum = 0)]
    uncut_height_error_mm: f64,
    /// A lower bound: no zigzag that keeps the scallop height takes less time.
    #[schema(required = false, minimum = 0)]
    least_time_s: f64,
    /// The times of the directions that were tried and have a plan.
    #[schema(required = false)]
    by_direction: ByDirection,
    /// The same cutter by the published method, if that has an answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    rectangle: Option<OnRectangle>,
}

/// The kind of a cutter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = CutterType)]
enum CutterKindName {
    Toroidal,
    BallEnd,
    FlatEnd,
}

/// Distances between passes.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
#[schema(as = StepOverRange)]
struct SpacingAnswer {
    /// The smallest.
    #[schema(minimum = 0)]
    min: f64,
    /// The median.
    #[schema(minimum = 0)]
    median: f64,
    /// The largest.
    #[schema(minimum = 0)]
    max: f64,
}

/// The links between runs.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
#[schema(as = Links)]
struct LinksAnswer {
    /// The number of links.
    count: usize,
    /// The length of all links.
    #[schema(minimum = 0)]
    length_mm: f64,
    /// The number of links over the clearance height.
    lifts: usize,
}

/// Scallop heights over the area.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
#[schema(as = ScallopHeights)]
struct ScallopAnswer {
    /// The median.
    #[schema(minimum = 0)]
    p50: f64,
    /// The 90th percentile.
    #[schema(minimum = 0)]
    p90: f64,
    /// The 99th percentile.
    #[schema(minimum = 0)]
    p99: f64,
    /// The largest.
    #[schema(minimum = 0)]
    max: f64,
}

/// Times by direction. The time of the recommended direction is that of the plan. The others are estimates: the times
/// before the check of the scallop height, multiplied by the factor by which the check changed the time of the fastest
/// direction.
#[derive(Debug, Clone, Serialize, ToSchema)]
struct ByDirection {
    /// The directions.
    direction_deg: Vec<f64>,
    /// The time in each direction.
    machining_time_s: Vec<f64>,
}

/// A plan by the published method.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
struct OnRectangle {
    /// The line of the passes; absent if the surface has no such direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0, exclusive_maximum = 180)]
    direction_deg: Option<f64>,
    /// The time of the zigzag.
    #[schema(minimum = 0)]
    machining_time_s: f64,
}

same_names!(CutterKind => CutterKindName: Toroidal, BallEnd, FlatEnd);

impl RankedCandidate {
    /// A plan simulated on the surface.
    pub(super) fn simulated(plan: &ZigzagPlan, candidates: &[NamedCandidate]) -> Self {
        let named = &candidates[plan.candidate];
        let (directions, times): (Vec<_>, Vec<_>) =
            plan.by_direction.iter().filter_map(|(direction, time)| Some((line_degrees(*direction), (*time)?.seconds()))).unzip();
        let (spacing, scallop) = (plan.step_over, plan.scallop_height);
        #[expect(clippy::cast_precision_loss, reason = "at most 50,000")]
        let passes = plan.planes as f64;
        Self {
            cutter: plan.candidate,
            name: named.name.clone(),
            preset: named.preset.clone(),
            kind: named.candidate.cutter.kind().into(),
            direction_deg: Some(line_degrees(plan.direction)),
            machining_time_s: plan.time.seconds(),
            passes,
            path_length_mm: plan.path_length().mm(),
            step_over_xy_mm: SpacingAnswer { min: spacing.min.mm(), median: spacing.median.mm(), max: spacing.max.mm() },
            feed_rate_mm_min: plan.feed_rate.mm_min(),
            feed_per_tooth_mm: plan.feed_per_tooth.map(Length::mm),
            simulated: Some(SimulatedFigures {
                links: LinksAnswer { count: plan.tour.links, length_mm: plan.tour.link_length, lifts: plan.tour.lifts },
                scallop_height_mm: ScallopAnswer {
                    p50: scallop.p50.mm(),
                    p90: scallop.p90.mm(),
                    p99: scallop.p99.mm(),
                    max: scallop.max.mm(),
                },
                over_tolerance_share: (scallop.over_tolerance_share + scallop.without_height_share).min(1.0),
                uncut_share: plan.reach.map_or(0.0, |reach| reach.uncut_share),
                uncut_height_mm: plan.reach.map_or(0.0, |reach| reach.uncut_height.mm()),
                uncut_height_error_mm: plan.reach.map_or(0.0, |reach| reach.uncut_height_error.mm()),
                least_time_s: plan.least_time.seconds(),
                by_direction: ByDirection { direction_deg: directions, machining_time_s: times },
                rectangle: plan.rectangle.map(|plan| OnRectangle {
                    direction_deg: plan.direction.map(line_degrees),
                    machining_time_s: plan.zigzag.time.seconds(),
                }),
            }),
        }
    }

    /// A plan by the published method. The distance between passes up and down the slope is horizontal and so the same
    /// seen from above; the distance between level passes is along the slope.
    pub(super) fn on_rectangle(cutter: usize, plan: &RectanglePlan, slope: Angle, feed_rate: Speed, candidates: &[NamedCandidate]) -> Self {
        let named = &candidates[cutter];
        let is_ball = named.candidate.cutter.kind() == CutterKind::BallEnd;
        let step_over = plan.zigzag.step_over.mm() * if is_ball { slope.cos() } else { 1.0 };
        Self {
            cutter,
            name: named.name.clone(),
            preset: named.preset.clone(),
            kind: named.candidate.cutter.kind().into(),
            direction_deg: plan.direction.map(line_degrees),
            machining_time_s: plan.zigzag.time.seconds(),
            passes: plan.zigzag.passes,
            path_length_mm: plan.zigzag.path_length.mm(),
            step_over_xy_mm: SpacingAnswer { min: step_over, median: step_over, max: step_over },
            feed_rate_mm_min: feed_rate.mm_min(),
            feed_per_tooth_mm: None,
            simulated: None,
        }
    }

    pub(super) fn time(&self) -> Time {
        Time::computed(self.machining_time_s)
    }
}

impl From<&RankedCandidate> for RecommendedCutter {
    fn from(candidate: &RankedCandidate) -> Self {
        Self {
            cutter: candidate.cutter,
            name: candidate.name.clone(),
            preset: candidate.preset.clone(),
            direction_deg: candidate.direction_deg,
            machining_time_s: candidate.machining_time_s,
            step_over_xy_mm: candidate.step_over_xy_mm.median,
            feed_rate_mm_min: candidate.feed_rate_mm_min,
        }
    }
}
