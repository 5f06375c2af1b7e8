//! What is left against closed forms and against the model `envelope`.

#![allow(clippy::cast_possible_truncation, reason = "few facets and passes")]

use super::*;
use crate::milling::{Contact, Cutter, EvaluatedPass, Model, Pass, Profile, Runout, SurfaceCurvature};
use crate::numerics::random::Random;
use crate::quantity::Length;
use crate::surface::{Facing, Mesh, MeshBuilder, Unit};
use approx::assert_relative_eq;
use nalgebra::Vector3;

pub(super) fn cut(from: Vector3<f64>, to: Vector3<f64>) -> Move {
    Move { from: from.into(), to: to.into(), kind: MoveKind::Cut }
}

pub(super) fn milled(profile: &Profile, moves: &[Move]) -> Milled {
    Milled::new(profile, moves, &|| false).unwrap()
}

/// A plane through the origin, with the directions of the passes and across them.
pub(super) struct Plane {
    pub(super) normal: Vector3<f64>,
    feed: Vector3<f64>,
    across: Vector3<f64>,
}

impl Plane {
    pub(super) fn new(slope_deg: f64, azimuth_deg: f64, feed_angle_deg: f64) -> Self {
        let (slope, azimuth, angle) = (slope_deg.to_radians(), azimuth_deg.to_radians(), feed_angle_deg.to_radians());
        let normal = Vector3::new(slope.sin() * azimuth.cos(), slope.sin() * azimuth.sin(), slope.cos());
        let level = Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0);
        let up = level.cross(&normal);
        // The feed seen from above has the angle to the steepest line; in the plane its tangent is times cos S.
        let feed = (up * angle.cos() / slope.cos() + level * angle.sin()).normalize();
        Self { normal, feed, across: normal.cross(&feed) }
    }

    pub(super) fn at(&self, along: f64, across: f64) -> Vector3<f64> {
        self.feed * along + self.across * across
    }

    /// The tip of a torus that touches the plane at the point.
    fn tip(&self, point: Vector3<f64>, outer: f64, corner: f64) -> Vector3<f64> {
        let level = Vector3::new(self.normal.x, self.normal.y, 0.0);
        let offset = if level.norm() > 0.0 { level.normalize() * (outer - corner) } else { level };
        point + offset + self.normal * corner - Vector3::z() * corner
    }

    /// Passes over 40 mm across and along, in moves of this length.
    pub(super) fn passes(&self, outer: f64, corner: f64, step_over: f64, length: f64) -> Vec<Move> {
        let mut moves = Vec::new();
        let count = (20.0 / step_over).ceil() as i32;
        for pass in -count..=count {
            let mut along = -20.0;
            while along < 20.0 {
                let [from, to] = [along, along + length].map(|along| self.tip(self.at(along, f64::from(pass) * step_over), outer, corner));
                moves.push(cut(from, to));
                along += length;
            }
        }
        moves
    }
}

/// The highest level on a line across the passes, about the middle of the plane.
fn ridge(plane: &Plane, milled: &Milled, step_over: f64) -> f64 {
    let level = |across: f64| milled.left_at(plane.at(0.3, across).into(), plane.normal.into()).unwrap().height;
    let steps = 4000;
    (0..=steps).map(|step| level(step_over * f64::from(step) / f64::from(steps))).fold(0.0, f64::max)
}

#[test]
fn a_ball_leaves_circles_on_planes() {
    for (slope, azimuth, feed) in [(0.0, 0.0, 0.0), (5.0, 20.0, 70.0), (45.0, 100.0, 10.0), (80.0, 200.0, 45.0), (80.0, 30.0, 90.0)] {
        for length in [0.4, 3.0, 40.0] {
            let plane = Plane::new(slope, azimuth, feed);
            let milled = milled(&Profile::torus(3.0, 3.0), &plane.passes(3.0, 3.0, 0.5, length));
            // The middle between two passes is one of the 4001 places. The search's steps end at 1e-7 mm.
            assert_relative_eq!(ridge(&plane, &milled, 0.5), 3.0 - (9.0_f64 - 0.0625).sqrt(), epsilon = 1e-8);
        }
    }
}

