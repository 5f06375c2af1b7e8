//! The order of the candidates, those without a plan, and the confidence.

use super::parts::{field, fillet_wall, plate, profile, steps};
use super::surfaces::{Facet, Height, facets, placed, published, quadrilateral};
use super::{drive, in_direction, mm, published_cutters, ranked, ranked_on, settings, workpiece};
use scallopd::milling::{Cutter, Model};
use scallopd::motion::Machine;
use scallopd::planning::plan::{CandidateCutter, CandidatePlan, MilledFigures, NotRankedReason, Pattern, PlanSettings, rank};
use scallopd::planning::{Level, SurfaceEvidence, SurfaceWeakness};
use std::sync::atomic::{AtomicUsize, Ordering};

fn milled(plan: &CandidatePlan) -> MilledFigures {
    plan.milled.unwrap()
}

fn level(n: usize) -> Vec<Facet> {
    facets(&Height { low: [0.0; 2], high: [50.0, 40.0], surface: |_, _| [3.0, 0.0, 0.0, 0.0, 0.0, 0.0] }, n, n)
}

#[test]
fn candidates_are_sorted_by_time_and_never_under_their_bound() {
    let facets = facets(&published(1), 40, 40);
    let mut candidates = published_cutters().to_vec();
    candidates.push(CandidateCutter::new(Cutter::ball_end(mm(4.0))));
    candidates.push(CandidateCutter::new(Cutter::toroidal(mm(12.0), mm(1.0)).unwrap()));
    let ranking = ranked(&facets, &candidates, &settings(Model::Envelope));
    assert_eq!((ranking.plans.len(), ranking.not_ranked.len()), (4, 0));
    let (milled, estimated): (Vec<_>, Vec<_>) = ranking.plans.iter().partition(|plan| plan.milled.is_some());
    for plans in [&milled, &estimated] {
        assert!(plans.is_sorted_by(|a, b| a.time.seconds() <= b.time.seconds()));
    }
    // Those that are far behind are not milled, and come last.
    assert!(ranking.plans.is_sorted_by_key(|plan| plan.milled.is_none()));
    assert!(estimated.iter().all(|plan| plan.time.seconds() > 1.2 * milled[0].time.seconds()));
    for plan in &ranking.plans {
        assert!(plan.least_time.seconds() < plan.time.seconds());
        assert!(plan.by_direction.len() >= 40 && plan.by_direction.is_sorted_by(|a, b| a.0.radians() < b.0.radians()));
    }
    for figures in milled.iter().filter_map(|plan| plan.milled) {
        let spacing = figures.step_over;
        assert!(spacing.min.mm() <= spacing.median.mm() && spacing.median.mm() <= spacing.max.mm());
        assert!(figures.layout_ratio >= 1.0, "{figures:?}");
    }
    // A small ball is the slowest.
    assert_eq!(ranking.plans[3].candidate, 2);
}

#[test]
fn a_level_surface_is_planned_and_no_spacing_exceeds_the_cutter() {
    for model in [Model::Analytic, Model::Envelope] {
        let ranking = ranked(&level(20), &published_cutters(), &settings(model));
        // The flat of the torus clears almost the cutter's width, in the analytic model all of it.
        let torus = &ranking.plans[0];
        let widest = if model == Model::Analytic { 10.0 } else { 6.0 + 2.0 * (0.04_f64 - 0.0001).sqrt() };
        assert_eq!(torus.candidate, 0);
        let spacing = milled(torus).step_over;
        println!("{model:?}: {spacing:?}, {:?}", milled(torus).finish);
        assert!(spacing.max.mm() <= widest + 1e-9 && milled(torus).finish.far_over_share <= 0.005, "{spacing:?}");
    }
}

/// Lines across stairs stop at every wall; the estimates of directions have to know.
#[test]
fn lines_follow_walls_at_which_others_stop() {
    let stairs: Vec<[f64; 1]> = (0..8).map(|step| [2.0 * f64::from(step)]).collect();
    let heights: Vec<&[f64]> = stairs.iter().map(<[f64; 1]>::as_slice).collect();
    let xs: Vec<f64> = (0..=8).map(|edge| 8.0 * f64::from(edge)).collect();
    let facets = placed(&steps(&xs, &[0.0, 40.0], &heights), 20.0, [0.0; 3]);
    let cutter = [CandidateCutter::new(Cutter::toroidal(mm(6.0), mm(1.0)).unwrap())];
    let [any, across] = [settings(Model::Envelope), in_direction(Model::Envelope, 20.0)].map(|settings| {
        // The corner of the cutter does not reach the feet of the walls.
        ranked(&facets, &cutter, &PlanSettings { max_uncut_share: 0.5, ..settings }).plans
    });
    let (best, across) = (&any[0], &across[0]);
    println!("{:?} in {:?}, across {:?}", best.time, best.direction, across.time);
    assert!((best.direction.degrees() - 110.0).abs() < 5.0 && best.time.seconds() < 0.8 * across.time.seconds());
}

