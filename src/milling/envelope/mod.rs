//! Model `envelope`: the height that the cutter's whole lower body leaves, with no circle in its place.
//!
//! The analytic radii are curvatures at one point. Near the horizontal the groove is far narrower than its curvature says, at oblique feed
//! neighbouring tooth marks meet along the feed and not in its normal plane, and on steep walls the cutter's side takes over from its
//! corner. Here the height is that of the highest place that some phase between the teeth of neighbouring passes can leave uncut:
//! a bound, and reached.
//!
//! What is assumed: a tooth prints the whole body at its place, that is, the feed per revolution is small against the cutter's
//! circumference; the cutter's side is as long as the wall that it passes; passes are parallel and the surface is a plane, but for a
//! correction that is the analytic model's. This file has the model's answers, `ridge` the search for the height on a plane, `newton` its
//! quick way, which the inverses take as well, `body` the cutter's solid and `root` the searches for roots.

mod body;
mod newton;
mod ridge;
mod root;

use super::gouging;
use super::{Contact, Cutter, CutterKind, NoAnswer, Pass, ScallopHeight};
use crate::quantity::{Angle, Length};
use body::Body;
use newton::{Lengths, Sought};
use ridge::Ridge;
use root::bracketed_root;

/// The envelope model at one contact. It has an answer at every slope from 0 to 90 deg, for every cutter.
///
/// **Heights.** h is the lowest height at which the cutter's section parallel to the surface holds two chords along the feed, both as long
/// as the tooth marks are apart and lying the step-over s apart. h1 is the same with chords of no length, and the feed's share is
/// h - h1. Both grow with s and with the feed.
///
/// **Where passes overlap.** Seen from above a pass clears a strip 2R wide, and the teeth print circles of radius R. With d the
/// passes' distance and f the marks' distance seen from above, something stays uncut from top to bottom unless d^2 + f^2 <= 4 R^2;
/// that is an error. On a wall along which the feed runs d is 0 whatever s.
///
/// **Curved surfaces.** What the analytic model says that the curvature changes, h1 on the curved surface less h1 on the plane, is
/// added to both heights. This part is not exact.
///
/// **Runout.** The outer radius is R + rr, and the tooth marks are as far apart as [`super::Runout::mark_spacing`] says, with the exact
/// climb of the feed.
#[derive(Debug, Clone, Copy)]
pub struct Envelope {
    pass: Pass,
    cutter: Cutter,
    body: Body,
    climb: Angle,
    relative_curvature: f64,
    /// The curvature of the groove against the surface, for first guesses.
    groove_curvature: f64,
}

impl Envelope {
    /// Places the cutter on the surface.
    ///
    /// # Errors
    /// [`NoAnswer::Gouges`] on a concave surface into which the cutter does not fit.
    pub fn new(pass: Pass) -> Result<Self, NoAnswer> {
        let relative_curvature = gouging::relative_curvature(&pass)?;
        let cutter = pass.cutter.widened(pass.runout.radial());
        let body = Body::new(cutter, pass.contact, pass.surface);
        Ok(Self {
            pass,
            cutter,
            body,
            climb: pass.contact.climb(),
            relative_curvature,
            groove_curvature: body.relative_radii().across.recip(),
        })
    }

    /// lambda, the smallest relative curvature of cutter and surface as a share of the cutter's own.
    pub(super) fn relative_curvature(&self) -> f64 {
        self.relative_curvature
    }

    /// h1 and the feed's share h - h1, for a step-over along the surface and a feed per tooth; `None` leaves no marks.
    ///
    /// # Errors
    /// - [`NoAnswer::PassesDoNotOverlap`], [`NoAnswer::MarksDoNotOverlap`];
    /// - [`NoAnswer::Gouges`] or [`NoAnswer::FlatGouges`] where a hollow sinks more between two passes than the cutter leaves there.
    pub fn scallop_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<ScallopHeight, NoAnswer> {
        let step_over_height = self.height(step_over.mm(), 0.0)?;
        let Some(feed_per_tooth) = feed_per_tooth else {
            return Ok(ScallopHeight { step_over: Length::computed(step_over_height), feed: Length::ZERO });
        };
        let spacing = self.pass.runout.mark_spacing(feed_per_tooth, self.climb);
        // h is never under h1; where marks leave next to nothing, rounding may put it there.
        let feed = (self.height(step_over.mm(), spacing.mm())? - step_over_height).max(0.0);
        Ok(ScallopHeight { step_over: Length::computed(step_over_height), feed: Length::computed(feed) })
    }

