//! The answer of a cutter recommendation.

use super::candidates::{ComparedCutter, line_degrees};
use super::confidence::ConfidenceAnswer;
use super::map::MapAnswer;
use super::parameters::Method;
use super::passes::PassesAnswer;
use super::shape::SurfaceAnswer;
use crate::http::codes::same_names;
use crate::http::wire::{NamedCandidate, NotRanked, Warning, answer};
use crate::milling::CutterKind;
use crate::planning::RectanglePlan;
use crate::planning::zigzag::{ScallopFigures, TourFigures, ZigzagPlan};
use crate::quantity::{Angle, Length, Speed, Time};
use serde::Serialize;
use utoipa::ToSchema;

answer! {
    /// The cutter that finishes the surface soonest, its plan, and the reliability of the recommendation.
    pub(crate) struct RecommendationAnswer {
        /// The method of the plans.
        pub(super) method: Method,
        /// The model by which passes are spaced: `analytic` or `envelope`.
        pub(super) model: &'static str [example = "envelope"],
        /// The fastest cutter, in its direction.
        pub(super) recommended: RecommendedCutter,
        /// All cutters that can be ranked, fastest first.
        pub(super) candidates: Vec<RankedCandidate> [min_items = 1],
        /// The cutters that cannot be ranked, in the order of the request, and then the faulty tools of libraries.
        pub(super) not_ranked: Vec<NotRanked>,
        /// The surface.
        pub(super) surface: SurfaceAnswer,
        /// The slope below which the toroidal cutter is faster on the surface's equivalent rectangle; 90 if it is faster on
        /// every slope, 0 if the ball-end cutter is. Only if one toroidal and one ball-end cutter are compared and the
        /// published method has an answer.
        pub(super) critical_slope_deg?: f64 [minimum = 0, maximum = 90],
        /// The cutter that is faster on every slope of that rectangle; absent if there is a critical slope.
        pub(super) always_faster?: ComparedCutter,
        /// The form factor below which the toroidal cutter is faster on a rectangle of this size and slope. Only with
        /// `critical_slope_deg`.
        pub(super) critical_form_factor?: f64 [minimum = 1],
        /// The surface as a raster, for drawing; only if `include` names it.
        pub(super) map?: MapAnswer,
        /// The passes of the recommended plan; only if `include` names them.
        pub(super) passes?: PassesAnswer,
        /// The reliability of the recommendation.
        pub(super) confidence: ConfidenceAnswer,
        /// Facts that need attention.
        pub(super) warnings: Vec<Warning>,
    }

    /// The recommended cutter and its plan.
    pub(super) struct RecommendedCutter of (candidate: &RankedCandidate) {
        /// The position of the cutter in the request, from 0; cutters of libraries follow.
        cutter: usize = candidate.cutter,
        /// The cutter's name, if it has one.
        name?: String = candidate.name.clone(),
        /// The preset of the tool library from which spindle speed and feed per tooth were taken.
        preset?: String = candidate.preset.clone(),
        /// The line of the passes seen from above, from +X counter-clockwise, in [0, 180). Absent in method rectangle if
        /// the surface has no such direction.
        direction_deg?: f64 [minimum = 0, exclusive_maximum = 180] = candidate.direction_deg,
        /// The time of all passes and links, stops included.
        machining_time_s: f64 [minimum = 0] = candidate.machining_time_s,
        /// The median distance between passes, seen from above.
        step_over_xy_mm: f64 [minimum = 0] = candidate.step_over_xy_mm.median,
        /// The mean feed rate of the passes.
        feed_rate_mm_min: f64 [minimum = 0] = candidate.feed_rate_mm_min,
    }

    /// A cutter with its fastest plan.
    #[derive(Clone)]
    pub(super) struct RankedCandidate {
        /// The position of the cutter in the request, from 0; cutters of libraries follow.
        pub(super) cutter: usize,
        /// The cutter's name, if it has one.
        name?: String,
        /// The preset of the tool library from which spindle speed and feed per tooth were taken.
        preset?: String,
        /// The kind of cutter.
        #[serde(rename = "type")]
        kind: CutterKindName,
        /// The line of the passes seen from above, from +X counter-clockwise, in [0, 180). Absent in method rectangle if
        /// the surface has no such direction.
        direction_deg?: f64 [minimum = 0, exclusive_maximum = 180],
        /// The time of all passes and links, stops included.
        pub(super) machining_time_s: f64 [minimum = 0],
        /// The number of planes that contain the passes; in method rectangle the quotient of length and step-over, not
        /// rounded.
        passes: f64 [minimum = 0],
        /// The length of all passes and links.
        path_length_mm: f64 [minimum = 0],
        /// The distances between passes, seen from above.
        step_over_xy_mm: SpacingAnswer,
        /// The mean feed rate of the passes: their length over the time they would take without stops.
        feed_rate_mm_min: f64 [minimum = 0],
        /// The mean feed per tooth; only for cutters with teeth and spindle speed, in method surface.
        feed_per_tooth_mm?: f64 [minimum = 0],
        /// The figures of the simulation; only in method surface.
        #[serde(flatten)]
        simulated: Option<SimulatedFigures> [value_type = SimulatedFigures],
    }

    /// The figures of a plan that was simulated on the surface.
    #[derive(Clone)]
    struct SimulatedFigures of (plan: &ZigzagPlan) {
        /// The links between runs.
        links: LinksAnswer [required = false] = LinksAnswer::of(&plan.tour),
        /// The scallop height over the area, by model `envelope` with the curvature of the surface.
        scallop_height_mm: ScallopAnswer [required = false] = ScallopAnswer::of(&plan.scallop_height),
        /// The share of the area whose scallop height exceeds `scallop_height_mm`, or that has none, because
        /// the cutter gouges there or leaves uncut material between its passes.
        over_tolerance_share: f64 [required = false, minimum = 0, maximum = 1]
            = (plan.scallop_height.over_tolerance_share + plan.scallop_height.without_height_share).min(1.0),
        /// The share of the area that the cutter leaves uncut because it does not fit.
        uncut_share: f64 [required = false, minimum = 0, maximum = 1] = plan.reach.map_or(0.0, |reach| reach.uncut_share),
        /// The largest height that the cutter leaves there.
        uncut_height_mm: f64 [required = false, minimum = 0] = plan.reach.map_or(0.0, |reach| reach.uncut_height.mm()),
        /// The error of that height, due to the raster on which it was computed.
        uncut_height_error_mm: f64 [required = false, minimum = 0] = plan.reach.map_or(0.0, |reach| reach.uncut_height_error.mm()),
        /// A lower bound: no zigzag that keeps the scallop height takes less time.
        least_time_s: f64 [required = false, minimum = 0] = plan.least_time.seconds(),
        /// The times of the directions that were tried and have a plan.
        by_direction: ByDirection [required = false] = ByDirection::of(plan),
        /// The same cutter by the published method, if that has an answer.
        rectangle?: OnRectangle = plan.rectangle.as_ref().map(OnRectangle::of),
    }
}

