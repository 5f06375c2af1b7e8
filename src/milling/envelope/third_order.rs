//! Heights and inverses on curved surfaces, where every mark has a normal of its own: the answers of the second order,
//! corrected by those of [`TurningMarks`].

use super::body::Body;
use super::clearing::Clearing;
use super::inverses::{SecondOrder, is_limit};
use super::length_search;
use super::newton::{self, End, Lengths, Place, Ridge, Sought};
use super::proved;
use super::section::Pattern;
use super::turned_ridge::{RidgeSearch, TurnedRidge};
use super::turning_marks::TurningMarks;
use super::{Envelope, QuickLevel};
use crate::milling::{CutterKind, NoAnswer, Pass, ScallopHeight};
use crate::quantity::{Angle, Length};

/// Under the whole cutter, the normal turns by at most this share of the slope's sine or cosine where the second order
/// answers: the answers change by about that share.
const NO_TURN: f64 = 1e-11;

/// The turn, as a share of the slope's sine or cosine, from which on the marks of the second order count more and more.
const TURNS_BEYOND: f64 = 1.0;

/// The factor of a tolerance over which the height of the marks alone leaves no step-over, although it is a little more than
/// that of the smallest step-over.
const USED_UP: f64 = 1.0 + 1e-4;

/// The slope's cosine up to which a contact is beside a wall: about 5 deg.
const BESIDE_WALL: f64 = 0.09;

/// A length at which the height may be the tolerance.
#[derive(Debug, Clone, Copy)]
enum Candidate {
    /// The answer, which no height need confirm.
    Proved(f64),
    /// A length at a ridge, which the height is to confirm; the guess is the start of a search otherwise.
    AtRidge { length: f64, guess: f64 },
    /// The start of a search.
    Guess(f64),
}

impl Envelope {
    /// h1 and the feed's share h - h1, for a step-over along the surface and a feed per tooth; `None` leaves no marks.
    ///
    /// # Errors
    /// [`NoAnswer::PassesDoNotOverlap`], [`NoAnswer::MarksDoNotOverlap`].
    pub fn scallop_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<ScallopHeight, NoAnswer> {
        // A refusal counts the feed, so that its step-over is one for that feed.
        let step_over_height = self.step_over_height_beside(step_over, self.pattern_of(feed_per_tooth).spacing)?;
        self.height_above(step_over_height, step_over, feed_per_tooth)
    }

    /// h1, the height that passes alone leave.
    pub(in crate::milling) fn step_over_height(&self, step_over: Length) -> Result<Length, NoAnswer> {
        self.step_over_height_beside(step_over, 0.0)
    }

    /// The same, or the reason why there is no height with marks f apart.
    fn step_over_height_beside(&self, step_over: Length, f: f64) -> Result<Length, NoAnswer> {
        let s = step_over.mm();
        self.turned_height(s, Pattern::even(0.0)).map(Length::computed).ok_or_else(|| self.no_height(s, f))
    }

