//! Feeds against closed forms, against the model `envelope`, and against every tooth placed along the path.

use super::*;
use crate::milling::{Contact, Cutter, EvaluatedPass, Model, Pass, Profile, Runout, SurfaceCurvature};
use crate::numerics::random::Random;
use crate::path::tests::{Plane, cut, milled};
use crate::path::{Milled, Places};
use crate::quantity::{Acceleration, Jerk, Length};
use crate::surface::{Facing, Mesh, MeshBuilder, Unit};
use approx::assert_relative_eq;
use nalgebra::Vector3;

const STOP: fn() -> bool = || false;

fn mm(value: f64) -> Length {
    Length::from_mm(value).unwrap()
}

/// A mesh of quadrilaterals, row after row.
fn grid(rows: usize, columns: usize, corner: impl Fn(usize, usize) -> Vector3<f64>) -> Mesh {
    let mut builder = MeshBuilder::new();
    let points: Vec<[f64; 3]> = (0..rows * columns).map(|at| corner(at / columns, at % columns).into()).collect();
    let cells = (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| row * columns + column));
    let triangles: Vec<[u64; 3]> = cells
        .flat_map(|at| {
            [[at, at + 1, at + columns], [at + 1, at + columns + 1, at + columns]].map(|facet| facet.map(|corner| corner as u64))
        })
        .collect();
    builder.indexed(&points, &triangles).unwrap();
    builder.finish(Unit::Millimetre, Facing::Up, &|| false).unwrap()
}

fn all_facets(mesh: &Mesh) -> Vec<u32> {
    (0..mesh.triangles().len() as u32).collect()
}

/// The cutter at every tooth of the path: teeth pass at the feed per tooth of each move, from a random phase after each
/// stop, and at the stops.
fn every_tooth(profile: &Profile, moves: &[Move], per_tooth: &[f64], seed: u64) -> Milled {
    let mut random = Random::new(seed);
    let mut teeth = Vec::new();
    let mut tooth = |tip: [f64; 3]| teeth.push(Move { from: tip, to: tip, kind: MoveKind::Cut });
    let mut phase = 0.0;
    for (at, each) in moves.iter().enumerate() {
        let starts = at == 0 || !joins(Some(&moves[at - 1]), each);
        let ends = moves.get(at + 1).is_none_or(|next| !joins(Some(each), next));
        if starts {
            phase = random.unit();
            tooth(each.from);
        }
        let turns = length_of(each) / per_tooth[at];
        let mut turn = phase;
        while turn < turns {
            tooth(std::array::from_fn(|axis| each.from[axis] + turn / turns * (each.to[axis] - each.from[axis])));
            turn += 1.0;
        }
        phase = turn - turns;
        if ends {
            tooth(each.to);
        }
    }
    milled(profile, &teeth)
}

/// The share of the places that teeth of some phases leave over the tolerance.
fn share_over(profile: &Profile, moves: &[Move], per_tooth: &[f64], places: &Places, tolerance: f64) -> f64 {
    let over = (0..4).map(|seed| {
        let teeth = every_tooth(profile, moves, per_tooth, seed);
        let is_over = |place: &&crate::path::Place| teeth.left_at(place.point, place.normal).is_none_or(|left| left.height > tolerance);
        places.inside().iter().filter(is_over).count()
    });
    over.max().unwrap() as f64 / places.inside().len() as f64
}

/// The largest feed per tooth by the model `envelope`.
fn by_model(outer: f64, corner: f64, slope: f64, feed_angle: f64, surface: SurfaceCurvature, tolerance: f64, step_over: f64) -> f64 {
    let cutter = if corner < outer { Cutter::toroidal(mm(2.0 * outer), mm(corner)).unwrap() } else { Cutter::ball_end(mm(2.0 * outer)) };
    let contact = Contact::from_degrees(slope, feed_angle).unwrap();
    let pass = Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None };
    EvaluatedPass::new(Model::Envelope, pass).unwrap().max_feed_per_tooth(mm(tolerance), mm(step_over)).unwrap().mm()
}

/// The feeds of the moves whose ends are within `radius` of the origin.
fn feeds_near(moves: &[Move], per_tooth: &[f64], radius: f64) -> Vec<f64> {
    let is_near = |each: &Move| each.from[0].hypot(each.from[1]).max(each.to[0].hypot(each.to[1])) < radius;
    moves.iter().zip(per_tooth).filter(|(each, _)| is_near(each)).map(|(_, feed)| *feed).collect()
}

