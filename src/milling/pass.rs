//! A finishing pass, independent of the model: cutter, contact, curvature of the surface, runout, and step-over; and the
//! reasons why a valid pass has no scallop height, feed or step-over, with the figures that help to correct it.

use super::{Contact, Cutter, SurfaceCurvature};
use crate::numerics::hypotenuse;
use crate::quantity::{Angle, Length, OutOfRange};
use std::fmt;
use std::num::NonZeroU32;

/// One contact of a finishing pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pass {
    /// The cutter, without runout.
    pub cutter: Cutter,
    /// Slope and feed direction.
    pub contact: Contact,
    /// The curvature of the surface at the contact.
    pub surface: SurfaceCurvature,
    /// The runout of the teeth.
    pub runout: Runout,
    /// z, the number of teeth; `None` if it is unknown. It matters only with runout; an unknown number counts as 2.
    pub teeth: Option<NonZeroU32>,
}

impl Pass {
    /// Whether two teeth in a row can protrude less than another one.
    pub(super) fn has_shallow_pairs(&self) -> bool {
        self.teeth.is_some_and(|teeth| teeth.get() > 2)
    }
}

/// The deviation of the teeth from their common circle [Segonds 2017, eq. 16-18]. Both parts are assumed to be small
/// compared with the feed per tooth; otherwise some teeth leave no mark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Runout {
    radial: f64,
    axial: f64,
}

impl Runout {
    /// A cutter without runout.
    pub const NONE: Self = Self { radial: 0.0, axial: 0.0 };
    /// The largest runout that is accepted, in mm.
    pub const LARGEST: f64 = 10.0;

    /// The same runout with the radial part rr, in mm: how much further one tooth protrudes than the next.
    ///
    /// # Errors
    /// [`OutOfRange`] unless 0 <= rr <= [`Runout::LARGEST`].
    pub fn with_radial_mm(self, radial: f64) -> Result<Self, OutOfRange> {
        Ok(Self { radial: OutOfRange::check(radial, 0.0, Self::LARGEST)?, ..self })
    }

    /// The same runout with the axial part ar, in mm: how much lower one tooth is than the next. If the feed climbs, a
    /// positive ar shortens the distance from mark to mark, and a negative one lengthens it.
    ///
    /// # Errors
    /// [`OutOfRange`] unless |ar| <= [`Runout::LARGEST`].
    pub fn with_axial_mm(self, axial: f64) -> Result<Self, OutOfRange> {
        Ok(Self { axial: OutOfRange::check(axial, -Self::LARGEST, Self::LARGEST)?, ..self })
    }

    /// rr, the radial runout.
    #[must_use]
    pub fn radial(self) -> Length {
        Length::computed(self.radial)
    }

    /// The largest displacement of a tooth, sqrt(rr^2 + ar^2).
    #[must_use]
    pub fn magnitude(self) -> Length {
        Length::computed(hypotenuse(self.radial, self.axial))
    }

    /// delta = |rr| sin(S) + |ar| cos(S), in mm: how much less deep the shallowest tooth reaches into a surface of
    /// slope S than the deepest.
    pub(super) fn depth(self, slope: Angle) -> f64 {
        self.radial * slope.sin() + self.axial.abs() * slope.cos()
    }

    /// By how much marks of teeth that follow each other can be further apart along the feed than the feed per tooth, in mm. The
    /// mark of a tooth that protrudes less is displaced along the steepest line: by up to |rr| cos(S) downwards if it is
    /// closer to the axis, and by up to |ar| sin(S) upwards if it is higher. Two shallow teeth in a row can be displaced
    /// either way.
    pub(super) fn displacement(self, contact: Contact, shallow_pairs: bool) -> f64 {
        let (down, up) = (self.radial * contact.slope().cos(), self.axial.abs() * contact.slope().sin());
        contact.omega().cos().abs() * if shallow_pairs { down + up } else { down.max(up) }
    }

    /// f'_z, the distance from tooth mark to tooth mark for the feed per tooth f_z with this runout and a feed that
    /// climbs at `climb` [Segonds 2017, eq. 17]: sqrt((f_z cos + rr)^2 + (f_z sin - ar)^2).
    #[must_use]
    pub fn mark_spacing(self, feed_per_tooth: Length, climb: Angle) -> Length {
        let (x, z) = (feed_per_tooth.mm() * climb.cos() + self.radial, feed_per_tooth.mm() * climb.sin() - self.axial);
        Length::computed(hypotenuse(x, z))
    }