#[test]
fn a_ball_leaves_circles_on_a_sphere() {
    let (sphere, ball, step) = (20.0, 4.0, 0.03_f64);
    let at =
        |latitude: f64, longitude: f64| Vector3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin());
    let tip = |direction: Vector3<f64>| direction * (sphere + ball) - Vector3::z() * ball;
    let mut moves = Vec::new();
    for ring in 5..50 {
        let latitude = f64::from(ring) * step;
        for chord in 0..2000 {
            let [from, to] = [chord, chord + 1].map(|chord| tip(at(latitude, f64::from(chord) * std::f64::consts::TAU / 2000.0)));
            moves.push(cut(from, to));
        }
    }
    let milled = milled(&Profile::torus(ball, ball), &moves);
    let centre = sphere + ball;
    let expected = centre * (step / 2.0).cos() - (ball * ball - (centre * (step / 2.0).sin()).powi(2)).sqrt() - sphere;
    for ring in 10..40 {
        let direction = at((f64::from(ring) + 0.5) * step, 0.7 * f64::from(ring));
        let left = milled.left_at((direction * sphere).into(), direction.into()).unwrap();
        // The sagitta of chords of 2 pi/2000 at 24 mm is 24 (pi/2000)^2/2 = 3e-5 mm.
        assert_relative_eq!(left.height, expected, epsilon = 3.1e-5);
    }
}

#[test]
fn a_torus_leaves_on_planes_what_the_envelope_has() {
    let cutter = Cutter::toroidal(Length::from_mm(10.0).unwrap(), Length::from_mm(2.0).unwrap()).unwrap();
    for (slope, feed, step_over) in [
        (40.0, 0.0, 0.73),
        (40.0, 90.0, 0.4),
        (5.0, 0.0, 2.0),
        (1.0, 0.0, 3.7),
        (0.5, 0.0, 5.27),
        (0.2, 0.0, 5.9),
        (0.01, 0.0, 6.4),
        (85.0, 90.0, 0.4),
        (44.0, 22.0, 0.55),
        (70.0, 60.0, 0.3),
    ] {
        let pass = Pass {
            cutter,
            contact: Contact::from_degrees(slope, feed).unwrap(),
            surface: SurfaceCurvature::PLANE,
            runout: Runout::NONE,
            teeth: None,
        };
        let expected = EvaluatedPass::new(Model::Envelope, pass)
            .unwrap()
            .scallop_height(Length::from_mm(step_over).unwrap(), None)
            .unwrap()
            .total()
            .mm();
        for length in [0.5, 40.0] {
            let plane = Plane::new(slope, 17.0, feed);
            let milled = milled(&Profile::torus(5.0, 2.0), &plane.passes(5.0, 2.0, step_over, length));
            // The ridge is at most 1/8000 of the step-over from a place; a ridge falls off at most as 4 h per step-over.
            assert_relative_eq!(ridge(&plane, &milled, step_over), expected, max_relative = 6e-4);
        }
    }
}

/// A profile with a barrel side, whose centre is beyond the axis, and one with a cone.
fn other_profiles() -> [Profile; 2] {
    use crate::milling::ProfileArc;
    let arc = |radius: f64, centre_offset: f64, centre_height: f64, from: f64, to: f64| ProfileArc {
        radius,
        centre_offset,
        centre_height,
        from,
        to,
    };
    let joint = ((80.0 - 5.0) / (80.0 - 2.0_f64)).asin();
    let side_height = 2.0 + (80.0 - 2.0) * joint.cos();
    let oval = [arc(2.0, 0.0, 2.0, 0.0, joint), arc(80.0, -75.0, side_height, joint, std::f64::consts::FRAC_PI_2)];
    let end = std::f64::consts::FRAC_PI_2 - 0.1;
    let ball = arc(1.0, 0.0, 1.0, 0.0, end);
    let (rho, z) = ball.point(end);
    let shank = arc(0.0, 3.0, z + (3.0 - rho) * end.tan(), end, std::f64::consts::FRAC_PI_2);
    [Profile::of_arcs(&oval).unwrap(), Profile::of_arcs(&[ball, shank]).unwrap()]
}