#[test]
fn a_valley_of_a_ball_on_a_plane_is_a_chord() {
    let radius = 3.0_f64;
    for (slope, feed) in [(0.0, 0.0), (35.0, 20.0), (60.0, 90.0), (75.0, 0.0)] {
        for length in [0.03, 0.4, 40.0] {
            let plane = Plane::new(slope, 40.0, feed);
            let moves: Vec<Move> = plane.passes(radius, radius, 30.0, length);
            let milled = milled(&Profile::torus(radius, radius), &moves);
            let passage = Passage::new(&milled, &moves);
            for (across, level) in [(0.0, 0.01), (0.1, 0.01), (0.2, 0.0072), (0.3, 0.1)] {
                let valleys = passage.valleys(plane.at(0.13, across).into(), plane.normal.into(), level);
                let half = (radius * radius - (radius - level).powi(2) - across * across).sqrt();
                assert_eq!(valleys.len(), 1, "{slope} {feed} {length} {valleys:?}");
                assert_relative_eq!(valleys[0].width(), 2.0 * half, epsilon = 1e-5);
            }
            let beside = passage.valleys(plane.at(0.13, 0.26).into(), plane.normal.into(), 0.01);
            assert_eq!(beside, []);
        }
    }
}

#[test]
fn feeds_on_planes_are_the_largest_that_keep_the_tolerance_with_every_tooth() {
    for (outer, corner, slope, angle, step_over, length) in [
        (3.0, 3.0, 0.0, 0.0, 0.35, 40.0),
        (3.0, 3.0, 50.0, 30.0, 0.3, 0.5),
        (5.0, 1.5, 30.0, 0.0, 0.5, 2.0),
        (5.0, 1.5, 30.0, 90.0, 0.25, 1.0),
    ] {
        let (tolerance, plane) = (0.01, Plane::new(slope, 25.0, angle));
        let side = 5.0 / slope.to_radians().cos().recip().max(1.0);
        let mesh = grid(2, 2, |row, column| plane.at(side * (2.0 * column as f64 - 1.0), side * (2.0 * row as f64 - 1.0)));
        let moves = plane.passes(outer, corner, step_over, length);
        let profile = Profile::torus(outer, corner);
        let milled = milled(&profile, &moves);
        let places = Places::draw(&mesh, &all_facets(&mesh), 40_000, 1);
        let found = LargestFeeds::new(&Passage::new(&milled, &moves), places.inside(), tolerance, &STOP).unwrap();
        assert_eq!((found.kept, found.never_kept), (40_000, 0));
        let expected = by_model(outer, corner, slope, angle, SurfaceCurvature::PLANE, tolerance, step_over);
        // Moves whose places and ridges are all on the mesh.
        let in_pass = moves.len() / (2 * (20.0_f64 / step_over).ceil() as usize + 1);
        let inside = |at: usize| {
            let (across, along) = (step_over * ((at / in_pass) as f64 - (20.0 / step_over).ceil()), -20.0 + length * (at % in_pass) as f64);
            across.abs() < side - step_over && (length > 10.0 || along.abs() < side - 2.0 * length)
        };
        let feeds: Vec<f64> = (0..moves.len()).filter(|at| inside(*at)).map(|at| found.per_tooth[at]).collect();
        assert!(feeds.len() > 10);
        for feed in feeds {
            assert!(feed <= expected * 1.005 && feed >= 0.95 * expected, "{slope} {angle}: {feed} {expected}");
        }
        let tried = Places::draw(&mesh, &all_facets(&mesh), 40_000, 7);
        let over = share_over(
            &profile,
            &moves,
            &found.per_tooth.iter().map(|feed| feed.min(10.0 * expected)).collect::<Vec<f64>>(),
            &tried,
            tolerance,
        );
        assert!(over <= 1e-3, "{slope} {angle}: {over}");
        // A third more are too much.
        let more: Vec<f64> = found.per_tooth.iter().map(|feed| 1.33 * feed.min(10.0 * expected)).collect();
        assert!(share_over(&profile, &moves, &more, &tried, tolerance) > 1e-3);
    }
}

/// Passes along a convex cylinder and around it.
#[test]
fn feeds_on_cylinders_are_the_largest_that_keep_the_tolerance_with_every_tooth() {
    let (cylinder, ball, tolerance) = (20.0, 3.0, 0.01);
    let at = |angle: f64, x: f64| Vector3::new(x, cylinder * angle.sin(), cylinder * angle.cos());
    let mesh = grid(241, 2, |row, column| at(0.0025 * (row as f64 - 120.0), 5.0 * (1.0 - 2.0 * column as f64)));
    let tip = |angle: f64, x: f64| Vector3::new(x, (cylinder + ball) * angle.sin(), (cylinder + ball) * angle.cos() - ball);
    let mut along = Vec::new();
    let step = 0.015;
    for pass in -26..=26 {
        let angle = step * f64::from(pass);
        along.push(cut(tip(angle, -9.0), tip(angle, 9.0)));
    }
    let mut around = Vec::new();
    for pass in -25..=25 {
        let x = 0.3 * f64::from(pass);
        for chord in -80..80 {
            around.push(cut(tip(0.005 * f64::from(chord), x), tip(0.005 * f64::from(chord + 1), x)));
        }
    }
    let across_axis = SurfaceCurvature::from_components_per_mm(0.0, 1.0 / cylinder, 0.0).unwrap();
    let about_axis = SurfaceCurvature::from_components_per_mm(1.0 / cylinder, 0.0, 0.0).unwrap();
    for (moves, surface, step_over) in [(along, across_axis, step * cylinder), (around, about_axis, 0.3)] {
        let profile = Profile::torus(ball, ball);
        let milled = milled(&profile, &moves);
        let places = Places::draw(&mesh, &all_facets(&mesh), 60_000, 1);
        let found = LargestFeeds::new(&Passage::new(&milled, &moves), places.inside(), tolerance, &STOP).unwrap();
        // On the crest the feed is level; the tip's path around the cylinder is longer than that of the contact.
        let by_contact = by_model(ball, ball, 0.0, 90.0, surface, tolerance, step_over);
        let expected =
            if step_over < 0.3 { by_contact } else { by_contact * (1.0 + if surface == about_axis { ball / cylinder } else { 0.0 }) };
        let feeds: Vec<f64> = feeds_near(&moves, &found.per_tooth, 6.0)
            .into_iter()
            .chain(found.per_tooth.iter().copied().filter(|_| surface == across_axis))
            .filter(|feed| feed.is_finite())
            .collect();
        assert!(feeds.len() > 10);
        for feed in &feeds {
            // Facets are up to 3e-5 mm off the cylinder, 0.3 % of the tolerance.
            assert!(*feed <= 1.01 * expected && *feed >= 0.95 * expected, "{feed} {expected}");
        }
        let tried = Places::draw(&mesh, &all_facets(&mesh), 40_000, 7);
        let limited: Vec<f64> = found.per_tooth.iter().map(|feed| feed.min(10.0 * expected)).collect();
        let over = share_over(&profile, &moves, &limited, &tried, tolerance);
        assert!(over <= 1e-3, "{over}");
    }
}