    /// The largest feed per tooth that keeps the tolerance `tolerance` on h.
    ///
    /// # Errors
    /// [`NoAnswer::StepOverUsesUpTolerance`], [`NoAnswer::RunoutUsesUpTolerance`], [`NoAnswer::ToleranceLimitsNoFeed`], and those of the
    /// step-over in [`Envelope::scallop_height`].
    pub fn max_feed_per_tooth(&self, tolerance: Length, step_over: Length) -> Result<Length, NoAnswer> {
        let step_over_height = Length::computed(self.height(step_over.mm(), 0.0)?);
        let used_up = |within: f64| {
            let max_step_over = self.max_step_over_within(tolerance, 0.0, within)?;
            Err(NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over })
        };
        if step_over_height >= tolerance {
            return used_up(step_over.mm());
        }
        let room = tolerance.mm() - step_over_height.mm();
        let largest_spacing = self.largest_mark_spacing(step_over.mm());
        let guess = (8.0 * room * self.cutter.outer_radius().mm()).sqrt();
        let ridge = Lengths { level: tolerance.mm(), step_over: step_over.mm(), mark_spacing: guess.min(largest_spacing) };
        let spacing = match self.held_by_section(ridge, Sought::MarkSpacing) {
            Some(found) if (Length::SMALLEST..=largest_spacing).contains(&found.mark_spacing) => Reached::At(found.mark_spacing),
            _ => largest_within(tolerance.mm(), guess, Length::SMALLEST, largest_spacing, |spacing| self.height(step_over.mm(), spacing))?,
        };
        let (runout, climb) = (self.pass.runout, self.climb);
        match spacing {
            // Room for less than any feed that can be stated.
            Reached::BeforeSmallest { .. } => used_up(self.largest_step_over(0.0)),
            Reached::At(spacing) => runout.feed_per_tooth(Length::computed(spacing), climb).ok_or(NoAnswer::RunoutUsesUpTolerance),
            Reached::Nowhere => match runout.feed_per_tooth(Length::computed(largest_spacing), climb) {
                Some(largest_feed_per_tooth) => Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth }),
                None => Err(NoAnswer::MarksDoNotOverlap { largest_mark_spacing: Length::computed(largest_spacing) }),
            },
        }
    }

    /// The largest step-over along the surface that keeps `tolerance` on h at a feed per tooth.
    ///
    /// # Errors
    /// - [`NoAnswer::FeedUsesUpTolerance`] where even passes [`Length::SMALLEST`] apart leave the tolerance;
    /// - [`NoAnswer::MarksDoNotOverlap`];
    /// - [`NoAnswer::ToleranceLimitsNoStepOver`] where no step-over up to the largest one leaves the tolerance;
    /// - [`NoAnswer::Gouges`] or [`NoAnswer::FlatGouges`] where the cutter cuts into a hollow before the step-over leaves the tolerance.
    pub fn max_step_over(&self, tolerance: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        let spacing = feed_per_tooth.map_or(0.0, |feed| self.pass.runout.mark_spacing(feed, self.climb).mm());
        self.max_step_over_within(tolerance, spacing, self.largest_step_over(spacing))
    }

    /// The same for marks `spacing` apart, among the step-overs up to `largest_step_over`.
    fn max_step_over_within(&self, tolerance: Length, spacing: f64, largest_step_over: f64) -> Result<Length, NoAnswer> {
        let height = |step_over: f64| self.height(step_over, spacing);
        // From above: the circle of the groove's radius, or near the floor what the cutter's flat and corner leave there.
        let (core, corner) = (self.cutter.core_radius().mm(), self.cutter.corner_radius().mm());
        let on_floor = 2.0 * (core + (2.0 * corner * tolerance.mm()).sqrt());
        let guess = (8.0 * tolerance.mm() / self.groove_curvature).sqrt().min(on_floor);
        let ridge = Lengths { level: tolerance.mm(), step_over: guess.min(largest_step_over), mark_spacing: spacing };
        if let Some(found) = self.held_by_section(ridge, Sought::StepOver)
            && (Length::SMALLEST..=largest_step_over).contains(&found.step_over)
        {
            return Ok(Length::computed(found.step_over));
        }
        match largest_within(tolerance.mm(), guess, Length::SMALLEST, largest_step_over, height)? {
            Reached::At(step_over) => Ok(Length::computed(step_over)),
            Reached::Nowhere => Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: Length::computed(largest_step_over) }),
            Reached::BeforeSmallest { height } => Err(NoAnswer::FeedUsesUpTolerance { feed_height: Length::computed(height) }),
        }
    }

    /// The largest step-over or distance of marks that the cutter's section at a height holds, near the one in `ridge`; `None` where that is
    /// not certain, and where heights have a closed form, which makes a search over them as quick.
    fn held_by_section(&self, ridge: Lengths, sought: Sought) -> Option<Lengths> {
        let (slope, sharp) = (self.contact().slope(), self.cutter.kind() == CutterKind::FlatEnd);
        let searched = slope.sin() != 0.0 && slope.cos() != 0.0 && !(sharp && ridge.mark_spacing == 0.0);
        if searched { newton::solve(&self.body, sought, ridge) } else { None }
    }

    /// h for passes s apart whose tooth marks lie f apart, both in the tangent plane.
    fn height(&self, s: f64, f: f64) -> Result<f64, NoAnswer> {
        let (across, along) = (s * self.spacing_ratio(), f * self.climb.cos());
        let (outer, core, corner) = (self.cutter.outer_radius().mm(), self.cutter.core_radius().mm(), self.cutter.corner_radius().mm());
        if across > 2.0 * outer {
            return Err(NoAnswer::PassesDoNotOverlap { largest_step_over: Length::computed(self.largest_step_over(0.0)) });
        }
        if across.hypot(along) > 2.0 * outer {
            return Err(NoAnswer::MarksDoNotOverlap { largest_mark_spacing: Length::computed(self.largest_mark_spacing(s)) });
        }
        if !self.pass.surface.is_plane() {
            return Ok(Ridge::new(&self.body, s, f).level(self.guess(s, f), self.highest(s, f)));
        }
        let slope = self.contact().slope();
        if slope.cos() == 0.0 {
            // Only the cylinder touches a wall.
            return Ok(circle_height(outer, across.hypot(along)));
        }
        if slope.sin() == 0.0 {
            // The corners of the rectangle between two teeth of two passes lie on the flat or on the corner's round.
            let beyond_flat = s.hypot(f) - 2.0 * core;
            return Ok(if beyond_flat > 0.0 { circle_height(corner, beyond_flat) } else { 0.0 });
        }
        if self.cutter.kind() == CutterKind::BallEnd && self.ball_alone(s, f) {
            return Ok(circle_height(outer, s.hypot(f)));
        }
        if self.cutter.kind() == CutterKind::FlatEnd && f == 0.0 {
            return Ok(self.edge_height(s));
        }
        Ok(Ridge::new(&self.body, s, f).level(self.guess(s, f), self.highest(s, f)))
    }

    fn contact(&self) -> Contact {
        self.pass.contact
    }

    /// d/s, how near the passes come seen from above: cos(S) / cos(climb), by which a square with a side along the feed shrinks, less
    /// its shrinking along the feed. On a wall 1 for the vertical feed and 0 for any other, whatever alpha, which only theta tells
    /// apart there.
    fn spacing_ratio(&self) -> f64 {
        if self.climb.cos() == 0.0 { 1.0 } else { self.contact().slope().cos().abs() / self.climb.cos() }
    }

    /// Whether a ball-end cutter touches the ridge with its ball and not with its side.
    ///
    /// On the sphere the lowest rectangle is centred over the contact, R - h below the centre; its highest corner is
    /// (s |sin(theta)| + f |cos(theta)|) / 2 up the slope and has to be below the centre.
    fn ball_alone(&self, s: f64, f: f64) -> bool {
        let (slope, theta, radius) = (self.contact().slope(), self.contact().theta(), self.cutter.outer_radius().mm());
        let half_diagonal = s.hypot(f) / 2.0;
        let up = f64::midpoint(s * theta.sin().abs(), f * theta.cos().abs());
        half_diagonal <= radius && ((radius - half_diagonal) * (radius + half_diagonal)).sqrt() * slope.cos() >= up * slope.sin()
    }

    /// h1 of a flat-end cutter between floor and wall.
    ///
    /// The outline seen along the feed is half of the edge's circle, the half within 90 deg of the feed's line seen from above, and the
    /// side over both its ends. Where the circle is at the angle delta from the contact it is R sin(S) (1 - cos(delta)) high. Ridges
    /// between two edges are the ends of a chord along the level line, of which the outline shows the part cos(theta):
    ///
    /// h1 = R sin(S) (1 - cos(delta)), sin(delta) = s / (2 R cos(theta)), while delta <= 90 deg - alpha, where the side begins.
    ///
    /// Ridges between edge and side lie on the circle at s cos(S) / cos(climb) from the side, seen from above: at the angle epsilon from
    /// where it begins, with R (1 - cos(epsilon)) that distance, and at delta = epsilon - (90 deg - alpha) from the contact.
    fn edge_height(&self, s: f64) -> f64 {
        let (outer, sin) = (self.cutter.outer_radius().mm(), self.contact().slope().sin());
        let (along_steepest, alpha) = (self.contact().theta().cos().abs(), self.contact().alpha());
        if s <= 2.0 * outer * along_steepest * alpha.cos().abs() {
            return circle_height(outer * along_steepest, s) * sin / along_steepest;
        }
        let epsilon = 2.0 * (s * self.spacing_ratio() / (2.0 * outer)).min(1.0).sqrt().asin();
        let delta = epsilon - alpha.cos().abs().atan2(alpha.sin().abs());
        2.0 * outer * sin * (delta / 2.0).sin().powi(2)
    }

    /// About h, for a search to start from: the parabola of the groove, and along the feed that of radius R. For the groove that is less than h near
    /// the floor, from where Newton's steps rise steadily; from far above they overshoot.
    fn guess(&self, s: f64, f: f64) -> f64 {
        let outer = self.cutter.outer_radius().mm();
        s * s / 8.0 * self.groove_curvature.min(2.0 / s) + f * f / (8.0 * outer)
    }

    /// A height that h cannot exceed on slopes under 90 deg: that of a rectangle between the teeth, seen from above and centred on the
    /// axis, which is as high as it must be to lie in the cylinder above the corner.
    ///
    /// Its corners have the radius sqrt(d^2 + f^2)/2 <= R seen from above. The centre of the disc in which the cylinder begins lies a
    /// sin(S) + r cos^2(S) + r sin^2(S) over the surface. With gamma the climb, one side of the rectangle rises by f sin(gamma) and
    /// the other, whose length d = s cos(S) / cos(gamma) runs at sin(theta) / cos(gamma) to the steepest line seen from above, by d
    /// tan(S) sin(theta) / cos(gamma). The centre must be half of both above the disc, of which the part cos(S) counts.
    fn highest(&self, s: f64, f: f64) -> f64 {
        let (slope, theta, climb) = (self.contact().slope(), self.contact().theta(), self.climb);
        let rise = f64::midpoint(f * climb.sin(), s * slope.sin() * theta.sin().abs() / (climb.cos() * climb.cos()).max(f64::EPSILON));
        let on_plane = self.cutter.core_radius().mm() * slope.sin() + self.cutter.corner_radius().mm() + rise * slope.cos();
        let [curvature, _] = self.pass.surface.principal_per_mm();
        on_plane + curvature.max(0.0) / 2.0 * (self.body.reach() + s + f).powi(2)
    }

    /// The step-over up to which passes with marks f apart overlap, seen from above, and grooves meet on a curved surface. A rounding
    /// less, so that it is in the domain itself; never more than can be stated.
    fn largest_step_over(&self, f: f64) -> f64 {
        let on_plane = largest_leg(2.0 * self.cutter.outer_radius().mm(), f * self.climb.cos(), self.spacing_ratio());
        on_plane.min(2.0 / self.pass.surface.across_per_mm().abs())
    }

    /// The distance of marks up to which they overlap, seen from above, in passes s apart.
    fn largest_mark_spacing(&self, s: f64) -> f64 {
        largest_leg(2.0 * self.cutter.outer_radius().mm(), s * self.spacing_ratio(), self.climb.cos())
    }
}