    /// The feed per tooth whose marks are `mark_spacing` apart, the inverse of [`Runout::mark_spacing`]: f_z = -b +
    /// sqrt(b^2 + q), b = rr cos - ar sin, q = f'_z^2 - rr^2 - ar^2. `None` if no feed above 0 has a distance this
    /// small.
    #[must_use]
    pub fn feed_per_tooth(self, mark_spacing: Length, climb: Angle) -> Option<Length> {
        let b = self.radial * climb.cos() - self.axial * climb.sin();
        let r = self.magnitude().mm();
        // The difference of squares is written as a product, so that nothing cancels if runout is most of the spacing.
        let q = (mark_spacing.mm() - r) * (mark_spacing.mm() + r);
        let discriminant = b * b + q;
        if discriminant < 0.0 {
            return None;
        }
        // For b > 0 the two terms of the root cancel; their product form does not: -b + sqrt(b^2 + q) = q / (b +
        // sqrt(b^2 + q)).
        let feed = if b > 0.0 { q / (b + discriminant.sqrt()) } else { discriminant.sqrt() - b };
        (feed > 0.0).then(|| Length::computed(feed))
    }
}

/// The step-over, in one of the two ways in which CAM systems state it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepOver {
    /// s, along the surface, perpendicular to the feed.
    AlongSurface(Length),
    /// d, between parallel vertical planes, seen from above.
    SeenFromAbove(Length),
}

impl StepOver {
    /// s, the step-over along the surface: d / sqrt(1 - sin^2(S) sin^2(alpha)) for a step-over d seen from above.
    ///
    /// # Errors
    /// [`NoAnswer::PassesCoincideFromAbove`] for a feed along a wall: vertical planes do not separate its passes.
    pub fn along_surface(self, contact: Contact) -> Result<Length, NoAnswer> {
        match self {
            Self::AlongSurface(s) => Ok(s),
            Self::SeenFromAbove(d) => {
                let ratio = contact.spacing_ratio();
                if ratio > 0.0 { Ok(Length::computed(d.mm() / ratio)) } else { Err(NoAnswer::PassesCoincideFromAbove) }
            }
        }
    }
}

/// The scallop height of a pass, in its two parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScallopHeight {
    /// h1, the height that the step-over alone leaves.
    pub step_over: Length,
    /// The height that the tooth marks along the feed add.
    pub feed: Length,
    total: Length,
    largest_turn: f64,
}

impl ScallopHeight {
    /// The height of two parts.
    pub(super) fn of_parts(step_over: Length, feed: Length) -> Self {
        Self { step_over, feed, total: step_over + feed, largest_turn: 0.0 }
    }

    /// The height `total`, of which the step-over alone leaves `step_over`, or less where that exceeds it.
    pub(super) fn of_total(step_over: Length, total: Length) -> Self {
        let step_over = if total < step_over { total } else { step_over };
        Self { step_over, feed: Length::computed(total.mm() - step_over.mm()), total, largest_turn: 0.0 }
    }

    pub(super) fn with_turn(self, largest_turn: f64) -> Self {
        Self { largest_turn, ..self }
    }

    /// h, the sum of both.
    #[must_use]
    pub fn total(self) -> Length {
        self.total
    }

    /// How much the normal of a curved surface turns from the stated contact to the marks at the ridge, under model
    /// `envelope`: the tangent of the largest angle, as a share of the turn with which the contact would leave its arc of the
    /// cutter's profile; on a torus that is the smaller of sine and cosine of the slope. 0 on a plane, for a ball, on a sharp
    /// edge, and under model `analytic`.
    #[must_use]
    pub fn largest_turn(self) -> f64 {
        self.largest_turn
    }

    /// The share of the feed height in the scallop height, from 0 to 1; `None` if the height is 0.
    #[must_use]
    pub fn feed_share(self) -> Option<f64> {
        let total = self.total().mm();
        (total > 0.0).then(|| self.feed.mm() / total)
    }
}

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