/// Whole lines along a filleted wall are as fast as those over it. Of the latter the floor and the top need only a part, which the
/// times of whole lines do not tell.
#[test]
fn the_direction_with_the_fastest_lines_in_part_is_found() {
    let part = workpiece(&field([40.0, 40.0], 0.4, fillet_wall));
    let cutter = [CandidateCutter::new(Cutter::toroidal(mm(6.0), mm(1.0)).unwrap())];
    let time = |settings: PlanSettings| ranked_on(&part, &cutter, &settings).plans[0].time.seconds();
    let [along, over] = [90.0, 0.0].map(|direction| time(in_direction(Model::Envelope, direction)));
    let any = time(settings(Model::Envelope));
    println!("{any} s, along the wall {along} s, over it {over} s");
    assert!(over < 0.9 * along && any < 1.05 * over);
}

/// What a cutter takes does not depend on the cutters that it is asked with: one direction that is behind tells nothing of the others.
#[test]
fn a_cutter_asked_with_others_has_the_plan_that_it_has_alone() {
    let part = workpiece(&field([40.0, 40.0], 0.4, fillet_wall));
    let cutters = [Cutter::flat_end(mm(6.0)), Cutter::toroidal(mm(6.0), mm(1.0)).unwrap()].map(CandidateCutter::new);
    let settings = settings(Model::Envelope);
    // At the feet of the fillets the flat end stands away from the wall.
    let together = ranked_on(&part, &cutters, &settings).plans;
    assert_eq!(together.len(), 2);
    for plan in &together {
        let alone = ranked_on(&part, &cutters[plan.candidate..=plan.candidate], &settings).plans[0].time.seconds();
        println!("cutter {}: {:?} together, {alone} s alone", plan.candidate, plan.time);
        assert!(plan.time.seconds() < 1.02 * alone);
    }
}

#[test]
fn cutters_that_do_not_reach_are_not_ranked() {
    // Grooves of 4 mm between plates of 6 mm, 3 mm deep.
    let steps = (0..5).map(|step| 10.0 * f64::from(step)).flat_map(|x| [[x, x + 6.0, 3.0], [x + 6.0, x + 10.0, 0.0]]);
    let level = |[from, to, z]: [f64; 3]| quadrilateral([[from, 0.0, z], [to, 0.0, z], [to, 30.0, z], [from, 30.0, z]]);
    let facets: Vec<Facet> = steps.flat_map(level).collect();
    let candidates = [Cutter::flat_end(mm(10.0)), Cutter::flat_end(mm(3.0))].map(CandidateCutter::new);
    let ranking = ranked(&facets, &candidates, &in_direction(Model::Envelope, 90.0));
    assert_eq!((ranking.not_ranked.len(), ranking.not_ranked[0].candidate), (1, 0));
    let NotRankedReason::CannotReach { uncut_share, uncut_height } = ranking.not_ranked[0].reason else { panic!("{ranking:?}") };
    // All floors but the last, beside which nothing stands: 4 of 5 grooves with 0.4 of the area. The standard error of a
    // share of 4,000 places is 0.8 %, and that of half of the last floor.
    assert!((0.3..0.42).contains(&uncut_share) && (uncut_height.mm() - 3.0).abs() < 1e-6, "{uncut_share} {uncut_height:?}");
    assert_eq!(ranking.plans[0].candidate, 1);
}

#[test]
fn a_flat_end_along_the_level_line_has_no_step_over() {
    let slope = facets(&Height { low: [0.0; 2], high: [50.0, 40.0], surface: |_, y| [0.5 * y, 0.0, 0.5, 0.0, 0.0, 0.0] }, 4, 4);
    let flat = [CandidateCutter::new(Cutter::flat_end(mm(10.0)))];
    let ranking = ranked(&slope, &flat, &in_direction(Model::Analytic, 0.0));
    assert_eq!(ranking.not_ranked[0].reason, NotRankedReason::NoStepOver);
    assert!(ranking.confidence.is_none());
    assert_eq!(ranked(&slope, &flat, &in_direction(Model::Envelope, 90.0)).plans.len(), 1);
}

#[test]
fn a_part_without_facets_to_machine_has_no_plan() {
    // A wall alone.
    let wall = quadrilateral([[0.0; 3], [20.0, 0.0, 0.0], [20.0, 0.0, 10.0], [0.0, 0.0, 10.0]]);
    let ranking = ranked(&wall, &published_cutters(), &settings(Model::Envelope));
    assert_eq!((ranking.plans.len(), ranking.not_ranked.len()), (0, 2));
}

#[test]
fn one_way_returns_over_the_clearance_height_after_every_run() {
    let settings = in_direction(Model::Envelope, 0.0);
    let one_way = PlanSettings { pattern: Pattern::OneWay, ..settings.clone() };
    let facets = facets(&published(1), 30, 30);
    for cutter in published_cutters() {
        let [zigzag, one_way] = [&settings, &one_way].map(|settings| ranked(&facets, &[cutter], settings).plans.remove(0));
        let tour = milled(&one_way).tour;
        assert_eq!((tour.lifts, tour.links), (tour.runs - 1, tour.runs - 1));
        assert!(one_way.time.seconds() > zigzag.time.seconds());
    }
}

