//! The reasons that lower the confidence in plans that are milled, and in checks of paths.

use super::confidence::Reason;
use std::fmt;

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
    /// The machine has no path tolerance: corners between stops take no time. Figure: the moves from stop to stop.
    CornersNotTimed,
}

impl fmt::Display for Reason<SurfaceWeakness> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { figure, threshold, .. } = self;
        match self.weakness {
            SurfaceWeakness::NotMilled => write!(
                f,
                "{figure:.0} candidates with shorter estimated times have paths too long to be milled; their figures are estimates"
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
            SurfaceWeakness::CornersNotTimed => write!(
                f,
                "{figure:.0} moves from stop to stop on average, between which the control slows down in no corner; state path_tolerance_mm of the machine"
            ),
        }
    }
}