#[test]
fn the_level_is_the_first_of_the_ray_in_the_solid_at_many_tips() {
    let [oval, tapered] = other_profiles();
    let mut random = Random::new(7);
    let mut hits = 0;
    for profile in [Profile::torus(3.0, 3.0), Profile::torus(3.0, 1.0), Profile::torus(3.0, 0.0), oval, tapered] {
        for _ in 0..60 {
            let mut within = |low: f64, high: f64| low + (high - low) * random.unit();
            let from = Vector3::new(within(-2.0, 2.0), within(-2.0, 2.0), within(-2.0, 2.0));
            let to = from + Vector3::new(within(-3.0, 3.0), within(-3.0, 3.0), within(-2.0, 2.0));
            let slope = within(0.0, 1.5);
            let azimuth = within(0.0, 6.3);
            let normal = Vector3::new(slope.sin() * azimuth.cos(), slope.sin() * azimuth.sin(), slope.cos());
            let point = Vector3::new(within(-3.0, 3.0), within(-3.0, 3.0), within(-2.0, 1.0));
            let found = milled(&profile, &[cut(from, to)]).left_at(point.into(), normal.into());
            let is_inside = |t: f64| {
                (0..=2000).any(|step| {
                    let tip = from + (to - from) * f64::from(step) / 2000.0;
                    let q = point + normal * t - tip;
                    q.z >= profile.low(q.x.hypot(q.y))
                })
            };
            // Points every 2 um on the ray; 2001 tips leave up to 5e-4 mm of the swept solid out, seen along the ray at most
            // a hundredth where the ray grazes it.
            if let Some(left) = found {
                hits += 1;
                let step = 0.01;
                if left.height < 0.0 {
                    // The largest ball about the place that is in the solid, or less along the normal.
                    let is_ball_inside = |radius: f64| {
                        (0..300).all(|number| {
                            let (z, turn) = (-1.0 + f64::from(number) / 149.5, 2.4 * f64::from(number));
                            let level = (1.0 - z * z).max(0.0).sqrt();
                            let about = point + Vector3::new(level * turn.cos(), level * turn.sin(), z) * radius;
                            (0..=2000).any(|step| {
                                let q = about - from - (to - from) * f64::from(step) / 2000.0;
                                q.z >= profile.low(q.x.hypot(q.y))
                            })
                        })
                    };
                    assert!(is_ball_inside(-0.98 * left.height - 1e-3), "{profile:?} {left:?}: {from} {to} {point} {normal}");
                    continue;
                }
                let outside = (1..200).map(|back| left.height - f64::from(back) * step).take_while(|t| *t > -2.0).all(|t| !is_inside(t));
                assert!(outside, "{profile:?} enters before {left:?}: {from} {to} {point} {normal}");
                let inside = (0..20).any(|on| is_inside(left.height + f64::from(on) * 1e-3));
                assert!(inside, "{profile:?} is not entered at {left:?}: {from} {to} {point} {normal}");
            } else {
                let enters = (0..600).map(|step| f64::from(step) * 0.01).any(is_inside);
                assert!(!enters, "{profile:?} is entered: {from} {to} {point} {normal}");
            }
        }
    }
    assert!(hits > 100, "{hits}");
}

#[test]
fn faults_of_a_path_are_found_with_their_moves() {
    let plane = Plane::new(0.0, 0.0, 0.0);
    let mut moves = plane.passes(3.0, 3.0, 0.5, 40.0);
    let ball = Profile::torus(3.0, 3.0);
    let up: [f64; 3] = Vector3::z().into();
    let place = plane.at(1.0, 2.1).into();
    let sound = milled(&ball, &moves).left_at(place, up).unwrap();
    // One pass 0.03 mm too low: a gouge of that depth under it.
    let lowered = sound.by as usize;
    moves[lowered].from[2] -= 0.03;
    moves[lowered].to[2] -= 0.03;
    let under = plane.at(1.0, moves[lowered].from[1]).into();
    let gouge = milled(&ball, &moves).left_at(under, up).unwrap();
    assert_relative_eq!(gouge.height, -0.03, epsilon = 1e-9);
    assert_eq!(gouge.by as usize, lowered);
    // Left out: the ridge between passes that are twice as far apart.
    let missing = moves.remove(lowered);
    let middle = [1.0, missing.from[1], 0.0];
    assert_relative_eq!(milled(&ball, &moves).left_at(middle, up).unwrap().height, 3.0 - (9.0_f64 - 0.25).sqrt(), epsilon = 1e-9);
    // A rapid clears nothing and collides.
    let rapid = Move { from: [-50.0, 0.0, -0.2], to: [50.0, 0.0, -0.2], kind: MoveKind::Rapid };
    moves.push(rapid);
    let with_rapid = milled(&ball, &moves);
    assert!(with_rapid.left_at([1.0, 0.0, 0.0], up).unwrap().height >= -1e-9);
    let hit = with_rapid.collision_at([1.0, 0.0, 0.0], up).unwrap();
    assert_relative_eq!(hit.height, -0.2, epsilon = 1e-9);
    assert_eq!(hit.by as usize, moves.len() - 1);
    assert_eq!(with_rapid.left_at([1.0, 60.0, 0.0], up), None);
}

