//! The reasons why a valid pass has no scallop height, feed or step-over, with the figures that help to correct it.

use crate::quantity::{Angle, Length};
use std::fmt;

/// The reason why a valid pass has no answer, with the bound that it exceeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoAnswer {
    /// On a floor the groove of a toroidal or flat-end cutter has no curvature, on which the analytic model is based.
    FlatFloor,
    /// The slope is that of a cone, whose flank touches along a line: the groove has no curvature, on which the analytic model
    /// is based.
    StraightFlank,
    /// The slope is steeper than the cutter's profile cuts: its shank would touch.
    TooSteep {
        /// The steepest slope.
        steepest: Angle,
    },
    /// The step-over is wider than the groove: uncut material remains between the passes.
    PassesDoNotOverlap {
        /// The step-over at which the grooves just meet.
        largest_step_over: Length,
    },
    /// Tooth marks are further apart than a mark is long: uncut material remains between them.
    MarksDoNotOverlap {
        /// The distance of marks at which they just meet.
        largest_mark_spacing: Length,
    },
    /// The cutter does not fit the concave surface and cuts into it beside the contact.
    Gouges {
        /// The smallest radius of curvature into which the cutter fits, of the stated concave radius or of the smaller
        /// concave principal radius, if both curvatures are scaled alike. If lambda is 0 there, it is that radius
        /// multiplied by 1 - lambda; otherwise it is up to 1 % too large. `None` if a flat or a wall gouges at any radius.
        smallest_radius: Option<Length>,
    },
    /// A flat-end cutter's edge runs along the cut: its circle has no radius, which the analytic model needs.
    SharpEdge,
    /// Seen from above, the passes coincide.
    PassesCoincideFromAbove,
    /// The step-over alone leaves as much as the tolerance allows, so that no feed is possible.
    StepOverUsesUpTolerance {
        /// The height that the step-over alone leaves.
        step_over_height: Length,
        /// The step-over that leaves just the tolerance; a smaller one leaves room for a feed.
        max_step_over: Length,
    },
    /// The feed's marks alone leave as much as the tolerance allows, so that no step-over is possible.
    FeedUsesUpTolerance {
        /// The height that the feed alone leaves.
        feed_height: Length,
    },
    /// Runout alone moves the marks so far apart that no feed keeps the tolerance.
    RunoutUsesUpTolerance,
    /// The tolerance is higher than any scallop between overlapping passes: it limits nothing.
    ToleranceLimitsNoStepOver {
        /// The step-over beyond which the passes no longer overlap.
        largest_step_over: Length,
    },
    /// The tolerance is higher than any mark between overlapping tooth marks: it limits nothing.
    ToleranceLimitsNoFeed {
        /// The feed per tooth beyond which the marks no longer overlap.
        largest_feed_per_tooth: Length,
    },
}

/// A length in a text: to a nanometre, and below a micrometre to four digits.
struct Shown(Length);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = self.0.mm();
        if mm == 0.0 || mm.abs() >= 1e-3 { write!(f, "{mm:.6}") } else { write!(f, "{mm:.3e}") }
    }
}

/// The lengths of a kind up to the largest at which passes or marks overlap; on a wall that is any accepted one.
struct UpTo(&'static str, Length);

impl fmt::Display for UpTo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(kind, largest) = *self;
        if largest.mm() >= Length::LARGEST { write!(f, "at any {kind}") } else { write!(f, "up to a {kind} of {} mm", Shown(largest)) }
    }
}

impl fmt::Display for NoAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FlatFloor => f.write_str(
                "on a floor (slope 0) the effective radius of a toroidal or flat-end cutter is infinite and the analytic model has no answer; model \"envelope\" has one",
            ),
            Self::StraightFlank => f.write_str(
                "the slope is that of the cutter's cone, whose effective radius is infinite, and the analytic model has no answer; model \"envelope\" has one",
            ),
            Self::TooSteep { steepest } => write!(
                f,
                "the cutter cuts slopes of up to {:.3} deg; on a steeper one its cone or shank would touch",
                steepest.degrees()
            ),
            Self::PassesDoNotOverlap { largest_step_over } => {
                write!(f, "the passes do not overlap and leave uncut material between them; the step-over must be at most {} mm", Shown(*largest_step_over))
            }
            Self::MarksDoNotOverlap { largest_mark_spacing } => write!(
                f,
                "the marks of neighbouring teeth do not overlap and leave uncut material between them; they must be at most {} mm apart, so reduce the feed per tooth or the runout",
                Shown(*largest_mark_spacing)
            ),
            Self::Gouges { smallest_radius: Some(radius) } => write!(
                f,
                "the cutter gouges the concave surface: its radius of curvature must exceed {} mm for this cutter at this contact; take a smaller cutter, or another corner radius",
                Shown(*radius)
            ),
            Self::Gouges { smallest_radius: None } => f.write_str(
                "the cutter gouges the concave surface at any radius of curvature, with its flat or its side; take a ball-end cutter, or tilt the tool",
            ),
            Self::SharpEdge => f.write_str(
                "in this feed direction a flat-end cutter's sharp edge makes the cut, and the analytic model has no circle to put in its place; model \"envelope\" has an answer",
            ),
            Self::PassesCoincideFromAbove => {
                f.write_str("the feed runs along a vertical wall, on which vertical planes cannot space the passes; give the step-over along the surface")
            }
            Self::StepOverUsesUpTolerance { step_over_height, max_step_over } => write!(
                f,
                "the step-over alone leaves {} mm, which uses up the tolerance; a step-over under {} mm leaves room for a feed",
                Shown(*step_over_height),
                Shown(*max_step_over)
            ),
            Self::FeedUsesUpTolerance { feed_height } => {
                write!(f, "the tooth marks alone leave {} mm, which uses up the tolerance; reduce the feed per tooth or the runout", Shown(*feed_height))
            }
            Self::RunoutUsesUpTolerance => {
                f.write_str("runout alone moves the tooth marks further apart than the tolerance allows; reduce the runout or the step-over, or allow more height")
            }
            Self::ToleranceLimitsNoStepOver { largest_step_over } => write!(
                f,
                "the tolerance exceeds every scallop between overlapping passes, so it sets no limit; the passes overlap {}; state a lower tolerance, or a largest step-over",
                UpTo("step-over", *largest_step_over)
            ),
            Self::ToleranceLimitsNoFeed { largest_feed_per_tooth } => write!(
                f,
                "the tolerance exceeds every mark between overlapping tooth marks, so it sets no limit; the marks overlap {}; state a lower tolerance, or a largest feed per tooth",
                UpTo("feed per tooth", *largest_feed_per_tooth)
            ),
        }
    }
}

impl std::error::Error for NoAnswer {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_under_a_micrometre_keep_their_digits() {
        let shown = |mm: f64| Shown(Length::computed(mm)).to_string();
        assert_eq!([0.0, 3.4e-5, 9.9e-4, 1e-3, 12.5].map(shown), ["0.000000", "3.400e-5", "9.900e-4", "0.001000", "12.500000"]);
    }
}
