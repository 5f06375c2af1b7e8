//! Passes of plans, point by point.

use super::surfaces::{Height, facets, published};
use super::{degrees, drive, in_direction, mm, published_cutters, ranked};
use scallopd::milling::{Contact, Cutter, EvaluatedPass, Model, Pass, Runout, SurfaceCurvature};
use scallopd::motion::{MachineLimits, travel_time};
use scallopd::planning::zigzag::{CandidateCutter, PassPoint, Passes, passes};
use scallopd::quantity::{Length, Speed, Time};

/// The time of runs at their points' feeds, and of links from run to run at the feed rate, by section 5. The path is
/// that of the contacts or of the tips, as `place` selects.
fn timed(passes: &Passes, limits: MachineLimits, link_rate: Speed, place: impl Fn(&PassPoint) -> [f64; 3]) -> f64 {
    let distance = |a: [f64; 3], b: [f64; 3]| (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt();
    let time =
        |length: f64, feed_rate: Speed| travel_time(Length::from_mm(length).unwrap(), MachineLimits { feed_rate, ..limits }).seconds();
    let ends = passes.run_starts[1..].iter().copied().chain([passes.points.len()]);
    let (mut seconds, mut last) = (0.0, None);
    for (start, end) in passes.run_starts.iter().copied().zip(ends) {
        let points = &passes.points[start..end];
        let at = |index: usize| place(&points[index]);
        if let Some(last) = last {
            seconds += time(distance(last, at(0)), link_rate);
        }
        let (mut length, mut without_stops) = (0.0, 0.0);
        for index in 1..points.len() {
            let part = distance(at(index - 1), at(index));
            length += part;
            without_stops += part * 0.5 * (1.0 / points[index - 1].feed_rate.mm_s() + 1.0 / points[index].feed_rate.mm_s());
        }
        seconds += time(length, Speed::from_mm_min(60.0 * length / without_stops).unwrap());
        last = Some(at(points.len() - 1));
    }
    seconds
}

/// The published cutters, a sharp bull-nose and a flat-end cutter.
fn cutters() -> [Cutter; 4] {
    let [bull_nose, ball] = published_cutters().map(|candidate| candidate.cutter);
    [bull_nose, ball, Cutter::toroidal(mm(10.0), mm(0.5)).unwrap(), Cutter::flat_end(mm(6.0))]
}

#[test]
fn the_contacts_take_the_time_of_their_plan_and_the_tips_that_of_the_passes() {
    let without_drive = cutters().into_iter().map(|cutter| (cutter, 0, 0.0));
    let with_drive = [(cutters()[0], 2, 10_000.0), (cutters()[1], 2, 10_000.0), (cutters()[0], 1, 3000.0)];
    for (cutter, teeth, rpm) in without_drive.chain(with_drive) {
        for (surface, direction) in [(0, 66.97), (1, 20.0)] {
            let facets = facets(&published(surface), 50, 50);
            let settings = in_direction(Model::Envelope, direction);
            let mut candidate = CandidateCutter::new(cutter);
            candidate.drive = (teeth > 0).then(|| drive(teeth, rpm));
            let plan = ranked(&facets, &[candidate], &settings).plans.remove(0);
            let passes = passes(&plan, &facets, &candidate, &settings, &|tip| tip[2], 200_000).unwrap();
            assert_eq!((passes.run_starts.len(), plan.tour.lifts), (plan.tour.runs, 0));
            let limits = settings.machine.limits;
            let [contacts, tips] = [
                timed(&passes, limits, limits.feed_rate, |point| point.contact.unwrap()),
                timed(&passes, limits, limits.feed_rate, |point| point.tip),
            ];
            let [planned, stated] = [plan.time, passes.time].map(Time::seconds);
            println!("surface {surface} at {direction} deg: plan {planned:.3} s, contacts {contacts:.3} s; tips {tips:.3} s");
            // Without a drive all feeds are the machine's, and contacts at the middles of cuts omit only the corners
            // between facets. With one, the points have the largest feeds and the plan has those of its tables.
            let most = if teeth > 0 { 0.02 } else { 1e-4 };
            assert!((contacts / planned - 1.0).abs() < most, "{contacts} s for {planned} s");
            // The links of cutters with a drive have the feed rate of the largest feed per tooth.
            assert!((tips / stated - 1.0).abs() < if teeth > 0 { 0.02 } else { 1e-9 }, "{tips} s for {stated} s");
        }
    }
}

#[test]
fn points_lie_in_the_planes_and_have_the_heights_of_the_model() {
    let facets = facets(&published(0), 40, 40);
    let settings = in_direction(Model::Envelope, 75.0);
    let mut candidate = published_cutters()[0];
    candidate.drive = Some(drive(2, 10_000.0));
    let plan = ranked(&facets, &[candidate], &settings).plans.remove(0);
    let passes = passes(&plan, &facets, &candidate, &settings, &|tip| tip[2], 200_000).unwrap();
    let (e, q) = ([degrees(75.0).cos(), degrees(75.0).sin()], [-degrees(75.0).sin(), degrees(75.0).cos()]);
    let ends = passes.run_starts[1..].iter().copied().chain([passes.points.len()]);
    let mut over = 0;
    for (start, end) in passes.run_starts.iter().copied().zip(ends) {
        let across = |point: [f64; 3]| q[0] * point[0] + q[1] * point[1];
        let first = across(passes.points[start].contact.unwrap());
        for point in &passes.points[start..end] {
            approx::assert_abs_diff_eq!(across(point.contact.unwrap()), first, epsilon = 1e-9);
            let n = point.normal;
            let feed = [e[0], e[1], -(n[0] * e[0] + n[1] * e[1]) / n[2]];
            let [along, sideways, twist] = point.curvature;
            let pass = Pass {
                cutter: candidate.cutter,
                contact: Contact::from_vectors(n, feed, None).unwrap(),
                surface: SurfaceCurvature::from_components_per_mm(along, sideways, twist).unwrap(),
                runout: Runout::NONE,
                teeth: None,
            };
            let height = EvaluatedPass::new(Model::Envelope, pass).unwrap().scallop_height(point.step_over, point.feed_per_tooth).unwrap();
            approx::assert_relative_eq!(height.total().mm(), point.scallop_height.unwrap().mm(), max_relative = 1e-9);
            over += usize::from(height.total().mm() > 1.001 * 0.01);
            approx::assert_relative_eq!(point.feed_rate.mm_min(), point.feed_per_tooth.unwrap().mm() * 20_000.0, max_relative = 1e-12);
        }
    }
    // Feeds are reduced where step-overs allow it; at most 1 in 100 points has no such feed.
    println!("{over} of {} points over the tolerance", passes.points.len());
    assert!(100 * over <= passes.points.len(), "{over} of {}", passes.points.len());
}

/// Waves that are convex, concave and twisted, with a level saddle and level tops.
fn waves(x: f64, y: f64) -> [f64; 6] {
    let ((sx, cx), (sy, cy)) = ((x / 18.0).sin_cos(), (y / 22.0).sin_cos());
    let [xx, xy, yy] = [-6.0 * sx * cy / (18.0 * 18.0), -6.0 * cx * sy / (18.0 * 22.0), -6.0 * sx * cy / (22.0 * 22.0) + 0.008];
    [6.0 * sx * cy + 0.15 * x + 0.004 * y * y, 6.0 * cx * cy / 18.0 + 0.15, -6.0 * sx * sy / 22.0 + 0.008 * y, xx, xy, yy]
}

#[test]
fn the_points_of_every_cutter_have_the_heights_of_contacts_with_their_figures() {
    let facets = facets(&Height { low: [0.0; 2], high: [50.0, 36.0], surface: waves }, 25, 18);
    let settings = in_direction(Model::Envelope, 27.0);
    for cutter in cutters() {
        for drive in [None, Some(drive(2, 12_000.0))] {
            let candidate = CandidateCutter { drive, ..CandidateCutter::new(cutter) };
            let plan = ranked(&facets, &[candidate], &settings).plans.remove(0);
            let passes = passes(&plan, &facets, &candidate, &settings, &|tip| tip[2], 200_000).unwrap();
            let mut compared = 0;
            for point in &passes.points {
                let (n, (sin, cos)) = (point.normal, 27.0_f64.to_radians().sin_cos());
                let feed = [cos, sin, -(n[0] * cos + n[1] * sin) / n[2]];
                let [along, across, twist] = point.curvature;
                let pass = Pass {
                    cutter,
                    contact: Contact::from_vectors(n, feed, None).unwrap(),
                    surface: SurfaceCurvature::from_components_per_mm(along, across, twist).unwrap(),
                    runout: Runout::NONE,
                    teeth: None,
                };
                let evaluated = EvaluatedPass::new(Model::Envelope, pass);
                let height = evaluated.ok().and_then(|pass| pass.scallop_height(point.step_over, point.feed_per_tooth).ok());
                assert_eq!(height.is_some(), point.scallop_height.is_some(), "{cutter:?} {drive:?} {point:?}");
                if let (Some(height), Some(stated)) = (height, point.scallop_height) {
                    let ratio = height.total().mm() / stated.mm();
                    assert!((ratio - 1.0).abs() <= 1e-6, "{cutter:?} {drive:?} {ratio} {point:?}");
                    compared += 1;
                }
            }
            println!("{cutter:?}, {drive:?}: {compared} of {} points have a height", passes.points.len());
            assert!(2 * compared > passes.points.len());
        }
    }
}

#[test]
fn fewer_points_are_kept_with_a_wider_chord_tolerance() {
    let facets = facets(&published(1), 40, 40);
    let (settings, candidate) = (in_direction(Model::Envelope, 10.0), published_cutters()[1]);
    let plan = ranked(&facets, &[candidate], &settings).plans.remove(0);
    let of = |limit: usize| passes(&plan, &facets, &candidate, &settings, &|tip| tip[2], limit);
    let all = of(200_000).unwrap();
    assert_eq!(all.chord_tolerance, mm(0.001));
    let fewer = of(all.points.len() / 2).unwrap();
    assert!(fewer.points.len() <= all.points.len() / 2 && fewer.chord_tolerance > all.chord_tolerance);
    // The two ends of each run are kept at any tolerance.
    assert_eq!(of(plan.tour.runs).unwrap_err().limit, plan.tour.runs);
}

#[test]
fn tips_that_would_gouge_are_raised() {
    let facets = facets(&published(1), 30, 30);
    let (settings, candidate) = (in_direction(Model::Envelope, 0.0), published_cutters()[1]);
    let plan = ranked(&facets, &[candidate], &settings).plans.remove(0);
    let raised = passes(&plan, &facets, &candidate, &settings, &|[x, _, z]| if x > 30.0 { 50.0 } else { z }, 200_000).unwrap();
    for point in &raised.points {
        assert_eq!(point.contact.is_none(), point.tip[0] > 30.0);
        assert!(point.contact.is_some() || (point.tip[2] - 50.0).abs() < 1e-12);
    }
}
