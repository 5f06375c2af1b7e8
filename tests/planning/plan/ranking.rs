//! The order of the candidates, those without a plan, and the confidence.

use super::surfaces::{Height, facets, published};
use super::{drive, in_direction, mm, published_cutters, ranked, settings};
use scallopd::milling::{Cutter, Model};
use scallopd::planning::Level;
use scallopd::planning::zigzag::{
    CandidateCutter, NoRanking, NotRankedReason, Pattern, PlanRoom, ReachFigures, SurfaceEvidence, SurfaceWeakness, ZigzagSettings, rank,
    rank_within,
};
use scallopd::surface::FinishFacet;
use std::sync::atomic::{AtomicUsize, Ordering};

fn level(n: usize) -> Vec<FinishFacet> {
    facets(&Height { low: [0.0; 2], high: [50.0, 40.0], surface: |_, _| [3.0, 0.0, 0.0, 0.0, 0.0, 0.0] }, n, n)
}

#[test]
fn candidates_are_sorted_by_time_and_never_under_their_bound() {
    let facets = facets(&published(1), 50, 50);
    let mut candidates = published_cutters().to_vec();
    candidates.push(CandidateCutter::new(Cutter::ball_end(mm(4.0))));
    candidates.push(CandidateCutter::new(Cutter::toroidal(mm(12.0), mm(1.0)).unwrap()));
    for model in [Model::Analytic, Model::Envelope] {
        let ranking = ranked(&facets, &candidates, &settings(model));
        assert_eq!((ranking.plans.len(), ranking.not_ranked.len()), (4, 0));
        assert!(ranking.plans.is_sorted_by(|a, b| a.time.seconds() <= b.time.seconds()));
        for plan in &ranking.plans {
            assert!(plan.least_time.seconds() < plan.time.seconds());
            assert!(plan.step_over.min.mm() <= plan.step_over.median.mm() && plan.step_over.median.mm() <= plan.step_over.max.mm());
            assert!(plan.by_direction.len() >= 40 && plan.by_direction.is_sorted_by(|a, b| a.0.radians() < b.0.radians()));
        }
        // A small ball is the slowest.
        assert_eq!(ranking.plans[3].candidate, 2);
    }
}

#[test]
fn a_level_surface_is_planned_and_no_spacing_exceeds_the_cutter() {
    for model in [Model::Analytic, Model::Envelope] {
        let ranking = ranked(&level(20), &published_cutters(), &settings(model));
        // The flat of the torus clears almost the cutter's width, in the analytic model all of it.
        let torus = &ranking.plans[0];
        let widest = if model == Model::Analytic { 10.0 } else { 6.0 + 2.0 * (0.04_f64 - 0.0001).sqrt() };
        assert_eq!(torus.candidate, 0);
        assert!(torus.step_over.max.mm() <= widest + 1e-9 && torus.step_over.max.mm() > 0.9 * widest, "{:?}", torus.step_over);
    }
}

