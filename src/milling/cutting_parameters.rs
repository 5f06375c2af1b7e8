//! Cutting parameters: the step-over and feed per tooth that finish the most area per time within a tolerance on the
//! scallop height.

use super::{EvaluatedPass, NoAnswer, Runout};
use crate::quantity::Length;
use std::fmt;

/// The limits on the cutting parameters, set by the cutter's manufacturer, the machine or the user. A largest feed
/// rate, divided by spindle speed and number of teeth, is a largest feed per tooth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CuttingLimits {
    max_feed_per_tooth: Option<Length>,
    min_step_over: Option<Length>,
    max_step_over: Option<Length>,
}

/// The smallest step-over exceeds the largest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CuttingLimitsError {
    /// The largest step-over, which the smallest must not exceed.
    pub max_step_over: Length,
}

impl fmt::Display for CuttingLimitsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the smallest step-over must not exceed the largest, {} mm", self.max_step_over.mm())
    }
}

impl std::error::Error for CuttingLimitsError {}

/// A limit that the cutting parameters reach.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitedBy {
    /// The tolerance on the scallop height.
    ScallopTolerance,
    /// The largest feed per tooth.
    MaxFeedPerTooth,
    /// The smallest step-over.
    MinStepOver,
    /// The largest step-over.
    MaxStepOver,
}

/// The fastest step-over and feed per tooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CuttingParameters {
    /// The step-over along the surface.
    pub step_over: Length,
    /// The feed per tooth.
    pub feed_per_tooth: Length,
    limited_by: [Option<LimitedBy>; 4],
}

impl CuttingParameters {
    /// All limits that bind.
    pub fn limited_by(&self) -> impl Iterator<Item = LimitedBy> + use<> {
        self.limited_by.into_iter().flatten()
    }
}

impl CuttingLimits {
    /// No limits except the tolerance.
    pub const NONE: Self = Self { max_feed_per_tooth: None, min_step_over: None, max_step_over: None };

    /// Limits on the feed per tooth and on the step-over along the surface; `None` sets none.
    ///
    /// # Errors
    /// [`CuttingLimitsError`] if the smallest step-over exceeds the largest.
    pub fn new(
        max_feed_per_tooth: Option<Length>,
        min_step_over: Option<Length>,
        max_step_over: Option<Length>,
    ) -> Result<Self, CuttingLimitsError> {
        match (min_step_over, max_step_over) {
            (Some(smallest), Some(max_step_over)) if smallest > max_step_over => Err(CuttingLimitsError { max_step_over }),
            _ => Ok(Self { max_feed_per_tooth, min_step_over, max_step_over }),
        }
    }
}

/// The ratio of the largest feed to the smallest in the first search over the feed. At less than a hundredth of the
/// largest feed, the marks are negligible.
const FEED_RANGE: f64 = 256.0;

/// The number of feeds in that search, evenly spaced in the logarithm. If h is smooth, the product has one maximum.
const PLACES: u8 = 10;

/// The number of feeds with runout: the product then has one maximum for deep marks alone and one for deep and shallow
/// marks. The ratio of the two feeds is of the order of the number of teeth; neighbouring feeds of the search differ by
/// 15 %.
const PLACES_WITH_RUNOUT: u8 = 40;

/// Without runout the feeds whose product is at least this share of the best are refined if both neighbours have less.
const NEARLY_BEST: f64 = 0.95;

/// With runout every interval between neighbouring feeds is refined whose better end has at least this share of the
/// best. With feeds 15 % apart, a maximum is at most 1 % higher than the product at the nearest feed, if the product is as
/// flat as that of a circle.
const NEARLY_BEST_WITH_RUNOUT: f64 = 0.985;

/// The relative width of the bracket at which the search ends. Near its maximum the product falls with the square of
/// this, 1e-8.
const CLOSE: f64 = 1e-4;

/// The share that is left of a step-over where it may have jumped between neighbouring feeds.
const LEAST_FALL: f64 = 0.9;

/// A length within this ratio of a limit counts as reaching it.
const REACHED: f64 = 1e-9;

impl EvaluatedPass {
    /// The step-over s and feed per tooth f_z that maximise s f_z, the area finished per tooth and time, subject to
    /// h(s, f_z) <= `tolerance` and `limits`.
    ///
    /// h grows with both, so the tolerance binds unless the limits on both do. Along h = tolerance the search is over
    /// f_z alone, with the largest step-over at each f_z.
    ///
    /// # Errors
    /// - [`NoAnswer::StepOverUsesUpTolerance`] if the smallest step-over leaves no feed,
    ///   [`NoAnswer::RunoutUsesUpTolerance`], [`NoAnswer::FeedUsesUpTolerance`];
    /// - [`NoAnswer::ToleranceLimitsNoFeed`], [`NoAnswer::ToleranceLimitsNoStepOver`] if neither the tolerance nor the
    ///   limits bound the feed or the step-over;
    /// - those of [`EvaluatedPass::scallop_height`].
    pub fn fastest(&self, tolerance: Length, limits: &CuttingLimits) -> Result<CuttingParameters, NoAnswer> {
        self.fastest_until(tolerance, limits, &|| false)
    }