/// The kind of a cutter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = CutterType)]
enum CutterKindName {
    Toroidal,
    BallEnd,
    FlatEnd,
    TaperedBall,
    Lens,
    Oval,
    ConicalBarrel,
    Profile,
}

answer! {
    /// Distances between passes.
    #[derive(Clone, Copy)]
    #[schema(as = StepOverRange)]
    struct SpacingAnswer {
        /// The smallest.
        min: f64 [minimum = 0],
        /// The median.
        median: f64 [minimum = 0],
        /// The largest.
        max: f64 [minimum = 0],
    }

    /// The links between runs.
    #[derive(Clone, Copy)]
    #[schema(as = Links)]
    struct LinksAnswer of (tour: &TourFigures) {
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
    struct ScallopAnswer of (heights: &ScallopFigures) {
        /// The median.
        p50: f64 [minimum = 0] = heights.p50.mm(),
        /// The 90th percentile.
        p90: f64 [minimum = 0] = heights.p90.mm(),
        /// The 99th percentile.
        p99: f64 [minimum = 0] = heights.p99.mm(),
        /// The largest.
        max: f64 [minimum = 0] = heights.max.mm(),
    }

    /// Times by direction. The time of the recommended direction is that of the plan. The others are estimates: the times
    /// before the check of the scallop height, multiplied by the factor by which the check changed the time of the fastest
    /// direction.
    #[derive(Clone)]
    struct ByDirection of (plan: &ZigzagPlan) {
        /// The directions.
        direction_deg: Vec<f64>
            = plan.by_direction.iter().filter(|(_, time)| time.is_some()).map(|(direction, _)| line_degrees(*direction)).collect(),
        /// The time in each direction.
        machining_time_s: Vec<f64> = plan.by_direction.iter().filter_map(|(_, time)| time.map(Time::seconds)).collect(),
    }

    /// A plan by the published method.
    #[derive(Clone, Copy)]
    struct OnRectangle of (plan: &RectanglePlan) {
        /// The line of the passes; absent if the surface has no such direction.
        direction_deg?: f64 [minimum = 0, exclusive_maximum = 180] = plan.direction.map(line_degrees),
        /// The time of the zigzag.
        machining_time_s: f64 [minimum = 0] = plan.zigzag.time.seconds(),
    }
}

same_names!(CutterKind => CutterKindName: Toroidal, BallEnd, FlatEnd, TaperedBall, Lens, Oval, ConicalBarrel, Profile);

impl RankedCandidate {
    /// A plan simulated on the surface.
    pub(super) fn simulated(plan: &ZigzagPlan, candidates: &[NamedCandidate]) -> Self {
        let named = &candidates[plan.candidate];
        let spacing = plan.step_over;
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
            simulated: Some(SimulatedFigures::of(plan)),
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
