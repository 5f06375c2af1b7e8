//! Heights and inverses on curved surfaces, where every mark has a normal of its own: the answers of the second order,
//! corrected by those of [`TurningMarks`].

use super::Envelope;
use super::clearing::Clearing;
use super::newton::{self, Lengths, Place, Ridge, Sought};
use super::section::Pattern;
use super::turned_ridge::{RidgeSearch, TurnedRidge};
use super::turning_marks::TurningMarks;
use crate::milling::{CutterKind, NoAnswer, ScallopHeight};
use crate::numerics::bracketed_root;
use crate::quantity::Length;
use std::convert::Infallible;

/// Under the whole cutter, the normal turns by at most this share of the slope's sine or cosine where the second order
/// answers: the answers change by about that share.
const NO_TURN: f64 = 1e-11;

/// The share of a tolerance that counts as a rounding.
const ROUNDING: f64 = 1e-10;

/// The logarithm of the ratio of a step-over to that of the second order, up to which its ridge is the same.
const NEAR: f64 = 0.25;

/// The factors of the steps by which a length is bracketed.
const STEPS: [f64; 2] = [1.02, 2.0];

impl Envelope {
    /// h1 and the feed's share h - h1, for a step-over along the surface and a feed per tooth; `None` leaves no marks.
    ///
    /// # Errors
    /// [`NoAnswer::PassesDoNotOverlap`], [`NoAnswer::MarksDoNotOverlap`].
    pub fn scallop_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<ScallopHeight, NoAnswer> {
        self.height_above(self.step_over_height(step_over)?, step_over, feed_per_tooth)
    }

    /// h1, the height that passes alone leave.
    pub(in crate::milling) fn step_over_height(&self, step_over: Length) -> Result<Length, NoAnswer> {
        self.turned_height(step_over.mm(), Pattern::even(0.0)).map(Length::computed)
    }

