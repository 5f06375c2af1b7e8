//! The largest step-over and the largest feed per tooth that keep a tolerance, to second order, each by the fastest search
//! that has it.

use super::newton::{Lengths, Ridge, Sought};
use super::section::{Pattern, Section};
use super::{Envelope, length_search, sharp_edge};
use crate::milling::{CutterKind, NoAnswer};
use crate::numerics::bracketed_root;
use crate::quantity::Length;
use std::convert::Infallible;

/// A step-over that is short compared with a feed, as a share of it. What a parabola leaves out is of the order of the
/// third power.
const SHORT: f64 = 5e-4;

/// The share by which a height over a parabola grows at most from one short step-over to twice that.
const FLAT: f64 = 1e-5;

/// The largest step-over or feed per tooth that keeps a tolerance to second order.
#[derive(Debug, Clone, Copy)]
pub(super) enum SecondOrder {
    /// The length, and its ridge if the fast search proved it.
    Found(f64, Option<Ridge>),
    /// No length up to the largest one exceeds the tolerance.
    Unlimited,
    /// The smallest accepted length exceeds the tolerance.
    UsedUp,
}

/// Whether a length is the largest one, up to the rounding errors of a search.
pub(super) fn is_limit(length: f64, largest: f64) -> bool {
    length >= largest * (1.0 - 1e-12)
}

