//! Model `analytic`: the published closed formulas, which replace the cutter by a circle of the effective radius.
//!
//! Formulas: Segonds et al. 2017, eq. 3 and 8 (effective radii), 9 and 12-15 (heights), 16-18 (runout).

use super::gouging;
use super::{Contact, Cutter, NoAnswer, Pass, Runout, ScallopHeight};
use crate::quantity::{Angle, Length};

/// The radius of curvature of the groove that a cutter leaves, in mm: positive, 0 for a sharp edge, or infinite for a
/// flat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectiveRadius(f64);

impl EffectiveRadius {
    /// `R_eff`, in the plane normal to the feed [Segonds 2017, eq. 3]:
    ///
    /// (R - r) cos^2(alpha) / (sin(S) (1 - sin^2(alpha) sin^2(S))) + r
    ///
    /// with e and r of the profile's arc at the slope in place of R - r and r. It is R for a ball-end cutter, and infinite at
    /// the slope of a flat or a cone. With omega, cos^2(omega) = cos^2(alpha) / (1 -
    /// sin^2(alpha) sin^2(S)), it is also defined on walls.
    #[must_use]
    pub fn across_feed(cutter: Cutter, contact: Contact) -> Self {
        Self::of(cutter, contact, contact.omega().cos().powi(2))
    }

    /// `TR_eff`, the transverse effective radius, in the plane along the feed [Segonds 2017, eq. 8]: `R_eff` for alpha
    /// + 90 deg.
    #[must_use]
    pub fn along_feed(cutter: Cutter, contact: Contact) -> Self {
        let (sin, cos) = (contact.alpha().sin(), contact.alpha().cos());
        // cos^2(omega) for alpha + 90 deg is sin^2(alpha) / (1 - cos^2(alpha) sin^2(S)); here the denominator is
        // written without cancellation.
        let share = if sin == 0.0 { 0.0 } else { sin * sin / (sin * sin + (cos * contact.slope().cos()).powi(2)) };
        Self::of(cutter, contact, share)
    }

    fn of(cutter: Cutter, contact: Contact, share: f64) -> Self {
        let (profile, slope) = (cutter.profile(), contact.slope());
        if profile.is_straight_at(slope.radians()) {
            return Self(f64::INFINITY);
        }
        let arc = profile.arc_at(slope.radians());
        // The arc of a ball has the same radius everywhere, on a floor too.
        let level = if arc.centre_offset == 0.0 { 0.0 } else { arc.centre_offset * share / slope.sin() };
        Self(level + arc.radius)
    }

    /// The radius; `None` if it is infinite, or so large that its diameter overflows or its reciprocal underflows.
    #[must_use]
    pub fn finite(self) -> Option<Length> {
        (self.0 < 1e300).then(|| Length::computed(self.0))
    }

    /// height(P, c) = P - sqrt(P^2 - c^2/4), the height between circles of radius P at the distance c. `None` if c >
    /// 2P, because the circles do not meet.
    fn height(self, chord: f64) -> Option<f64> {
        let half = chord / 2.0;
        let ratio = half / self.0;
        // With x = c/2P: P (1 - sqrt(1 - x^2)) = (c/2) x / (1 + sqrt((1 - x)(1 + x))), without cancellation or
        // overflow.
        (ratio <= 1.0).then(|| half * ratio / (1.0 + ((1.0 - ratio) * (1.0 + ratio)).sqrt()))
    }

    /// chord(P, h) = 2 sqrt(2 P h - h^2), the inverse of the height. `None` if h > P, because no circles leave this
    /// height.
    fn chord(self, height: f64) -> Option<f64> {
        (height <= self.0).then(|| 2.0 * height.sqrt() * (2.0 * self.0 - height).sqrt())
    }
}

/// The analytic model at one contact.
///
/// The formulas use the curvatures 1/rho of the surface and 1/R_eff of the groove, so that a plane, 1/rho = 0, is not a
/// special case.
#[derive(Debug, Clone, Copy)]
pub struct Analytic {
    pass: Pass,
    across: EffectiveRadius,
    along: EffectiveRadius,
    relative_curvature: f64,
}

