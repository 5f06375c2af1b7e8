//! The plan of a candidate with the figures of its milled path, or the reason why it has none.

use super::judged::FinishFigures;
use super::milled_plan::MilledPlan;
use super::settings::PlanSettings;
use super::spacing::Prepared;
use super::tour::TourFigures;
use super::workpiece::Workpiece;
use crate::planning::RectanglePlan;
use crate::quantity::{Angle, Length, Speed, Time};
use std::fmt;

/// The plan of one candidate.
#[derive(Debug, Clone)]
pub struct CandidatePlan {
    /// The position of the cutter among the candidates.
    pub candidate: usize,
    /// The direction of the lines seen from above, counted from X.
    pub direction: Angle,
    /// The time of all runs and links: of the tips' path, or estimated.
    pub time: Time,
    /// The milled plan. It is `None`, and the time is an estimate, for a candidate that is too far behind or not among the
    /// eight with the shortest estimates, and for paths that are too long.
    pub milled: Option<MilledFigures>,
    /// The share of the area that the cutter leaves over the scallop height because it does not fit, and the largest height
    /// left there: of the milled path, or estimated.
    pub uncut_share: f64,
    /// The largest height left there.
    pub uncut_height: Length,
    /// A lower bound: no lines that keep the scallop height take less time.
    pub least_time: Time,
    /// The time of each direction that was tried; `None` if it has no plan. Times of directions that were not milled are
    /// estimates.
    pub by_direction: Vec<(Angle, Option<Time>)>,
    /// This cutter by the published method on a rectangle, for comparison; `None` without a shape, or if that method
    /// finds no step-over.
    pub rectangle: Option<RectanglePlan>,
    /// Whether the flutes are shorter than the surface is deep.
    pub flutes_too_short: bool,
    pub(super) path: Option<PlannedPath>,
}

/// The path of an operation, with the cutter that it belongs to.
#[derive(Debug, Clone)]
pub(super) struct PlannedPath {
    pub(super) plan: MilledPlan,
    pub(super) prepared: Prepared,
}

impl CandidatePlan {
    /// The number of points of its path; 0 for a plan that was estimated, or that is not the fastest.
    #[must_use]
    pub fn points(&self) -> usize {
        self.path.as_ref().map_or(0, |path| path.plan.tour.points.len())
    }
}

/// The figures of a milled plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MilledFigures {
    /// Runs, links and their lengths.
    pub tour: TourFigures,
    /// The number of lines.
    pub lines: usize,
    /// The spacing of the lines, seen from above.
    pub step_over: SpacingFigures,
    /// The mean feed rate of the runs: their length over the time they would take without stops.
    pub feed_rate: Speed,
    /// The mean feed per tooth, for cutters with a drive.
    pub feed_per_tooth: Option<Length>,
    /// What the path leaves.
    pub finish: FinishFigures,
    /// The time without acceleration over the least time.
    pub layout_ratio: f64,
}

impl MilledFigures {
    /// The figures of a plan; `least_seconds` is the lower bound of the time of any lines.
    pub(super) fn of(workpiece: &Workpiece, settings: &PlanSettings, prepared: &Prepared, plan: &MilledPlan, least_seconds: f64) -> Self {
        let tour = plan.tour.figures;
        // The rounding of the sums may carry the mean over the machine's limit.
        let rate = (tour.run_length / tour.cutting_seconds).min(settings.machine.limits.feed_rate.mm_s());
        let [low, high] = workpiece.bounds;
        let width = (high[0] - low[0]).hypot(high[1] - low[1]).min(2.0 * prepared.profile.outer_radius());
        Self {
            tour,
            lines: plan.lines.count(),
            step_over: SpacingFigures::of(plan.lines.spacings(), width),
            feed_rate: Speed::computed(rate),
            feed_per_tooth: prepared.range.map(|range| Length::computed(rate / range.teeth_per_second)),
            finish: plan.finish,
            layout_ratio: if least_seconds > 0.0 { tour.moving_seconds / least_seconds } else { 1.0 },
        }
    }
}

/// Spacings of lines, seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpacingFigures {
    /// The smallest.
    pub min: Length,
    /// The median.
    pub median: Length,
    /// The largest.
    pub max: Length,
}

impl SpacingFigures {
    /// The figures of these spacings. A single line has none, and counts as one of `width`.
    fn of(mut spacings: Vec<f64>, width: f64) -> Self {
        if spacings.is_empty() {
            spacings.push(width);
        }
        spacings.sort_by(f64::total_cmp);
        let at = |index: usize| Length::computed(spacings[index]);
        Self { min: at(0), median: at(spacings.len() / 2), max: at(spacings.len() - 1) }
    }
}

/// A candidate without a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnrankedCandidate {
    /// The position of the cutter among the candidates.
    pub candidate: usize,
    /// The reason why it has no plan.
    pub reason: NotRankedReason,
}

/// The reason why a candidate has no plan.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum NotRankedReason {
    /// The cutter leaves more of the area uncut than allowed.
    CannotReach {
        /// The share of the area, 0 to 1.
        uncut_share: f64,
        /// The largest height by which the cutter stands over a place that it should touch.
        uncut_height: Length,
    },
    /// In every direction, some part of the surface has no step-over that keeps the scallop height, or step-overs are so
    /// small that there would be more than 50,000 lines.
    NoStepOver,
}

impl fmt::Display for NotRankedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CannotReach { uncut_share, uncut_height } => write!(
                f,
                "the cutter does not reach {:.2} % of the area and stands up to {:.4} mm over it there",
                100.0 * uncut_share,
                uncut_height.mm()
            ),
            Self::NoStepOver => f.write_str("in no direction do 50,000 lines or fewer keep the scallop height everywhere"),
        }
    }
}
