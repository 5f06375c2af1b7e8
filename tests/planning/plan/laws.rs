//! Laws of plans: planes, turning, mirroring, refinement, pieces, directions.

use super::surfaces::{Facet, Height, facets, placed, published};
use super::{degrees, in_direction, mm, published_cutters, ranked, settings};
use scallopd::milling::{Cutter, Model};
use scallopd::motion::travel_time;
use scallopd::planning::InclinedRectangle;
use scallopd::planning::plan::{CandidateCutter, CandidatePlan, Directions, MilledFigures, PlanSettings};

/// A rectangle w x h whose long side is level and along X, inclined by the slope in deg, as n x n quads.
fn rectangle(w: f64, h: f64, slope: f64, n: usize) -> Vec<Facet> {
    let (sin, cos) = slope.to_radians().sin_cos();
    let tan = sin / cos;
    facets(&Height { low: [0.0; 2], high: [w, h * cos], surface: |_, y| [tan * y, 0.0, tan, 0.0, 0.0, 0.0] }, n, n)
}

fn milled(plan: &CandidatePlan) -> MilledFigures {
    plan.milled.unwrap()
}

fn seconds(facets: &[Facet], cutter: Cutter, settings: &PlanSettings) -> f64 {
    let ranking = ranked(facets, &[CandidateCutter::new(cutter)], settings);
    assert_eq!(ranking.plans.len(), 1, "{:?}", ranking.not_ranked);
    milled(&ranking.plans[0]);
    ranking.plans[0].time.seconds()
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
            #[expect(clippy::cast_precision_loss, reason = "hundreds")]
            let passes = milled(plan).lines as f64;
            // The published time has no approach and no retreat, each over the height of the rectangle and 5 mm at most.
            let above = h * slope.to_radians().sin() + 5.0;
            let at_ends = 2.0 * travel_time(mm(above), limits).seconds() / expected.time.seconds();
            let ratio = plan.time.seconds() / expected.time.seconds();
            println!("{w} x {h} at {slope} deg, {n}, cutter {candidate}: {ratio:.4}; {passes} passes for {:.2}", expected.passes);
            // One link fewer than passes, and a whole number of passes.
            let tolerance = 0.01 + 1.0 / expected.passes;
            assert!((-tolerance..=tolerance + at_ends).contains(&(ratio - 1.0)), "{w} x {h} at {slope} deg, cutter {candidate}: {ratio}");
            assert!((passes - expected.passes).abs() <= 1.0, "{passes} passes for {}", expected.passes);
        }
    }
}

#[test]
fn turning_the_part_turns_the_directions() {
    let original = facets(&published(0), 40, 40);
    let turned = placed(&original, 30.0, [1000.0, -500.0, 77.0]);
    for cutter in published_cutters().map(|candidate| candidate.cutter) {
        for direction in [0.0, 84.0, 102.0] {
            let one = seconds(&original, cutter, &in_direction(Model::Envelope, direction));
            let other = seconds(&turned, cutter, &in_direction(Model::Envelope, direction + 30.0));
            println!("{direction} deg: {one:.3} s, turned {other:.3} s");
            // The places on which a plan is judged are drawn anew for the turned part, and move its lines: a pass more or
            // less in each half is 2 in 100.
            assert!((other / one - 1.0).abs() < 0.02, "{direction} deg: {one} s, turned {other} s");
        }
    }
}

#[test]
fn a_mirrored_part_takes_the_same_time_within_1_percent() {
    let original = facets(&published(0), 40, 40);
    let mirrored: Vec<Facet> = original.iter().map(|&[a, b, c]| [a, c, b].map(|[x, y, z]| [-x, y, z])).collect();
    for cutter in published_cutters().map(|candidate| candidate.cutter) {
        for direction in [0.0, 37.0] {
            let one = seconds(&original, cutter, &in_direction(Model::Envelope, direction));
            let other = seconds(&mirrored, cutter, &in_direction(Model::Envelope, (180.0 - direction) % 180.0));
            println!("{direction} deg: {one:.3} s, mirrored {other:.3} s");
            assert!((other / one - 1.0).abs() < 0.01, "{direction} deg: {one} s, mirrored {other} s");
        }
    }
}

