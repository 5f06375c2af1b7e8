//! Model `envelope`: the height that the cutter's exact lower body leaves.
//!
//! The analytic radii are radii of curvature at one point. They fail in three cases: on gentle slopes the groove is far
//! narrower than the circle of its curvature; with an oblique feed, neighbouring tooth marks meet along the feed and
//! not in its normal plane; and on steep walls the cutter's side cuts beside its corner. Here the height is that of the
//! highest point that any phase between the teeth of neighbouring passes can leave uncut: a bound that is reached.
//!
//! Assumptions: a tooth cuts the shape of the whole body, so the feed per revolution is small compared with the
//! cutter's circumference; the cutter's side is as long as the wall that it passes; passes are parallel; the surface is
//! of the second order, so that changes of its curvature are left out.
//!
//! - `mod` (this file): the height to second order, by the fastest search that has it; `inverses`: largest step-over and
//!   feed to second order; `length_search`: lengths by their heights
//! - `closed_form`: plane floors and walls, ball-end cutters, sharp edges on planes
//! - `newton`: the fast search on all unknowns at once, with a proof of the result; `proved`: the same, with `local` where
//!   it does not converge; `clearing` and `runout`: with runout; `sharp_edge`: sharp edges on curved surfaces
//! - `nested` and `section`: the general searches; `chord`: the search along the feed, which the other searches use
//! - `concave`, `outline` and `local`: surfaces on which the section need not be convex
//! - `body`: the cutter's solid over the surface
//! - `turning_marks`: marks that have normals of their own on a curved surface; `turned_ridge`: the ridge between them;
//!   `nearby`: the fast search for it where turns are small; `third_order`: the answers corrected by it

mod body;
mod chord;
mod clearing;
mod closed_form;
mod concave;
mod inverses;
mod length_search;
mod local;
mod nearby;
mod nested;
mod newton;
mod outline;
mod proved;
mod runout;
mod section;
mod sharp_edge;
mod smooth_bound;
mod third_order;
mod turned_pair;
mod turned_ridge;
mod turning_marks;

use super::gouging;
use super::{Contact, Cutter, CutterKind, NoAnswer, Pass};
use crate::quantity::{Direction, Length};
use body::Body;
use clearing::Clearing;
use newton::{Lengths, Ridge, Sought};
use section::{Pattern, Section};

/// The share by which the largest length that is reported may be smaller than the largest that has a height on a curved
/// surface.
const MET: f64 = 0.01;

/// The envelope model at one contact. It covers every slope from 0 to 90 deg and every cutter.
///
/// **Heights.** h is the lowest height at which the cutter's section parallel to the surface contains two chords along
/// the feed, each as long as the distance of the tooth marks, and the step-over s apart. h1 is the same with chords of
/// length 0, and the feed's part is h - h1. Both grow with s and with the feed.
///
/// **Overlap.** Seen from above, a pass clears a strip 2R wide, and the marks of the teeth are circles of radius R.
/// With d the passes' distance and f the marks' distance seen from above, material stays uncut from top to bottom
/// unless d^2 + f^2 <= 4 R^2; that is an error. For a feed along a wall, d is 0 for every s.
///
/// **Curved surfaces.** Heights are measured from the surface 1/2 u'Ku below the tangent plane. The relative curvature
/// of cutter and surface is then exact. To second order all marks have the normal of the stated contact; the answers
/// place each mark by its own.
///
/// **Runout.** Heights are measured from the surface that the deepest tooth touches, whose radius is R + |rr|. The
/// shallowest tooth reaches delta = |rr| sin(S) + |ar| cos(S) less deep, and its mark is displaced along the slope, by up to
/// |rr| cos(S) downwards and |ar| sin(S) upwards. A pass clears the offsets that a deep and a shallow mark clear in the worse
/// order, and those that deep marks alone, z f_z apart, clear. A deep and a shallow mark are one feed per tooth and the
/// displacement along the feed apart.
#[derive(Debug, Clone, Copy)]
pub struct Envelope {
    pass: Pass,
    cutter: Cutter,
    body: Body,
    climb: Direction,
    /// delta, how much less deep the shallowest tooth reaches than the deepest.
    drop: f64,
    /// By how much runout lengthens the distance of neighbouring marks along the feed.
    displacement: f64,
    relative_curvature: f64,
    /// The curvature of the groove relative to the surface, for first guesses.
    groove_curvature: f64,
    /// Whether the turning of the surface's normal changes the marks.
    has_third_order: bool,
}

