//! The fastest step-over and feed per tooth within a tolerance.

use crate::laws::passes::{BOTH, evaluated, height, is_settled, mm, passes, toroidal};
use approx::assert_relative_eq;
use proptest::prelude::*;
use scallopd::milling::{
    Contact, Cutter, CutterKind, CuttingLimits, EvaluatedPass, LimitedBy, Model, NoAnswer, Pass, Runout, SurfaceCurvature,
};

fn at_40_deg(cutter: Cutter) -> Pass {
    let contact = Contact::from_degrees(40.0, 30.0).unwrap();
    Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None }
}

#[test]
fn a_ball_end_cutter_has_its_closed_form() {
    let ball = evaluated(Model::Envelope, at_40_deg(Cutter::ball_end(mm(10.0))));
    let fastest = ball.fastest(mm(0.01), &CuttingLimits::NONE).unwrap();
    // s = f_z = sqrt(2 (2 R t - t^2)). Near its maximum the product falls with the square of the feed's error, so the
    // feed is only accurate to the search's 1e-4, and the product to 1e-8.
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
        let limits = CuttingLimits::new(Some(mm(largest_feed)), None, Some(mm(2.0))).unwrap();
        for model in BOTH {
            let Ok(evaluated) = EvaluatedPass::new(model, pass) else { continue };
            let Ok(fastest) = evaluated.fastest(mm(tolerance), &limits) else { continue };
            let (step_over, feed) = (fastest.step_over.mm(), fastest.feed_per_tooth.mm());
            prop_assert!(height(&evaluated, step_over, feed).unwrap() <= tolerance * (1.0 + 1e-12));
            prop_assert!(feed <= largest_feed && step_over <= 2.0);
            if !is_settled(&evaluated, step_over, feed) || !is_settled(&evaluated, step_over, largest_feed) {
                continue;
            }
            for place in 1..=60 {
                let feed_tried = largest_feed * f64::from(place) / 60.0;
                if let Ok(widest) = evaluated.max_step_over(mm(tolerance), Some(mm(feed_tried)))
                    && is_settled(&evaluated, widest.mm(), feed_tried)
                {
                    prop_assert!(widest.mm().min(2.0) * feed_tried <= step_over * feed * (1.0 + 1e-6), "{model:?}: {feed_tried} {widest:?}");
                }
            }
        }
    }
}

/// One maximum of the product is that of the deepest tooth's marks alone, the other that of deep and shallow marks;
/// here they are nearly equal. With a sharp edge, the step-over falls to half where the shallow marks begin to count.
#[test]
fn both_maxima_with_runout_are_found() {
    for (teeth, radial, axial) in [(2, 0.0061, -0.0067), (3, 0.0061, -0.0067), (2, 0.003, 0.001), (4, 0.001, 0.002), (6, 0.002, 0.0)] {
        let runout = Runout::NONE.with_radial_mm(radial).unwrap().with_axial_mm(axial).unwrap();
        for alpha in [0.0, 20.0, 55.0, 90.0] {
            let contact = Contact::from_degrees(43.8, alpha).unwrap();
            let tolerances = [0.002, 0.005, 0.008, 0.01, 0.012, 0.015, 0.02].into_iter();
            let cutters = [toroidal(0.5, 0.14), Cutter::flat_end(mm(2.6))].into_iter();
            for (cutter, tolerance) in cutters.flat_map(|cutter| tolerances.clone().map(move |tolerance| (cutter, tolerance))) {
                let pass = Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout, teeth: std::num::NonZeroU32::new(teeth) };
                let envelope = evaluated(Model::Envelope, pass);
                let Ok(fastest) = envelope.fastest(mm(tolerance), &CuttingLimits::NONE) else { continue };
                let found = fastest.step_over.mm() * fastest.feed_per_tooth.mm();
                for place in 1..=200 {
                    let feed = 0.4 * f64::from(place) / 200.0;
                    let area = envelope.max_step_over(mm(tolerance), Some(mm(feed))).map_or(0.0, |widest| widest.mm() * feed);
                    // With a sharp edge the product can have another maximum beside the one that is refined.
                    let missed = if cutter.kind() == CutterKind::FlatEnd { 0.01 } else { 1e-6 };
                    assert!(area <= found * (1.0 + missed), "{area} at {feed}, {fastest:?}, tolerance {tolerance}, {pass:?}");
                }
            }
        }
    }
}