impl Analytic {
    /// Computes the effective radii of a pass: across the feed with R + rr in place of R [Segonds 2017, after eq. 15],
    /// along it without runout.
    ///
    /// # Errors
    /// - [`NoAnswer::FlatFloor`] at slope 0, unless the cutter's tip is round; [`NoAnswer::StraightFlank`] at the slope of a
    ///   cone; [`NoAnswer::TooSteep`] beyond it;
    /// - [`NoAnswer::SharpEdge`] if the effective radius is 0: a flat-end cutter fed along the level line;
    /// - [`NoAnswer::Gouges`] on a concave surface into which the cutter does not fit.
    #[inline]
    pub fn new(pass: Pass) -> Result<Self, NoAnswer> {
        Self::fitting(pass)?.ok_or_else(|| gouging::reason(&pass))
    }

    /// Prepares the cutter in contact with the surface, or `None` if it does not fit.
    #[inline]
    pub(super) fn fitting(pass: Pass) -> Result<Option<Self>, NoAnswer> {
        let Some(relative_curvature) = gouging::relative_curvature(&pass) else { return Ok(None) };
        let across = EffectiveRadius::across_feed(pass.cutter.widened(pass.runout.radial()), pass.contact);
        let along = EffectiveRadius::along_feed(pass.cutter, pass.contact);
        let (Some(effective_radius), Some(_)) = (across.finite(), along.finite()) else {
            let is_floor = pass.contact.slope().sin() == 0.0;
            return Err(if is_floor { NoAnswer::FlatFloor } else { NoAnswer::StraightFlank });
        };
        if across.0 == 0.0 {
            return Err(NoAnswer::SharpEdge);
        }
        // The groove's circle must also be more curved than the surface across the feed, whatever the curvature along
        // the feed is.
        if across.0.recip() + pass.surface.across_per_mm() <= 0.0 {
            return Err(NoAnswer::Gouges { smallest_radius: Some(effective_radius) });
        }
        Ok(Some(Self { pass, across, along, relative_curvature }))
    }

    pub(super) fn pass(&self) -> &Pass {
        &self.pass
    }

    /// lambda, the smallest relative curvature of cutter and surface as a share of the cutter's own.
    pub(super) fn relative_curvature(&self) -> f64 {
        self.relative_curvature
    }

    /// The effective radius across the feed, as h1 uses it.
    #[must_use]
    pub fn across_feed(&self) -> EffectiveRadius {
        self.across
    }

    /// The effective radius along the feed, as h2 uses it.
    #[must_use]
    pub fn along_feed(&self) -> EffectiveRadius {
        self.along
    }

    /// h1 and h2 [Segonds 2017, eq. 12-14 and 18] for a step-over along the surface and a feed per tooth; `None` leaves
    /// no marks.
    ///
    /// # Errors
    /// [`NoAnswer::PassesDoNotOverlap`], [`NoAnswer::MarksDoNotOverlap`]; [`NoAnswer::SharpEdge`] for the marks of a
    /// flat-end cutter fed down the slope.
    pub fn scallop_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<ScallopHeight, NoAnswer> {
        self.height_above(self.step_over_height(step_over)?, feed_per_tooth)
    }

    /// h1 and h2 beside a step-over that alone leaves `step_over_height`.
    pub(super) fn height_above(&self, step_over_height: Length, feed_per_tooth: Option<Length>) -> Result<ScallopHeight, NoAnswer> {
        Ok(ScallopHeight::of_parts(step_over_height, self.feed_height(feed_per_tooth)?))
    }

    /// The largest feed per tooth that keeps the tolerance `tolerance` on h1 + h2.
    ///
    /// # Errors
    /// [`NoAnswer::StepOverUsesUpTolerance`], [`NoAnswer::RunoutUsesUpTolerance`], [`NoAnswer::ToleranceLimitsNoFeed`],
    /// and those of the step-over in [`Analytic::scallop_height`].
    pub fn max_feed_per_tooth(&self, tolerance: Length, step_over: Length) -> Result<Length, NoAnswer> {
        self.max_feed_per_tooth_above(self.step_over_height(step_over)?, tolerance)
    }

