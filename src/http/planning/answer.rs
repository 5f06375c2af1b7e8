//! The answer of a cutter recommendation.

use super::candidates::{ComparedCutter, line_degrees};
use super::confidence_answer::ConfidenceAnswer;
use super::map::{CutterMap, MapAnswer};
use super::parameters::Method;
use super::plan_answer::{LinksAnswer, PassesAnswer, PlanAnswer, ScallopAnswer, SpacingAnswer};
use super::program::ProgramAnswer;
use super::surface_answer::SurfaceAnswer;
use crate::http::codes::same_names;
use crate::http::wire::{NamedCandidate, NotRanked, Warning, answer};
use crate::milling::{CutterKind, ra_um};
use crate::planning::RectanglePlan;
use crate::planning::plan::{CandidatePlan, MilledFigures};
use crate::quantity::{Angle, Length, Time};
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
        /// The share of the surface's area that the cutter of `rest_of` leaves, over which all figures of plans are; only with
        /// `rest_of`.
        pub(super) rest_area_share?: f64 [minimum = 0, maximum = 1],
        /// The slope below which the toroidal cutter is faster on the surface's equivalent rectangle; 90 if it is faster on
        /// every slope, 0 if the ball-end cutter is. Only if one toroidal and one ball-end cutter are compared and the
        /// published method has an answer.
        pub(super) critical_slope_deg?: f64 [minimum = 0, maximum = 90],
        /// The cutter that is faster on every slope of that rectangle; absent if there is a critical slope.
        pub(super) always_faster?: ComparedCutter,
        /// The form factor below which the toroidal cutter is faster on a rectangle of this size and slope. Only with
        /// `critical_slope_deg`.
        pub(super) critical_form_factor?: f64 [minimum = 1],
        /// The fastest plan of the number of operations that `operations` allows; only if it allows several, in method surface.
        pub(super) plan?: PlanAnswer,
        /// The surface as a raster, for drawing; only if `include` names it or `maps`.
        pub(super) map?: MapAnswer,
        /// Where the other cutters do not fit, on the cells of `map`: those with a plan, fastest first, then those that are not ranked, 16
        /// at most; only if `include` names it.
        pub(super) maps?: Vec<CutterMap> [max_items = 16],
        /// The passes of `plan`, else of the recommended plan; only if `include` names them.
        pub(super) passes?: PassesAnswer,
        /// `plan`, else the recommended plan, as a program; only if `include` names it.
        pub(super) program?: ProgramAnswer,
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
        step_over_xy_mm?: f64 [minimum = 0] = candidate.step_over_xy_mm.map(|spacing| spacing.median),
        /// The mean feed rate of the passes.
        feed_rate_mm_min?: f64 [minimum = 0] = candidate.feed_rate_mm_min,
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
        /// Whether the cutter's feed is `stated`, by teeth and spindle speed, or `assumed`: the machine's feed rate.
        feed: FeedSource,
        /// The number of lines of passes; in method rectangle the quotient of length and step-over, not rounded. Absent if the
        /// time is an estimate.
        passes?: f64 [minimum = 0],
        /// The length of all passes and links. Absent if the time is an estimate.
        path_length_mm?: f64 [minimum = 0],
        /// The distances between passes, seen from above. Absent if the time is an estimate.
        step_over_xy_mm?: SpacingAnswer,
        /// The mean feed rate of the passes: their length over the time they would take without stops. Absent if the time is an
        /// estimate.
        feed_rate_mm_min?: f64 [minimum = 0],
        /// The mean feed per tooth; only for cutters with teeth and spindle speed.
        feed_per_tooth_mm?: f64 [minimum = 0],
        /// The figures of the plan on the surface; only in method surface.
        #[serde(flatten)]
        planned: Option<PlannedFigures> [value_type = PlannedFigures],
        /// The figures of the milled path; only in method surface, and only if `figures` is `milled`.
        #[serde(flatten)]
        milled: Option<MilledAnswer> [value_type = MilledAnswer],
    }

    /// The figures of a plan on the surface.
    #[derive(Clone)]
    struct PlannedFigures of (plan: &CandidatePlan) {
        /// `milled`: the time and all figures are those of the tips' path, milled; `estimated`: the cutter's estimated time is
        /// more than 1.5 times the shortest, or eight other cutters have shorter ones, or paths are too long, and its
        /// path was not milled.
        figures: FiguresSource [required = false] = if plan.milled.is_some() { FiguresSource::Milled } else { FiguresSource::Estimated },
        /// The share of the area that is left over the scallop height because the cutter does not fit.
        uncut_share: f64 [required = false, minimum = 0, maximum = 1] = plan.uncut_share,
        /// The largest height left there.
        uncut_height_mm: f64 [required = false, minimum = 0] = plan.uncut_height.mm(),
        /// A lower bound: no passes that keep the scallop height take less time, without stops and walls.
        least_time_s: f64 [required = false, minimum = 0] = plan.least_time.seconds(),
        /// The times of the directions that were tried and have a plan.
        by_direction: ByDirection [required = false] = ByDirection::of(plan),
        /// The same cutter by the published method, if that has an answer.
        rectangle?: OnRectangle = plan.rectangle.as_ref().map(OnRectangle::of),
    }

    /// The figures of a milled path.
    #[derive(Clone)]
    struct MilledAnswer of (milled: &MilledFigures) {
        /// The links between runs.
        links: LinksAnswer [required = false] = LinksAnswer::of(&milled.tour),
        /// The height that the path leaves, tooth marks included, over the area that the cutter can reach.
        scallop_height_mm: ScallopAnswer [required = false] = ScallopAnswer::of(&milled.finish),
        /// Ra of the geometry, in um, at `scallop_height_mm.p99`: 99 % of the area are smoother. Real surfaces are rougher.
        ra_um: f64 [required = false, minimum = 0] = ra_um(milled.finish.p99),
        /// The share of the area that the cutter can reach and the path leaves more than 2 % over the scallop height.
        over_tolerance_share: f64 [required = false, minimum = 0, maximum = 1] = milled.finish.far_over_share,
        /// The deepest cut into the part, links and lifts included.
        gouge_mm: f64 [required = false, minimum = 0] = milled.finish.gouge.mm(),
        /// The share of the area that is left with at least half of the scallop height.
        used_share: f64 [required = false, minimum = 0, maximum = 1] = milled.finish.used_share,
        /// The time of the path without acceleration over `least_time_s`.
        layout_ratio: f64 [required = false, minimum = 0] = milled.layout_ratio,
    }
}

