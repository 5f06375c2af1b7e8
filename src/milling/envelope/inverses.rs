//! The largest feed per tooth and the largest step-over that keep a tolerance.

use super::search::{Lengths, Outcome, Sought};
use super::{Envelope, JUST_UNDER};
use crate::milling::NoAnswer;
use crate::numerics::bracketed_root;
use crate::quantity::Length;
use std::convert::Infallible;

/// The share by which the height at a largest length may differ from the tolerance.
const MET: f64 = 1e-12;

/// The share of a length within which a jump of the height is found.
const JUMP: f64 = 1e-10;

/// The first and the largest ratio of the lengths between which the root of the height is sought.
const FIRST_RATIO: f64 = 1.001;
const LARGEST_RATIO: f64 = 2.0;

impl Envelope {
    /// The largest feed per tooth that keeps `tolerance` on h at a step-over along the surface.
    ///
    /// # Errors
    /// - [`NoAnswer::StepOverUsesUpTolerance`], [`NoAnswer::ToleranceLimitsNoFeed`];
    /// - those of the step-over in [`Envelope::scallop_height`].
    pub fn max_feed_per_tooth(&self, tolerance: Length, step_over: Length) -> Result<Length, NoAnswer> {
        self.max_feed_per_tooth_above(self.step_over_height(step_over)?, tolerance, step_over)
    }

