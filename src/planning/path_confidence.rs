//! The confidence in the check of a path, and the reasons that lower it.

use super::confidence::{Confidence, Reason};
use crate::quantity::Length;
use std::fmt;

/// What the check of a path rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathEvidence {
    /// The share of the selected area that is hidden from above or overhangs, without the undersides of closed solids.
    pub hidden_area_share: f64,
    /// The share of the visible area whose facets face the other way than the rest.
    pub turned_area_share: f64,
    /// The area in mm^2 that the surface lacks to be a closed solid, 0 for a skin.
    pub missing_area: f64,
    /// The tolerance of the check.
    pub tolerance: Length,
    /// The share of the length of the moves at the feed rate for which the path states no feed rate.
    pub assumed_feed_share: f64,
    /// The moves at the feed rate from stop to stop, on average, on a control without a path tolerance; 0 with one.
    pub moves_without_corners: f64,
}

/// A weakness of the check of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathWeakness {
    /// A part of the selected area is hidden from above and is not checked. Figure: its share.
    HiddenArea,
    /// Some facets have the opposite orientation, so that the mesh does not show on which side the part is. Figure: their
    /// share of the area.
    InconsistentOrientation,
    /// A solid lacks facets, or some are turned: into a hole the path may cut, and what it leaves there is not checked. Figure: their
    /// area in mm^2.
    NotClosed,
    /// A part of the path has no feed rate and is timed at the machine's. Figure: its share of the length.
    AssumedPathFeed,
    /// The machine has no path tolerance: corners between stops take no time. Figure: the moves from stop to stop.
    CornersNotTimed,
}

impl Confidence<PathWeakness> {
    /// The confidence in the check of a path.
    #[must_use]
    pub fn in_path(evidence: &PathEvidence) -> Self {
        let PathEvidence { hidden_area_share, turned_area_share, missing_area, tolerance, assumed_feed_share, moves_without_corners } =
            *evidence;
        let reasons = [
            Reason::over(PathWeakness::InconsistentOrientation, turned_area_share, 0.001, 0.05),
            Reason::missing_area(PathWeakness::NotClosed, missing_area, tolerance),
            Reason::over(PathWeakness::HiddenArea, hidden_area_share, 0.001, 0.1),
            Reason::over(PathWeakness::AssumedPathFeed, assumed_feed_share, 0.01, f64::INFINITY),
            // A move and the two about it are a pass with its links.
            Reason::over(PathWeakness::CornersNotTimed, moves_without_corners, 3.0, f64::INFINITY),
        ];
        Self::from_reasons(reasons.into_iter().flatten().collect())
    }
}

impl fmt::Display for Reason<PathWeakness> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let figure = self.figure;
        match self.weakness {
            PathWeakness::HiddenArea => {
                write!(
                    f,
                    "{:.2} % of the selected area, without the undersides of solids, is hidden from above and not checked",
                    100.0 * figure
                )
            }
            PathWeakness::InconsistentOrientation => {
                write!(
                    f,
                    "{:.2} % of the area faces the other way than the rest: the mesh does not show which side is the part",
                    100.0 * figure
                )
            }
            PathWeakness::NotClosed => {
                write!(f, "the solid is not closed: facets of {figure:.4} mm^2 are missing or turned, and there the path is not checked")
            }
            PathWeakness::AssumedPathFeed => {
                write!(f, "{:.2} % of the length has no feed rate and is timed at the machine's", 100.0 * figure)
            }
            PathWeakness::CornersNotTimed => {
                write!(
                    f,
                    "{figure:.0} moves from stop to stop on average, between which the control slows down in no corner; state path_tolerance_mm of the machine"
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::Level;

    #[test]
    fn reasons_are_named_from_their_thresholds_on() {
        let sound = PathEvidence {
            hidden_area_share: 0.0,
            turned_area_share: 0.0,
            missing_area: 0.005,
            tolerance: Length::computed(0.01),
            assumed_feed_share: 0.0,
            moves_without_corners: 0.0,
        };
        assert_eq!(Confidence::in_path(&sound).level(), Level::High);
        let doubtful =
            PathEvidence { hidden_area_share: 0.02, turned_area_share: 0.2, missing_area: 0.5, moves_without_corners: 40.0, ..sound };
        let confidence = Confidence::in_path(&doubtful);
        assert_eq!(confidence.level(), Level::Low);
        let weaknesses: Vec<PathWeakness> = confidence.reasons().iter().map(|reason| reason.weakness).collect();
        assert_eq!(
            weaknesses,
            [PathWeakness::InconsistentOrientation, PathWeakness::NotClosed, PathWeakness::HiddenArea, PathWeakness::CornersNotTimed]
        );
    }
}