    /// h, the height that passes and marks leave.
    pub(in crate::milling) fn total_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        self.answered_height(step_over.mm(), self.pattern_of(feed_per_tooth))
    }

    /// [`Envelope::turned_height`] or the reason why there is none.
    fn answered_height(&self, s: f64, pattern: Pattern) -> Result<Length, NoAnswer> {
        self.turned_height(s, pattern).map(Length::computed).ok_or_else(|| self.no_height(s, pattern.spacing))
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
        let height = |pattern: Pattern| {
            let s = step_over.mm();
            self.height(s, pattern).ok_or_else(|| self.no_height(s, pattern.spacing))
        };
        let step_over_height = height(Pattern::even(0.0))?;
        let total = if feed_per_tooth.is_some() { height(self.pattern_of(feed_per_tooth))? } else { step_over_height };
        Ok(ScallopHeight::of_total(Length::computed(step_over_height), Length::computed(total)))
    }

    /// The largest feed per tooth that keeps the tolerance `tolerance` on h.
    ///
    /// # Errors
    /// [`NoAnswer::StepOverUsesUpTolerance`], [`NoAnswer::ToleranceLimitsNoFeed`], and those of the
    /// step-over in [`Envelope::scallop_height`].
    pub fn max_feed_per_tooth(&self, tolerance: Length, step_over: Length) -> Result<Length, NoAnswer> {
        if !self.has_third_order {
            return self.second_order_max_feed_per_tooth_above(self.step_over_height(step_over)?, tolerance, step_over);
        }
        self.max_turned_feed(self.step_over_height(step_over)?, tolerance, step_over)
    }

    /// The same for a step-over that alone leaves `step_over_height`.
    pub(in crate::milling) fn max_feed_per_tooth_above(
        &self,
        step_over_height: Length,
        tolerance: Length,
        step_over: Length,
    ) -> Result<Length, NoAnswer> {
        if !self.has_third_order {
            return self.second_order_max_feed_per_tooth_above(step_over_height, tolerance, step_over);
        }
        self.max_turned_feed(step_over_height, tolerance, step_over)
    }

    /// The same with turned marks.
    fn max_turned_feed(&self, step_over_height: Length, tolerance: Length, step_over: Length) -> Result<Length, NoAnswer> {
        let (p, s) = (tolerance.mm(), step_over.mm());
        let used_up = || {
            let max_step_over = self.max_step_over(tolerance, None)?;
            Err(NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over })
        };
        if step_over_height >= tolerance {
            return used_up();
        }
        self.check_feeds(s)?;
        let largest = self.largest_spacing(s);
        let candidate = self.feed_candidate(p, s, step_over_height.mm(), largest);
        let spacing = Self::confirmed_length(candidate, p, largest, |spacing| self.turned_height(s, self.pattern(spacing)));
        spacing.map_or_else(used_up, |spacing| self.largest_feed(spacing, largest).unwrap_or_else(used_up))
    }

    /// The largest step-over along the surface that keeps `tolerance` on h at a feed per tooth.
    ///
    /// # Errors
    /// - [`NoAnswer::FeedUsesUpTolerance`] if even passes [`Length::SMALLEST`] apart exceed the tolerance;
    /// - [`NoAnswer::MarksDoNotOverlap`];
    /// - [`NoAnswer::ToleranceLimitsNoStepOver`] if no step-over up to the largest one exceeds the tolerance.
    pub fn max_step_over(&self, tolerance: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        let p = tolerance.mm();
        let pattern = self.pattern_of(feed_per_tooth);
        let largest = self.largest_step_over(pattern.spacing);
        let feed_height = || self.feed_height(pattern, |s| self.turned_height(s, pattern));
        let used_up = |feed_height: f64| Err(NoAnswer::FeedUsesUpTolerance { feed_height: Length::computed(feed_height) });
        // With runout or on a concave surface, a search for a step-over that does not exist takes longer than a height. Beside
        // concave walls heights can fall where step-overs grow, so that the height of the smallest one proves nothing.
        let is_slow = !pattern.is_even() || self.body.is_concave();
        let proves = !self.body.is_concave() || self.contact().slope().cos() > BESIDE_WALL;
        if is_slow
            && proves
            && largest >= Length::SMALLEST
            && self.guess(0.0, pattern) > p
            && let Ok(feed_height) = feed_height()
            && feed_height > p * USED_UP
        {
            return used_up(feed_height);
        }
        if !self.has_third_order {
            return self.second_order_max_step_over(tolerance, feed_per_tooth);
        }
        let candidate = if let Some(candidate) = self.step_over_candidate(p, pattern, largest)? {
            candidate
        } else {
            let feed_height = feed_height()?;
            if feed_height > p {
                return used_up(feed_height);
            }
            Candidate::Guess(Length::SMALLEST)
        };
        match Self::confirmed_length(candidate, p, largest, |s| self.turned_height(s, pattern)) {
            Some(step_over) if is_limit(step_over, largest) => {
                Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: Length::computed(largest) })
            }
            Some(step_over) => Ok(Length::computed(step_over)),
            None => used_up(feed_height()?.max(p)),
        }
    }

    /// A feed per tooth that may leave the height p between passes s apart, which alone leave `step_over_height`.
    fn feed_candidate(&self, p: f64, s: f64, step_over_height: f64, largest: f64) -> Candidate {
        if let Some(feed) = self.nearby_feed(p, s, step_over_height, largest) {
            return self.nearby_candidate(feed);
        }
        // To second order the step-over leaves about as much.
        match self.second_order_feed(p, s, step_over_height) {
            SecondOrder::Found(feed, ridge) if self.pattern(feed).is_even() => {
                self.candidate(Sought::MarkSpacing, Lengths { level: p, step_over: s, mark_spacing: feed }, ridge)
            }
            SecondOrder::Found(feed, _) => self.candidate_with_runout(p, feed, |feed| (s, self.pattern(feed))),
            SecondOrder::Unlimited => Candidate::Guess(largest),
            SecondOrder::UsedUp => Candidate::Guess(Length::SMALLEST),
        }
    }

    /// A step-over that may leave the height p at a pattern of marks; `None` if to second order the marks alone leave more.
    fn step_over_candidate(&self, p: f64, pattern: Pattern, largest: f64) -> Result<Option<Candidate>, NoAnswer> {
        if let Some(step_over) = self.nearby_step_over(p, pattern, largest) {
            return Ok(Some(self.nearby_candidate(step_over)));
        }
        Ok(match self.second_order_step_over(p, pattern)? {
            SecondOrder::Found(step_over, ridge) if pattern.is_even() => {
                Some(self.candidate(Sought::StepOver, Lengths { level: p, step_over, mark_spacing: pattern.spacing }, ridge))
            }
            SecondOrder::Found(step_over, _) => Some(self.candidate_with_runout(p, step_over, |s| (s, pattern))),
            SecondOrder::Unlimited => Some(Candidate::Guess(largest)),
            SecondOrder::UsedUp => None,
        })
    }

    /// A length near that of the second order, `guess`, at which the height with turned marks is p. `passes` has the step-over
    /// and the pattern of marks of a length.
    fn candidate_with_runout(&self, p: f64, guess: f64, passes: impl Fn(f64) -> (f64, Pattern)) -> Candidate {
        let ratio_at = |s: f64, pattern: &Pattern| self.ratio_of_turns(s, self.even_spacing(pattern));
        let mut last = None;
        // To second order the height at the guess is p.
        let (s, pattern) = passes(guess);
        let length = length_search::by_secants(guess, ratio_at(s, &pattern).ln(), |length| {
            let (s, pattern) = passes(length);
            let quick = self.quick_level_with_runout(s, &pattern).filter(|_| self.overlap(s, pattern.spacing))?;
            let ratio = ratio_at(s, &pattern);
            last = Some((quick, ratio));
            Some((quick.level * ratio / p).ln())
        });
        let Some(length) = length else { return Candidate::Guess(guess) };
        // The height there, of which the fast search and the ratio are known.
        let (s, pattern) = passes(length);
        let height = last.and_then(|(quick, ratio)| Some(self.checked_level(s, pattern, Some(quick))? * ratio));
        let is_confirmed = height.is_some_and(|height| length_search::confirms(height, p));
        if is_confirmed { Candidate::Proved(length) } else { Candidate::Guess(length) }
    }

    /// A length at a ridge near that of the second order.
    fn nearby_candidate(&self, length: f64) -> Candidate {
        if self.has_one_ridge() { Candidate::Proved(length) } else { Candidate::AtRidge { length, guess: length } }
    }

    /// The length that a candidate leads to; `None` if the height of the smallest length exceeds p.
    fn confirmed_length(candidate: Candidate, p: f64, largest: f64, height: impl Fn(f64) -> Option<f64>) -> Option<f64> {
        match candidate {
            Candidate::Proved(length) => Some(length),
            Candidate::AtRidge { length, guess } => length_search::largest_within(p, guess, Some(length), largest, height),
            Candidate::Guess(guess) => length_search::largest_within(p, guess, None, largest, height),
        }
    }

    /// h for passes s apart with a pattern of marks; `None` if there is none, for the reason in [`Envelope::no_height`].
    pub(super) fn turned_height(&self, s: f64, pattern: Pattern) -> Option<f64> {
        if !self.has_third_order {
            return self.height(s, pattern);
        }
        if pattern.is_even() {
            if !self.is_in_reach(s, pattern.spacing) {
                return None;
            }
            if let Some(ridge) = self.nearby_height(s, pattern) {
                return Some(ridge.lengths.level);
            }
            let (lengths, ridge) = self.second_order(s, pattern.spacing)?;
            return Some(self.turned_level(lengths, ridge));
        }
        Some(self.height(s, pattern)? * self.ratio_of_turns(s, self.even_spacing(&pattern)))
    }

    /// The ratio of the height of turned marks f apart to that of the second order; 1 if there is none. With runout, the
    /// height changes in the same ratio as for marks of equal depth that leave about the same height, at any ridge.
    fn ratio_of_turns(&self, s: f64, f: f64) -> f64 {
        if !self.overlap(s, f) {
            return 1.0;
        }
        let lengths = Lengths { level: self.guess(s, Pattern::even(f)), step_over: s, mark_spacing: f };
        let quick = proved::solve(&self.body, Sought::Level, lengths, [Clearing::EVEN; 2]);
        let second_order = quick.map_or_else(|| self.second_order(s, f), |ridge| Some((ridge.lengths, Some(ridge))));
        match second_order {
            Some((lengths, ridge)) if lengths.level > 0.0 => self.turned_level(lengths, ridge) / lengths.level,
            _ => 1.0,
        }
    }

    /// The height to second order with its lengths, for marks of equal depth, and its ridge if the search is proved.
    pub(super) fn second_order(&self, s: f64, f: f64) -> Option<(Lengths, Option<Ridge>)> {
        if !self.is_in_reach(s, f) {
            return None;
        }
        let pattern = Pattern::even(f);
        let lengths = |level: f64| Lengths { level, step_over: s, mark_spacing: f };
        let quick = proved::solve(&self.body, Sought::Level, lengths(self.guess(s, pattern)), [Clearing::EVEN; 2]);
        if let Some(ridge) = quick.filter(|ridge| self.is_convex_up_to(ridge.lengths.level)) {
            return Some((ridge.lengths, Some(ridge)));
        }
        let found = quick.map(|ridge| QuickLevel::of(&ridge));
        let level = self.searched_level(s, pattern, found)?;
        let is_quick = |ridge: &Ridge| ridge.lengths.level.total_cmp(&level).is_eq();
        let ridge = quick.filter(is_quick).or_else(|| self.ridge_of_second_order(Sought::Level, lengths(level)));
        Some((lengths(level), ridge))
    }

    /// h of turned marks from the lengths and the ridge of the second order.
    pub(super) fn turned_level(&self, lengths: Lengths, ridge: Option<Ridge>) -> f64 {
        let marks = TurningMarks::new(&self.body);
        let search = RidgeSearch::new(&marks);
        let Some(start) = self.start_of_turns(lengths, ridge) else { return lengths.level };
        let weight = weight_of_turns(search.share(&start));
        if weight == 0.0 {
            return lengths.level;
        }
        let Some(turned) = search.solve(Sought::Level, start).or_else(|| search.search(&start)) else { return lengths.level };
        if weight < 1.0 { lengths.level * (turned.lengths.level / lengths.level).powf(weight) } else { turned.lengths.level }
    }

    /// The length sought at the ridge of turned marks, of which that of the second order is in `lengths`, with its ridge if
    /// that is proved.
    fn candidate(&self, sought: Sought, lengths: Lengths, ridge: Option<Ridge>) -> Candidate {
        let marks = TurningMarks::new(&self.body);
        let search = RidgeSearch::new(&marks);
        let guess = sought.of(&lengths);
        let known = ridge.or_else(|| self.ridge_of_second_order(sought, lengths));
        let Some(start) = self.start_of_turns(lengths, known) else { return Candidate::AtRidge { length: guess, guess } };
        if weight_of_turns(search.share(&start)) == 0.0 {
            let is_proved = ridge.is_some() && self.is_convex_up_to(lengths.level);
            return if is_proved { Candidate::Proved(guess) } else { Candidate::AtRidge { length: guess, guess } };
        }
        let ridge = search.solve(sought, start);
        ridge.map_or(Candidate::Guess(guess), |ridge| Candidate::AtRidge { length: sought.of(&ridge.lengths), guess })
    }

    /// The ridge of the second order, if its search ends.
    fn ridge_of_second_order(&self, sought: Sought, lengths: Lengths) -> Option<Ridge> {
        let both = [Clearing::EVEN; 2];
        let start = Place::start(&self.body, lengths.step_over, both, lengths.mark_spacing);
        newton::solve_from(&self.body, sought, lengths, start, both, End::AtRidge)
    }

    /// The ridge at which the search of turned marks starts: that of the second order if it is known; `None` if it is at
    /// an overhang, which turned marks do not know.
    fn start_of_turns(&self, lengths: Lengths, ridge: Option<Ridge>) -> Option<TurnedRidge> {
        match ridge {
            Some(ridge) if ridge.is_at_overhang(&self.body) => None,
            Some(ridge) if ridge.is_exact => Some(TurnedRidge::of_second_order(&ridge)),
            _ => Some(self.ridge_of_paraboloid(lengths)),
        }
    }

    /// The ridge where the cutter is a paraboloid.
    pub(super) fn ridge_of_paraboloid(&self, lengths: Lengths) -> TurnedRidge {
        let radii = self.body.relative_radii();
        let ahead = radii.skew / radii.across.max(f64::MIN_POSITIVE) * lengths.step_over / 2.0;
        let ahead = ahead.clamp(-self.body.reach(), self.body.reach());
        let half = lengths.mark_spacing / 2.0;
        TurnedRidge { behind: [half + ahead, half - ahead], aside: 0.0, lengths, is_round: false }
    }

    /// How much the surface's normal turns from the stated contact to the marks at the ridge: the tangent of the
    /// largest angle, as a share of the smaller of sine and cosine of the slope. Infinite if turns do not count, or if
    /// no ridge of turned marks was found; the answers are then those of the second order.
    pub(in crate::milling) fn largest_turn(&self, step_over: Length, feed_per_tooth: Option<Length>) -> f64 {
        if !self.has_third_order {
            let is_exact = match self.cutter.kind() {
                CutterKind::BallEnd => true,
                CutterKind::FlatEnd => false,
                _ => is_inclined(self.contact().slope()),
            };
            return if is_exact || self.pass.surface.is_plane() { 0.0 } else { f64::INFINITY };
        }
        let (s, f) = (step_over.mm(), feed_per_tooth.map_or(0.0, |feed| self.mark_spacing(feed.mm())));
        let marks = TurningMarks::new(&self.body);
        let search = RidgeSearch::new(&marks);
        if let Some(ridge) = self.nearby_height(s, Pattern::even(f)) {
            return search.share(&ridge);
        }
        let Some((lengths, ridge)) = self.second_order(s, f) else { return f64::INFINITY };
        let Some(start) = self.start_of_turns(lengths, ridge) else { return f64::INFINITY };
        if weight_of_turns(search.share(&start)) == 0.0 {
            return f64::INFINITY;
        }
        search.solve(Sought::Level, start).or_else(|| search.search(&start)).map_or(f64::INFINITY, |ridge| search.share(&ridge))
    }
}