#[test]
fn cutters_that_do_not_reach_are_not_ranked() {
    let mut candidates = published_cutters();
    let reach = ReachFigures { uncut_share: 0.12, uncut_height: mm(0.4), uncut_height_error: mm(0.1) };
    candidates[0].reach = Some(reach);
    candidates[1].reach = Some(ReachFigures { uncut_share: 0.004, uncut_height: mm(0.02), uncut_height_error: mm(0.1) });
    let ranking = ranked(&level(10), &candidates, &settings(Model::Envelope));
    assert_eq!(ranking.not_ranked.len(), 1);
    assert_eq!((ranking.not_ranked[0].candidate, ranking.not_ranked[0].reason), (0, NotRankedReason::CannotReach(reach)));
    assert!(matches!(ranking.not_ranked[0].reason, NotRankedReason::CannotReach(_)));
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
fn a_surface_without_facets_has_no_plan() {
    let ranking = ranked(&[], &published_cutters(), &settings(Model::Envelope));
    assert_eq!((ranking.plans.len(), ranking.not_ranked.len()), (0, 2));
}

#[test]
fn one_way_returns_over_the_clearance_height_after_every_run() {
    let settings = in_direction(Model::Envelope, 0.0);
    let one_way = ZigzagSettings { pattern: Pattern::OneWay, ..settings.clone() };
    let facets = facets(&published(1), 30, 30);
    let (both, one) = (ranked(&facets, &published_cutters(), &settings), ranked(&facets, &published_cutters(), &one_way));
    for (zigzag, one_way) in both.plans.iter().zip(&one.plans) {
        assert_eq!((one_way.tour.lifts, one_way.tour.links), (one_way.tour.runs - 1, one_way.tour.runs - 1));
        assert!(one_way.time.seconds() > zigzag.time.seconds());
    }
}

#[test]
fn feed_marks_narrow_the_spacing_and_slow_teeth_the_feed() {
    let facets = facets(&published(1), 30, 30);
    let settings = in_direction(Model::Envelope, 0.0);
    let mut driven = published_cutters();
    for candidate in &mut driven {
        candidate.drive = Some(drive(2, 10_000.0));
    }
    let (alone, with_marks) = (ranked(&facets, &published_cutters(), &settings), ranked(&facets, &driven, &settings));
    for plan in &with_marks.plans {
        let other = alone.plans.iter().find(|other| other.candidate == plan.candidate).unwrap();
        assert!(plan.step_over.median < other.step_over.median);
        // 5000 mm/min over 2 teeth at 10,000 rev/min.
        assert!(plan.feed_per_tooth.unwrap().mm() <= 0.25 + 1e-12);
        assert!(plan.scallop_height.over_tolerance_share < 0.02, "{:?}", plan.scallop_height);
    }
    let mut slow = published_cutters();
    for candidate in &mut slow {
        candidate.drive = Some(drive(1, 1000.0));
    }
    for plan in ranked(&facets, &slow, &settings).plans {
        // The machine allows 5 mm per tooth; the scallop height allows about the step-over itself.
        let feed = plan.feed_per_tooth.unwrap().mm();
        assert!(feed > 0.1 && feed < 0.8, "{feed}");
        approx::assert_relative_eq!(plan.feed_rate.mm_min(), 1000.0 * feed, max_relative = 1e-12);
    }
}

#[test]
fn confidence_lists_the_weaknesses() {
    let facets = facets(&published(1), 80, 80);
    let ranking = ranked(&facets, &published_cutters(), &settings(Model::Envelope));
    let confidence = ranking.confidence.unwrap();
    assert_eq!((confidence.level(), confidence.reasons()), (Level::High, &[][..]));
    let evidence = SurfaceEvidence { hidden_area_share: 0.3, pieces: 2, turned_area_share: 0.0 };
    let confidence = rank(&facets, &published_cutters(), &settings(Model::Envelope), evidence, &|| false).unwrap().confidence.unwrap();
    let weaknesses: Vec<_> = confidence.reasons().iter().map(|reason| (reason.weakness, reason.level)).collect();
    assert_eq!(weaknesses, [(SurfaceWeakness::HiddenArea, Level::Low), (SurfaceWeakness::SeveralPieces, Level::Moderate)]);
}

#[test]
fn a_cancelled_ranking_ends_early() {
    let facets = facets(&published(1), 60, 60);
    let settings = settings(Model::Envelope);
    let asked = AtomicUsize::new(0);
    let all = rank(&facets, &published_cutters(), &settings, SurfaceEvidence::default(), &|| {
        asked.fetch_add(1, Ordering::Relaxed);
        false
    });
    assert!(all.is_some());
    // Two cutters in 46 directions, each with some 80 planes.
    let in_all = asked.into_inner();
    assert!(in_all > 200, "{in_all}");
    // After the cancellation, the flag is checked once for each step that would have started: for two cutters up to
    // 2,000 places of a check, 400 strips and 200 rows of a table.
    for stopped_at in [0, 1, 10, in_all / 2, in_all - 10] {
        let asked = AtomicUsize::new(0);
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= stopped_at;
        let ranking = rank(&facets, &published_cutters(), &settings, SurfaceEvidence::default(), &stop);
        assert!(ranking.is_none(), "stopped at {stopped_at} of {in_all}");
        let afterwards = asked.into_inner() - stopped_at;
        assert!(afterwards <= 6_000, "{afterwards} checks after the cancellation");
    }
}

#[test]
fn room_for_plans_bounds_their_size_and_not_their_result() {
    let facets = facets(&published(1), 40, 40);
    let (settings, evidence) = (in_direction(Model::Envelope, 30.0), SurfaceEvidence::default());
    let within = |room| rank_within(&facets, &published_cutters(), &settings, evidence, room, &|| false);
    let whole = rank(&facets, &published_cutters(), &settings, evidence, &|| false).unwrap();
    let planes = whole.plans.iter().map(|plan| plan.planes).max().unwrap();
    assert_eq!(within(PlanRoom::USUAL).as_ref(), Ok(&whole));
    assert_eq!(within(PlanRoom { planes: planes / 2, ..PlanRoom::LARGEST }), Err(NoRanking::NoRoom));
    assert_eq!(within(PlanRoom { runs: planes / 2, ..PlanRoom::LARGEST }), Err(NoRanking::NoRoom));
    assert_eq!(rank_within(&facets, &published_cutters(), &settings, evidence, PlanRoom::USUAL, &|| true), Err(NoRanking::Stopped));
    assert_eq!(PlanRoom::USUAL.larger().larger(), PlanRoom::LARGEST.larger());
}
