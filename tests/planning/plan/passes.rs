//! The path of a plan, point by point.

use super::parts::{cone_on_floor, field, profile, steps};
use super::surfaces::{Facet, Height, facets, placed, published};
use super::{drive, in_direction, mm, published_cutters, ranked_on, settings, workpiece};
use scallopd::milling::{Contact, Cutter, EvaluatedPass, Model, Pass, Runout, SurfaceCurvature};
use scallopd::motion::{Machine, MachineLimits, travel_time};
use scallopd::path::MoveKind;
use scallopd::planning::plan::{CandidateCutter, CandidatePlan, Drive, PassPoint, Passes, PlanSettings, Workpiece, passes};
use scallopd::quantity::{Length, Speed};
use std::collections::HashSet;
use std::iter;

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

fn planned(part: &Workpiece, candidate: CandidateCutter, settings: &PlanSettings) -> (CandidatePlan, Passes) {
    let plan = ranked_on(part, &[candidate], settings).plans.remove(0);
    let path = passes(part, &plan, settings, &|| false).unwrap();
    (plan, path)
}

/// The time of a path by section 5 of the model: a run from rest to rest at its mean speed, a link on the surface as one
/// move for each part that is straight seen from above, and each move of a lift by itself.
fn timed(path: &Passes, machine: &Machine) -> f64 {
    let time = |length: f64, feed_rate: Speed| {
        if length > 0.0 {
            travel_time(Length::from_mm(length).unwrap(), MachineLimits { feed_rate, ..machine.limits }).seconds()
        } else {
            0.0
        }
    };
    let heading = |index: usize| {
        let [from, to] = [path.points[index - 1].tip, path.points[index].tip];
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        (x.hypot(y) > 1e-9).then(|| [x / x.hypot(y), y / x.hypot(y)])
    };
    let ends = path.run_starts[1..].iter().copied().chain([path.points.len()]);
    // What leads to the first run's first cut.
    let approach = path.points.iter().position(|point| point.kind == MoveKind::Cut).unwrap() - 1;
    let mut seconds = 0.0;
    for pair in path.points[..=approach].windows(2) {
        seconds += time(distance(pair[0].tip, pair[1].tip), pair[1].feed_rate);
    }
    for (start, end) in iter::once(approach).chain(path.run_starts[1..].iter().copied()).zip(ends) {
        let (mut run, mut at_rate, mut link, mut is_lifted) = (0.0, 0.0, 0.0, false);
        let mut ahead: Option<[f64; 2]> = None;
        // The last move of a link ends at the next run's first point.
        for index in (start + 1..=end).filter(|index| *index < path.points.len()) {
            let point = &path.points[index];
            let length = distance(path.points[index - 1].tip, point.tip);
            if index < end && point.kind == MoveKind::Cut {
                run += length;
                at_rate += length / point.feed_rate.mm_s();
                continue;
            }
            is_lifted |= point.kind == MoveKind::Rapid;
            if is_lifted {
                seconds += time(length, point.feed_rate);
                continue;
            }
            let turns = ahead.zip(heading(index)).is_some_and(|(a, b)| (a[0] * b[1] - a[1] * b[0]).abs() > 1e-6);
            if turns {
                seconds += time(link, point.feed_rate);
                link = 0.0;
            }
            link += length;
            ahead = heading(index).or(ahead);
            if index == end {
                seconds += time(link, point.feed_rate);
            }
        }
        if run > 0.0 {
            seconds += time(run, Speed::from_mm_min(60.0 * run / at_rate).unwrap());
        }
    }
    seconds
}

fn top(facets: &[Facet]) -> f64 {
    facets.iter().flatten().map(|point| point[2]).fold(f64::NEG_INFINITY, f64::max)
}

/// A boss on a floor, turned: with lifts, links and runs along its walls.
fn boss() -> Vec<Facet> {
    let part = steps(&[0.0, 14.0, 24.0, 36.0], &[0.0, 12.0, 22.0, 34.0], &[&[0.0; 3], &[0.0, 5.0, 0.0], &[0.0; 3]]);
    placed(&part, 17.0, [0.0; 3])
}