/// How a candidate's figures were computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = FiguresSource)]
enum FiguresSource {
    Milled,
    Estimated,
}

/// Where a cutter's feed rate is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = FeedSource)]
enum FeedSource {
    Stated,
    Assumed,
}

impl FeedSource {
    fn of(named: &NamedCandidate) -> Self {
        if named.candidate.drive.is_some() { Self::Stated } else { Self::Assumed }
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
    /// Times by direction. The fastest one's is that of its path, those of at most two more are of drafts with whole lines, and the
    /// others are estimates of such, each independent of which directions were asked for.
    #[derive(Clone)]
    struct ByDirection of (plan: &CandidatePlan) {
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
    /// A plan on the surface.
    pub(super) fn planned(plan: &CandidatePlan, candidates: &[NamedCandidate]) -> Self {
        let named = &candidates[plan.candidate];
        let milled = plan.milled.as_ref();
        let spacing = |milled: &MilledFigures| SpacingAnswer::of(&milled.step_over);
        #[expect(clippy::cast_precision_loss, reason = "at most 50,000")]
        let lines = |milled: &MilledFigures| milled.lines as f64;
        Self {
            cutter: plan.candidate,
            name: named.name.clone(),
            preset: named.preset.clone(),
            kind: named.candidate.cutter.kind().into(),
            direction_deg: Some(line_degrees(plan.direction)),
            machining_time_s: plan.time.seconds(),
            feed: FeedSource::of(named),
            passes: milled.map(lines),
            path_length_mm: milled.map(|milled| milled.tour.run_length + milled.tour.link_length),
            step_over_xy_mm: milled.map(spacing),
            feed_rate_mm_min: milled.map(|milled| milled.feed_rate.mm_min()),
            feed_per_tooth_mm: milled.and_then(|milled| milled.feed_per_tooth).map(Length::mm),
            planned: Some(PlannedFigures::of(plan)),
            milled: milled.map(MilledAnswer::of),
        }
    }

    /// A plan by the published method. The distance between passes up and down the slope is horizontal and so the same
    /// seen from above; the distance between level passes is along the slope.
    pub(super) fn on_rectangle(cutter: usize, plan: &RectanglePlan, slope: Angle, candidates: &[NamedCandidate]) -> Self {
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
            feed: FeedSource::of(named),
            passes: Some(plan.zigzag.passes),
            path_length_mm: Some(plan.zigzag.path_length.mm()),
            step_over_xy_mm: Some(SpacingAnswer { min: step_over, median: step_over, max: step_over }),
            feed_rate_mm_min: Some(plan.feed_rate.mm_min()),
            feed_per_tooth_mm: plan.feed_per_tooth.map(Length::mm),
            planned: None,
            milled: None,
        }
    }

    pub(super) fn time(&self) -> Time {
        Time::computed(self.machining_time_s)
    }
}
