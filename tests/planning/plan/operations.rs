//! Plans of several operations and of a rest, milled by the independent simulator.

use super::parts::{cone_on_floor, field, fillet_wall, profile, steps};
use super::referee::{Path, milled};
use super::surfaces::{Facet, placed};
use super::{mm, ranked_on, settings, workpiece};
use scallopd::milling::{Cutter, Model};
use scallopd::planning::plan::{CandidateCutter, FinishFigures, Lines, OperationsPlan, PlanSettings, Ranking, passes, passes_of_all};
use scallopd::planning::{Level, Reason, SurfaceWeakness};
use scallopd::quantity::Time;

fn pocket() -> Vec<Facet> {
    steps(&[0.0, 6.0, 26.0, 32.0], &[0.0, 6.0, 20.0, 26.0], &[&[5.0; 3], &[5.0, 0.0, 5.0], &[5.0; 3]])
}

fn several(most_operations: usize, max_uncut_share: f64) -> PlanSettings {
    PlanSettings { most_operations, max_uncut_share, ..settings(Model::Envelope) }
}

/// The plan of several operations, which must keep what it states, and the time of the best one alone.
fn planned(facets: &[Facet], cutters: &[Cutter], settings: &PlanSettings) -> (OperationsPlan, Ranking) {
    let part = workpiece(facets);
    let candidates: Vec<_> = cutters.iter().map(|cutter| CandidateCutter::new(*cutter)).collect();
    let ranking = ranked_on(&part, &candidates, settings);
    let plan = ranking.operations.clone().unwrap();
    let path = passes_of_all(&part, &plan, settings, &|| false);
    assert_eq!(path.points.len(), plan.points());
    assert_eq!(path.run_starts.len(), path.operations.len());
    let ends = path.operation_starts.iter().skip(1).copied().chain([path.points.len()]);
    let paths: Vec<_> = path
        .operation_starts
        .iter()
        .zip(ends)
        .zip(&plan.operations)
        .map(|((from, to), operation)| Path { cutter: cutters[operation.candidate], points: &path.points[*from..to] })
        .collect();
    let verdict = milled(facets, &paths, &plan.finish);
    println!("{verdict}, {:.1} s in {} operations", plan.time.seconds(), plan.operations.len());
    assert!(verdict.is_kept(), "{verdict}");
    // The times of the operations and of the tool changes are the plan's.
    let operations: f64 = plan.operations.iter().map(|operation| operation.figures.tour.seconds).sum();
    #[expect(clippy::cast_precision_loss, reason = "one or two")]
    let changes = plan.tool_changes as f64 * settings.machine.change_time().seconds();
    assert!((plan.time.seconds() - operations - changes).abs() < 1e-9);
    (plan, ranking)
}

#[test]
fn a_cone_is_cut_along_its_levels_and_its_floor_to_and_fro() {
    let cutters = [Cutter::toroidal(mm(6.0), mm(1.0)).unwrap()];
    let (plan, ranking) = planned(&cone_on_floor(32.0, [12.0, 16.0], [9.0, 6.0, 5.0]), &cutters, &several(2, 0.1));
    assert!(plan.operations.iter().any(|operation| operation.lines == Lines::Waterline));
    let [plan, single] = [plan.time.seconds(), ranking.plans[0].time.seconds()];
    assert!(plan < 0.75 * single, "{plan} s beside {single} s");
}

/// The flat end on the floor would reach the corner at the cone's foot, which the ball on the cone cannot. As the flat end does
/// not machine the cone, the corner stays, and counts as uncut.
#[test]
fn a_place_counts_as_reached_only_where_an_operation_machines_it() {
    let cutters = [Cutter::ball_end(mm(6.0)), Cutter::flat_end(mm(6.0))];
    let settings = several(2, 0.3);
    let part = workpiece(&cone_on_floor(32.0, [12.0, 16.0], [9.0, 6.0, 5.0]));
    let candidates = cutters.map(CandidateCutter::new);
    let ranking = ranked_on(&part, &candidates, &settings);
    let plan = ranking.operations.unwrap();
    let lines_of = |index: usize| plan.operations.iter().find(|operation| operation.candidate == index).map(|operation| operation.lines);
    assert_eq!(lines_of(0), Some(Lines::Waterline));
    assert!(matches!(lines_of(1), Some(Lines::Zigzag(_))));
    assert!(plan.finish.over_tolerance_share < 0.005 && plan.finish.uncut_share > 0.005);
    assert!(plan.time.seconds() < ranking.plans[0].time.seconds());
}