impl Envelope {
    /// Prepares the cutter in contact with the surface.
    ///
    /// # Errors
    /// [`NoAnswer::Gouges`] on a concave surface into which the cutter does not fit.
    pub fn new(pass: Pass) -> Result<Self, NoAnswer> {
        Self::fitting(pass).ok_or_else(|| gouging::reason(&pass))
    }

    /// The same; `None` if the cutter does not fit.
    pub(in crate::milling) fn fitting(pass: Pass) -> Option<Self> {
        let relative_curvature = gouging::relative_curvature(&pass)?;
        let cutter = pass.cutter.widened(pass.runout.radial());
        let body = Body::new(cutter, pass.contact, pass.surface);
        let drop = pass.runout.depth(pass.contact.slope());
        let displacement = pass.runout.displacement(pass.contact, pass.has_shallow_pairs());
        let groove_curvature = body.relative_radii().across.recip();
        if groove_curvature.is_nan() || groove_curvature <= 0.0 {
            // The relative curvature is a rounding error, and the cutter's radius that of the surface.
            return None;
        }
        let has_third_order = third_order::has_third_order(&pass, &body);
        Some(Self {
            pass,
            cutter,
            body,
            climb: pass.contact.climb(),
            drop,
            displacement,
            relative_curvature,
            groove_curvature,
            has_third_order,
        })
    }

    pub(super) fn pass(&self) -> &Pass {
        &self.pass
    }

    /// lambda, the smallest relative curvature of cutter and surface as a share of the cutter's own.
    pub(super) fn relative_curvature(&self) -> f64 {
        self.relative_curvature
    }

    /// Whether the section at the height p is known to be convex.
    fn is_convex_up_to(&self, p: f64) -> bool {
        !self.body.is_concave() || self.body.is_convex_up_to(p)
    }

    /// The number of teeth.
    fn teeth(&self) -> f64 {
        self.pass.teeth.map_or(2.0, |teeth| f64::from(teeth.get()))
    }

    /// The largest distance of neighbouring marks at a feed per tooth; at most that of the deepest tooth's own marks.
    fn mark_spacing(&self, feed_per_tooth: f64) -> f64 {
        (feed_per_tooth + self.displacement).min(self.teeth() * feed_per_tooth).max(feed_per_tooth)
    }

    /// The feed per tooth of a distance of neighbouring marks, the inverse of [`Envelope::mark_spacing`].
    fn feed_per_tooth(&self, mark_spacing: f64) -> f64 {
        (mark_spacing - self.displacement).max(mark_spacing / self.teeth())
    }

    /// The marks at a distance of neighbouring ones.
    fn pattern(&self, spacing: f64) -> Pattern {
        let deep_spacing = self.teeth() * self.feed_per_tooth(spacing);
        Pattern { spacing, deep_spacing, drop: self.drop, shallow_pairs: self.pass.has_shallow_pairs() }
    }

    /// The marks of a feed per tooth; none without a feed.
    fn pattern_of(&self, feed_per_tooth: Option<Length>) -> Pattern {
        feed_per_tooth.map_or(Pattern::even(0.0), |feed| self.pattern(self.mark_spacing(feed.mm())))
    }

    /// The ridge by the fast search; `None` if its result is not proved, or cannot be because of a sharp edge or a
    /// wall.
    fn quickly(&self, lengths: Lengths, sought: Sought) -> Option<Ridge> {
        if self.is_quick(lengths.mark_spacing) { proved::solve(&self.body, sought, lengths, [Clearing::EVEN; 2]) } else { None }
    }

