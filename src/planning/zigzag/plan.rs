//! The plan of one candidate, or the reason why it has none.

use super::candidate::ReachFigures;
use super::check::ScallopFigures;
use super::march::{MOST_MET, MOST_PLANES, NoPlanes, Plane};
use super::room::MOST_RUNS;
use super::slivers::Sliver;
use super::tour::TourFigures;
use crate::planning::RectanglePlan;
use crate::quantity::{Angle, Length, Speed, Time};
use std::fmt;

/// The plan of one candidate: a zigzag in its fastest direction.
#[derive(Debug, Clone, PartialEq)]
pub struct ZigzagPlan {
    /// The position of the cutter among the candidates.
    pub candidate: usize,
    /// The direction of the passes seen from above, counted from X. It is in [0, pi), unless the request states
    /// another.
    pub direction: Angle,
    /// The time of all runs and links.
    pub time: Time,
    /// Runs, links and their lengths.
    pub tour: TourFigures,
    /// The number of planes with passes.
    pub planes: usize,
    /// The spacing of the planes, seen from above.
    pub step_over: SpacingFigures,
    /// The mean feed rate of the runs: their length over the time they would take without stops.
    pub feed_rate: Speed,
    /// The mean feed per tooth, for cutters with a drive.
    pub feed_per_tooth: Option<Length>,
    /// The scallop height over the area.
    pub scallop_height: ScallopFigures,
    /// A lower bound: no zigzag that keeps the scallop height takes less time.
    pub least_time: Time,
    /// The time of each direction that was tried; `None` if it has no plan. The time of `direction` is `time`. The
    /// others are estimates: the times before the check, multiplied by the factor by which the check changed the time
    /// of the fastest direction.
    pub by_direction: Vec<(Angle, Option<Time>)>,
    /// The area that the cutter cannot reach.
    pub reach: Option<ReachFigures>,
    /// The same cutter by the published method on a rectangle, for comparison; `None` without a shape, or if that
    /// method finds no step-over.
    pub rectangle: Option<RectanglePlan>,
    /// Whether the flutes are shorter than the surface is deep.
    pub flutes_too_short: bool,
    pub(super) passes: Vec<Plane>,
    /// The parts of facets beside planes over which passes continue.
    pub(super) slivers: Vec<Sliver>,
}

impl ZigzagPlan {
    /// The length of all runs and links.
    #[must_use]
    pub fn path_length(&self) -> Length {
        Length::computed(self.tour.run_length + self.tour.link_length)
    }
}

/// Spacings of planes, seen from above.
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
    pub(super) fn of(planes: &[Plane]) -> Self {
        let mut spacings: Vec<f64> = planes.iter().map(|plane| plane.after).collect();
        spacings.sort_by(f64::total_cmp);
        let at = |index: usize| Length::computed(spacings.get(index).copied().unwrap_or(0.0));
        Self { min: at(0), median: at(spacings.len() / 2), max: at(spacings.len().saturating_sub(1)) }
    }
}

/// A candidate without a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NotRanked {
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
    CannotReach(ReachFigures),
    /// In every direction, some part of the surface has no step-over that keeps the scallop height.
    NoStepOver,
    /// Step-overs that keep the scallop height are so small that there would be more than 50,000 passes.
    TooManyPasses,
    /// The passes fall into more than 65,536 runs.
    TooManyRuns,
    /// The facets overlap so much that the passes meet facets more than 50,000,000 times.
    TooMuchWork,
    /// On a large share of the area the cutter gouges the surface beside the contact, or leaves uncut material between
    /// its passes, so that it cannot finish that area.
    NoHeight {
        /// The share of the area.
        share: f64,
    },
}

impl From<NoPlanes> for NotRankedReason {
    /// A cancelled plan, or one without room, is discarded with the whole ranking, so its reason does not matter.
    fn from(reason: NoPlanes) -> Self {
        match reason {
            NoPlanes::NoSpacing | NoPlanes::Cancelled | NoPlanes::NoRoom => Self::NoStepOver,
            NoPlanes::TooManyPlanes => Self::TooManyPasses,
            NoPlanes::TooManyRuns => Self::TooManyRuns,
            NoPlanes::TooManyMet => Self::TooMuchWork,
        }
    }
}

impl fmt::Display for NotRankedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CannotReach(reach) => write!(
                f,
                "the cutter does not reach {:.2} % of the area and leaves up to {:.4} mm there, give or take {:.4} mm",
                100.0 * reach.uncut_share,
                reach.uncut_height.mm(),
                reach.uncut_height_error.mm()
            ),
            Self::NoStepOver => f.write_str("in no direction does any step-over keep the scallop height everywhere"),
            Self::TooManyPasses => write!(f, "in no direction do {MOST_PLANES} passes or fewer keep the scallop height"),
            Self::TooManyRuns => write!(f, "in no direction do the passes have {MOST_RUNS} runs or fewer"),
            Self::TooMuchWork => {
                write!(f, "in no direction do the passes meet {MOST_MET} facets or fewer, each counted as often as a pass meets it")
            }
            Self::NoHeight { share } => {
                write!(f, "the cutter gouges the surface beside its contacts on {:.1} % of the area", 100.0 * share)
            }
        }
    }
}