/// P - sqrt(P^2 - c^2/4), what circles of radius P leave at the distance c <= 2P, without cancellation.
fn circle_height(radius: f64, chord: f64) -> f64 {
    // A rounding may put c over 2P where the caller's own comparison did not.
    let ratio = (chord / (2.0 * radius)).min(1.0);
    chord / 2.0 * ratio / (1.0 + ((1.0 - ratio) * (1.0 + ratio)).sqrt())
}

/// The length whose part `ratio` and the leg `leg` have the hypotenuse `hypotenuse`, a rounding less; at most what can be stated.
fn largest_leg(hypotenuse: f64, leg: f64, ratio: f64) -> f64 {
    let room = ((hypotenuse - leg) * (hypotenuse + leg)).max(0.0).sqrt();
    (room / ratio * (1.0 - 4.0 * f64::EPSILON)).min(Length::LARGEST)
}

/// Where a height that grows reaches a target.
enum Reached {
    At(f64),
    /// It stays under the target.
    Nowhere,
    /// It is not under the target even at the smallest place, but `height`.
    BeforeSmallest {
        height: f64,
    },
}

/// Where in `[smallest, largest]` a height that grows reaches `target`. The search starts at `guess`.
///
/// The root is sought over the logarithm, in (h - target) / (h + target), where a power law is nearly a straight line.
fn largest_within(
    target: f64,
    guess: f64,
    smallest: f64,
    largest: f64,
    height: impl Fn(f64) -> Result<f64, NoAnswer>,
) -> Result<Reached, NoAnswer> {
    // That even the smallest place is over the target is the commonest reason for an error, and known at once.
    if let Ok(height) = height(smallest)
        && height >= target
    {
        return Ok(Reached::BeforeSmallest { height });
    }
    let excess = |height: f64| (height - target) / (height + target);
    let mut at = guess.max(smallest).min(largest);
    let (mut low, mut high) = (None::<(f64, f64)>, None::<(f64, f64)>);
    // From the guess up by factors of 2, down by factors that square, so that a target out of reach is known after a few steps.
    let mut shrink = 2.0;
    let (low, high) = loop {
        match height(at) {
            Ok(height) if height < target => low = Some((at, excess(height))),
            Ok(height) if at <= smallest => return Ok(Reached::BeforeSmallest { height }),
            Ok(height) => high = Some((at, excess(height))),
            // Nothing to be had so far out; coming back here from below, nothing was reached before.
            Err(no_answer) if low.is_some() || at <= smallest => return Err(no_answer),
            Err(_) => {}
        }
        match (low, high) {
            (Some(low), Some(high)) => break (low, high),
            (Some(_), None) if at >= largest => return Ok(Reached::Nowhere),
            (Some(_), None) => at = (2.0 * at).min(largest),
            (None, _) => {
                at = (at / shrink).max(smallest);
                shrink *= shrink;
            }
        }
    };
    // Between two places with a height, a place without one is in a hollow that the cutter gouges: it has no height left.
    let over_logarithm = |u: f64| height(u.exp()).map_or(-1.0, excess);
    Ok(Reached::At(bracketed_root((low.0.ln(), low.1), (high.0.ln(), high.1), over_logarithm).exp()))
}

#[cfg(test)]
mod tests;
