//! Tests of passes without an answer, and of the figures that their errors state.

use super::*;

#[test]
fn passes_and_marks_that_do_not_overlap_seen_from_above_are_errors_with_the_way_out() {
    let envelope = on_plane(cutter(5.0, 0.4), 60.0, 90.0);
    // Seen from above s = 20 mm is 10 mm = 2R at 60 deg.
    let Err(NoAnswer::PassesDoNotOverlap { largest_step_over }) = envelope.scallop_height(mm(20.01), None) else { panic!("an answer") };
    approx::assert_relative_eq!(largest_step_over.mm(), 20.0, max_relative = 1e-14);
    assert!(envelope.scallop_height(largest_step_over, None).unwrap().total().mm().is_finite());
    // Marks 8 mm apart leave 6 mm for the passes, 12 mm along the slope, and the other way round.
    let Err(NoAnswer::MarksDoNotOverlap { largest_mark_spacing }) = envelope.scallop_height(mm(12.0), Some(mm(8.01))) else {
        panic!("an answer")
    };
    approx::assert_relative_eq!(largest_mark_spacing.mm(), 8.0, max_relative = 1e-14);
    assert!(envelope.scallop_height(mm(12.0), Some(largest_mark_spacing)).unwrap().total().mm().is_finite());
}

#[test]
fn a_tolerance_that_is_used_up_or_limits_nothing_is_an_error_with_the_way_out() {
    let envelope = on_plane(cutter(5.0, 0.4), 40.0, 30.0);
    let Err(NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over }) = envelope.max_feed_per_tooth(mm(0.01), mm(0.9)) else {
        panic!("an answer")
    };
    assert_eq!(Ok(step_over_height), envelope.scallop_height(mm(0.9), None).map(|height| height.step_over));
    approx::assert_relative_eq!(envelope.scallop_height(max_step_over, None).unwrap().step_over.mm(), 0.01, max_relative = 1e-12);
    assert!(matches!(envelope.max_step_over(mm(0.001), Some(mm(0.4))), Err(NoAnswer::FeedUsesUpTolerance { .. })));
    assert!(matches!(envelope.max_step_over(mm(100.0), None), Err(NoAnswer::ToleranceLimitsNoStepOver { .. })));
    assert!(matches!(envelope.max_feed_per_tooth(mm(100.0), mm(0.5)), Err(NoAnswer::ToleranceLimitsNoFeed { .. })));
    let wall = on_plane(cutter(5.0, 0.4), 90.0, 90.0);
    assert_eq!(wall.max_step_over(mm(0.01), None), Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: mm(Length::LARGEST) }));
}

#[test]
fn a_concave_surface_that_the_cutter_gouges_is_an_error() {
    let gouges = |radius| Envelope::new(curved(pass(cutter(5.0, 0.4), 40.0, 0.0), radius)).map(|_| ());
    // The feed runs down the slope, and across it the cutter's radius is 3/sin(40 deg) + 2 = 6.667 mm.
    let Err(NoAnswer::Gouges { smallest_radius: Some(smallest) }) = gouges(-6.6) else { panic!("no gouging") };
    approx::assert_relative_eq!(smallest.mm(), 3.0 / 40.0_f64.to_radians().sin() + 2.0, max_relative = 1e-12);
    assert_eq!(gouges(-6.7), Ok(()));
    let floor = Envelope::new(curved(pass(cutter(5.0, 0.4), 0.0, 0.0), -1e6)).map(|_| ());
    assert_eq!(floor, Err(NoAnswer::Gouges { smallest_radius: None }));
}

#[test]
fn beyond_the_longest_step_over_on_a_strongly_curved_surface_there_is_no_height_again() {
    let torus = Cutter::toroidal(mm(49.502), mm(0.132_64)).unwrap();
    let surface = SurfaceCurvature::from_components_per_mm(0.026_87, 0.037_39, -0.006_39).unwrap();
    let envelope = Envelope::new(Pass { surface, ..pass(torus, 38.54, 26.88) }).unwrap();
    // The quadric goes on where the surface, with radii of 24 and 44 mm, does not.
    let heights: Vec<Option<f64>> = (1..=60).map(|s| envelope.at(f64::from(s), 0.0)).collect();
    let count = heights.iter().take_while(|height| height.is_some()).count();
    assert!((25..40).contains(&count), "{count} step-overs have a height");
    assert!(heights[count..].iter().all(Option::is_none), "{heights:?}");
    assert!(heights[..count].is_sorted(), "{heights:?}");
}
