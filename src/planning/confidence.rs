//! The confidence in plans that are milled, in checks of paths, and in recommendations by the published method: a level, and
//! the reasons that lower it.

use crate::quantity::Length;
use std::fmt;

/// The reliability of a recommendation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// The surface is of the kind for which the method is intended.
    High,
    /// The surface differs from that kind so much that times and critical slope are estimates.
    Moderate,
    /// The recommendation may be wrong; simulate both candidates.
    Low,
}

/// A weakness `W` of a method on a surface, with its figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reason<W> {
    /// The weakness.
    pub weakness: W,
    /// The level to which it lowers the confidence.
    pub level: Level,
    /// The figure on which it is based, in the unit that the weakness states.
    pub figure: f64,
    /// The threshold that the figure crossed.
    pub threshold: f64,
}

impl<W> Reason<W> {
    /// The reason for a figure below the threshold `moderate`, or below the lower threshold `low`.
    pub(super) fn under(weakness: W, figure: f64, moderate: f64, low: f64) -> Option<Self> {
        let (level, threshold) = if figure < low { (Level::Low, low) } else { (Level::Moderate, moderate) };
        (figure < moderate).then_some(Self { weakness, level, figure, threshold })
    }

    /// The reason for a figure above the threshold `moderate`, or above the higher threshold `low`.
    pub(super) fn over(weakness: W, figure: f64, moderate: f64, low: f64) -> Option<Self> {
        let (level, threshold) = if figure > low { (Level::Low, low) } else { (Level::Moderate, moderate) };
        (figure > moderate).then_some(Self { weakness, level, figure, threshold })
    }

    /// The reason for an area in mm^2 that a solid lacks: a ball of 3 mm sinks by 4 % of a scallop height of 0.01 mm into a hole ten
    /// scallop heights wide, and by four scallop heights into one ten times as wide.
    pub(super) fn missing_area(weakness: W, area: f64, scallop_height: Length) -> Option<Self> {
        let [moderate, low] = [10.0, 100.0].map(|heights| (heights * scallop_height.mm()).powi(2));
        Self::over(weakness, area, moderate, low)
    }
}

/// The confidence in a recommendation, with the reasons that lower it.
#[derive(Debug, Clone, PartialEq)]
pub struct Confidence<W> {
    level: Level,
    reasons: Vec<Reason<W>>,
}

impl<W> Confidence<W> {
    pub(super) fn from_reasons(mut reasons: Vec<Reason<W>>) -> Self {
        reasons.sort_by_key(|reason| std::cmp::Reverse(reason.level));
        Self { level: reasons.first().map_or(Level::High, |reason| reason.level), reasons }
    }

    pub(super) fn into_reasons(self) -> Vec<Reason<W>> {
        self.reasons
    }

    /// The level: the lowest of the reasons' levels, high if there are none.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }

    /// The reasons why the level is not high, the gravest first.
    #[must_use]
    pub fn reasons(&self) -> &[Reason<W>] {
        &self.reasons
    }
}

/// Properties of a mesh that cannot be derived from the facets that are machined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceEvidence {
    /// The share of the area to machine that is hidden from above or overhangs, 0 to 1, without the undersides of closed
    /// solids.
    pub hidden_area_share: f64,
    /// The number of connected pieces.
    pub pieces: usize,
    /// The share of the visible area whose facets face the other way than the rest, 0 to a half.
    pub turned_area_share: f64,
    /// The area in mm^2 that the surface lacks to be a closed solid, 0 for a skin.
    pub missing_area: f64,
}

impl Default for SurfaceEvidence {
    /// One piece, completely visible, with one orientation.
    fn default() -> Self {
        Self { hidden_area_share: 0.0, pieces: 1, turned_area_share: 0.0, missing_area: 0.0 }
    }
}