impl Envelope {
    /// [`Envelope::max_feed_per_tooth`] to second order, for a step-over that alone leaves `step_over_height`.
    pub(super) fn second_order_max_feed_per_tooth_above(
        &self,
        step_over_height: Length,
        tolerance: Length,
        step_over: Length,
    ) -> Result<Length, NoAnswer> {
        let s = step_over.mm();
        self.check_feeds(s)?;
        let largest = self.largest_spacing(s);
        let feed = match self.second_order_feed(tolerance.mm(), s, step_over_height.mm()) {
            SecondOrder::Found(spacing, _) => self.largest_feed(spacing, largest),
            SecondOrder::Unlimited => self.largest_feed(largest, largest),
            SecondOrder::UsedUp => None,
        };
        feed.unwrap_or_else(|| {
            let max_step_over = self.second_order_max_step_over(tolerance, None)?;
            Err(NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over })
        })
    }

    /// The feed per tooth of the largest distance of marks that keeps a tolerance, or the error that the tolerance limits none
    /// up to `largest`; `None` for a feed below the smallest accepted one.
    pub(super) fn largest_feed(&self, spacing: f64, largest: f64) -> Option<Result<Length, NoAnswer>> {
        let feed = Some(self.feed_per_tooth(spacing)).filter(|feed| *feed >= Length::SMALLEST).map(Length::computed)?;
        Some(if spacing >= largest { Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth: feed }) } else { Ok(feed) })
    }

    /// An error if passes s apart are so far apart that no marks of an accepted feed per tooth overlap.
    pub(super) fn check_feeds(&self, s: f64) -> Result<(), NoAnswer> {
        let largest = self.feed_per_tooth(self.largest_spacing(s));
        if largest < Length::SMALLEST {
            return Err(NoAnswer::MarksDoNotOverlap { largest_mark_spacing: Length::computed(largest) });
        }
        Ok(())
    }

    /// The largest distance of marks that keeps the height p in passes s apart, whose step-over alone leaves
    /// `step_over_height`.
    pub(super) fn second_order_feed(&self, p: f64, s: f64, step_over_height: f64) -> SecondOrder {
        if step_over_height >= p {
            return SecondOrder::UsedUp;
        }
        let largest = self.largest_spacing(s);
        let room = p - step_over_height;
        let guess = (8.0 * room * self.cutter.outer_radius().mm()).sqrt().max(self.feed_on_flat(p, s)).min(largest);
        let lengths = Lengths { level: p, step_over: s, mark_spacing: guess };
        let mut ridge = None;
        let quick = if let Some(feed) = self.feed_on_floor_or_wall(p, s) {
            Some(feed.min(largest))
        } else {
            // With runout, marks that are closer together than the displacement are those of the deepest tooth alone.
            if self.displacement > 0.0 || self.pattern(guess).is_even() {
                ridge = self.quickly(lengths, Sought::MarkSpacing).filter(|ridge| self.pattern(ridge.lengths.mark_spacing).is_even());
            }
            // On a concave surface nothing proves the result; the height confirms it.
            ridge.map(|ridge| ridge.lengths.mark_spacing).or_else(|| {
                let with_runout = || self.quick_feed_with_runout(p, s, step_over_height, guess);
                if self.drop > 0.0 { with_runout() } else { None }
            })
        };
        let height = |feed: f64| self.height(s, self.pattern(feed));
        let quick = quick.filter(|feed| (Length::SMALLEST..=largest).contains(feed));
        let is_guessed = !self.is_convex_up_to(p) && !self.has_third_order;
        let found = self.feed_at(p, s, quick, guess, largest).or(is_guessed.then_some(guess));
        match found.and_then(|feed| self.confirmed(feed, p, largest, height)) {
            Some(feed) if feed >= largest => SecondOrder::Unlimited,
            Some(feed) => SecondOrder::Found(feed, ridge),
            // The tolerance allows only feeds below the smallest accepted one.
            None => SecondOrder::UsedUp,
        }
    }

    /// The largest feed per tooth, from [`Length::SMALLEST`] to `largest`, at which the passes clear the step-over s
    /// down to the height p; `None` if there is none.
    pub(super) fn feed_held(&self, p: f64, s: f64, guess: f64, largest: f64) -> Option<f64> {
        let excess = |feed: f64| s - Section::new(&self.body, self.pattern(feed), 2.0 * s).width(p);
        if excess(largest) <= 0.0 {
            return Some(largest);
        }
        let mut low = guess.clamp(Length::SMALLEST, largest);
        let mut high;
        if excess(low) <= 0.0 {
            loop {
                high = (2.0 * low).min(largest);
                if excess(high) > 0.0 {
                    break;
                }
                if high >= largest {
                    return Some(largest);
                }
                low = high;
            }
        } else {
            loop {
                high = low;
                low = (low / 2.0).max(Length::SMALLEST);
                if excess(low) <= 0.0 {
                    break;
                }
                if low <= Length::SMALLEST {
                    return None;
                }
            }
        }
        self.feed_between(p, s, low, high)
    }

    /// The largest feed per tooth in a bracket.
    fn feed_between(&self, p: f64, s: f64, low: f64, high: f64) -> Option<f64> {
        let excess = |feed: f64| s - Section::new(&self.body, self.pattern(feed), 2.0 * s).width(p);
        if excess(low) > 0.0 || excess(high) <= 0.0 {
            return None;
        }
        let Ok(logarithm) = bracketed_root(low.ln(), high.ln(), |logarithm| Ok::<_, Infallible>(excess(logarithm.exp())));
        Some(logarithm.exp())
    }

    /// [`Envelope::max_step_over`] to second order.
    pub(super) fn second_order_max_step_over(&self, tolerance: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        let pattern = self.pattern_of(feed_per_tooth);
        match self.second_order_step_over(tolerance.mm(), pattern)? {
            SecondOrder::Found(step_over, _) => Ok(Length::computed(step_over)),
            SecondOrder::Unlimited => {
                let largest_step_over = Length::computed(self.largest_step_over(pattern.spacing));
                Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over })
            }
            SecondOrder::UsedUp => {
                let feed_height = self.feed_height(pattern, |s| self.height(s, pattern))?.max(tolerance.mm());
                Err(NoAnswer::FeedUsesUpTolerance { feed_height: Length::computed(feed_height) })
            }
        }
    }

    /// The height of the smallest step-over.
    ///
    /// # Errors
    /// [`Envelope::no_height`].
    pub(super) fn feed_height(&self, pattern: Pattern, height: impl Fn(f64) -> Option<f64>) -> Result<f64, NoAnswer> {
        let height = self.feed_vertex(pattern, &height).or_else(|| height(Length::SMALLEST));
        height.ok_or_else(|| self.no_height(Length::SMALLEST, pattern.spacing))
    }

    /// The height of the smallest step-over by the vertex of a parabola over short step-overs; `None` if heights do not
    /// follow one, because runout or an edge lets them grow more. Searches of ridges need passes that are apart.
    fn feed_vertex(&self, pattern: Pattern, height: impl Fn(f64) -> Option<f64>) -> Option<f64> {
        if !pattern.is_even() || self.pass.surface.is_plane() || self.cutter.kind() == CutterKind::FlatEnd {
            return None;
        }
        let s = Length::SMALLEST.max(SHORT * pattern.spacing);
        let (one, two) = (height(s)?, height(2.0 * s)?);
        (two <= one * (1.0 + FLAT)).then(|| one - (two - one) / 3.0 * (1.0 - (Length::SMALLEST / s).powi(2)))
    }

    /// Whether the marks alone leave more than the height p, where their parabola does by a good part. A search for
    /// a step-over that does not exist takes longer than two heights.
    fn is_clearly_used_up(&self, p: f64, pattern: Pattern) -> bool {
        let is_likely = self.has_third_order && !self.body.is_nearly_level() && self.is_convex_up_to(p) && self.guess(0.0, pattern) > p;
        is_likely && self.feed_vertex(pattern, |s| self.height(s, pattern)).is_some_and(|height| height > p)
    }

    /// The largest step-over that keeps the height p with a pattern of marks.
    ///
    /// # Errors
    /// [`NoAnswer::MarksDoNotOverlap`].
    pub(super) fn second_order_step_over(&self, p: f64, pattern: Pattern) -> Result<SecondOrder, NoAnswer> {
        let largest = self.largest_step_over(pattern.spacing);
        if largest < Length::SMALLEST {
            return Err(NoAnswer::MarksDoNotOverlap {
                largest_mark_spacing: Length::computed(self.feed_per_tooth(self.largest_spacing(Length::SMALLEST))),
            });
        }
        let guess = self.step_over_guess(p).min(largest);
        let lengths = Lengths { level: p, step_over: guess, mark_spacing: pattern.spacing };
        let mut ridge = None;
        let quick = if let Some(step_over) = self.step_over_on_floor_or_wall(p, &pattern) {
            Some(step_over.min(largest))
        } else if self.is_sharp_on_concave(pattern.spacing) {
            sharp_edge::step_over(&self.body, p, guess)
        } else if pattern.is_even() {
            if self.is_clearly_used_up(p, pattern) {
                return Ok(SecondOrder::UsedUp);
            }
            ridge = self.quickly(lengths, Sought::StepOver);
            ridge.map(|ridge| ridge.lengths.step_over)
        } else {
            // On a concave surface nothing proves the result; the height confirms it.
            let is_proved = self.is_convex_up_to(p);
            self.quick_step_over_with_runout(p, &pattern, guess).filter(|step_over| is_proved || *step_over > 0.0)
        };
        let width = if self.is_convex_up_to(p) {
            quick.unwrap_or_else(|| Section::new(&self.body, pattern, 2.0 * largest).width(p))
        } else {
            quick.unwrap_or_else(|| self.step_over_on_concave(p, pattern, largest))
        };
        // If only the overlap of the passes limits the step-over, the result is that limit.
        if is_limit(width, largest) && (self.is_convex_up_to(p) || self.has_third_order) {
            return Ok(SecondOrder::Unlimited);
        }
        // The section can be empty again over the whole cutter, so that a width of 0 shows nothing on a concave surface.
        if width < Length::SMALLEST && (self.is_convex_up_to(p) || self.has_third_order) {
            return Ok(SecondOrder::UsedUp);
        }
        Ok(match self.confirmed(width, p, largest, |step_over| self.height(step_over, pattern)) {
            Some(step_over) if is_limit(step_over, largest) => SecondOrder::Unlimited,
            Some(step_over) => SecondOrder::Found(step_over, ridge),
            None => SecondOrder::UsedUp,
        })
    }

    /// A step-over above the one that leaves the height p: the groove's parabola, or near the floor the width of the
    /// cutter's flat and corner.
    pub(super) fn step_over_guess(&self, p: f64) -> f64 {
        let (core, corner) = (self.cutter.core_radius().mm(), self.cutter.corner_radius().mm());
        let on_floor = 2.0 * (core + (2.0 * corner * p).sqrt());
        (8.0 * p / self.groove_curvature).sqrt().min(on_floor)
    }

    /// `found`, or the largest value up to `largest` at which the height keeps the tolerance; `None` if the smallest value
    /// does not keep it.
    ///
    /// The height decides, so that no answer exceeds the tolerance. If the section is not convex, `found` and the height
    /// can belong to different ridges. With runout, `found` can be a length at which the height jumps, so that its
    /// rounding error exceeds the tolerance. At the side of a flat-end cutter on a nearly level surface heights rise by
    /// thousands of times a length's change. Before a correction by the third order, `found` is only a guess.
    fn confirmed(&self, found: f64, tolerance: f64, largest: f64, height: impl Fn(f64) -> Option<f64>) -> Option<f64> {
        let is_convex = self.is_convex_up_to(tolerance);
        let has_steep_side = self.cutter.kind() == CutterKind::FlatEnd && !self.pass.surface.is_plane();
        if is_convex && self.drop == 0.0 && !has_steep_side || self.has_third_order {
            return Some(found);
        }
        if is_convex {
            let keeps = |value: &f64| height(*value).is_some_and(|height| height <= tolerance * (1.0 + 1e-9));
            let smaller = [1.0, 1.0 - 1e-14, 1.0 - 1e-12, 1.0 - 1e-9].map(|share| share * found);
            if let Some(kept) = smaller.into_iter().find(keeps) {
                return Some(kept);
            }
        }
        let found = found.clamp(Length::SMALLEST, largest);
        length_search::largest_within(tolerance, found, Some(found), largest, height)
    }

    /// The largest feed per tooth, at most `largest`, that keeps the height p in passes s apart. `quick` is the result
    /// of the fast search; otherwise the search starts from `guess`.
    pub(super) fn feed_at(&self, p: f64, s: f64, quick: Option<f64>, guess: f64, largest: f64) -> Option<f64> {
        if !self.is_convex_up_to(p) {
            return quick.or_else(|| self.feed_on_concave(p, s, largest));
        }
        let nested = || self.nested_feed(p, s, guess).map(|feed| if is_limit(feed, largest) { largest } else { feed });
        quick.or_else(nested).or_else(|| self.feed_held(p, s, guess, largest)).filter(|feed| *feed >= Length::SMALLEST)
    }

    /// An approximation of the largest feed per tooth near a plane floor, if the tolerance p exceeds the height of the
    /// whole flat, so that the marks lie on the flat and on the corner's round. Otherwise 0.
    fn feed_on_flat(&self, p: f64, s: f64) -> f64 {
        let (core, corner) = (self.cutter.core_radius().mm(), self.cutter.corner_radius().mm());
        let over_flat = (p - 2.0 * core * self.contact().slope().sin()).min(corner);
        if over_flat <= 0.0 || !self.pass.surface.is_plane() {
            return 0.0;
        }
        let diameter = 2.0 * (core + (over_flat * (2.0 * corner - over_flat)).sqrt());
        ((diameter - s) * (diameter + s)).max(0.0).sqrt()
    }
}
