//! The fastest step-over and feed per tooth within a tolerance.

use crate::laws::passes::{BOTH, evaluated, height, mm, passes, toroidal};
use approx::assert_relative_eq;
use proptest::prelude::*;
use scallopd::milling::{Contact, Cutter, CuttingLimits, EvaluatedPass, LimitedBy, Model, Pass, Runout, SurfaceCurvature};

fn at_40_deg(cutter: Cutter) -> Pass {
    let contact = Contact::from_degrees(40.0, 30.0).unwrap();
    Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None }
}

#[test]
fn a_ball_end_cutter_has_its_closed_form() {
    let ball = evaluated(Model::Envelope, at_40_deg(Cutter::ball_end(mm(10.0))));
    let fastest = ball.fastest(mm(0.01), &CuttingLimits::NONE).unwrap();
    // s = f_z = sqrt(2 (2 R t - t^2)). Around its maximum the product falls with the square of the feed's error, so the feed is found to
    // the search's 1e-4 only, and the product to 1e-8.
    let side = (2.0 * (2.0 * 5.0 * 0.01 - 0.01 * 0.01_f64)).sqrt();
    assert_relative_eq!(fastest.step_over.mm() * fastest.feed_per_tooth.mm(), side * side, max_relative = 1e-7);
    assert_relative_eq!(fastest.feed_per_tooth.mm(), side, max_relative = 1e-3);
    assert_eq!(fastest.limited_by().collect::<Vec<_>>(), [LimitedBy::ScallopTolerance]);
}

#[test]
fn binding_limits_are_named() {
    let pass = evaluated(Model::Envelope, at_40_deg(toroidal(5.0, 0.4)));
    let limits = |feed, smallest, largest: Option<f64>| CuttingLimits::new(feed, smallest, largest.map(mm)).unwrap();
    let bind = |limits| pass.fastest(mm(0.01), &limits).unwrap().limited_by().collect::<Vec<_>>();
    assert_eq!(bind(limits(Some(mm(0.05)), None, None)), [LimitedBy::ScallopTolerance, LimitedBy::MaxFeedPerTooth]);
    assert_eq!(bind(limits(Some(mm(0.05)), None, Some(0.1))), [LimitedBy::MaxFeedPerTooth, LimitedBy::MaxStepOver]);
    assert_eq!(bind(limits(None, None, Some(0.1))), [LimitedBy::ScallopTolerance, LimitedBy::MaxStepOver]);
    assert_eq!(bind(limits(None, Some(mm(0.65)), None)), [LimitedBy::ScallopTolerance, LimitedBy::MinStepOver]);
    assert!(CuttingLimits::new(None, Some(mm(0.2)), Some(mm(0.1))).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn no_pair_on_a_grid_is_faster(pass in passes(), tolerance in 0.002..0.02_f64, largest_feed in 0.02..0.5_f64) {
        // With runout the product has a second maximum, where deep marks alone begin to clear enough, which the search can miss: docs/envelope-on-curved-surfaces.md.
        let pass = Pass { runout: Runout::NONE, ..pass };
        let limits = CuttingLimits::new(Some(mm(largest_feed)), None, Some(mm(2.0))).unwrap();
        for model in BOTH {
            let Ok(evaluated) = EvaluatedPass::new(model, pass) else { continue };
            let Ok(fastest) = evaluated.fastest(mm(tolerance), &limits) else { continue };
            let (step_over, feed) = (fastest.step_over.mm(), fastest.feed_per_tooth.mm());
            prop_assert!(height(&evaluated, step_over, feed).unwrap() <= tolerance * (1.0 + 1e-12));
            prop_assert!(feed <= largest_feed && step_over <= 2.0);
            for place in 1..=60 {
                let feed_tried = largest_feed * f64::from(place) / 60.0;
                if let Ok(widest) = evaluated.max_step_over(mm(tolerance), Some(mm(feed_tried))) {
                    prop_assert!(widest.mm().min(2.0) * feed_tried <= step_over * feed * (1.0 + 1e-6), "{model:?}: {feed_tried} {widest:?}");
                }
            }
        }
    }
}
