//! The confidence in the check of a path, and the reasons that lower it.

use super::confidence::{Confidence, Reason};
use super::weakness::{SurfaceEvidence, SurfaceWeakness};
use crate::quantity::Length;

/// What the check of a path rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathEvidence {
    /// The surface.
    pub surface: SurfaceEvidence,
    /// The tolerance of the check.
    pub tolerance: Length,
    /// The share of the length of the moves at the feed rate for which the path states no feed rate.
    pub assumed_feed_share: f64,
    /// The moves at the feed rate from stop to stop, on average, on a control without a path tolerance; 0 with one.
    pub moves_without_corners: f64,
}

impl Confidence<SurfaceWeakness> {
    /// The confidence in the check of a path.
    #[must_use]
    pub fn in_path(evidence: &PathEvidence) -> Self {
        let PathEvidence { surface, tolerance, assumed_feed_share, moves_without_corners } = *evidence;
        let reasons = [
            Reason::over(SurfaceWeakness::InconsistentOrientation, surface.turned_area_share, 0.001, 0.05),
            Reason::missing_area(SurfaceWeakness::NotClosed, surface.missing_area, tolerance),
            Reason::over(SurfaceWeakness::HiddenArea, surface.hidden_area_share, 0.001, 0.1),
            Reason::over(SurfaceWeakness::AssumedPathFeed, assumed_feed_share, 0.01, f64::INFINITY),
            // A move and the two about it are a pass with its links.
            Reason::over(SurfaceWeakness::CornersNotTimed, moves_without_corners, 3.0, f64::INFINITY),
        ];
        Self::from_reasons(reasons.into_iter().flatten().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::Level;

    #[test]
    fn reasons_are_named_from_their_thresholds_on() {
        let sound = PathEvidence {
            surface: SurfaceEvidence { missing_area: 0.005, ..SurfaceEvidence::default() },
            tolerance: Length::computed(0.01),
            assumed_feed_share: 0.0,
            moves_without_corners: 0.0,
        };
        assert_eq!(Confidence::in_path(&sound).level(), Level::High);
        let surface = SurfaceEvidence { hidden_area_share: 0.02, turned_area_share: 0.2, missing_area: 0.5, ..sound.surface };
        let doubtful = PathEvidence { surface, moves_without_corners: 40.0, ..sound };
        let confidence = Confidence::in_path(&doubtful);
        assert_eq!(confidence.level(), Level::Low);
        let weaknesses: Vec<SurfaceWeakness> = confidence.reasons().iter().map(|reason| reason.weakness).collect();
        assert_eq!(
            weaknesses,
            [
                SurfaceWeakness::InconsistentOrientation,
                SurfaceWeakness::NotClosed,
                SurfaceWeakness::HiddenArea,
                SurfaceWeakness::CornersNotTimed
            ]
        );
    }
}