    /// Whether a sharp edge without marks cuts a concave surface, in which case `sharp_edge` finds the ridge.
    fn is_sharp_on_concave(&self, mark_spacing: f64) -> bool {
        mark_spacing == 0.0 && self.cutter.kind() == CutterKind::FlatEnd && self.body.is_concave()
    }

    /// Whether the fast search can converge. It cannot on plane floors and walls, where the section's edges are
    /// straight along the feed, nor for a sharp edge without marks.
    fn is_quick(&self, mark_spacing: f64) -> bool {
        let (slope, sharp) = (self.contact().slope(), self.cutter.kind() == CutterKind::FlatEnd);
        let is_straight = self.pass.surface.is_plane() && (slope.sin() == 0.0 || slope.cos() == 0.0);
        !(is_straight || sharp && mark_spacing == 0.0)
    }

    /// h for passes s apart with a pattern of marks, both in the tangent plane; `None` if there is none, for the reason in
    /// [`Envelope::no_height`].
    fn height(&self, s: f64, pattern: Pattern) -> Option<f64> {
        if self.is_in_reach(s, pattern.spacing) { self.level(s, pattern) } else { None }
    }

    /// Whether passes s apart with marks f apart overlap seen from above, at a step-over at which grooves can meet.
    fn is_in_reach(&self, s: f64, f: f64) -> bool {
        s <= self.largest_step_over(0.0) && self.overlap(s, f)
    }

    /// Whether passes s apart with marks f apart overlap, seen from above. The largest step-over and feed lie on the
    /// limit, up to a few rounding errors.
    fn overlap(&self, s: f64, f: f64) -> bool {
        let (across, along) = (s * self.spacing_ratio(), f * self.climb.cos());
        let diameter = 2.0 * self.cutter.outer_radius().mm() * (1.0 + 16.0 * f64::EPSILON);
        across * across + along * along <= diameter * diameter
    }

    /// h for passes and marks that overlap seen from above; `None` if no height clears s, which can happen on a curved
    /// surface.
    fn level(&self, s: f64, pattern: Pattern) -> Option<f64> {
        let f = pattern.spacing;
        if !pattern.is_even() {
            let on_floor_or_wall = self.level_on_floor_or_wall(s, &pattern).map(QuickLevel::exact);
            return self.checked_level(s, pattern, on_floor_or_wall.or_else(|| self.quick_level_with_runout(s, &pattern)));
        }
        if self.pass.surface.is_plane()
            && let Some(closed) = self.closed_form(s, f)
        {
            return Some(closed);
        }
        let lengths = Lengths { level: self.guess(s, pattern), step_over: s, mark_spacing: f };
        let quick = if self.is_sharp_on_concave(f) {
            sharp_edge::level(&self.body, s).map(QuickLevel::exact)
        } else {
            self.quickly(lengths, Sought::Level).map(|ridge| QuickLevel::of(&ridge))
        };
        self.checked_level(s, pattern, quick)
    }

    /// The result of a fast search if the section is known to be convex; otherwise h by the search that also checks it.
    fn checked_level(&self, s: f64, pattern: Pattern, quick: Option<QuickLevel>) -> Option<f64> {
        match quick {
            Some(QuickLevel { level, .. }) if self.is_convex_up_to(level) => Some(level),
            quick => self.searched_level(s, pattern, quick),
        }
    }

    fn contact(&self) -> Contact {
        self.pass.contact
    }

    /// d/s, the ratio of the passes' distance seen from above to that along the surface: cos(S) / cos(climb). Seen from
    /// above, a unit square with a side along the feed has the area cos(S), and that side the length cos(climb). On a
    /// wall the ratio is 1 for the vertical feed and 0 for any other; only theta distinguishes feeds there.
    fn spacing_ratio(&self) -> f64 {
        if self.climb.cos() == 0.0 { 1.0 } else { self.contact().slope().cos().abs() / self.climb.cos() }
    }