    /// The largest feed per tooth beside a step-over that alone leaves `step_over_height`.
    pub(super) fn max_feed_per_tooth_above(&self, step_over_height: Length, tolerance: Length) -> Result<Length, NoAnswer> {
        if step_over_height >= tolerance {
            // The height at this step-over reaches the tolerance, so there is a step-over that leaves exactly the
            // tolerance.
            let max_step_over = self.step_over_of(tolerance)?;
            return Err(NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over });
        }
        if self.along.0 == 0.0 {
            return Err(NoAnswer::SharpEdge);
        }
        match self.along.chord(tolerance.mm() - step_over_height.mm()) {
            Some(spacing) => self.feed_per_tooth(Length::computed(spacing)).ok_or(NoAnswer::RunoutUsesUpTolerance),
            None => match self.feed_per_tooth(Length::computed(2.0 * self.along.0)) {
                Some(largest_feed_per_tooth) => Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth }),
                None => Err(NoAnswer::MarksDoNotOverlap { largest_mark_spacing: Length::computed(2.0 * self.along.0) }),
            },
        }
    }

    /// The largest step-over along the surface that keeps `tolerance` on h1 + h2 at a feed per tooth.
    ///
    /// # Errors
    /// [`NoAnswer::FeedUsesUpTolerance`], [`NoAnswer::MarksDoNotOverlap`], [`NoAnswer::ToleranceLimitsNoStepOver`].
    pub fn max_step_over(&self, tolerance: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        let feed_height = self.feed_height(feed_per_tooth)?;
        if feed_height >= tolerance {
            return Err(NoAnswer::FeedUsesUpTolerance { feed_height });
        }
        self.step_over_of(Length::computed(tolerance.mm() - feed_height.mm()))
    }

    /// h1 on the curved surface, [`groove_height`].
    pub(super) fn step_over_height(&self, step_over: Length) -> Result<Length, NoAnswer> {
        let largest_step_over = self.largest_step_over();
        let height = groove_height(self.across.0.recip(), self.pass.surface.across_per_mm(), step_over.mm());
        let height = height.filter(|_| step_over <= largest_step_over);
        height.map(Length::computed).ok_or(NoAnswer::PassesDoNotOverlap { largest_step_over })
    }

    /// The step-over that leaves the height h1, in closed form.
    ///
    /// The law of cosines [Segonds 2017, eq. 9] gives 1 - cos(beta) = c^2 w with w = h (2 - h k) / (2 (k + c) (1 + h
    /// c)), hence s = 2 rho sin(beta) = 2 sqrt(w (2 - c^2 w)); on a plane that is the chord 2 sqrt(2 R_eff h - h^2).
    fn step_over_of(&self, height: Length) -> Result<Length, NoAnswer> {
        let largest_step_over = self.largest_step_over();
        if height > self.step_over_height(largest_step_over)? {
            return Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over });
        }
        let (k, c, h) = (self.across.0.recip(), self.pass.surface.across_per_mm(), height.mm());
        let w = h * (2.0 - h * k) / (2.0 * (k + c) * (1.0 + h * c));
        Ok(Length::computed(2.0 * (w * (2.0 - c * c * w)).sqrt()))
    }

    /// The largest step-over at which the grooves meet and the passes, seen from above, are at most 2 (R + rr) apart.
    fn largest_step_over(&self) -> Length {
        let width = 2.0 * self.pass.cutter.widened(self.pass.runout.radial()).outer_radius().mm() / self.pass.contact.spacing_ratio();
        largest_groove_distance(self.across.0.recip(), self.pass.surface.across_per_mm(), width)
    }

    /// The climb of the feed as printed [Segonds 2017, eq. 16], S cos(alpha); the exact value is atan(tan(S) cos(alpha)).
    /// A zigzag cuts in both directions, so the absolute value is used.
    fn climb(&self) -> Angle {
        Angle::from_radians(self.pass.contact.slope().radians() * self.pass.contact.alpha().cos().abs())
    }

    /// The distance of the marks of a feed per tooth.
    fn mark_spacing(&self, feed_per_tooth: Length) -> Length {
        let runout = self.pass.runout;
        if runout == Runout::NONE { feed_per_tooth } else { runout.mark_spacing(feed_per_tooth, self.climb()) }
    }

    /// The feed per tooth of marks at a distance; `None` if runout alone sets them further apart.
    fn feed_per_tooth(&self, mark_spacing: Length) -> Option<Length> {
        let runout = self.pass.runout;
        if runout == Runout::NONE { Some(mark_spacing) } else { runout.feed_per_tooth(mark_spacing, self.climb()) }
    }

    /// h2, or with runout its upper bound [Segonds 2017, eq. 14 and 18].
    fn feed_height(&self, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        let Some(feed_per_tooth) = feed_per_tooth else {
            return Ok(Length::ZERO);
        };
        if self.along.0 == 0.0 {
            return Err(NoAnswer::SharpEdge);
        }
        let spacing = self.mark_spacing(feed_per_tooth);
        let height = self.along.height(spacing.mm());
        height.map(Length::computed).ok_or(NoAnswer::MarksDoNotOverlap { largest_mark_spacing: Length::computed(2.0 * self.along.0) })
    }
}