/// A weakness of plans that are milled, or of the check of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SurfaceWeakness {
    /// Paths of plans with shorter estimated times are too long to be milled, or all are. Figure: their number.
    NotMilled,
    /// Several operations were asked for, and some of them with shorter estimated times are not planned: the paths of other plans took
    /// all lines that are computed for one answer. Figure: the number of such arrangements of cutters and lines.
    OperationsNotPlanned,
    /// The fastest cutter has no teeth and spindle speed and is timed at the machine's feed rate, others are timed at their
    /// own. Figure: the number of these others.
    AssumedFeed,
    /// The fastest plan leads by less than 2 %, about the error of the simulation. Figure: the lead over the next plan
    /// as a share of its time.
    SmallLead,
    /// Facets are wide compared with the step-over although the surface is curved, so that slopes and curvatures
    /// between passes are those of the tessellation. Figure: the size of a facet over the median step-over. At 2, one
    /// facet determines two strips; at 8, eight. Facets within a tenth of the scallop height of the surface are
    /// accurate enough at any size. Within the scallop height they lower the confidence to moderate: a flat-end
    /// cutter's time on waves changes by 1 % if facets 13 times as wide as its step-over are divided in four.
    CoarseTessellation,
    /// A part of the area is steeper than the largest slope and sets no spacing. Figure: its share.
    SteepArea,
    /// A part of the selected area is hidden from above and left out. Figure: its share.
    HiddenArea,
    /// The surface has several pieces; finished one by one, they would need fewer links. Figure: their number.
    SeveralPieces,
    /// Some facets have the opposite orientation, so that the mesh does not show on which side the part is. Figure:
    /// their share of the area.
    InconsistentOrientation,
    /// A solid lacks facets, or some are turned. Into a hole the cutter may go, and what it leaves there does not count. Figure: their
    /// area in mm^2.
    NotClosed,
    /// The recommended plan leaves more than half a per cent of the area, of what the cutter can reach, higher than 1.02 of
    /// the scallop height. Figure: that share.
    OverTolerance,
    /// The recommended plan cuts into the part deeper than two fifths of the scallop height. Figure: the depth over the
    /// scallop height.
    Gouge,
    /// The runs of the recommended plan have sharp corners, and its time counts no stops in them. Figure: its time on a control that
    /// stops in corners of more than 45 deg, over the stated one.
    SharpCorners,
    /// A part of the path has no feed rate and is timed at the machine's. Figure: its share of the length.
    AssumedPathFeed,
    /// The path misses most of the surface, or cuts into most of it. Figure: that share of the area.
    PathMisplaced,
    /// The machine has no path tolerance: corners between stops take no time. Figure: the moves from stop to stop.
    CornersNotTimed,
}

impl fmt::Display for Reason<SurfaceWeakness> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { figure, threshold, .. } = self;
        match self.weakness {
            SurfaceWeakness::NotMilled => write!(
                f,
                "of the candidates with shorter estimated times, {figure:.0} have paths too long to be milled; their figures are estimates"
            ),
            SurfaceWeakness::OperationsNotPlanned => write!(
                f,
                "{figure:.0} arrangements of several operations have shorter estimated times and were not planned: paths planned before them took all lines that are computed for one answer"
            ),
            SurfaceWeakness::AssumedFeed => write!(
                f,
                "the fastest cutter has no teeth and spindle speed and is timed at the machine's feed rate; {figure:.0} others are timed at their own"
            ),
            SurfaceWeakness::SmallLead => write!(
                f,
                "the fastest plan leads the next by {:.2} %, less than the {:.0} % by which the simulation may err",
                100.0 * figure,
                100.0 * threshold
            ),
            SurfaceWeakness::CoarseTessellation => {
                write!(
                    f,
                    "facets are {figure:.2} times as wide as the step-over, over {threshold}: slope and curvature are those of the tessellation"
                )
            }
            SurfaceWeakness::SteepArea => write!(f, "{:.2} % of the area is too steep to set a spacing", 100.0 * figure),
            SurfaceWeakness::HiddenArea => write!(
                f,
                "{:.2} % of the selected area, without the undersides of solids, is hidden from above and left out",
                100.0 * figure
            ),
            SurfaceWeakness::SeveralPieces => {
                write!(f, "the surface is in {figure:.0} pieces; finished piece by piece it may take fewer links")
            }
            SurfaceWeakness::InconsistentOrientation => {
                write!(
                    f,
                    "{:.2} % of the area faces the other way than the rest: the mesh does not show which side is the part",
                    100.0 * figure
                )
            }
            SurfaceWeakness::NotClosed => write!(
                f,
                "the solid is not closed: facets of {figure:.4} mm^2 are missing or turned; the cutter may go into the hole, and what it leaves there does not count"
            ),
            SurfaceWeakness::OverTolerance => {
                write!(
                    f,
                    "{:.2} % of the area is left more than 2 % over the scallop height although the cutter reaches it",
                    100.0 * figure
                )
            }
            SurfaceWeakness::Gouge => write!(f, "the path cuts {figure:.2} times the scallop height deep into the part, over {threshold}"),
            SurfaceWeakness::SharpCorners => write!(
                f,
                "on a control that stops in corners of more than 45 deg the plan takes {figure:.2} times as long; state path_tolerance_mm of the machine"
            ),
            SurfaceWeakness::AssumedPathFeed => {
                write!(f, "{:.2} % of the length has no feed rate and is timed at the machine's", 100.0 * figure)
            }
            SurfaceWeakness::PathMisplaced => write!(
                f,
                "{:.1} % of the area is missed or cut into by the path: select the facets that it is for; or its zero point, unit, cutter or tip is wrong",
                100.0 * figure
            ),
            SurfaceWeakness::CornersNotTimed => write!(
                f,
                "{figure:.0} moves from stop to stop on average, between which the control slows down in no corner; state path_tolerance_mm of the machine"
            ),
        }
    }
}

