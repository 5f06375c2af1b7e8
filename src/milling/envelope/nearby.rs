//! The fast search for the ridge of marks with small turns: a few steps to second order, then Newton's method on turned
//! marks.
//!
//! Where the section is convex the second order has one ridge, and near it is that of turned marks. The second order need
//! not be searched to its end then. An answer counts if all marks touch with the corner's round at every step. Over the flat,
//! the distance of turned marks can have several minima along the feed, and slower searches answer.

use super::Envelope;
use super::clearing::Clearing;
use super::newton::{self, End, Lengths, Place, Sought};
use super::section::Pattern;
use super::turned_ridge::{RidgeSearch, TurnedRidge};
use super::turning_marks::TurningMarks;
use crate::quantity::Length;

/// The largest turn, as a share of the slope's sine or cosine: half of that up to which turns are exact.
const SMALL_TURN: f64 = 0.15;

/// The feed's part along the steepest line from which on there is one ridge. Of 470,000 inverses of random contacts that
/// were found here, the heights at six differ from the tolerance, all with parts under 0.01.
const OBLIQUE: f64 = 0.25;

impl Envelope {
    /// Whether a ridge found here is the only one that heights and inverses can find.
    pub(super) fn has_one_ridge(&self) -> bool {
        self.body.along_steepest() >= OBLIQUE
    }

    /// The ridge between passes s apart with a pattern of marks of equal depth; `None` if a slower search has to find it.
    pub(super) fn nearby_height(&self, s: f64, pattern: Pattern) -> Option<TurnedRidge> {
        self.nearby_ridge(Sought::Level, Lengths { level: self.guess(s, pattern), step_over: s, mark_spacing: pattern.spacing })
    }

    /// The feed per tooth under `largest` that leaves the height p between passes s apart, which alone leave
    /// `step_over_height`; `None` if a slower search has to find it.
    pub(super) fn nearby_feed(&self, p: f64, s: f64, step_over_height: f64, largest: f64) -> Option<f64> {
        if self.drop != 0.0 {
            return None;
        }
        let guess = (8.0 * (p - step_over_height) / self.body.bend_along_feed()).sqrt().min(largest);
        let ridge = self.nearby_ridge(Sought::MarkSpacing, Lengths { level: p, step_over: s, mark_spacing: guess })?;
        Some(ridge.lengths.mark_spacing).filter(|feed| (Length::SMALLEST..largest).contains(feed))
    }

    /// The step-over under `largest` that leaves the height p at a pattern of marks; `None` if a slower search has to find
    /// it.
    pub(super) fn nearby_step_over(&self, p: f64, pattern: Pattern, largest: f64) -> Option<f64> {
        let left_by_feed = pattern.spacing * pattern.spacing / 8.0 * self.body.bend_along_feed();
        if !pattern.is_even() || left_by_feed >= p || largest < Length::SMALLEST {
            return None;
        }
        let guess = self.step_over_guess(p - left_by_feed).min(largest);
        let ridge = self.nearby_ridge(Sought::StepOver, Lengths { level: p, step_over: guess, mark_spacing: pattern.spacing })?;
        Some(ridge.lengths.step_over).filter(|step_over| (Length::SMALLEST..largest).contains(step_over))
    }