#[test]
fn what_is_left_with_marks_is_that_of_the_model() {
    let (outer, corner, slope, step_over, feed) = (5.0, 1.5, 30.0, 0.5, 0.25);
    let plane = Plane::new(slope, 25.0, 0.0);
    let mesh = grid(2, 2, |row, column| plane.at(8.0 * column as f64 - 4.0, 8.0 * row as f64 - 4.0));
    let moves = plane.passes(outer, corner, step_over, 1.0);
    let milled = milled(&Profile::torus(outer, corner), &moves);
    let places = Places::draw(&mesh, &all_facets(&mesh), 20_000, 1);
    let left = Passage::new(&milled, &moves).with_marks(places.inside(), &vec![feed; moves.len()], 0.01, 0.1, &STOP).unwrap();
    assert!(left.left.iter().all(Option::is_some));
    let cutter = Cutter::toroidal(mm(2.0 * outer), mm(corner)).unwrap();
    let contact = Contact::from_degrees(slope, 0.0).unwrap();
    let pass = Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
    let expected = EvaluatedPass::new(Model::Envelope, pass).unwrap().scallop_height(mm(step_over), Some(mm(feed))).unwrap().total().mm();
    // The worst of 20 000 places is within 1/500 of the step-over of a ridge, where the height falls by up to 4 h per step.
    let max = left.residual.unwrap().max;
    assert!(max <= 1.001 * expected && max >= 0.98 * expected, "{max} {expected}");
}

#[test]
fn smoothed_feeds_can_be_followed_with_limited_acceleration_and_jerk() {
    let at = |x: f64| Vector3::new(x, 0.0, 0.0);
    let mut moves: Vec<Move> = (0..30).map(|step| cut(at(f64::from(step)), at(f64::from(step + 1)))).collect();
    moves[20].kind = MoveKind::Rapid;
    let stated: Vec<Speed> = (0..30).map(|step| Speed::computed(if step % 10 == 5 { 5.0 } else { 100.0 })).collect();
    let mut feeds = stated.clone();
    let limits = MachineLimits {
        feed_rate: Speed::computed(100.0),
        acceleration: Acceleration::from_m_s2(0.3).unwrap(),
        jerk: Jerk::from_m_s3(3.0).unwrap(),
    };
    smooth(&moves, &mut feeds, limits);
    assert!(feeds.iter().zip(&stated).all(|(smoothed, stated)| smoothed.mm_s() <= stated.mm_s()));
    for at in 0..30 {
        for later in at + 1..30 {
            // A slower move is left and reached within the lengths between, but not through the rapid.
            if (at..=later).contains(&20) {
                continue;
            }
            let (one, other) = (feeds[at], feeds[later]);
            let length = Length::computed((later - at) as f64);
            let (slow, fast) = if one.mm_s() < other.mm_s() { (one, other) } else { (other, one) };
            // Speeds within a ramp begin with an acceleration.
            if stated[at].mm_s() <= 5.0 || stated[later].mm_s() <= 5.0 {
                assert!(fast.mm_s() <= speed_after(slow, length, limits).mm_s() * (1.0 + 1e-12), "{at} {later}");
            }
        }
    }
    let reached = |length: f64| speed_after(Speed::computed(5.0), Length::computed(length), limits).mm_s();
    for (at, length) in [(4, 1.0), (6, 1.0), (9, 4.0), (0, 5.0), (21, 4.0), (29, 4.0)] {
        assert_relative_eq!(feeds[at].mm_s(), reached(length).min(100.0), max_relative = 1e-12);
    }
}