/// Whether the turning of the surface's normal changes the marks. It does not change those of a ball, which is the same
/// in every direction.
///
/// A sharp edge has no radius that a turn could change smoothly; its marks keep the second order.
pub(super) fn has_third_order(pass: &Pass, body: &Body) -> bool {
    let is_turning = || TurningMarks::new(body).turn_per_mm() * body.reach() > NO_TURN;
    !pass.surface.is_plane() && pass.cutter.kind() == CutterKind::Toroidal && is_inclined(pass.contact.slope()) && is_turning()
}

/// Whether a contact of this slope is neither on the floor nor on a wall, where no turn is allowed.
fn is_inclined(slope: Angle) -> bool {
    slope.sin() > 0.0 && slope.cos() > 0.0
}

/// The weight of turned marks against those of the second order where the normal turns by a share of the slope's sine or
/// cosine at most: 1 up to [`TURNS_BEYOND`], 0 from twice that on.
///
/// Turns of more than the slope lead over the floor, where the cutter touches the surface on its other side. Neither
/// height holds there (docs/envelope-on-curved-surfaces.md); that of the second order is continuous up to a level
/// contact, which has no turns.
fn weight_of_turns(share: f64) -> f64 {
    let beyond = (share / TURNS_BEYOND - 1.0).clamp(0.0, 1.0);
    1.0 - beyond * beyond * (3.0 - 2.0 * beyond)
}
