//! The codes of reasons why a valid request has no answer, with the figures that help the caller to correct it. Each
//! code is also the type of a problem.

use super::codes;
use crate::milling::NoAnswer;
use crate::quantity::Length;

codes! {
    /// A reason why a contact or a surface has no answer.
    NoAnswerCode: UNPROCESSABLE_ENTITY {
        FlatFloor = "flat-floor": "The analytic model has no answer on a floor", "Use model \"envelope\", or a ball-end cutter.";
        StraightFlank = "straight-flank": "The analytic model has no answer at the slope of a cone", "Use model \"envelope\", or another slope.";
        SlopeTooSteep = "slope-too-steep": "The slope is steeper than the cutter cuts", "Use a cutter with a smaller taper, or tilt the tool; steepest_slope_deg is the steepest slope that it cuts.";
        PassesDoNotOverlap = "passes-do-not-overlap": "The passes do not overlap", "Reduce the step-over to at most largest_step_over_mm.";
        MarksDoNotOverlap = "marks-do-not-overlap": "The tooth marks do not overlap", "Reduce the feed per tooth.";
        Gouging = "gouging": "The cutter gouges", "Use a smaller cutter, another corner radius, or a tilted tool; smallest_radius_mm, if present, is the smallest concave radius that the cutter fits.";
        SharpEdge = "sharp-edge": "The model has no answer if a sharp edge makes the cut", "Use model \"envelope\", a cutter with a corner radius, or another feed direction.";
        PassesCoincideFromAbove = "passes-coincide-from-above": "Seen from above, the passes coincide", "State the step-over along the surface, step_over_mm.";
        ToleranceExceeded = "tolerance-exceeded": "The step-over alone uses up the tolerance", "Reduce the step-over to under max_step_over_mm, or allow more height.";
        ToleranceExceededByFeed = "tolerance-exceeded-by-feed": "The feed alone uses up the tolerance", "Reduce the feed per tooth or the runout, or allow more height than feed_height_mm.";
        ToleranceExceededByRunout = "tolerance-exceeded-by-runout": "Runout alone uses up the tolerance", "Reduce the runout or the step-over, or allow more height.";
        ToleranceSetsNoLimit = "tolerance-sets-no-limit": "The tolerance sets no limit", "State a lower tolerance; or max_feed_per_tooth_mm for a feed, and max_step_over_mm as well for cutting parameters.";
    }
}

/// A figure that a problem has as a member.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ProblemFigure {
    /// The member's name on the wire, with its unit.
    pub(crate) name: &'static str,
    pub(crate) about: &'static str,
}

const STEP_OVER_HEIGHT: ProblemFigure = figure("step_over_height_mm", "h1, the height that the step-over alone leaves");
const MAX_STEP_OVER: ProblemFigure = figure(
    "max_step_over_mm",
    "the step-over that alone leaves exactly the tolerance; a smaller one leaves room for tooth marks and runout",
);
const LARGEST_STEP_OVER: ProblemFigure = figure(
    "largest_step_over_mm",
    "the largest step-over at which the passes, and the tooth marks if there is a feed, meet; if the marks meet at no step-over, the largest one without them; on a curved surface up to 1 % less",
);
const LARGEST_OVERLAP: ProblemFigure = figure(
    LARGEST_STEP_OVER.name,
    "the largest step-over at which the passes, and the tooth marks if there is a feed, overlap; absent if it is the feed that has no limit",
);
const SMALLEST_RADIUS: ProblemFigure = figure(
    "smallest_radius_mm",
    "the smallest concave radius of the surface into which the cutter fits, if both principal curvatures are scaled alike; up to 1 % too large where the cutter gouges away from the contact; absent if it gouges at any radius",
);
const FEED_HEIGHT: ProblemFigure =
    figure("feed_height_mm", "the height that the tooth marks leave with the smallest step-over; at least the tolerance");

const STEEPEST_SLOPE: ProblemFigure = figure("steepest_slope_deg", "the steepest slope that the cutter cuts");

const fn figure(name: &'static str, about: &'static str) -> ProblemFigure {
    ProblemFigure { name, about }
}

