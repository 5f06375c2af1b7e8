//! Inverses: the height at a largest feed or step-over is the tolerance, and runout's formula and its inverse cancel.

use crate::laws::passes::{BOTH, height, is_settled, mm, passes};
use approx::assert_relative_eq;
use proptest::prelude::*;
use scallopd::milling::{Contact, Cutter, EvaluatedPass, NoAnswer, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::Angle;

/// Asserts that the height at a largest feed or step-over is the tolerance. With runout, the height jumps at the point
/// where the deep marks alone cease to suffice. It can then be below the tolerance, if `more`, the height at an input
/// larger by 1e-9, is above it. Beside concave walls it jumps too, and one of some 1,000 lengths is not the largest,
/// because marks cease to meet; its height is then less by up to 5 %. The tolerance is never exceeded.
fn assert_largest(pass: &Pass, height: f64, more: Result<f64, NoAnswer>, tolerance: f64) {
    let is_beside_wall = pass.surface.principal_per_mm()[1] < 0.0 && pass.contact.slope().degrees() >= 85.0;
    let can_jump = pass.runout != Runout::NONE || is_beside_wall;
    let jumps = height < tolerance && can_jump && more.is_ok_and(|more| more > tolerance);
    let is_smaller = is_beside_wall && height < tolerance && height > 0.95 * tolerance;
    if !(jumps || is_smaller) {
        assert_relative_eq!(height, tolerance, max_relative = 1e-9);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// The height at the largest feed is the tolerance. There is no answer if the tolerance allows no feed or sets no
    /// limit, or if the cutter or the passes do not fit the surface.
    #[test]
    fn the_height_at_the_largest_feed_is_the_tolerance(pass in passes(), step_over in 0.02..1.0_f64, tolerance in 0.001..0.05_f64) {
        for model in BOTH {
            let Ok(evaluated) = EvaluatedPass::new(model, pass) else { continue };
            match evaluated.max_feed_per_tooth(mm(tolerance), mm(step_over)) {
                Ok(feed) if !is_settled(&evaluated, step_over, feed.mm()) => {
                    prop_assert!(height(&evaluated, step_over, feed.mm()).unwrap() <= tolerance * (1.0 + 1e-9));
                }
                Ok(feed) => {
                    let more = height(&evaluated, step_over, feed.mm() * (1.0 + 1e-9));
                    assert_largest(&pass, height(&evaluated, step_over, feed.mm()).unwrap(), more, tolerance);
                }
                Err(NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over }) => {
                    prop_assert!(step_over_height.mm() >= tolerance);
                    let left = height(&evaluated, max_step_over.mm(), 0.0).unwrap();
                    // Elsewhere heights can fall where step-overs grow.
                    if !(is_settled(&evaluated, max_step_over.mm(), 0.0) && is_settled(&evaluated, step_over, 0.0)) {
                        prop_assert!(left <= tolerance * (1.0 + 1e-9));
                        continue;
                    }
                    prop_assert!(max_step_over.mm() <= step_over * (1.0 + 1e-9));
                    assert_largest(&pass, left, height(&evaluated, max_step_over.mm() * (1.0 + 1e-9), 0.0), tolerance);
                }
                Err(NoAnswer::RunoutUsesUpTolerance) => prop_assert!(pass.runout != Runout::NONE),
                Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth }) => {
                    let just_under = largest_feed_per_tooth.mm() * (1.0 - 1e-6);
                    prop_assert!(height(&evaluated, step_over, just_under).is_ok_and(|height| height <= tolerance));
                }
                Err(NoAnswer::PassesDoNotOverlap { largest_step_over }) => prop_assert!(largest_step_over.mm() < step_over),
                Err(NoAnswer::MarksDoNotOverlap { .. } | NoAnswer::Gouges { .. }) => {}
                Err(other) => prop_assert!(false, "{other:?}"),
            }
        }
    }

    #[test]
    fn the_height_at_the_largest_step_over_is_the_tolerance(pass in passes(), feed in prop_oneof![1 => Just(0.0), 3 => 0.01..0.4_f64], tolerance in 0.001..0.05_f64) {
        for model in BOTH {
            let Ok(evaluated) = EvaluatedPass::new(model, pass) else { continue };
            match evaluated.max_step_over(mm(tolerance), (feed > 0.0).then(|| mm(feed))) {
                Ok(step_over) if !is_settled(&evaluated, step_over.mm(), feed) => {
                    prop_assert!(height(&evaluated, step_over.mm(), feed).unwrap() <= tolerance * (1.0 + 1e-9));
                }
                Ok(step_over) => {
                    let more = height(&evaluated, step_over.mm() * (1.0 + 1e-9), feed);
                    assert_largest(&pass, height(&evaluated, step_over.mm(), feed).unwrap(), more, tolerance);
                }
                Err(NoAnswer::FeedUsesUpTolerance { feed_height }) => prop_assert!(feed_height.mm() >= tolerance),
                Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over }) => {
                    let just_under = largest_step_over.mm() * (1.0 - 1e-6);
                    prop_assert!(height(&evaluated, just_under, feed).map_or(true, |height| height <= tolerance));
                }
                Err(NoAnswer::MarksDoNotOverlap { .. } | NoAnswer::Gouges { .. }) => {}
                Err(other) => prop_assert!(false, "{other:?}"),
            }
        }
    }

    /// The side of a flat-end cutter on a nearly level surface is so steep over the surface that heights rise by thousands of
    /// times a step-over's change.
    #[test]
    fn the_side_of_a_flat_end_cutter_keeps_the_tolerance(
        outer in 0.5..20.0_f64, slope in -7.0..0.0_f64, alpha in 0.0..90.0_f64, bends in [-4.0..-1.0_f64, -4.0..-1.0_f64],
        turn in 0.0..180.0_f64, length in -3.0..0.0_f64, tolerance in -4.0..-1.0_f64,
    ) {
        let [length, tolerance, slope] = [length, tolerance, slope].map(|log| 10_f64.powf(log));
        let (length, tolerance) = (length * outer, tolerance * outer);
        let surface = SurfaceCurvature::from_principal_per_mm(bends.map(|bend| 10_f64.powf(bend) / outer), Angle::from_degrees(turn).unwrap());
        let (contact, cutter) = (Contact::from_degrees(slope, alpha).unwrap(), Cutter::flat_end(mm(2.0 * outer)));
        let pass = Pass { cutter, contact, surface: surface.unwrap(), runout: Runout::NONE, teeth: None };
        let evaluated = EvaluatedPass::new(BOTH[1], pass).unwrap();
        let kept = tolerance * (1.0 + 1e-9);
        if let Ok(step_over) = evaluated.max_step_over(mm(tolerance), Some(mm(length))) {
            prop_assert!(height(&evaluated, step_over.mm(), length).unwrap() <= kept);
        }
        if let Ok(feed) = evaluated.max_feed_per_tooth(mm(tolerance), mm(length)) {
            prop_assert!(height(&evaluated, length, feed.mm()).unwrap() <= kept);
        }
    }

    /// The distance between tooth marks and the feed per tooth are inverse to each other. The feed is a difference of
    /// terms. The largest of them is the runout, up to ten times the feed, so that 1e-15 of it is 1e-14 of the feed.
    /// The argument of the square root cancels once more.
    #[test]
    fn the_mark_spacing_with_runout_and_its_inverse_cancel(feed in 0.01..1.0_f64, radial in 0.0..0.1_f64, axial in -0.1..0.1_f64, climb in 0.0..90.0_f64) {
        let runout = Runout::NONE.with_radial_mm(radial).unwrap().with_axial_mm(axial).unwrap();
        let climb = Angle::from_degrees(climb).unwrap();
        let spacing = runout.mark_spacing(mm(feed), climb);
        // If the feed climbs and the next tooth is higher, two feeds have the same spacing, and the larger one is
        // found.
        let least = axial * climb.sin() - radial * climb.cos();
        if feed > least + 0.001 {
            assert_relative_eq!(runout.feed_per_tooth(spacing, climb).unwrap().mm(), feed, max_relative = 1e-11);
        }
    }
}

/// Along a wall the height of the marks does not depend on the step-over: if the marks are too far apart, no step-over
/// keeps the tolerance.
#[test]
fn along_a_wall_marks_over_the_tolerance_leave_no_step_over() {
    let contact = Contact::from_degrees(90.0, 90.0).unwrap();
    let cutter = Cutter::toroidal(mm(1.0), mm(0.025)).unwrap();
    let surface = SurfaceCurvature::PLANE;
    let evaluated = EvaluatedPass::new(BOTH[1], Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None }).unwrap();
    assert!(matches!(evaluated.max_step_over(mm(0.001), Some(mm(0.396))), Err(NoAnswer::FeedUsesUpTolerance { .. })));
}