    /// The ridge whose sought length is a guess in `lengths`.
    fn nearby_ridge(&self, sought: Sought, lengths: Lengths) -> Option<TurnedRidge> {
        if self.body.is_nearly_level() || !self.is_convex_up_to(lengths.level) {
            return None;
        }
        let both = [Clearing::EVEN; 2];
        let place = Place::start(&self.body, lengths.step_over, both, lengths.mark_spacing);
        // Where there can be several ridges, the start decides which one is found, and must not depend on the number of
        // steps to it.
        let end = if self.has_one_ridge() { End::Nearby } else { End::AtRidge };
        let near = newton::solve_from(&self.body, sought, lengths, place, both, end)?;
        let marks = TurningMarks::new(&self.body);
        let search = RidgeSearch::new(&marks);
        let is_small = |ridge: &TurnedRidge| search.share(ridge) <= SMALL_TURN;
        let start = Some(TurnedRidge::of_second_order(&near)).filter(is_small)?;
        let is_valid = |ridge: &TurnedRidge| ridge.is_round && is_small(ridge) && self.is_convex_up_to(ridge.lengths.level);
        search.solve(sought, start).filter(is_valid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::{Contact, Cutter, Pass, Runout, SurfaceCurvature};
    use crate::quantity::Angle;
    use proptest::prelude::*;

    fn mm(value: f64) -> Length {
        Length::from_mm(value.max(Length::SMALLEST)).unwrap()
    }

    /// A toroidal cutter on a surface with radii of curvature from the cutter's own on; `None` if it gouges or if the
    /// surface turns too little to matter.
    fn envelope(outer: f64, ratio: f64, slope: f64, alpha: f64, bends: [f64; 2], turn: f64) -> Option<Envelope> {
        let cutter = Cutter::toroidal(mm(2.0 * outer), mm(ratio * outer)).unwrap();
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        let surface = SurfaceCurvature::from_principal_per_mm(bends.map(|bend| bend / outer), Angle::from_degrees(turn).unwrap());
        let pass = Pass { cutter, contact, surface: surface.unwrap(), runout: Runout::NONE, teeth: None };
        Envelope::new(pass).ok().filter(|envelope| envelope.has_third_order)
    }

    /// Principal curvatures, as shares of the inverse of the cutter's radius.
    fn bends() -> impl Strategy<Value = [f64; 2]> {
        let bend = || (-4.0..0.0_f64, prop_oneof![3 => Just(1.0), 1 => Just(-1.0)]).prop_map(|(log, sign)| sign * 10_f64.powf(log));
        [bend(), bend()]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// The slower searches can end at a higher ridge where the feed is nearly level.
        #[test]
        fn heights_are_those_of_slower_searches(
            outer in 0.25..25.0_f64, ratio in 0.02..0.98_f64, slope in 0.0..90.0_f64, alpha in 0.0..360.0_f64, bends in bends(),
            turn in 0.0..180.0_f64, s in -4.0..-0.15_f64, f in prop_oneof![1 => Just(f64::NEG_INFINITY), 4 => -3.0..-0.4_f64],
        ) {
            let Some(envelope) = envelope(outer, ratio, slope, alpha, bends, turn) else { return Ok(()) };
            let [s, f] = [s, f].map(|log| 10_f64.powf(log) * outer);
            let Some(nearby) = envelope.nearby_height(s, Pattern::even(f)) else { return Ok(()) };
            let Some((lengths, ridge)) = envelope.second_order(s, f) else { return Ok(()) };
            let slower = envelope.turned_level(lengths, ridge);
            let share = nearby.lengths.level / slower - 1.0;
            prop_assert!(share < 1e-10 && (share > -1e-10 || !envelope.has_one_ridge()), "{share}");
        }

        #[test]
        fn heights_confirm_inverses_with_one_ridge(
            outer in 0.25..25.0_f64, ratio in 0.02..0.98_f64, slope in 0.0..90.0_f64, alpha in 0.0..75.0_f64, bends in bends(),
            turn in 0.0..180.0_f64, s in -4.0..-0.15_f64, f in -3.0..-0.4_f64, p in -5.0..-1.0_f64,
        ) {
            let Some(envelope) = envelope(outer, ratio, slope, alpha, bends, turn).filter(Envelope::has_one_ridge) else { return Ok(()) };
            let [s, f, p] = [s, f, p].map(|log| 10_f64.powf(log) * outer);
            let is_confirmed = |s: f64, f: f64| (envelope.turned_height(s, Pattern::even(f)).unwrap() / p - 1.0).abs() < 1e-10;
            if let Some(step_over) = envelope.nearby_step_over(p, Pattern::even(f), envelope.largest_step_over(f)) {
                prop_assert!(is_confirmed(step_over, f));
            }
            let Some(step_over_height) = envelope.turned_height(s, Pattern::even(0.0)) else { return Ok(()) };
            if step_over_height < p && let Some(feed) = envelope.nearby_feed(p, s, step_over_height, envelope.largest_spacing(s)) {
                prop_assert!(is_confirmed(s, feed));
            }
        }
    }
}
