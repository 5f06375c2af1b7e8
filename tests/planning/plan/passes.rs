//! Passes of plans, point by point.

use super::surfaces::{Height, facet, facets, published};
use super::{degrees, drive, in_direction, mm, published_cutters, ranked};
use scallopd::milling::{Contact, Cutter, EvaluatedPass, Model, Pass, Runout, SurfaceCurvature};
use scallopd::motion::{MachineLimits, travel_time};
use scallopd::planning::zigzag::{CandidateCutter, PassPoint, Passes, passes};
use scallopd::quantity::{Length, Speed, Time};
use scallopd::surface::FinishFacet;

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
    let fewer = of(all.points.len() - 1).unwrap();
    assert!(fewer.points.len() < all.points.len() && fewer.chord_tolerance == mm(0.002));
    // The chord tolerance stays under the scallop height.
    assert_eq!(of(plan.tour.runs).unwrap_err().limit, plan.tour.runs);
}

#[test]
fn tips_that_would_gouge_are_raised() {
    let facets = facets(&published(1), 30, 30);
    let (settings, candidate) = (in_direction(Model::Envelope, 0.0), published_cutters()[1]);
    let plan = ranked(&facets, &[candidate], &settings).plans.remove(0);
    let raised = passes(&plan, &facets, &candidate, &settings, &|[x, _, z]| if x > 30.0 { 50.0 } else { z }, 200_000).unwrap();
    for point in &raised.points {
        let is_raised = (point.tip[2] - 50.0).abs() < 1e-12;
        assert!(is_raised || point.tip[0] <= 30.0, "{point:?}");
        assert!(!is_raised || point.contact.is_none(), "{point:?}");
    }
    // The tips rise before the place from which they are raised, and not on the way to it.
    let crossing = |pair: &&[PassPoint]| (pair[0].tip[0] > 30.0) != (pair[1].tip[0] > 30.0);
    let crossings: Vec<f64> = raised.points.windows(2).filter(crossing).map(|pair| pair[0].tip[2].min(pair[1].tip[2])).collect();
    assert!(!crossings.is_empty() && crossings.iter().all(|low| (low - 50.0).abs() < 1e-12), "{crossings:?}");
}

/// A surface of rectangles that rise and fall along x, each given by the heights at its ends.
fn profile(corners: &[[f64; 2]]) -> Vec<FinishFacet> {
    let quad = |pair: &[[f64; 2]]| {
        let [[from, low], [to, high]] = [pair[0], pair[1]];
        let corners = [[from, 0.0, low], [to, 0.0, high], [to, 20.0, high], [from, 20.0, low]];
        [[0, 1, 2], [0, 2, 3]].map(|triangle| facet(triangle.map(|corner| corners[corner]), [0.0; 6]))
    };
    corners.windows(2).flat_map(quad).collect()
}

/// The tips of the first run of a plan along x, in the order of x.
fn tips_over(corners: &[[f64; 2]], cutter: Cutter) -> Vec<[f64; 3]> {
    let (facets, settings, candidate) = (profile(corners), in_direction(Model::Envelope, 0.0), CandidateCutter::new(cutter));
    let plan = ranked(&facets, &[candidate], &settings).plans.remove(0);
    let passes = passes(&plan, &facets, &candidate, &settings, &|tip| tip[2], 200_000).unwrap();
    let mut tips: Vec<[f64; 3]> = passes.points[..passes.run_starts[1]].iter().map(|point| point.tip).collect();
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
        // The ridge lies at the origin. No tip is lower than one that touches it.
        let over_ridge = tips_over(&[[-half, -rise], [0.0, 0.0], [half, -rise]], cutter);
        for [x, _, z] in over_ridge
            .windows(2)
            .flat_map(|pair| (0..=20).map(|i| [0, 1, 2].map(|axis| pair[0][axis] + f64::from(i) / 20.0 * (pair[1][axis] - pair[0][axis]))))
        {
            let beyond = (x.abs() - core).max(0.0);
            let lowest = if beyond < corner { (corner * corner - beyond * beyond).sqrt() - corner } else { f64::NEG_INFINITY };
            assert!(z > lowest - 0.004, "{cutter:?}: {z} at {x}, under {lowest}");
        }
        // In the valley the tip touches both sides in the middle, and goes straight to there.
        let over_valley = tips_over(&[[-half, rise], [0.0, 0.0], [half, rise]], cutter);
        let lowest = over_valley.iter().copied().min_by(|a, b| a[2].total_cmp(&b[2])).unwrap();
        let touching = corner / slope.cos() - corner + core * slope.tan();
        assert!(lowest[0].abs() < 1e-9 && (lowest[2] - touching).abs() < 1e-9, "{cutter:?}: {lowest:?}, not {touching}");
        assert!(over_valley.windows(2).all(|pair| pair[1][0] >= pair[0][0] - 1e-9), "{over_valley:?}");
        assert!(over_valley.iter().all(|[x, _, z]| (z - touching - x.abs() * slope.tan()).abs() < 1e-9), "{over_valley:?}");
    }
}

#[test]
fn a_gap_that_holds_a_rib_is_crossed_above_it() {
    let floor = |from: f64, to: f64| profile(&[[from, 0.0], [to, 0.0]]);
    let facets: Vec<FinishFacet> = floor(0.0, 30.0).into_iter().chain(floor(34.0, 60.0)).collect();
    let cutter = Cutter::ball_end(mm(10.0));
    let (settings, candidate) = (in_direction(Model::Envelope, 0.0), CandidateCutter::new(cutter));
    let plan = ranked(&facets, &[candidate], &settings).plans.remove(0);
    // The rib is 12 mm high; the floor is at 0.
    let resting = |[x, _, z]: [f64; 3]| {
        let beside = (30.0 - x).max(x - 34.0).max(0.0);
        if beside < 5.0 { z.max(12.0 - 5.0 + (25.0 - beside * beside).sqrt()) } else { z }
    };
    let passes = passes(&plan, &facets, &candidate, &settings, &resting, 200_000).unwrap();
    let ends = passes.run_starts[1..].iter().copied().chain([passes.points.len()]);
    for (start, end) in passes.run_starts.iter().copied().zip(ends) {
        for pair in passes.points[start..end].windows(2) {
            for i in 0..=20 {
                let at = [0, 1, 2].map(|axis| pair[0].tip[axis] + f64::from(i) / 20.0 * (pair[1].tip[axis] - pair[0].tip[axis]));
                // Between two comparisons with the surface the tip can be too low by the change over half a step.
                let depth = resting([at[0], at[1], f64::NEG_INFINITY]) - at[2];
                assert!(depth < 0.1, "{depth} at {at:?}");
            }
        }
    }
}