#[test]
fn the_points_in_their_order_are_the_whole_path_of_the_stated_time_and_length() {
    let patch = facets(&published(0), 30, 30);
    let [bull_nose, ball] = published_cutters();
    let driven = CandidateCutter { drive: Some(drive(2, 10_000.0)), ..bull_nose };
    let small = CandidateCutter::new(Cutter::toroidal(mm(6.0), mm(1.0)).unwrap());
    for (facets, candidate) in [(&patch, bull_nose), (&patch, ball), (&patch, driven), (&boss(), small)] {
        let settings = PlanSettings { max_uncut_share: 1.0, ..in_direction(Model::Envelope, 20.0) };
        let (plan, path) = planned(&workpiece(facets), candidate, &settings);
        let tour = plan.milled.unwrap().tour;
        assert_eq!(path.run_starts.len(), tour.runs);
        let at_clearance = |point: &PassPoint| (point.tip[2] - (top(facets) + 5.0)).abs() < 1e-9;
        assert!(at_clearance(&path.points[0]) && at_clearance(path.points.last().unwrap()));
        let length = |is_cut: bool| -> f64 {
            let pairs = path.points.windows(2).filter(|pair| (pair[1].kind == MoveKind::Cut) == is_cut);
            pairs.map(|pair| distance(pair[0].tip, pair[1].tip)).sum()
        };
        approx::assert_relative_eq!(length(true), tour.run_length, max_relative = 1e-9);
        approx::assert_relative_eq!(length(false), tour.link_length, max_relative = 1e-9);
        let (timed, stated) = (timed(&path, &settings.machine), plan.time.seconds());
        println!("{timed:.3} s of the moves, {stated:.3} s stated; {tour:?}");
        assert!((timed / stated - 1.0).abs() < 0.01, "{timed} s, {stated} s stated");
        // Rapid moves go up, across at one height and down.
        for pair in path.points.windows(2).filter(|pair| pair[1].kind == MoveKind::Rapid) {
            let [from, to] = [pair[0].tip, pair[1].tip];
            let across = (to[0] - from[0]).hypot(to[1] - from[1]);
            assert!(across < 1e-9 || (to[2] - from[2]).abs() < 1e-9, "{pair:?}");
            approx::assert_relative_eq!(pair[1].feed_rate.mm_s(), settings.machine.rapid_rate.mm_s(), max_relative = 1e-12);
        }
        // Links and lifts have no contact, and every run has some.
        assert!(path.points.iter().all(|point| point.kind == MoveKind::Cut || point.cut.is_none() || point.kind == MoveKind::Link));
        assert!(path.points.iter().any(|point| point.cut.is_some()));
    }
}

/// Where a straight link to the next run would climb a wall, the link goes around its corner.
#[test]
fn links_go_around_the_corners_of_walls() {
    let ledges: Vec<f64> = (0..8).map(|ledge| 5.0 * f64::from(ledge)).collect();
    let heights: Vec<Vec<f64>> = (0..7).map(|x| (0..7).map(|y| if x + y < 7 { 0.0 } else { 8.0 }).collect()).collect();
    let heights: Vec<&[f64]> = heights.iter().map(Vec::as_slice).collect();
    let cutter = CandidateCutter::new(Cutter::toroidal(mm(4.0), mm(1.0)).unwrap());
    for direction in [0.0, 90.0] {
        let settings = PlanSettings { max_uncut_share: 1.0, ..in_direction(Model::Envelope, direction) };
        let part = workpiece(&steps(&ledges, &ledges, &heights));
        let tour = ranked_on(&part, &[cutter], &settings).plans[0].milled.unwrap().tour;
        println!("{direction} deg: {} lifts of {} links", tour.lifts, tour.links);
        assert!(4 * tour.lifts <= tour.links, "{} lifts of {} links", tour.lifts, tour.links);
    }
}

/// Waves that are convex, concave and twisted, with a level saddle and level tops.
fn waves(x: f64, y: f64) -> [f64; 6] {
    let ((sx, cx), (sy, cy)) = ((x / 18.0).sin_cos(), (y / 22.0).sin_cos());
    let [xx, xy, yy] = [-6.0 * sx * cy / (18.0 * 18.0), -6.0 * cx * sy / (18.0 * 22.0), -6.0 * sx * cy / (22.0 * 22.0) + 0.008];
    [6.0 * sx * cy + 0.15 * x + 0.004 * y * y, 6.0 * cx * cy / 18.0 + 0.15, -6.0 * sx * sy / 22.0 + 0.008 * y, xx, xy, yy]
}