    /// [`EvaluatedPass::fastest`], which computes dozens of largest step-overs and asks `stop` before each. Once that returns true, the
    /// search ends, and what it returns is not the answer: the caller discards it.
    ///
    /// # Errors
    /// Those of [`EvaluatedPass::fastest`].
    pub(crate) fn fastest_until(
        &self,
        tolerance: Length,
        limits: &CuttingLimits,
        stop: &dyn Fn() -> bool,
    ) -> Result<CuttingParameters, NoAnswer> {
        let smallest = limits.min_step_over.map_or(Length::computed(Length::SMALLEST), |smallest| smallest);
        let largest_feed = self.largest_feed(tolerance, smallest, limits.max_feed_per_tooth)?;
        let step_over = |feed: f64| self.widest(tolerance, Length::computed(feed), limits.max_step_over);
        let area = |feed: f64| if stop() { 0.0 } else { step_over(feed).map_or(0.0, |step_over| step_over.mm() * feed) };
        let stopped = CuttingParameters { step_over: smallest, feed_per_tooth: largest_feed, limited_by: [None; 4] };

        let count = if self.pass().runout == Runout::NONE { PLACES } else { PLACES_WITH_RUNOUT };
        let ratio = FEED_RANGE.powf(-1.0 / f64::from(count - 1));
        let mut places = [(0.0, 0.0); PLACES_WITH_RUNOUT as usize];
        let places = &mut places[..usize::from(count)];
        for (place, exponent) in places.iter_mut().zip(0..) {
            let feed = largest_feed.mm() * ratio.powi(exponent);
            *place = (feed, area(feed));
        }
        if stop() {
            return Ok(stopped);
        }
        if places.iter().skip(1).all(|(_, area)| *area <= 0.0) {
            // At the largest feed, rounding decides whether the marks use up the tolerance. At the next feed it does
            // not.
            step_over(places[1].0)?;
        }
        let fastest = |best: (f64, f64), next: (f64, f64)| if next.1 > best.1 { next } else { best };
        let mut best = places.iter().copied().fold((largest_feed.mm(), 0.0), fastest);
        // The corner below is no place of the search, and must not keep a maximum between two places from it.
        let best_place = best.1;
        // At the feed from which the largest step-over binds, the product has a corner, which the search would find
        // only approximately.
        if let Some(max_step_over) = limits.max_step_over
            && let Ok(feed) = self.max_feed_per_tooth(tolerance, max_step_over)
        {
            let feed = feed.mm().min(largest_feed.mm());
            best = fastest(best, (feed, area(feed)));
        }
        if self.pass().runout == Runout::NONE {
            let area_at = |place: Option<usize>| place.and_then(|place| places.get(place)).map_or(0.0, |(_, area)| *area);
            for (place, &(feed, here)) in places.iter().enumerate() {
                if here >= NEARLY_BEST * best_place && here >= area_at(place.checked_sub(1)) && here >= area_at(Some(place + 1)) {
                    best = fastest(best, highest(feed * ratio, (feed / ratio).min(largest_feed.mm()), area));
                }
            }
        } else {
            // Two maxima can be neighbours, so that the feeds between them do not show the lower end of either.
            for ends in places.windows(2).filter(|ends| ends[0].1.max(ends[1].1) >= ratio * best_place).take_while(|_| !stop()) {
                let [(high, of_high), (low, of_low)] = [ends[0], ends[1]];
                if let Some(jump) = self.jump_of_step_over(tolerance, [(low, of_low), (high, of_high)]) {
                    best = fastest(best, (jump, area(jump)));
                    best = fastest(best, highest(low, jump, area));
                    best = fastest(best, highest(jump, high, area));
                } else if of_low.max(of_high) >= NEARLY_BEST_WITH_RUNOUT * best_place {
                    best = fastest(best, highest(low, high, area));
                }
            }
        }

        if stop() {
            return Ok(stopped);
        }
        let mut feed_per_tooth = Length::computed(best.0);
        let mut step_over = self.widest(tolerance, feed_per_tooth, limits.max_step_over)?;
        // The largest step-over keeps the tolerance only up to the rounding of its search.
        if self.scallop_height(step_over, Some(feed_per_tooth))?.total() > tolerance {
            step_over = Length::computed((step_over.mm() * (1.0 - 1e-11)).max(smallest.mm()));
        }
        if step_over < smallest {
            // The search over the largest feed ends within a rounding of the smallest step-over.
            step_over = smallest;
        }
        // Beside walls, heights on curved surfaces can fall where the step-over grows, so that a step-over under the largest
        // one can exceed the tolerance.
        if self.scallop_height(step_over, Some(feed_per_tooth))?.total().mm() > tolerance.mm() * (1.0 + REACHED) {
            feed_per_tooth = self.largest_feed(tolerance, step_over, limits.max_feed_per_tooth)?;
        }
        self.with_limits(tolerance, limits, step_over, feed_per_tooth)
    }