/// Near a wall heights on curved surfaces can fall where the step-over grows, with a warning. A stated largest step-over is
/// then under one that keeps the tolerance, and exceeds it.
#[test]
fn a_largest_step_over_near_a_wall_keeps_the_tolerance() {
    let bend = |along, across, twist| SurfaceCurvature::from_components_per_mm(along, across, twist).unwrap();
    for (cutter, slope, alpha, surface, runout, teeth, tolerance, feed, step_over) in [
        (
            toroidal(1.010_64, 0.2),
            89.802_311,
            90.0,
            bend(0.144_467, 0.018_201_6, 0.142_079),
            [0.001_55, 0.000_342_6],
            6,
            0.009_086_6,
            0.294,
            0.021_384,
        ),
        (
            Cutter::flat_end(mm(3.667_8)),
            89.999_954_2,
            90.0,
            bend(0.031_624_6, 0.017_722_1, -0.114_044),
            [0.0, 0.0],
            4,
            0.000_108_6,
            0.425,
            0.785_5,
        ),
        (
            toroidal(8.028_7, 0.2),
            89.999_999_93,
            180.0,
            bend(2.216e-5, -0.023_911_9, 0.001_983_6),
            [0.0, 0.0],
            2,
            0.000_305_9,
            80.0,
            0.083_36,
        ),
    ] {
        let runout = Runout::NONE.with_radial_mm(runout[0]).unwrap().with_axial_mm(runout[1]).unwrap();
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        let pass = Pass { cutter, contact, surface, runout, teeth: std::num::NonZeroU32::new(teeth) };
        let pass = evaluated(Model::Envelope, pass);
        let fastest = pass.fastest(mm(tolerance), &CuttingLimits::new(Some(mm(feed)), None, Some(mm(step_over))).unwrap()).unwrap();
        let left = height(&pass, fastest.step_over.mm(), fastest.feed_per_tooth.mm()).unwrap();
        assert!(left <= tolerance * (1.0 + 1e-9), "{} of the tolerance, {fastest:?}", left / tolerance);
    }
}

/// Along a wall no step-over leaves a height. Without a largest step-over there is no fastest one.
#[test]
fn without_a_largest_step_over_there_is_no_fastest_along_a_wall() {
    for (cutter, tolerance, smallest) in [
        (Cutter::flat_end(mm(12.962_432_073_597_608)), 0.027_853_027_670_048_557, Some(mm(0.18))),
        (Cutter::ball_end(mm(10.0)), 0.01, None),
        (toroidal(5.0, 0.4), 0.02, Some(mm(0.5))),
    ] {
        let contact = Contact::from_degrees(90.0, 90.0).unwrap();
        let pass = Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
        let found = evaluated(Model::Envelope, pass).fastest(mm(tolerance), &CuttingLimits::new(None, smallest, None).unwrap());
        assert!(matches!(found, Err(NoAnswer::ToleranceLimitsNoStepOver { .. })), "{found:?}");
    }
}

/// The tolerance also binds if the height jumps over it at a larger feed or step-over.
#[test]
fn the_tolerance_is_named_wherever_limits_do_not_bind_both_lengths() {
    let runout = Runout::NONE.with_radial_mm(0.003_522_595_252_865_276_4).unwrap().with_axial_mm(0.003_443_138_659_330_416_8).unwrap();
    let cutter = Cutter::toroidal(mm(13.126_799_813_871_317), mm(0.431_257_225_048_038_4)).unwrap();
    let contact = Contact::from_degrees(0.0, 90.0).unwrap();
    let pass = Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout, teeth: std::num::NonZeroU32::new(2) };
    let limits = CuttingLimits::new(Some(mm(6_366.817_544_471_17 / 16_000.0)), None, None).unwrap();
    let fastest = evaluated(Model::Envelope, pass).fastest(mm(0.005_565_678_660_558_304), &limits).unwrap();
    assert_eq!(fastest.limited_by().collect::<Vec<_>>(), [LimitedBy::ScallopTolerance, LimitedBy::MaxFeedPerTooth]);
}