#[test]
fn feed_marks_narrow_the_spacing_and_slow_teeth_the_feed() {
    let facets = facets(&published(1), 30, 30);
    let settings = in_direction(Model::Envelope, 0.0);
    for cutter in published_cutters() {
        let driven = CandidateCutter { drive: Some(drive(2, 10_000.0)), ..cutter };
        let [alone, with_marks] = [cutter, driven].map(|cutter| milled(&ranked(&facets, &[cutter], &settings).plans[0]));
        assert!(with_marks.step_over.median < alone.step_over.median);
        // 5000 mm/min over 2 teeth at 10,000 rev/min.
        assert!(with_marks.feed_per_tooth.unwrap().mm() <= 0.25 + 1e-12);
        assert!(with_marks.finish.far_over_share < 0.005, "{:?}", with_marks.finish);
        let slow = CandidateCutter { drive: Some(drive(1, 1000.0)), ..cutter };
        let slow = milled(&ranked(&facets, &[slow], &settings).plans[0]);
        // The machine allows 5 mm per tooth; the scallop height allows about the step-over itself.
        let feed = slow.feed_per_tooth.unwrap().mm();
        assert!(feed > 0.1 && feed < 0.8, "{feed}");
        approx::assert_relative_eq!(slow.feed_rate.mm_min(), 1000.0 * feed, max_relative = 1e-12);
    }
}

#[test]
fn confidence_lists_the_weaknesses() {
    let part = workpiece(&facets(&published(1), 80, 80));
    let settings = in_direction(Model::Envelope, 0.0);
    let confidence = |evidence| rank(&part, &published_cutters(), &settings, evidence, &|| false).unwrap().confidence.unwrap();
    let sound = confidence(SurfaceEvidence::default());
    assert_eq!((sound.level(), sound.reasons()), (Level::High, &[][..]));
    let doubtful = confidence(SurfaceEvidence { hidden_area_share: 0.3, pieces: 2, ..SurfaceEvidence::default() });
    let weaknesses: Vec<_> = doubtful.reasons().iter().map(|reason| (reason.weakness, reason.level)).collect();
    assert_eq!(weaknesses, [(SurfaceWeakness::HiddenArea, Level::Low), (SurfaceWeakness::SeveralPieces, Level::Moderate)]);
}

#[test]
fn runs_over_ribs_are_named_where_the_control_does_not_look_ahead() {
    let ribs = profile(&[[0.0, 0.0], [6.0, 0.0], [6.8, 4.0], [11.2, 4.0], [12.0, 0.0], [18.0, 0.0], [18.8, 4.0], [24.0, 4.0]], 20.0);
    let ball = [CandidateCutter::new(Cutter::ball_end(mm(4.0)))];
    let across = PlanSettings { max_uncut_share: 1.0, ..in_direction(Model::Envelope, 0.0) };
    let reasons = |facets: &[Facet], settings: &PlanSettings| {
        let confidence = ranked(facets, &ball, settings).confidence.unwrap();
        confidence.reasons().iter().find(|reason| reason.weakness == SurfaceWeakness::SharpCorners).map(|reason| reason.figure)
    };
    // Each line climbs and falls, with a stop at the foot of each wall.
    assert!(reasons(&ribs, &across).unwrap() > 1.5);
    assert_eq!(reasons(&plate([30.0, 20.0], 25.0), &across), None);
    let machine = Machine { path_tolerance: Some(mm(0.01)), ..across.machine };
    assert_eq!(reasons(&ribs, &PlanSettings { machine, ..across }), None);
}

#[test]
fn a_cancelled_ranking_ends_early() {
    let part = workpiece(&facets(&published(1), 30, 30));
    let settings = in_direction(Model::Envelope, 0.0);
    let asked_until = |stopped_at: usize| {
        let asked = AtomicUsize::new(0);
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= stopped_at;
        let ranking = rank(&part, &published_cutters(), &settings, SurfaceEvidence::default(), &stop);
        (ranking.is_some(), asked.into_inner())
    };
    let (is_whole, in_all) = asked_until(usize::MAX);
    assert!(is_whole && in_all > 200, "{in_all}");
    for stopped_at in [0, 1, 10, in_all / 2, in_all - 10] {
        let (is_whole, asked) = asked_until(stopped_at);
        assert!(!is_whole, "stopped at {stopped_at} of {in_all}");
        // After the cancellation the flag is checked once for each step that would have started: for two cutters up to
        // 20,000 places and 4,000 for the estimate.
        let afterwards = asked - stopped_at;
        assert!(afterwards <= 60_000, "{afterwards} checks after the cancellation at {stopped_at}");
    }
}