/// h1 [Segonds 2017, eq. 12 with its signs corrected] of grooves with the curvature k = 1/R_eff on a surface with the
/// curvature c = 1/rho, at the step-over s. `None` if the grooves do not meet.
///
/// Printed as A - Dq with A = R_eff cos(beta) - rho (1 - cos(beta)), Dq = sqrt(R_eff^2 - (1 + R_eff/rho)^2 s^2/4) and
/// sin(beta) = s / 2 rho. With a = A/R_eff and d = Dq/R_eff it equals s^2 (k + c) / (2 (1 + cos(beta)) (a + d)), which
/// has no cancellation and no special cases: k = 0 is a flat, c = 0 a plane.
fn groove_height(k: f64, c: f64, s: f64) -> Option<f64> {
    let sin_beta = c * s / 2.0;
    let offset = (k + c) * s / 2.0;
    if sin_beta.abs() > 1.0 || offset > 1.0 {
        return None;
    }
    let cos_beta = ((1.0 - sin_beta) * (1.0 + sin_beta)).sqrt();
    // The factors are paired so that none exceeds 4: on a nearly flat floor, the square of a step-over can overflow.
    let a = cos_beta - (s * k) * (s * c) / (4.0 * (1.0 + cos_beta));
    let d = ((1.0 - offset) * (1.0 + offset)).sqrt();
    Some(s * offset / ((1.0 + cos_beta) * (a + d)))
}

/// The step-over at which such grooves just meet: 2 R_eff on a plane, 2 / (1/R_eff + 1/rho) on a curved surface, but at
/// most the surface's width 2 |rho| and at most `width`. It is reduced by a rounding error, so that it is in the domain
/// of [`groove_height`].
fn largest_groove_distance(k: f64, c: f64, width: f64) -> Length {
    Length::computed((2.0 / (k + c)).min(2.0 / c.abs()).min(width) * (1.0 - 2.0 * f64::EPSILON))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::SurfaceCurvature;

    #[test]
    fn a_sharp_edge_has_no_circle_on_any_surface() {
        let length = |mm: f64| Length::from_mm(mm).unwrap();
        for surface in
            [SurfaceCurvature::PLANE, SurfaceCurvature::from_radius_mm(120.0).unwrap(), SurfaceCurvature::from_radius_mm(-120.0).unwrap()]
        {
            let pass = |alpha| Pass {
                cutter: Cutter::flat_end(length(6.0)),
                contact: Contact::from_degrees(45.0, alpha).unwrap(),
                surface,
                runout: Runout::NONE,
                teeth: None,
            };
            assert_eq!(Analytic::new(pass(90.0)).err(), Some(NoAnswer::SharpEdge));
            let down_hill = Analytic::new(pass(0.0)).unwrap();
            assert_eq!(down_hill.scallop_height(length(0.3), Some(length(0.1))), Err(NoAnswer::SharpEdge));
            assert_eq!(down_hill.max_feed_per_tooth(length(0.01), length(0.3)), Err(NoAnswer::SharpEdge));
            assert!(down_hill.scallop_height(length(0.3), None).is_ok());
        }
    }
}