#[test]
fn what_a_large_cutter_leaves_of_a_turned_pocket_is_left_to_a_small_one() {
    let cutters = [Cutter::flat_end(mm(8.0)), Cutter::flat_end(mm(3.0))];
    let mut settings = several(3, 0.01);
    settings.machine.tool_change = Time::from_s(0.0).unwrap();
    let (plan, ranking) = planned(&placed(&pocket(), 17.3, [0.0; 3]), &cutters, &settings);
    assert_eq!((plan.tool_changes, plan.operations.last().unwrap().candidate), (1, 1));
    let (rests, of_slopes): (Vec<_>, Vec<_>) = plan.operations.iter().partition(|operation| operation.after.is_some());
    assert_eq!(rests.len(), 1);
    assert!((of_slopes.iter().map(|operation| operation.area_share).sum::<f64>() - 1.0).abs() < 0.05);
    assert!(plan.time.seconds() < ranking.plans[0].time.seconds());
}

#[test]
fn a_rest_is_what_the_cutter_before_cannot_reach() {
    let facets = pocket();
    let part = workpiece(&facets);
    let (large, small) = (Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(), Cutter::flat_end(mm(3.0)));
    let alone = ranked_on(&part, &[CandidateCutter::new(large)], &several(1, 1.0));
    let rest_settings = PlanSettings { rest_of: Some(large), ..several(1, 0.01) };
    let rest = ranked_on(&part, &[CandidateCutter::new(small)], &rest_settings);
    let share = rest.rest_share.unwrap();
    // Of 4,000 places, three standard errors are 0.017.
    assert!((share - alone.plans[0].uncut_share).abs() < 0.02, "{share} and {}", alone.plans[0].uncut_share);
    // A rest takes less time than everything does.
    let whole = ranked_on(&part, &[CandidateCutter::new(small)], &several(1, 0.01));
    assert!(rest.plans[0].time.seconds() < 0.8 * whole.plans[0].time.seconds());
    let [first, second] =
        [passes(&part, &alone.plans[0], &several(1, 1.0), &|| false), passes(&part, &rest.plans[0], &rest_settings, &|| false)];
    let (first, second) = (first.unwrap(), second.unwrap());
    let paths = [Path { cutter: large, points: &first.points }, Path { cutter: small, points: &second.points }];
    let [of_alone, of_rest, of_whole] = [&alone, &rest, &whole].map(|ranking| ranking.plans[0].milled.unwrap().finish);
    let deeper = if of_alone.gouge.mm() > of_rest.gouge.mm() { of_alone.gouge } else { of_rest.gouge };
    let verdict = milled(&facets, &paths, &FinishFigures { gouge: deeper, ..of_whole });
    assert!(verdict.is_kept(), "{verdict}");
}

/// How far a strip is off a cylinder depends on its width alone, not on its length. A ball hardly larger than the groove leaves far
/// more than that.
#[test]
fn a_groove_of_long_strips_is_a_rest_and_no_coarse_mesh() {
    let (radius, half) = (2.8, 60.0_f64.to_radians());
    let arc = (0..=24).map(|step| half * (f64::from(step) / 12.0 - 1.0));
    let bottom = arc.map(|angle| [radius * (half.sin() + angle.sin()) + 4.0, radius * (half.cos() - angle.cos())]);
    let points: Vec<[f64; 2]> = [[0.0, 0.0]].into_iter().chain(bottom).chain([[2.0 * radius * half.sin() + 8.0, 0.0]]).collect();
    let part = workpiece(&profile(&points, 40.0));
    let (before, small) = (Cutter::ball_end(mm(6.0)), Cutter::ball_end(mm(3.0)));
    let alone = ranked_on(&part, &[CandidateCutter::new(before)], &several(1, 1.0));
    let rest = ranked_on(&part, &[CandidateCutter::new(small)], &PlanSettings { rest_of: Some(before), ..several(1, 0.05) });
    let [share, uncut] = [rest.rest_share.unwrap(), alone.plans[0].uncut_share];
    assert!(uncut > 0.2 && (share - uncut).abs() < 0.1 * uncut, "{share} of the area beside {uncut}");
    let is_coarse = |reason: &Reason<SurfaceWeakness>| reason.weakness == SurfaceWeakness::CoarseTessellation && reason.level == Level::Low;
    assert!(!rest.confidence.unwrap().reasons().iter().any(is_coarse));
}

#[test]
fn nothing_is_left_where_the_cutter_before_reaches_everything() {
    let part = workpiece(&super::parts::plate([30.0, 20.0], 25.0));
    let ball = Cutter::ball_end(mm(6.0));
    let ranking = ranked_on(&part, &[CandidateCutter::new(ball)], &PlanSettings { rest_of: Some(ball), ..several(1, 0.01) });
    assert_eq!(ranking.rest_share, Some(0.0));
    assert!(ranking.plans.is_empty() && ranking.not_ranked.is_empty());
}

#[test]
fn the_tightest_hollow_is_the_fillet() {
    let radius = workpiece(&field([34.0, 20.0], 0.25, fillet_wall)).smallest_concave_radius().unwrap().mm();
    assert!((radius - 6.0).abs() < 0.9, "{radius}");
    assert_eq!(workpiece(&pocket()).smallest_concave_radius(), Some(scallopd::quantity::Length::ZERO));
    assert_eq!(workpiece(&super::parts::plate([30.0, 20.0], 25.0)).smallest_concave_radius(), None);
}