    /// The feed from which on the largest step-over is much smaller, between two feeds with their products; `None` where it
    /// falls little. With runout, a sharp edge leaves marks whose height jumps. The product rises up to the jump.
    fn jump_of_step_over(&self, tolerance: Length, [(low, of_low), (high, of_high)]: [(f64, f64); 2]) -> Option<f64> {
        let [widest, narrowest] = [of_low / low, of_high / high];
        if narrowest >= LEAST_FALL * widest {
            return None;
        }
        let between = Length::computed(f64::midpoint(widest, narrowest));
        let feed = self.max_feed_per_tooth(tolerance, between).ok()?.mm() * (1.0 - REACHED);
        (low < feed && feed < high).then_some(feed)
    }

    /// The largest feed per tooth that limits and tolerance allow at a step-over.
    fn largest_feed(&self, tolerance: Length, step_over: Length, limit: Option<Length>) -> Result<Length, NoAnswer> {
        let by_tolerance = match self.max_feed_per_tooth(tolerance, step_over) {
            Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth })
                if limit.is_some_and(|limit| limit <= largest_feed_per_tooth) =>
            {
                largest_feed_per_tooth
            }
            answer => answer?,
        };
        Ok(limit.map_or(by_tolerance, |limit| if limit < by_tolerance { limit } else { by_tolerance }))
    }

    /// The largest step-over at a feed per tooth, at most the stated one.
    fn widest(&self, tolerance: Length, feed: Length, limit: Option<Length>) -> Result<Length, NoAnswer> {
        let widest = match (self.max_step_over(tolerance, Some(feed)), limit) {
            (Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over }), Some(limit)) if limit <= largest_step_over => limit,
            (answer, _) => answer?,
        };
        Ok(limit.map_or(widest, |limit| if limit < widest { limit } else { widest }))
    }

    fn with_limits(
        &self,
        tolerance: Length,
        limits: &CuttingLimits,
        step_over: Length,
        feed_per_tooth: Length,
    ) -> Result<CuttingParameters, NoAnswer> {
        let reached = |value: Length, limit: Length| (value.mm() / limit.mm() - 1.0).abs() <= REACHED;
        let height = self.scallop_height(step_over, Some(feed_per_tooth))?.total();
        let by_feed = limits.max_feed_per_tooth.is_some_and(|limit| reached(feed_per_tooth, limit));
        let by_step_over = limits.max_step_over.is_some_and(|limit| reached(step_over, limit));
        // Unless limits bind both, the tolerance binds one of them, even if the height jumps over the tolerance.
        let by_tolerance = reached(height, tolerance) || !(by_feed && by_step_over);
        let limited_by = [
            by_tolerance.then_some(LimitedBy::ScallopTolerance),
            by_feed.then_some(LimitedBy::MaxFeedPerTooth),
            limits.min_step_over.filter(|limit| reached(step_over, *limit)).map(|_| LimitedBy::MinStepOver),
            by_step_over.then_some(LimitedBy::MaxStepOver),
        ];
        Ok(CuttingParameters { step_over, feed_per_tooth, limited_by })
    }
}

/// The maximum in `[low, high]` of a function with one maximum, as argument and value, by golden-section search in the
/// logarithm.
fn highest(low: f64, high: f64, function: impl Fn(f64) -> f64) -> (f64, f64) {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let (mut low, mut high) = (low.ln(), high.ln());
    let at = |u: f64| (u.exp(), function(u.exp()));
    let (mut left, mut right) = (at(high - GOLDEN * (high - low)), at(low + GOLDEN * (high - low)));
    while high - low > CLOSE {
        if left.1 > right.1 {
            high = right.0.ln();
            (left, right) = (at(high - GOLDEN * (high - low)), left);
        } else {
            low = left.0.ln();
            (left, right) = (right, at(low + GOLDEN * (high - low)));
        }
    }
    if left.1 > right.1 { left } else { right }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::{Contact, Cutter, Model, Pass, SurfaceCurvature};
    use std::cell::Cell;

    #[test]
    fn a_stopped_search_asks_for_no_more_step_overs() {
        let mm = |value: f64| Length::from_mm(value).unwrap();
        let (cutter, contact) = (Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(), Contact::from_degrees(30.0, 20.0).unwrap());
        let pass = Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
        let evaluated = EvaluatedPass::new(Model::Envelope, pass).unwrap();
        let limits = CuttingLimits::new(Some(mm(0.1)), Some(mm(0.01)), None).unwrap();
        let asked = Cell::new(0);
        let stop = || {
            asked.set(asked.get() + 1);
            asked.get() > 3
        };
        let stopped = evaluated.fastest_until(mm(0.01), &limits, &stop).unwrap();
        assert_eq!(stopped.step_over, mm(0.01));
        assert!(asked.get() <= 2 + usize::from(PLACES), "{asked:?}");
        assert!(evaluated.fastest(mm(0.01), &limits).unwrap().step_over > mm(0.1));
    }
}