impl NoAnswerCode {
    /// The figures of a problem of this type: those that are always present, and those that may be absent.
    pub(crate) fn figures(self) -> (&'static [ProblemFigure], &'static [ProblemFigure]) {
        match self {
            Self::ToleranceExceeded => (&[STEP_OVER_HEIGHT, MAX_STEP_OVER], &[]),
            Self::PassesDoNotOverlap => (&[LARGEST_STEP_OVER], &[]),
            Self::ToleranceSetsNoLimit => (&[], &[LARGEST_OVERLAP]),
            Self::Gouging => (&[], &[SMALLEST_RADIUS]),
            Self::ToleranceExceededByFeed => (&[FEED_HEIGHT], &[]),
            Self::SlopeTooSteep => (&[STEEPEST_SLOPE], &[]),
            Self::FlatFloor
            | Self::StraightFlank
            | Self::MarksDoNotOverlap
            | Self::SharpEdge
            | Self::PassesCoincideFromAbove
            | Self::ToleranceExceededByRunout => (&[], &[]),
        }
    }

    /// The code of `cause`, with its figures.
    pub(crate) fn of(cause: NoAnswer) -> (Self, Vec<(ProblemFigure, f64)>) {
        let one = |figure, length: Length| vec![(figure, length.mm())];
        match cause {
            NoAnswer::FlatFloor => (Self::FlatFloor, Vec::new()),
            NoAnswer::StraightFlank => (Self::StraightFlank, Vec::new()),
            NoAnswer::TooSteep { steepest } => (Self::SlopeTooSteep, vec![(STEEPEST_SLOPE, steepest.degrees())]),
            NoAnswer::PassesDoNotOverlap { largest_step_over } => (Self::PassesDoNotOverlap, one(LARGEST_STEP_OVER, largest_step_over)),
            NoAnswer::MarksDoNotOverlap { largest_mark_spacing: _ } => (Self::MarksDoNotOverlap, Vec::new()),
            NoAnswer::Gouges { smallest_radius } => {
                (Self::Gouging, smallest_radius.map_or(Vec::new(), |radius| one(SMALLEST_RADIUS, radius)))
            }
            NoAnswer::SharpEdge => (Self::SharpEdge, Vec::new()),
            NoAnswer::PassesCoincideFromAbove => (Self::PassesCoincideFromAbove, Vec::new()),
            NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over } => {
                let figures = vec![(STEP_OVER_HEIGHT, step_over_height.mm()), (MAX_STEP_OVER, max_step_over.mm())];
                (Self::ToleranceExceeded, figures)
            }
            NoAnswer::FeedUsesUpTolerance { feed_height } => (Self::ToleranceExceededByFeed, one(FEED_HEIGHT, feed_height)),
            NoAnswer::RunoutUsesUpTolerance => (Self::ToleranceExceededByRunout, Vec::new()),
            NoAnswer::ToleranceLimitsNoStepOver { largest_step_over } => {
                (Self::ToleranceSetsNoLimit, one(LARGEST_OVERLAP, largest_step_over))
            }
            NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth: _ } => (Self::ToleranceSetsNoLimit, Vec::new()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Angle;

    #[test]
    fn every_cause_carries_the_figures_that_its_code_documents() {
        let length = Length::from_mm(1.0).unwrap();
        for cause in [
            NoAnswer::FlatFloor,
            NoAnswer::StraightFlank,
            NoAnswer::TooSteep { steepest: Angle::RIGHT },
            NoAnswer::PassesDoNotOverlap { largest_step_over: length },
            NoAnswer::MarksDoNotOverlap { largest_mark_spacing: length },
            NoAnswer::Gouges { smallest_radius: Some(length) },
            NoAnswer::Gouges { smallest_radius: None },
            NoAnswer::SharpEdge,
            NoAnswer::PassesCoincideFromAbove,
            NoAnswer::StepOverUsesUpTolerance { step_over_height: length, max_step_over: length },
            NoAnswer::FeedUsesUpTolerance { feed_height: length },
            NoAnswer::RunoutUsesUpTolerance,
            NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: length },
            NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth: length },
        ] {
            let (code, figures) = NoAnswerCode::of(cause);
            let (always, sometimes) = code.figures();
            let has = |figure: &ProblemFigure| figures.iter().any(|(found, _)| found == figure);
            assert!(always.iter().all(has), "{cause:?}");
            assert!(figures.iter().all(|(figure, _)| always.contains(figure) || sometimes.contains(figure)), "{cause:?}");
        }
    }
}