#[test]
fn a_flat_end_beside_a_wall_touches_it_with_its_side() {
    let pass = [cut(Vector3::new(-10.0, 3.0, 0.0), Vector3::new(10.0, 3.0, 0.0))];
    let milled = milled(&Profile::torus(2.5, 0.0), &pass);
    // The wall y = 0.4 faces the cutter's side at y = 0.5. The side leans by 1e-6 of its height.
    let left = milled.left_at([0.0, 0.4, 3.0], [0.0, 1.0, 0.0]).unwrap();
    assert_relative_eq!(left.height, 0.1, epsilon = 4e-6);
    // A wall behind the one that is cut: the cutter does not come to its outer side.
    assert_eq!(milled.left_at([0.0, 8.0, 3.0], [0.0, 1.0, 0.0]), None);
    // A plunge clears what its lower end holds.
    let plunge = [cut(Vector3::new(0.0, 0.0, 5.0), Vector3::new(0.0, 0.0, 1.0))];
    let plunged = super::tests::milled(&Profile::torus(2.5, 0.5), &plunge);
    assert_relative_eq!(plunged.left_at([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]).unwrap().height, 1.0, epsilon = 1e-9);
}

/// A block of 30 by 30 mm with a step up of 4 mm at x = 15.
fn step_in_a_plate() -> Mesh {
    let mut builder = MeshBuilder::new();
    let corner = |x: f64, z: f64| [[x, 0.0, z], [x, 30.0, z]];
    for [[a, b], [c, d]] in
        [[corner(0.0, 0.0), corner(15.0, 0.0)], [corner(15.0, 0.0), corner(15.0, 4.0)], [corner(15.0, 4.0), corner(30.0, 4.0)]]
    {
        builder.indexed(&[a, b, c, d], &[[0, 2, 1], [1, 2, 3]]).unwrap();
    }
    builder.finish(Unit::Millimetre, Facing::Up, &|| false).unwrap()
}

fn level_facets(mesh: &Mesh) -> Vec<u32> {
    (0..mesh.triangles().len()).filter(|&facet| mesh.normal_and_area(facet).0[2] > 0.5).map(|facet| facet as u32).collect()
}

#[test]
fn the_finish_of_a_stepped_plate_is_that_of_its_geometry() {
    let mesh = step_in_a_plate();
    let (radius, step_over) = (2.0, 0.4);
    let mut moves = Vec::new();
    for pass in -5..=80 {
        let y = step_over * f64::from(pass);
        for (from, to, z) in [(-3.0, 13.0, 0.0), (13.0, 33.0, 4.0)] {
            moves.push(cut(Vector3::new(from, y, z), Vector3::new(to, y, z)));
        }
    }
    let milled = milled(&Profile::torus(radius, radius), &moves);
    let drop = DropCutter::of_mesh(&mesh, &|| false);
    let places = Places::draw(&mesh, &level_facets(&mesh), 40_000, 1).with_cuts(&mesh, &level_facets(&mesh), &drop, 10_000);
    assert_relative_eq!(places.area(), 900.0, epsilon = 1e-9);
    let tolerance = 0.011;
    let profiles = [Profile::torus(radius, radius)];
    let reach = Reach::new(&profiles, &drop, &places, tolerance);
    let finish = Finish::new(&milled, &mesh, &places, &reach, tolerance, &|| false).unwrap();
    let ridge = radius - (radius * radius - step_over * step_over / 4.0).sqrt();
    // Up to the ball's centre at 2 mm from the wall all can be reached; nearer, the ball touches the wall first. A strip of
    // 1.8 mm of 30 is left at more than 11 um: R - sqrt(R^2 - d^2) = 0.011 at d = 0.21 mm, less across the ridges.
    let over = finish.over_share.value;
    assert!((1.80 / 30.0..1.92 / 30.0).contains(&over), "{over}");
    assert!(finish.over_reachable_share.value < 4.0 * finish.over_share.standard_error, "{:?}", finish.over_reachable_share);
    let residual = finish.reached.unwrap();
    assert_relative_eq!(residual.p50, ridge / 4.0, max_relative = 0.03);
    assert!(residual.max <= OVER * tolerance && residual.max >= ridge - 1e-6, "{residual:?}");
    assert!(finish.unreachable_height > 1.5, "{}", finish.unreachable_height);
    assert!(finish.gouge_share.value <= 0.0);
    assert!(finish.gouge.is_none_or(|gouge| gouge.left.height > -1e-6), "{:?}", finish.gouge);
    // Between the ends of two passes a corner of 0.2 by 0.01 mm is not under the ball.
    assert!(finish.uncut_share.value < 1e-3, "{:?}", finish.uncut_share);
    assert!(finish.used_share.value > 0.99, "{:?}", finish.used_share);
}