    /// h, the height that passes and marks leave.
    pub(in crate::milling) fn total_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        let pattern = feed_per_tooth.map_or(Pattern::even(0.0), |feed| self.pattern(feed.mm()));
        self.turned_height(step_over.mm(), pattern).map(Length::computed)
    }

    /// The height in its parts, for a step-over that alone leaves `step_over_height`.
    pub(in crate::milling) fn height_above(
        &self,
        step_over_height: Length,
        step_over: Length,
        feed_per_tooth: Option<Length>,
    ) -> Result<ScallopHeight, NoAnswer> {
        let total = if feed_per_tooth.is_some() { self.total_height(step_over, feed_per_tooth)? } else { step_over_height };
        // Without marks no more is left than with them; where each comes from a polygon of its own, or is rounded, the
        // lower one holds for both.
        Ok(ScallopHeight::of_total(step_over_height, total))
    }

    /// The same to second order, as if all marks had the normal of the stated contact.
    ///
    /// # Errors
    /// Those of [`Envelope::scallop_height`].
    pub fn second_order_scallop_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<ScallopHeight, NoAnswer> {
        let s = step_over.mm();
        let step_over_height = self.height(s, Pattern::even(0.0))?;
        let total = feed_per_tooth.map_or(Ok(step_over_height), |feed| self.height(s, self.pattern(feed.mm())))?;
        Ok(ScallopHeight::of_total(Length::computed(step_over_height), Length::computed(total)))
    }

    /// The largest feed per tooth that keeps the tolerance `tolerance` on h.
    ///
    /// # Errors
    /// [`NoAnswer::StepOverUsesUpTolerance`], [`NoAnswer::ToleranceLimitsNoFeed`], and those of the
    /// step-over in [`Envelope::scallop_height`].
    pub fn max_feed_per_tooth(&self, tolerance: Length, step_over: Length) -> Result<Length, NoAnswer> {
        self.max_feed_per_tooth_above(self.step_over_height(step_over)?, tolerance, step_over)
    }

    /// The same for a step-over that alone leaves `step_over_height`.
    pub(in crate::milling) fn max_feed_per_tooth_above(
        &self,
        step_over_height: Length,
        tolerance: Length,
        step_over: Length,
    ) -> Result<Length, NoAnswer> {
        if !self.has_third_order() {
            return self.second_order_max_feed_per_tooth_above(step_over_height, tolerance, step_over);
        }
        let (p, s) = (tolerance.mm(), step_over.mm());
        let used_up = || {
            let max_step_over = self.max_step_over(tolerance, None)?;
            Err(NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over })
        };
        if step_over_height >= tolerance {
            return used_up();
        }
        let largest = self.largest_feed(s);
        let height = |feed: f64| self.turned_height(s, self.pattern(feed)).ok();
        let (guess, found) = match self.second_order_max_feed_per_tooth(tolerance, step_over) {
            Ok(feed) => {
                let lengths = Lengths { level: p, step_over: s, mark_spacing: feed.mm() };
                let is_even = self.pattern(feed.mm()).is_even();
                let ridge = if is_even { self.turned(Sought::MarkSpacing, lengths) } else { None };
                (feed.mm(), ridge.map(|ridge| ridge.lengths.mark_spacing))
            }
            Err(NoAnswer::ToleranceLimitsNoFeed { .. }) => (largest, None),
            Err(NoAnswer::StepOverUsesUpTolerance { .. }) => (Length::SMALLEST, None),
            Err(other) => return Err(other),
        };
        match Self::largest_within(p, guess, found, largest, height) {
            Some(feed) if feed >= largest => Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth: Length::computed(largest) }),
            Some(feed) => Ok(Length::computed(feed)),
            None => used_up(),
        }
    }

    /// The largest step-over along the surface that keeps `tolerance` on h at a feed per tooth.
    ///
    /// # Errors
    /// - [`NoAnswer::FeedUsesUpTolerance`] if even passes [`Length::SMALLEST`] apart exceed the tolerance;
    /// - [`NoAnswer::MarksDoNotOverlap`];
    /// - [`NoAnswer::ToleranceLimitsNoStepOver`] if no step-over up to the largest one exceeds the tolerance.
    pub fn max_step_over(&self, tolerance: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        self.step_over_within(tolerance, feed_per_tooth, true)
    }

    /// The same in half the time, for plans: the ridge at the tolerance is not confirmed by the height of its step-over
    /// if it is near the ridge of the second order.
    ///
    /// # Errors
    /// Those of [`Envelope::max_step_over`].
    pub(in crate::milling) fn unconfirmed_max_step_over(
        &self,
        tolerance: Length,
        feed_per_tooth: Option<Length>,
    ) -> Result<Length, NoAnswer> {
        self.step_over_within(tolerance, feed_per_tooth, false)
    }

    fn step_over_within(&self, tolerance: Length, feed_per_tooth: Option<Length>, is_confirmed: bool) -> Result<Length, NoAnswer> {
        let second_order = self.second_order_max_step_over(tolerance, feed_per_tooth);
        if !self.has_third_order() {
            return second_order;
        }
        let p = tolerance.mm();
        let pattern = feed_per_tooth.map_or(Pattern::even(0.0), |feed| self.pattern(feed.mm()));
        let largest = self.largest_step_over(pattern.spacing);
        let height = |s: f64| self.turned_height(s, pattern).ok();
        let (guess, found) = match second_order {
            Ok(step_over) => {
                let lengths = Lengths { level: p, step_over: step_over.mm(), mark_spacing: pattern.spacing };
                let ridge = if pattern.is_even() { self.turned(Sought::StepOver, lengths) } else { None };
                let found = ridge.map(|ridge| ridge.lengths.step_over);
                let is_near = |found: &f64| *found < largest && (found / step_over.mm()).ln().abs() < NEAR;
                if let Some(found) = found.filter(is_near).filter(|_| !is_confirmed) {
                    return Ok(Length::computed(found));
                }
                (step_over.mm(), found)
            }
            Err(NoAnswer::ToleranceLimitsNoStepOver { .. }) => (largest, None),
            Err(NoAnswer::FeedUsesUpTolerance { .. }) => (Length::SMALLEST, None),
            Err(other) => return Err(other),
        };
        match Self::largest_within(p, guess, found, largest, height) {
            Some(step_over) if step_over >= largest * (1.0 - 1e-12) => {
                Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: Length::computed(largest) })
            }
            Some(step_over) => Ok(Length::computed(step_over)),
            None => {
                let feed_height = self.turned_height(Length::SMALLEST, pattern)?.max(p);
                Err(NoAnswer::FeedUsesUpTolerance { feed_height: Length::computed(feed_height) })
            }
        }
    }

    /// The largest length up to `largest` whose height is at most p: `found`, or the result of a search over the
    /// heights that starts at `guess`; `None` if the height of the smallest length exceeds p.
    pub(super) fn largest_within(p: f64, guess: f64, found: Option<f64>, largest: f64, height: impl Fn(f64) -> Option<f64>) -> Option<f64> {
        let excess = |length: f64| height(length).map_or(f64::INFINITY, |height| height / p - 1.0);
        let is_kept = |length: f64| excess(length) <= ROUNDING;
        if let Some(found) = found.filter(|found| (Length::SMALLEST..largest).contains(found))
            && excess(found).abs() <= ROUNDING
        {
            return Some(found);
        }
        let (mut low, mut high) = (guess, guess);
        let mut step = STEPS[0];
        while !is_kept(low) {
            if low <= Length::SMALLEST {
                return None;
            }
            high = low;
            (low, step) = ((low / step).max(Length::SMALLEST), STEPS[1]);
        }
        while high <= low {
            if low >= largest {
                return Some(largest);
            }
            let next = (low * step).min(largest);
            if is_kept(next) {
                (low, step) = (next, STEPS[1]);
            } else {
                high = next;
            }
        }
        // A length without a height does not keep the tolerance.
        let bounded = |logarithm: f64| Ok::<_, Infallible>(excess(logarithm.exp()).min(1.0));
        let Ok(logarithm) = bracketed_root(low.ln(), high.ln(), bounded);
        // Where the height jumps over the tolerance, the root can be on the far side.
        [1.0, 1.0 - 1e-14, 1.0 - 1e-12, 1.0 - 1e-9]
            .map(|share| share * logarithm.exp())
            .into_iter()
            .find(|length| is_kept(*length))
            .or(Some(low))
    }

    /// Whether the turning of the surface's normal changes the marks. It does not change those of a ball, which is the
    /// same in every direction.
    ///
    /// A sharp edge has no radius that a turn could change smoothly; its marks keep the second order.
    pub(super) fn has_third_order(&self) -> bool {
        let is_turning = || TurningMarks::new(&self.body).turn_per_mm() * self.body.reach() > NO_TURN;
        !self.pass.surface.is_plane() && self.cutter.kind() == CutterKind::Toroidal && self.is_inclined() && is_turning()
    }

    /// Whether the contact is neither on the floor nor on a wall, where no turn is allowed.
    fn is_inclined(&self) -> bool {
        let slope = self.contact().slope();
        slope.sin() > 0.0 && slope.cos() > 0.0
    }

    /// h for passes s apart with a pattern of marks.
    fn turned_height(&self, s: f64, pattern: Pattern) -> Result<f64, NoAnswer> {
        let level = self.height(s, pattern)?;
        if !self.has_third_order() {
            return Ok(level);
        }
        let lengths = |level: f64, mark_spacing: f64| Lengths { level, step_over: s, mark_spacing };
        let turned = |lengths: Lengths| self.turned(Sought::Level, lengths).map_or(lengths.level, |ridge| ridge.lengths.level);
        if pattern.is_even() {
            return Ok(turned(lengths(level, pattern.spacing)));
        }
        // With runout, the height changes in the same ratio as for marks of equal depth that leave about the same
        // height.
        let spacing = self.even_spacing(&pattern);
        let even = self.height(s, Pattern::even(spacing));
        Ok(even.map_or(level, |even| if even > 0.0 { level * turned(lengths(even, spacing)) / even } else { level }))
    }

    /// The ridge between marks of equal depth; `None` if there is none.
    fn turned(&self, sought: Sought, lengths: Lengths) -> Option<TurnedRidge> {
        let marks = TurningMarks::new(&self.body);
        let search = RidgeSearch::new(&marks);
        let start = self.ridge_of_second_order(sought, lengths).unwrap_or_else(|| self.ridge_of_paraboloid(lengths));
        search.solve(sought, start).or_else(|| if matches!(sought, Sought::Level) { search.search(&start) } else { None })
    }

    /// The ridge of the second order, if its search is proved.
    fn ridge_of_second_order(&self, sought: Sought, lengths: Lengths) -> Option<TurnedRidge> {
        let both = [Clearing::EVEN; 2];
        let start = Place::start(&self.body, lengths.step_over, both, lengths.mark_spacing);
        let Ridge { lengths, place } = newton::solve_from(&self.body, sought, lengths, start, both)?;
        Some(TurnedRidge { behind: [place.x[0], place.neighbour_x[0]], aside: place.t - lengths.step_over / 2.0, lengths })
    }

    /// The ridge where the cutter is a paraboloid.
    pub(super) fn ridge_of_paraboloid(&self, lengths: Lengths) -> TurnedRidge {
        let radii = self.body.relative_radii();
        let ahead = radii.skew / radii.across.max(f64::MIN_POSITIVE) * lengths.step_over / 2.0;
        let ahead = ahead.clamp(-self.body.reach(), self.body.reach());
        let half = lengths.mark_spacing / 2.0;
        TurnedRidge { behind: [half + ahead, half - ahead], aside: 0.0, lengths }
    }

    /// How much the surface's normal turns from the stated contact to the marks at the ridge: the tangent of the
    /// largest angle, as a share of the smaller of sine and cosine of the slope. Infinite if no ridge of turned marks
    /// was found; the answers are then those of the second order.
    pub(in crate::milling) fn largest_turn(&self, step_over: Length, feed_per_tooth: Option<Length>) -> f64 {
        if !self.has_third_order() {
            let is_exact = match self.cutter.kind() {
                CutterKind::BallEnd => true,
                CutterKind::FlatEnd => false,
                CutterKind::Toroidal => self.is_inclined(),
            };
            return if is_exact || self.pass.surface.is_plane() { 0.0 } else { f64::INFINITY };
        }
        let (s, f) = (step_over.mm(), feed_per_tooth.map_or(0.0, Length::mm));
        let Ok(level) = self.height(s, Pattern::even(f)) else { return f64::INFINITY };
        let lengths = Lengths { level, step_over: s, mark_spacing: f };
        self.turned(Sought::Level, lengths).map_or(f64::INFINITY, |ridge| RidgeSearch::new(&TurningMarks::new(&self.body)).share(&ridge))
    }
}