    /// The largest feed per tooth beside a step-over that alone leaves `step_over_height`.
    pub(in crate::milling) fn max_feed_per_tooth_above(
        &self,
        step_over_height: Length,
        tolerance: Length,
        step_over: Length,
    ) -> Result<Length, NoAnswer> {
        let (p, s) = (tolerance.mm(), step_over.mm());
        let used_up = || {
            let max_step_over = self.max_step_over(tolerance, None)?;
            Err(NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over })
        };
        if step_over_height >= tolerance {
            return used_up();
        }
        let largest = self.pattern.feed_per_tooth(self.largest_spacing(s));
        if largest < Length::SMALLEST {
            return Err(NoAnswer::MarksDoNotOverlap { largest_mark_spacing: Length::computed(largest) });
        }
        let [along, across, _] = self.groove();
        // The heights of parabolas add up.
        let spacing = (8.0 * (p - step_over_height.mm()).max(p * 1e-6).min(p - across * s * s / 8.0).max(p * 1e-6) / along).sqrt();
        let guess = Lengths { level: p, step_over: s, feed: self.pattern.feed_per_tooth(spacing) };
        match self.solve(Sought::Feed, guess, largest) {
            Outcome::At(feed) if feed >= Length::SMALLEST => Ok(Length::computed(feed)),
            Outcome::Above => Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth: Length::computed(largest) }),
            Outcome::At(_) | Outcome::Below => used_up(),
        }
    }

    /// The largest step-over along the surface that keeps `tolerance` on h at a feed per tooth.
    ///
    /// # Errors
    /// - [`NoAnswer::FeedUsesUpTolerance`] if even passes [`Length::SMALLEST`] apart exceed the tolerance;
    /// - [`NoAnswer::MarksDoNotOverlap`];
    /// - [`NoAnswer::ToleranceLimitsNoStepOver`] if no step-over up to the largest one exceeds the tolerance.
    pub fn max_step_over(&self, tolerance: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        let (p, feed) = (tolerance.mm(), feed_per_tooth.map_or(0.0, Length::mm));
        let spacing = self.pattern.spacing(feed);
        let largest = self.largest_step_over(spacing);
        if largest < Length::SMALLEST {
            return Err(self.no_height(Length::SMALLEST, feed));
        }
        let [along, across, _] = self.groove();
        let left = (p - along * spacing * spacing / 8.0).max(p * 1e-6);
        let guess = Lengths { level: p, step_over: (8.0 * left / across).sqrt().min(largest), feed };
        match self.solve(Sought::StepOver, guess, largest) {
            Outcome::At(step_over) if step_over >= Length::SMALLEST => Ok(Length::computed(step_over)),
            Outcome::Above => Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: Length::computed(largest) }),
            Outcome::At(_) | Outcome::Below => {
                let feed_height = self.height(Length::SMALLEST, feed).ok_or_else(|| self.no_height(Length::SMALLEST, feed))?;
                Err(NoAnswer::FeedUsesUpTolerance { feed_height: Length::computed(feed_height.level.max(p)) })
            }
        }
    }

    /// The largest length at which h is at most a tolerance, by the fast search or the sure one. On a curved surface a height
    /// confirms it, or the root of the height is sought beside it.
    #[expect(clippy::float_cmp, reason = "a length that is held to its bound is the bound")]
    fn solve(&self, sought: Sought, guess: Lengths, largest: f64) -> Outcome {
        let excess = |length: f64| {
            let lengths = guess.with(sought, length);
            let height = self.height(lengths.step_over, lengths.feed)?;
            let excess = height.level / guess.level - 1.0;
            Some(if excess.abs() <= MET { 0.0 } else { excess })
        };
        let is_plane = self.pass.surface.is_plane();
        let is_root = |length: f64| is_plane || excess(length) == Some(0.0);
        // With runout the height jumps where the deepest tooth's marks only just overlap, and rounding decides whether they do.
        let may_jump = |Lengths { step_over, feed, .. }: Lengths| {
            !self.overlap(step_over / JUST_UNDER, self.pattern.marks(feed).pairs()[0].distance / JUST_UNDER)
        };
        let is_confirmed = |length: f64| {
            let is_kept = || excess(length).is_some_and(|excess| excess <= 0.0);
            is_root(length) && (!is_plane || !may_jump(guess.with(sought, length)) || is_kept())
        };
        let smallest = guess.with(sought, Length::SMALLEST);
        let least = Lengths { level: self.guess(smallest.step_over, smallest.feed), ..smallest };
        let is_used_up = || self.quickly(&self.body, Sought::Level, least).is_some_and(|ridge| ridge.lengths.level > guess.level);
        // Where the approximation is over the tolerance, the refusal comes first: the searches for a length would all fail.
        let is_refusal_likely = least.level > guess.level;
        if is_refusal_likely && is_used_up() {
            return Outcome::Below;
        }
        for body in self.bodies() {
            let quick = self.quickly(body, sought, guess).map(|ridge| ridge.lengths.get(sought));
            if let Some(length) = quick.filter(|length| *length <= largest && is_root(*length)) {
                return Outcome::At(length);
            }
        }
        if !is_refusal_likely && is_used_up() {
            return Outcome::Below;
        }
        // Of both bodies the one that leaves more decides.
        let solve = |body| self.search(body).solve(sought, guess, Length::SMALLEST, largest, &mut self.places(&guess));
        let by_body: Vec<Outcome> = self.bodies().map(solve).collect();
        let least = by_body.iter().copied().reduce(|one, other| if one.is_better(sought, &other) { other } else { one });
        match least {
            // Where passes or marks only just overlap, rounding decides.
            Some(Outcome::At(length)) if length > largest * JUST_UNDER && excess(largest).is_some_and(|excess| excess <= 0.0) => {
                return Outcome::Above;
            }
            Some(Outcome::At(length)) if is_confirmed(length) => return Outcome::At(length),
            Some(outcome @ (Outcome::Above | Outcome::Below)) if is_plane => return outcome,
            _ => {}
        }
        // Otherwise the search for the length begins at the one whose height is the nearest to the tolerance.
        let lengths = by_body.iter().map(|outcome| match outcome {
            Outcome::At(length) => *length,
            Outcome::Above => largest,
            Outcome::Below => Length::SMALLEST,
        });
        let by_excess = lengths.map(|length| (excess(length).map_or(f64::INFINITY, f64::abs), length));
        let start = by_excess.min_by(|one, other| one.0.total_cmp(&other.0)).map_or(largest, |(_, length)| length);
        let mut ratio = FIRST_RATIO;
        let (mut kept, mut exceeds) = (0.0_f64, f64::INFINITY);
        let mut keeps = |length: f64| {
            // Lengths at which passes or marks do not meet leave everything.
            let excess = excess(length).unwrap_or(f64::MAX);
            if excess <= 0.0 {
                kept = kept.max(length);
            } else {
                exceeds = exceeds.min(length);
            }
            // Where the height jumps over the tolerance.
            if kept > 0.0 && exceeds - kept <= JUMP * kept { 0.0 } else { excess }
        };
        let mut value = start.clamp(Length::SMALLEST, largest);
        let is_over = keeps(value) > 0.0;
        let mut end = value;
        loop {
            let bound = if is_over { Length::SMALLEST } else { largest };
            if end == bound {
                return if is_over { Outcome::Below } else { Outcome::Above };
            }
            value = end;
            end = (if is_over { end / ratio } else { end * ratio }).clamp(Length::SMALLEST, largest);
            if (keeps(end) > 0.0) != is_over {
                break;
            }
            ratio = (ratio * ratio).min(LARGEST_RATIO);
        }
        let Ok(_) = bracketed_root(value.min(end), value.max(end), |length| Ok::<_, Infallible>(keeps(length)));
        Outcome::At(kept)
    }
}