    /// An approximation of h, from which a search starts: the parabola of the groove, and along the feed the parabola
    /// of radius R. Near the floor the groove's parabola is less than h. From below, Newton's steps rise monotonically;
    /// from far above they would overshoot.
    fn guess(&self, s: f64, pattern: Pattern) -> f64 {
        let outer = self.cutter.outer_radius().mm();
        let f = self.even_spacing(&pattern);
        // Above the whole cutter there is no section.
        let parabola = s * s / 8.0 * self.groove_curvature.min(2.0 / s) + f * f / (8.0 * outer);
        let guess = if self.pass.surface.is_plane() { parabola.min(self.guess_on_flat(s, f)) } else { parabola };
        guess.min(outer / 4.0)
    }

    /// An approximation of h near a plane floor. There the rectangle between four marks lies on the flat, whose height at
    /// the furthest corner counts, or beyond it on the corner's round.
    fn guess_on_flat(&self, s: f64, f: f64) -> f64 {
        let (slope, theta) = (self.contact().slope(), self.contact().theta());
        let steep = s * theta.sin().abs() + f * theta.cos().abs() + 0.1 * (s + f);
        let beyond_flat = (s.hypot(f) - 2.0 * self.cutter.core_radius().mm()).max(0.0);
        slope.sin() * steep + beyond_flat * beyond_flat / (8.0 * self.cutter.corner_radius().mm().max(f64::MIN_POSITIVE))
    }

    /// An approximation of the distance at which marks of equal depth leave the same height. Circles of radius P, f apart
    /// and with every second one raised by delta, meet as if they were f + 2 P delta / f apart.
    fn even_spacing(&self, pattern: &Pattern) -> f64 {
        if pattern.is_even() {
            return pattern.spacing;
        }
        pattern.deep_spacing.min(pattern.spacing + 2.0 * self.cutter.corner_radius().mm() * pattern.drop / pattern.spacing)
    }

    /// A height that clears passes s apart on a plane; infinity on other surfaces, and if passes and marks do not overlap
    /// seen from above, or if a deep mark meets a shallow one, which is displaced along the slope.
    ///
    /// The rectangle between four marks, centred under the cutter's axis and seen from above, lies in the circle of
    /// radius R. Its corners are in the body if they are not below the upper end of the corner's round, which is r
    /// cos(S) above the contact. At the height p, a corner a + r sin(S) + c from the contact along the steepest line is
    /// (p - sin(S) (a + r sin(S) + c)) / cos(S) above it. With the largest c this gives p = r + sin(S) (a + c). A
    /// shallow mark needs delta more.
    fn ceiling(&self, s: f64, pattern: &Pattern) -> f64 {
        let is_mixed = !pattern.is_even() && !pattern.shallow_pairs;
        if is_mixed || !self.pass.surface.is_plane() || !self.overlap(s, pattern.spacing) {
            return f64::INFINITY;
        }
        let (contact, core) = (self.contact(), self.cutter.core_radius().mm());
        let (across, along) = (s * self.spacing_ratio(), pattern.spacing * self.climb.cos());
        let furthest = f64::midpoint(across * contact.alpha().sin().abs(), along * contact.alpha().cos().abs());
        let drop = if pattern.is_even() { 0.0 } else { pattern.drop };
        self.cutter.corner_radius().mm() + contact.slope().sin() * (core + furthest) + drop
    }

    /// h by the general searches, or on a concave surface by the outline, which checks what the fast search found.
    fn searched_level(&self, s: f64, pattern: Pattern, quick: Option<QuickLevel>) -> Option<f64> {
        if self.body.is_concave() {
            return self.level_on_concave(s, pattern, quick);
        }
        // Most ridges of a sharp edge without marks lie between points of the edge.
        let is_sharp = pattern.spacing == 0.0 && self.cutter.kind() == CutterKind::FlatEnd;
        let guess = if is_sharp { sharp_edge::level(&self.body, s) } else { None }.unwrap_or_else(|| self.guess(s, pattern));
        let section = || Section::new(&self.body, pattern, 2.0 * s).level(s, guess, self.ceiling(s, &pattern));
        let level = self.nested_level(s, &pattern, guess).unwrap_or_else(section);
        Some(level).filter(|level| *level <= Length::LARGEST)
    }