#[test]
fn the_points_of_every_cutter_have_the_heights_of_contacts_with_their_figures() {
    let part = workpiece(&facets(&Height { low: [0.0; 2], high: [40.0, 28.0], surface: waves }, 20, 14));
    let settings = in_direction(Model::Envelope, 27.0);
    let (sin, cos) = 27.0_f64.to_radians().sin_cos();
    let [bull_nose, ball] = published_cutters().map(|candidate| candidate.cutter);
    for cutter in [bull_nose, ball, Cutter::toroidal(mm(10.0), mm(0.5)).unwrap(), Cutter::flat_end(mm(6.0))] {
        for drive in [None, Some(drive(2, 12_000.0))] {
            let (_, path) = planned(&part, CandidateCutter { drive, ..CandidateCutter::new(cutter) }, &settings);
            let (mut compared, mut cuts) = (0, 0);
            for (point, cut) in path.points.iter().filter_map(|point| Some((point, point.cut?))) {
                cuts += 1;
                let n = cut.normal;
                let feed = [cos, sin, -(n[0] * cos + n[1] * sin) / n[2]];
                let [along, across, twist] = cut.curvature;
                let pass = Pass {
                    cutter,
                    contact: Contact::from_vectors(n, feed, None).unwrap(),
                    surface: SurfaceCurvature::from_components_per_mm(along, across, twist).unwrap(),
                    runout: Runout::NONE,
                    teeth: drive.and_then(|drive| std::num::NonZeroU32::new(drive.teeth)),
                };
                let evaluated = EvaluatedPass::new(Model::Envelope, pass);
                let height = evaluated.ok().and_then(|pass| pass.scallop_height(cut.step_over, point.feed_per_tooth).ok());
                if let (Some(height), Some(stated)) = (height, cut.scallop_height) {
                    let ratio = height.total().mm() / stated.mm();
                    assert!((ratio - 1.0).abs() <= 1e-6, "{cutter:?} {drive:?} {ratio} {point:?}");
                    compared += 1;
                }
            }
            println!("{cutter:?}, {drive:?}: {compared} of {cuts} points have a height");
            assert!(2 * compared > cuts);
        }
    }
}

/// Lines in part: beside a stretch that is left out, the neighbour is the next line that is cut there.
#[test]
fn step_overs_are_the_distances_to_the_farther_of_the_neighbours_that_are_cut() {
    let part = workpiece(&cone_on_floor(32.0, [12.0, 16.0], [9.0, 6.0, 5.0]));
    let settings = PlanSettings { max_uncut_share: 1.0, ..in_direction(Model::Envelope, 0.0) };
    for cutter in [Cutter::flat_end(mm(6.0)), Cutter::toroidal(mm(6.0), mm(1.0)).unwrap()] {
        let (_, path) = planned(&part, CandidateCutter::new(cutter), &settings);
        let along = |pair: &&[PassPoint]| pair[1].kind == MoveKind::Cut && (pair[1].tip[1] - pair[0].tip[1]).abs() < 1e-9;
        let cuts: Vec<[PassPoint; 2]> = path.points.windows(2).filter(along).map(|pair| [pair[0], pair[1]]).collect();
        // The distances to the nearest cuts on both sides of a place.
        let neighbours = |x: f64, y: f64| {
            let passes_it = |cut: &&[PassPoint; 2]| (cut[0].tip[0] - x) * (cut[1].tip[0] - x) <= 0.0;
            let across = cuts.iter().filter(passes_it).map(|cut| cut[0].tip[1] - y);
            across.fold([f64::INFINITY; 2], |[below, above], across| match across {
                _ if across < -1e-6 => [below.min(-across), above],
                _ if across > 1e-6 => [below, above.min(across)],
                _ => [below, above],
            })
        };
        let (mut compared, mut agree, mut widest, mut narrowest) = (0, 0, 0.0_f64, f64::INFINITY);
        for [point, other] in cuts.iter().flat_map(|[from, to]| [[from, to], [to, from]]) {
            let Some(cut) = point.cut.filter(|cut| cut.normal[2] > 1.0 - 1e-9) else { continue };
            // A place just inside the move: at its end, those beside it begin or end by a rounding.
            let x = point.tip[0] + ((other.tip[0] - point.tip[0]) / 2.0).clamp(-0.01, 0.01);
            let [below, above] = neighbours(x, point.tip[1]);
            if below.max(above) < f64::INFINITY {
                compared += 1;
                agree += usize::from((below.max(above) - cut.step_over.mm()).abs() < 1e-6);
                (widest, narrowest) = (widest.max(cut.step_over.mm()), narrowest.min(cut.step_over.mm()));
            }
        }
        println!("{agree} of {compared}, {narrowest} to {widest} mm");
        assert!(compared > 100 && widest > 3.0 * narrowest, "{compared}, {narrowest} to {widest}");
        assert_eq!(agree, compared);
    }
}

/// The tips of the first run of a plan along x, in the order of x.
fn tips_over(corners: &[[f64; 2]], cutter: Cutter) -> Vec<[f64; 3]> {
    let part = workpiece(&profile(corners, 20.0));
    let settings = PlanSettings { max_uncut_share: 1.0, ..in_direction(Model::Envelope, 0.0) };
    let (_, path) = planned(&part, CandidateCutter::new(cutter), &settings);
    let first = &path.points[..path.run_starts[1]];
    let mut tips: Vec<[f64; 3]> = first.iter().filter(|point| point.kind == MoveKind::Cut).map(|point| point.tip).collect();
    if tips[0][0] > tips[tips.len() - 1][0] {
        tips.reverse();
    }
    tips
}

