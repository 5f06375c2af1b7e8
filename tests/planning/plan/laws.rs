//! Laws of the simulation: planes, turning, refinement, pieces.

use super::surfaces::{Height, facets, placed, published};
use super::{degrees, in_direction, mm, published_cutters, ranked, settings};
use scallopd::milling::Model;
use scallopd::motion::travel_time;
use scallopd::planning::InclinedRectangle;
use scallopd::planning::zigzag::{Directions, ZigzagSettings};
use scallopd::surface::FinishFacet;

/// A rectangle w x h whose long side is level and along X, inclined by the slope in deg, as n x n quads.
fn rectangle(w: f64, h: f64, slope: f64, n: usize) -> Vec<FinishFacet> {
    let (sin, cos) = slope.to_radians().sin_cos();
    let tan = sin / cos;
    facets(&Height { low: [0.0; 2], high: [w, h * cos], surface: |_, y| [tan * y, 0.0, tan, 0.0, 0.0, 0.0] }, n, n)
}

#[test]
fn an_inclined_rectangle_takes_the_time_of_the_published_method() {
    for (w, h, slope, n) in [(56.0, 28.0, 60.0, 1), (56.0, 28.0, 60.0, 30), (80.0, 40.0, 15.0, 40), (40.0, 33.0, 30.0, 7)] {
        let facets = rectangle(w, h, slope, n);
        let by_rectangle = InclinedRectangle::from_sides(mm(w), mm(h)).unwrap();
        for (candidate, direction) in [(0, 90.0), (1, 0.0)] {
            let settings = in_direction(Model::Analytic, direction);
            let cutters = published_cutters();
            let plan = &ranked(&facets, &cutters[candidate..=candidate], &settings).plans[0];
            let radius = if candidate == 0 { 3.0 / slope.to_radians().sin() + 2.0 } else { 5.0 };
            let step_over = mm(2.0 * (2.0 * radius * 0.01 - 0.01 * 0.01_f64).sqrt());
            let limits = settings.machine.limits;
            let expected = if candidate == 0 {
                by_rectangle.up_and_down(step_over, limits)
            } else {
                by_rectangle.along_the_long_side(step_over, limits)
            };
            // One link fewer than passes, and a whole number of passes.
            let tolerance = 0.01 + 1.0 / expected.passes;
            let ratio = plan.time.seconds() / expected.time.seconds();
            assert!((ratio - 1.0).abs() <= tolerance, "{w} x {h} at {slope} deg, cutter {candidate}: {ratio}");
            #[expect(clippy::cast_precision_loss, reason = "hundreds")]
            let passes = plan.planes as f64;
            assert!((passes - expected.passes).abs() <= 1.0, "{passes} passes for {}", expected.passes);
            // With the simulation's number of passes, only the spacings differ, which are in single precision, and the
            // last one, which ends at the border.
            let pass = travel_time(mm(if candidate == 0 { h } else { w }), limits).seconds();
            let link = travel_time(step_over, limits).seconds();
            let own = passes * pass + (passes - 1.0) * link;
            assert!(plan.time.seconds() <= own * (1.0 + 1e-6) && plan.time.seconds() >= own - link, "{} s, {own}", plan.time.seconds());
        }
    }
}

#[test]
fn turning_the_part_turns_the_directions() {
    let original = facets(&published(0), 50, 50);
    let turned = placed(&original, 30.0, [1000.0, -500.0, 77.0]);
    // For the opposite direction of the same line, the planes start from the other border.
    let lines = |offset: f64| Directions::Only((0..36).map(|step| degrees(5.0 * f64::from(step) + offset)).collect());
    for model in [Model::Analytic, Model::Envelope] {
        let of = |facets: &[FinishFacet], offset: f64| {
            let settings = ZigzagSettings { directions: lines(offset), ..settings(model) };
            let ranking = ranked(facets, &published_cutters(), &settings);
            ranking.plans.into_iter().map(|plan| (plan.candidate, plan.direction.degrees(), plan.time.seconds())).collect::<Vec<_>>()
        };
        for (one, other) in of(&original, 0.0).into_iter().zip(of(&turned, 30.0)) {
            assert_eq!(one.0, other.0);
            approx::assert_abs_diff_eq!(other.1 - one.1, 30.0, epsilon = 1e-9);
            // Coordinates of a metre are rounded to 1e-13 and spacings to 6e-8. One pass more or less at a border is
            // 1/100 of the time.
            approx::assert_relative_eq!(one.2, other.2, max_relative = 1e-4);
        }
    }
}

#[test]
fn refining_the_mesh_converges() {
    for (surface, direction) in [(0, 66.97), (1, 0.0), (1, 37.0)] {
        for model in [Model::Analytic, Model::Envelope] {
            let time = |n: usize| {
                let ranking = ranked(&facets(&published(surface), n, n), &published_cutters()[..1], &in_direction(model, direction));
                ranking.plans[0].time.seconds()
            };
            let [coarse, middle, fine] = [20, 60, 120].map(time);
            println!("{model:?} surface {surface}: {coarse:.3} {middle:.3} {fine:.3} s");
            // One pass more or less is 1 in 100.
            assert!((fine / middle - 1.0).abs() < 0.011, "{coarse} {middle} {fine}");
            assert!((middle / coarse - 1.0).abs() < 0.025, "{coarse} {middle} {fine}");
        }
    }
}

#[test]
fn two_pieces_take_the_sum_of_their_runs_and_links() {
    let one = facets(&published(1), 40, 40);
    let settings = in_direction(Model::Analytic, 0.0);
    let cutters = published_cutters();
    let alone = ranked(&one, &cutters[..1], &settings).plans.remove(0);
    // The pieces are beside each other across the passes: each has the same planes as alone.
    let mut beside = one.clone();
    beside.extend(placed(&one, 0.0, [0.0, 100.0, 0.0]));
    let plan = ranked(&beside, &cutters[..1], &settings).plans.remove(0);
    assert_eq!((plan.planes, plan.tour.runs, plan.tour.lifts), (2 * alone.planes, 2 * alone.tour.runs, 1));
    approx::assert_relative_eq!(plan.tour.run_length, 2.0 * alone.tour.run_length, max_relative = 1e-7);
    // Facets moved by 100 mm are rounded to 1e-14, and so are their spacings, which are kept in single precision.
    approx::assert_relative_eq!(plan.time.seconds() - plan.tour.lift_seconds, 2.0 * alone.time.seconds(), max_relative = 1e-7);
    // One behind the other along the passes: the same planes with two runs each. Each piece is machined completely
    // before the next, with one lift between them.
    let mut behind = one.clone();
    behind.extend(placed(&one, 0.0, [100.0, 0.0, 0.0]));
    let plan = ranked(&behind, &cutters[..1], &settings).plans.remove(0);
    assert_eq!((plan.planes, plan.tour.runs, plan.tour.lifts), (alone.planes, 2 * alone.tour.runs, 1));
    approx::assert_relative_eq!(plan.tour.run_length, 2.0 * alone.tour.run_length, max_relative = 1e-7);
    approx::assert_relative_eq!(plan.time.seconds() - plan.tour.lift_seconds, 2.0 * alone.time.seconds(), max_relative = 1e-7);
}