    /// The reason why passes s apart with marks f apart have no height: they do not overlap seen from above, or on a curved
    /// surface the grooves or the marks do not meet.
    fn no_height(&self, s: f64, f: f64) -> NoAnswer {
        if f == 0.0 || self.height(s, Pattern::even(0.0)).is_none() {
            // With a feed at which no passes overlap, the feed is the next thing to change.
            let with_marks = Some(self.largest_met_step_over(f)).filter(|step_over| f > 0.0 && *step_over >= Length::SMALLEST);
            let largest_step_over = with_marks.unwrap_or_else(|| self.largest_met_step_over(0.0));
            return NoAnswer::PassesDoNotOverlap { largest_step_over: Length::computed(largest_step_over) };
        }
        NoAnswer::MarksDoNotOverlap { largest_mark_spacing: Length::computed(self.feed_per_tooth(self.largest_met_spacing(s))) }
    }

    /// The largest step-over at which passes with marks f apart meet; on a curved surface one that is smaller by at most
    /// [`MET`].
    fn largest_met_step_over(&self, f: f64) -> f64 {
        let overlapping = self.largest_step_over(f);
        if self.pass.surface.is_plane() {
            return overlapping;
        }
        let without_marks = Pattern::even(0.0);
        let pattern = if f == 0.0 { without_marks } else { self.pattern(f) };
        // An answer has both heights. That without marks can be missing alone, because it is searched in another way.
        largest_met(overlapping, |s| [pattern, without_marks].into_iter().all(|pattern| self.height(s, pattern).is_some()))
    }

    /// The same of the distances of marks that meet in passes s apart.
    fn largest_met_spacing(&self, s: f64) -> f64 {
        let overlapping = self.largest_spacing(s);
        if self.pass.surface.is_plane() {
            return overlapping;
        }
        largest_met(overlapping, |spacing| self.height(s, self.pattern(spacing)).is_some())
    }

    /// The step-over up to which passes with marks f apart overlap, seen from above, and grooves meet on a curved
    /// surface. It is reduced by a rounding error, so that it is itself in the domain, and is at most the largest
    /// accepted length.
    fn largest_step_over(&self, f: f64) -> f64 {
        let on_plane = largest_leg(2.0 * self.cutter.outer_radius().mm(), f * self.climb.cos(), self.spacing_ratio());
        on_plane.min(2.0 / self.pass.surface.across_per_mm().abs())
    }

    /// The distance up to which marks overlap, seen from above, in passes s apart.
    fn largest_spacing(&self, s: f64) -> f64 {
        largest_leg(2.0 * self.cutter.outer_radius().mm(), s * self.spacing_ratio(), self.climb.cos())
    }
}

/// The height that a fast search found.
#[derive(Debug, Clone, Copy)]
struct QuickLevel {
    level: f64,
    /// As in [`Ridge`].
    is_exact: bool,
}

impl QuickLevel {
    fn of(ridge: &Ridge) -> Self {
        Self { level: ridge.lengths.level, is_exact: ridge.is_exact }
    }

    fn exact(level: f64) -> Self {
        Self { level, is_exact: true }
    }
}

/// The largest length, at most `length`, that has a height, to [`MET`]: 0 if none has down to the smallest.
fn largest_met(length: f64, has_height: impl Fn(f64) -> bool) -> f64 {
    if has_height(length) {
        return length;
    }
    let mut high = length;
    let mut low = loop {
        let low = high / 2.0;
        if low < Length::SMALLEST {
            return 0.0;
        }
        if has_height(low) {
            break low;
        }
        high = low;
    };
    while high - low > MET * high {
        let middle = f64::midpoint(low, high);
        if has_height(middle) { low = middle } else { high = middle }
    }
    low
}

/// The length x for which `ratio` x and `leg` are the legs of a right triangle with the hypotenuse `hypotenuse`. It is
/// reduced by a rounding error, and at most the largest accepted length.
fn largest_leg(hypotenuse: f64, leg: f64, ratio: f64) -> f64 {
    let room = ((hypotenuse - leg) * (hypotenuse + leg)).max(0.0).sqrt();
    (room / ratio * (1.0 - 4.0 * f64::EPSILON)).min(Length::LARGEST)
}

#[cfg(test)]
mod tests;