#[test]
fn the_deepest_gouge_is_at_the_edge_that_a_chord_cuts_off() {
    let mesh = step_in_a_plate();
    // A link that drops over the edge at (15, y, 4), 0.1 mm under it.
    let mut moves = vec![cut(Vector3::new(20.0, 10.3, 4.0), Vector3::new(15.0 + 1.0, 10.3, 4.0 - 0.05))];
    moves.push(cut(Vector3::new(16.0, 10.3, 3.95), Vector3::new(9.0, 10.3, 3.6)));
    let profile = Profile::torus(3.0, 3.0);
    let milled = milled(&profile, &moves);
    let drop = DropCutter::of_mesh(&mesh, &|| false);
    let places = Places::draw(&mesh, &level_facets(&mesh), 2000, 3).with_cuts(&mesh, &level_facets(&mesh), &drop, 500);
    let profiles = [profile];
    let reach = Reach::new(&profiles, &drop, &places, 0.01);
    let finish = Finish::new(&milled, &mesh, &places, &reach, 0.01, &|| false).unwrap();
    let gouge = finish.gouge.unwrap();
    // The ball's centre passes on a line that falls by 0.05 per mm, 2.9 mm over the edge at x = 15.
    let expected = 2.9 / 1.0025_f64.sqrt() - 3.0;
    assert_relative_eq!(gouge.left.height, expected, epsilon = 1e-5);
    assert_eq!(gouge.left.by, 1);
}

#[test]
fn the_deepest_gouge_is_at_the_point_of_a_small_pyramid_that_a_pass_cuts_off() {
    let corner = |x: f64, y: f64| [15.0 + x, 15.0 + y, 0.0];
    let mut builder = MeshBuilder::new();
    let (outer, inner) =
        ([[-15.0, -15.0], [15.0, -15.0], [15.0, 15.0], [-15.0, 15.0]], [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]);
    let points: Vec<[f64; 3]> = outer.into_iter().chain(inner).map(|[x, y]| corner(x, y)).chain([[15.0, 15.0, 0.2]]).collect();
    let sides = (0..4).flat_map(|side| {
        let next = (side + 1) % 4;
        [[side, next, 4 + next], [side, 4 + next, 4 + side], [4 + side, 4 + next, 8]]
    });
    builder.indexed(&points, &sides.collect::<Vec<[u64; 3]>>()).unwrap();
    let mesh = builder.finish(Unit::Millimetre, Facing::Up, &|| false).unwrap();
    let profile = Profile::torus(3.0, 1.0);
    let milled = milled(&profile, &[cut(Vector3::new(0.0, 15.3, 0.198), Vector3::new(30.0, 15.3, 0.198))]);
    let facets: Vec<u32> = (0..12).collect();
    let drop = DropCutter::of_mesh(&mesh, &|| false);
    let places = Places::draw(&mesh, &facets, 1000, 1).with_cuts(&mesh, &facets, &drop, 100);
    let profiles = [profile];
    let finish = Finish::new(&milled, &mesh, &places, &Reach::new(&profiles, &drop, &places, 0.01), 0.01, &|| false).unwrap();
    let gouge = finish.gouge.unwrap();
    // None of the random places is on the pyramid.
    assert!(places.inside().iter().all(|place| place.point[2] <= 0.0));
    assert_relative_eq!(gouge.place.point[2], 0.2);
    assert_relative_eq!(gouge.left.height, -0.002, epsilon = 1e-9);
}

#[test]
fn a_stopped_computation_has_no_result() {
    let mesh = step_in_a_plate();
    let drop = DropCutter::of_mesh(&mesh, &|| false);
    let places = Places::draw(&mesh, &level_facets(&mesh), 1000, 3).with_cuts(&mesh, &level_facets(&mesh), &drop, 500);
    let profile = Profile::torus(3.0, 3.0);
    let profiles = [profile];
    let reach = Reach::new(&profiles, &drop, &places, 0.01);
    assert!(Milled::new(&profile, &[], &|| true).is_none());
    assert!(Finish::new(&milled(&profile, &[]), &mesh, &places, &reach, 0.01, &|| true).is_none());
    let nothing = Finish::new(&milled(&profile, &[]), &mesh, &places, &reach, 0.01, &|| false).unwrap();
    assert!(nothing.uncut_share.value >= 1.0);
    assert_eq!(nothing.residual, None);
}