#[test]
fn refining_the_mesh_converges() {
    for (surface, direction) in [(0, 66.97), (1, 0.0), (1, 37.0)] {
        for model in [Model::Analytic, Model::Envelope] {
            let time = |n: usize| {
                let cutter = published_cutters()[0].cutter;
                seconds(&facets(&published(surface), n, n), cutter, &in_direction(model, direction))
            };
            let [coarse, middle, fine] = [20, 60, 120].map(time);
            println!("{model:?} surface {surface}: {coarse:.3} {middle:.3} {fine:.3} s");
            // The path is that of the facets. Quads of 0.9 mm are up to 2 um from the surface, a fifth of the scallop
            // height, by which spacings may be 1 - sqrt(0.8) = 0.1 narrower in the worst strips; those of 0.5 mm a quarter
            // of that. So times differ by up to 0.075, if all strips are the worst. One pass more or less is 1 in 100.
            assert!((fine / middle - 1.0).abs() < 0.05, "{coarse} {middle} {fine}");
            assert!((fine - middle).abs() < 0.5 * (middle - coarse).abs() + 0.01 * fine, "{coarse} {middle} {fine}");
        }
    }
}

#[test]
fn two_pieces_take_the_sum_of_their_runs_and_a_lift() {
    let one = facets(&published(1), 40, 40);
    let settings = in_direction(Model::Analytic, 0.0);
    let cutter = published_cutters()[0];
    let alone = ranked(&one, &[cutter], &settings).plans.remove(0);
    for shift in [[0.0, 100.0, 0.0], [100.0, 0.0, 0.0]] {
        let mut both = one.clone();
        both.extend(placed(&one, 0.0, shift));
        let plan = ranked(&both, &[cutter], &settings).plans.remove(0);
        let (tour, of_one) = (milled(&plan).tour, milled(&alone).tour);
        println!("{shift:?}: {tour:?}, alone {of_one:?}");
        assert!(tour.lifts >= 1 && tour.lifts <= 2 * of_one.lifts + 3 && tour.links == tour.runs - 1, "{tour:?}");
        // Each piece is judged on half as many places. A strip is spaced by the worst of its about 200 places: of half as
        // many it is lower by as much as heights vary between the highest hundredth and two hundredths of a strip, a few per
        // cent of the spacing on facets of 1.4 mm.
        approx::assert_relative_eq!(tour.run_length, 2.0 * of_one.run_length, max_relative = 0.05);
        approx::assert_relative_eq!(plan.time.seconds(), 2.0 * alone.time.seconds(), max_relative = 0.05);
    }
}

#[test]
fn a_direction_takes_the_same_time_alone_and_among_others() {
    let facets = facets(&published(1), 30, 30);
    let of = |directions: &[f64]| {
        let directions = Directions::Only(directions.iter().map(|direction| degrees(*direction)).collect());
        ranked(&facets, &published_cutters()[..1], &PlanSettings { directions, ..settings(Model::Envelope) }).plans.remove(0)
    };
    let among = of(&[0.0, 40.0, 90.0, 135.0]);
    let alone = of(&[among.direction.degrees()]);
    assert_eq!((alone.time, alone.milled), (among.time, among.milled));
}

#[test]
fn no_direction_in_the_list_is_faster_than_the_plan() {
    let facets = facets(&published(0), 30, 30);
    for plan in ranked(&facets, &published_cutters(), &settings(Model::Envelope)).plans {
        let own = plan.by_direction.iter().find(|(direction, _)| *direction == plan.direction).unwrap().1.unwrap();
        assert_eq!(own, plan.time);
    }
}

/// The places on which lines are spaced are farther apart here than the cutter is wide: where the lines end must not depend on them.
#[test]
fn lines_reach_the_border_of_a_part_that_is_large_beside_the_cutter() {
    let ball = [CandidateCutter::new(Cutter::ball_end(mm(2.0)))];
    let finish = milled(&ranked(&rectangle(200.0, 133.0, 10.0, 1), &ball, &in_direction(Model::Envelope, 0.0)).plans[0]).finish;
    println!("{finish:?}");
    assert!(finish.far_over_share < 0.003 && finish.max.mm() < 0.02, "{finish:?}");
}