/// What the check of a path rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathEvidence {
    /// The surface.
    pub surface: SurfaceEvidence,
    /// The tolerance of the check.
    pub tolerance: Length,
    /// The share of the length of the moves at the feed rate for which the path states no feed rate.
    pub assumed_feed_share: f64,
    /// The share of the area over which no move comes, or which the path cuts into.
    pub missed_or_cut_share: f64,
    /// The moves at the feed rate from stop to stop, on average, on a control without a path tolerance; 0 with one.
    pub moves_without_corners: f64,
}

impl Confidence<SurfaceWeakness> {
    /// The confidence in the check of a path.
    #[must_use]
    pub fn in_path(evidence: &PathEvidence) -> Self {
        let PathEvidence { surface, tolerance, assumed_feed_share, missed_or_cut_share, moves_without_corners } = *evidence;
        let reasons = [
            Reason::over(SurfaceWeakness::InconsistentOrientation, surface.turned_area_share, 0.001, 0.05),
            Reason::missing_area(SurfaceWeakness::NotClosed, surface.missing_area, tolerance),
            Reason::over(SurfaceWeakness::HiddenArea, surface.hidden_area_share, 0.001, 0.1),
            // A path for a small part of a surface is intended more often than one for hardly any of it.
            Reason::over(SurfaceWeakness::PathMisplaced, missed_or_cut_share, 0.5, 0.95),
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

    #[test]
    fn reasons_are_named_from_their_thresholds_on() {
        let sound = PathEvidence {
            surface: SurfaceEvidence { missing_area: 0.005, ..SurfaceEvidence::default() },
            tolerance: Length::computed(0.01),
            assumed_feed_share: 0.0,
            missed_or_cut_share: 0.5,
            moves_without_corners: 0.0,
        };
        assert_eq!(Confidence::in_path(&sound).level(), Level::High);
        let surface = SurfaceEvidence { hidden_area_share: 0.02, turned_area_share: 0.2, missing_area: 0.5, ..sound.surface };
        let doubtful = PathEvidence { surface, missed_or_cut_share: 0.9, moves_without_corners: 40.0, ..sound };
        let confidence = Confidence::in_path(&doubtful);
        assert_eq!(confidence.level(), Level::Low);
        let weaknesses: Vec<SurfaceWeakness> = confidence.reasons().iter().map(|reason| reason.weakness).collect();
        assert_eq!(
            weaknesses,
            [
                SurfaceWeakness::InconsistentOrientation,
                SurfaceWeakness::NotClosed,
                SurfaceWeakness::HiddenArea,
                SurfaceWeakness::PathMisplaced,
                SurfaceWeakness::CornersNotTimed
            ]
        );
    }
}