#[test]
fn the_tip_turns_around_a_ridge_and_follows_a_valley_to_its_bottom() {
    let (half, slope) = (20.0, 20.0_f64.to_radians());
    let rise = half * slope.tan();
    for cutter in [Cutter::ball_end(mm(10.0)), Cutter::toroidal(mm(10.0), mm(2.0)).unwrap()] {
        let (core, corner) = (cutter.core_radius().mm(), cutter.corner_radius().mm());
        // The ridge lies at the origin. No tip is lower than one that touches it, but for the chord tolerance of 1 um.
        let over_ridge = tips_over(&[[-half, -rise], [0.0, 0.0], [half, -rise]], cutter);
        for [x, _, z] in over_ridge
            .windows(2)
            .flat_map(|pair| (0..=20).map(|i| [0, 1, 2].map(|axis| pair[0][axis] + f64::from(i) / 20.0 * (pair[1][axis] - pair[0][axis]))))
        {
            let beyond = (x.abs() - core).max(0.0);
            let lowest = if beyond < corner { (corner * corner - beyond * beyond).sqrt() - corner } else { f64::NEG_INFINITY };
            assert!(z > lowest - 0.001 - 1e-9, "{cutter:?}: {z} at {x}, under {lowest}");
        }
        // In the valley the tip touches both sides in the middle, and goes straight to there.
        let over_valley = tips_over(&[[-half, rise], [0.0, 0.0], [half, rise]], cutter);
        let lowest = over_valley.iter().copied().min_by(|a, b| a[2].total_cmp(&b[2])).unwrap();
        let touching = corner / slope.cos() - corner + core * slope.tan();
        assert!(lowest[0].abs() < 0.01 && (lowest[2] - touching).abs() < 0.001, "{cutter:?}: {lowest:?}, not {touching}");
        assert!(over_valley.windows(2).all(|pair| pair[1][0] >= pair[0][0] - 1e-9), "{over_valley:?}");
    }
}

#[test]
fn a_rib_that_is_not_machined_is_crossed_above_it() {
    // A rib of 12 mm between two floors, whose walls are vertical and whose top is a point higher than any tip of the floors.
    let part = profile(&[[0.0, 0.0], [30.0, 0.0], [31.0, 12.0], [33.0, 12.0], [34.0, 0.0], [64.0, 0.0]], 20.0);
    let settings = PlanSettings { max_uncut_share: 1.0, ..settings(Model::Envelope) };
    let (_, path) = planned(&workpiece(&part), CandidateCutter::new(Cutter::ball_end(mm(10.0))), &settings);
    for pair in path.points.windows(2) {
        for i in 0..=20 {
            let at = [0, 1, 2].map(|axis| pair[0].tip[axis] + f64::from(i) / 20.0 * (pair[1].tip[axis] - pair[0].tip[axis]));
            let beside = (31.0 - at[0]).max(at[0] - 33.0).max(0.0);
            // Beyond the part's borders the tip goes down.
            if !(0.0..=64.0).contains(&at[0]) || !(0.0..=20.0).contains(&at[1]) {
                continue;
            }
            let lowest = if beside < 5.0 { 12.0 - 5.0 + (25.0 - beside * beside).sqrt() } else { 0.0 };
            assert!(at[2] >= lowest - 0.002, "{at:?}, under {lowest}");
        }
    }
}

#[test]
fn no_stretch_is_cut_twice() {
    // On a slope with ripples the edges of facets hold a flat cutter up: where it leaves as much as the path did, it need not go again.
    let ripples = |x: f64, y: f64| 0.6 * ((x - 8.0).hypot(y - 6.0) / 1.8).sin() + 20.0_f64.to_radians().tan() * y;
    let part = workpiece(&field([16.0, 12.0], 0.25, ripples));
    let drive = Drive { max_feed_per_tooth: Some(mm(0.05)), ..drive(2, 12_000.0) };
    let candidate = CandidateCutter { drive: Some(drive), ..CandidateCutter::new(Cutter::flat_end(mm(6.0))) };
    let settings = PlanSettings { max_uncut_share: 1.0, ..settings(Model::Envelope) };
    let (_, path) = planned(&part, candidate, &settings);
    #[expect(clippy::cast_possible_truncation, reason = "tens of thousands")]
    let micrometres = |tip: [f64; 3]| tip.map(|part| (1e3 * part).round() as i64);
    let mut cut = HashSet::new();
    for pair in path.points.windows(2).filter(|pair| pair[1].kind == MoveKind::Cut && distance(pair[0].tip, pair[1].tip) > 0.02) {
        let [from, to] = [0, 1].map(|end| micrometres(pair[end].tip));
        assert!(cut.insert([from.min(to), from.max(to)]), "{:?} to {:?}", pair[0].tip, pair[1].tip);
    }
}
