//! The drop-cutter against closed forms, against a search over the facets' points, and against laws.

use super::*;
use crate::milling::ProfileArc;
use approx::assert_abs_diff_eq;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Numbers from 0 to 1, the same in every run.
struct Random(u64);

impl Random {
    #[expect(clippy::cast_precision_loss, reason = "53 bits are kept")]
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * self.next()
    }
}

fn tapered_ball() -> Profile {
    let (radius, taper) = (1.0, 0.2_f64);
    let end = FRAC_PI_2 - taper;
    let ball = ProfileArc { radius, centre_offset: 0.0, centre_height: radius, from: 0.0, to: end };
    let (rho, z) = ball.point(end);
    let shank = ProfileArc { radius: 0.0, centre_offset: 2.0, centre_height: z + (2.0 - rho) * end.tan(), from: end, to: FRAC_PI_2 };
    Profile::of_arcs(&[ball, shank]).unwrap()
}

/// A ball of 1 mm, then a side of 20 mm whose centre is beyond the axis: R = 3 mm.
fn oval() -> Profile {
    let (tip, side, radius) = (1.0, 20.0, 3.0_f64);
    let joint = ((side - radius) / (side - tip)).asin();
    let ball = ProfileArc { radius: tip, centre_offset: 0.0, centre_height: tip, from: 0.0, to: joint };
    let centre_height = tip + (side - tip) * joint.cos();
    let barrel = ProfileArc { radius: side, centre_offset: radius - side, centre_height, from: joint, to: FRAC_PI_2 };
    Profile::of_arcs(&[ball, barrel]).unwrap()
}

/// A cone of 45 deg with a sharp tip and R = 2 mm.
fn cone() -> Profile {
    let tip = ProfileArc { radius: 0.0, centre_offset: 0.0, centre_height: 0.0, from: 0.0, to: FRAC_PI_2 / 2.0 };
    let rim = ProfileArc { radius: 0.0, centre_offset: 2.0, centre_height: 2.0, from: FRAC_PI_2 / 2.0, to: FRAC_PI_2 };
    Profile::of_arcs(&[tip, rim]).unwrap()
}

fn profiles() -> [Profile; 6] {
    [Profile::torus(3.0, 1.0), Profile::torus(2.0, 2.0), Profile::torus(2.5, 0.0), tapered_ball(), oval(), cone()]
}

fn cutter_over(facets: &[[[f64; 3]; 3]]) -> DropCutter {
    DropCutter::new(facets, &|| false)
}

fn height(drop: &DropCutter, profile: &Profile, [x, y]: [f64; 2]) -> f64 {
    drop.drop(profile, x, y, None).unwrap().height
}

/// z = f(x, y) over a square of side 2 `half`, in 2 n^2 triangles.
fn surface(half: f64, n: u32, f: impl Fn(f64, f64) -> f64) -> Vec<[[f64; 3]; 3]> {
    let at = |i: u32, j: u32| {
        let [x, y] = [i, j].map(|k| half * (2.0 * f64::from(k) / f64::from(n) - 1.0));
        [x, y, f(x, y)]
    };
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    cells.flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]).collect()
}

/// Facets of every size and slope, with their corners in a box around the origin.
fn scattered(random: &mut Random, count: usize) -> Vec<[[f64; 3]; 3]> {
    (0..count)
        .map(|_| {
            let centre = [random.between(-6.0, 6.0), random.between(-6.0, 6.0), random.between(-1.0, 1.0)];
            let size = 4.0 * random.next().powi(2);
            [0, 1, 2].map(|_| centre.map(|part| part + size * random.between(-1.0, 1.0)))
        })
        .collect()
}

/// The largest value of a concave function from 0 to 1: each step keeps two thirds of the interval, (2/3)^48 = 4e-9.
fn largest(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    let mut best = f(0.0).max(f(1.0));
    for _ in 0..48 {
        let (one, other) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        let (f_one, f_other) = (f(one), f(other));
        best = best.max(f_one).max(f_other);
        if f_one < f_other { low = one } else { high = other }
    }
    best
}

/// T by its definition: a search over the points of each facet. Beyond R the profile goes on steeper than any facet, which
/// keeps the function concave and its largest value within R.
fn searched(facets: &[[[f64; 3]; 3]], profile: &Profile, at: [f64; 2]) -> f64 {
    const STEEP: f64 = 3000.0;
    let radius = profile.outer_radius();
    let end = profile.low(radius);
    let limit = |p: [f64; 3]| {
        let rho = (p[0] - at[0]).hypot(p[1] - at[1]);
        p[2] - if rho <= radius { profile.low(rho) } else { end + STEEP * (rho - radius) }
    };
    let mix = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|axis| a[axis] + t * (b[axis] - a[axis]));
    let of_facet = |[a, b, c]: [[f64; 3]; 3]| largest(|u| largest(|v| limit(mix(mix(a, b, u), mix(a, c, u), v))));
    facets.iter().map(|facet| of_facet(*facet)).fold(f64::NEG_INFINITY, f64::max)
}

fn slope_of([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let plane = Plane::of(&[a, b, c]).gradient;
    plane[0].hypot(plane[1])
}

#[test]
fn the_height_is_the_largest_over_all_points_of_the_facets() {
    let mut random = Random(1);
    let facets: Vec<_> = scattered(&mut random, 60).into_iter().filter(|facet| slope_of(*facet) < 300.0).collect();
    assert!(facets.len() > 50);
    let drop = cutter_over(&facets);
    for profile in profiles() {
        for _ in 0..12 {
            let at = [random.between(-4.0, 4.0), random.between(-4.0, 4.0)];
            // The search finds heights to 4e-9 times facets of 8 mm times slopes up to 300: 1e-5.
            assert_abs_diff_eq!(height(&drop, &profile, at), searched(&facets, &profile, at), epsilon = 1e-5);
        }
    }
}

#[test]
fn no_point_of_any_facet_is_inside_the_cutter() {
    let mut random = Random(2);
    let facets = scattered(&mut random, 200);
    let drop = cutter_over(&facets);
    for profile in profiles() {
        for _ in 0..10 {
            let at = [random.between(-5.0, 5.0), random.between(-5.0, 5.0)];
            let height = height(&drop, &profile, at);
            for [a, b, c] in &facets {
                for _ in 0..20 {
                    let (u, v) = (random.next(), random.next());
                    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                    let p = [0, 1, 2].map(|axis| a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis]));
                    assert!(p[2] - profile.low((p[0] - at[0]).hypot(p[1] - at[1])) <= height + 1e-9);
                }
            }
        }
    }
}

#[test]
fn a_plane_carries_every_cutter_at_its_support() {
    for slope in [0.0_f64, 0.1, 0.5, 0.9, 1.2] {
        let azimuth = 0.7_f64;
        let [gx, gy] = [slope.tan() * azimuth.cos(), slope.tan() * azimuth.sin()];
        let drop = cutter_over(&surface(20.0, 16, |x, y| gx * x + gy * y));
        for profile in profiles() {
            let arc = profile.arc_at(slope);
            // The tip is the profile's point with the plane's normal, moved to the origin.
            let (rho, z) = arc.point(slope);
            let touch = drop.drop(&profile, 0.3, -0.2, None).unwrap();
            assert_abs_diff_eq!(touch.height, gx * 0.3 - gy * 0.2 + rho * slope.tan() - z, epsilon = 1e-9);
            let normal = Vector3::new(-gx, -gy, 1.0).normalize();
            assert_abs_diff_eq!((touch.normal - normal).norm(), 0.0, epsilon = 1e-9);
        }
    }
}

#[test]
fn a_ball_on_an_edge_and_on_a_vertex() {
    // A ridge along y, and the corner of a level plate.
    let ridge = [[[0.0, -9.0, 1.0], [0.0, 9.0, 1.0], [-1.0, 0.0, -9.0]], [[0.0, -9.0, 1.0], [0.0, 9.0, 1.0], [1.0, 0.0, -9.0]]];
    let ball = Profile::torus(2.0, 2.0);
    let touch = cutter_over(&ridge).drop(&ball, 1.2, 0.5, None).unwrap();
    // 2 - sqrt(4 - 1.44) = 0.4
    assert_abs_diff_eq!(touch.height, 0.6, epsilon = 1e-12);
    assert!(matches!(touch.feature, Feature::Edge(_)));
    assert_abs_diff_eq!((touch.contact - Vector3::new(0.0, 0.5, 1.0)).norm(), 0.0, epsilon = 1e-12);
    assert_abs_diff_eq!((touch.normal - Vector3::new(0.6, 0.0, 0.8)).norm(), 0.0, epsilon = 1e-12);

    let plate = cutter_over(&[[[0.0, 0.0, 1.0], [0.0, -9.0, 1.0], [-9.0, 0.0, 1.0]]]);
    let touch = plate.drop(&ball, 0.8, 0.8, None).unwrap();
    assert_abs_diff_eq!(touch.height, 1.0 - (2.0 - (4.0_f64 - 1.28).sqrt()), epsilon = 1e-12);
    assert!(matches!(touch.feature, Feature::Vertex(_)));
    assert_eq!(plate.drop(&ball, 1.5, 1.5, None), None);
    // An inclined edge, touched where the ball's normal is perpendicular to it: the distance of the centre from the edge is R.
    let incline = cutter_over(&[[[-9.0, 0.0, -4.5], [9.0, 0.0, 4.5], [0.0, 0.0, -20.0]]]);
    let touch = incline.drop(&ball, 1.0, 1.0, None).unwrap();
    let centre = Vector3::new(1.0, 1.0, touch.height + 2.0);
    let along = Vector3::new(2.0, 0.0, 1.0).normalize();
    assert_abs_diff_eq!((centre - along * centre.dot(&along)).norm(), 2.0, epsilon = 1e-12);
    assert_abs_diff_eq!((touch.contact - centre).dot(&along), 0.0, epsilon = 1e-12);
}

#[test]
fn a_flat_end_beside_a_wall_stands_on_the_floor_up_to_its_radius() {
    let floor = [[-20.0, -20.0, 0.0], [0.0, -20.0, 0.0], [0.0, 20.0, 0.0], [-20.0, 20.0, 0.0]];
    let wall = [[0.0, -20.0, 0.0], [0.0, 20.0, 0.0], [0.0, 20.0, 7.0], [0.0, -20.0, 7.0]];
    let facets = [floor, wall].map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).concat();
    let drop = cutter_over(&facets);
    let flat = Profile::torus(2.5, 0.0);
    assert_abs_diff_eq!(height(&drop, &flat, [-2.5 - 1e-9, 0.3]), 0.0, epsilon = 1e-12);
    assert_abs_diff_eq!(height(&drop, &flat, [-2.5 + 1e-9, 0.3]), 7.0, epsilon = 1e-12);
    let torus = Profile::torus(2.5, 1.0);
    // Two from the wall, the corner's circle is over the wall's top edge: w = 0.5, low = 1 - sqrt(1 - 0.25).
    assert_abs_diff_eq!(height(&drop, &torus, [-2.0, 0.3]), 7.0 - (1.0 - 0.75_f64.sqrt()), epsilon = 1e-12);
    let (floor, level) = drop.facet_over(-1.0, 1.0).unwrap();
    assert!(level.abs() < 1e-12 && drop.corners(floor).iter().all(|corner| corner[2].abs() < 1e-12), "facet {floor} at {level}");
    assert_eq!(drop.facet_over(1.0, 1.0), None);
}

/// Corners turned about the z axis, and mirrored at the plane y = 0.
fn turned(facets: &[[[f64; 3]; 3]], angle: f64) -> Vec<[[f64; 3]; 3]> {
    facets.iter().map(|facet| facet.map(|[x, y, z]| turned_point([x, y], angle, z))).collect()
}

fn turned_point([x, y]: [f64; 2], angle: f64, z: f64) -> [f64; 3] {
    [x * angle.cos() - y * angle.sin(), x * angle.sin() + y * angle.cos(), z]
}

#[test]
fn turned_mirrored_raised_and_turned_over_parts_carry_the_cutter_alike() {
    let mut random = Random(3);
    let facets = scattered(&mut random, 120);
    let drop = cutter_over(&facets);
    let over: Vec<_> = facets.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let mirrored: Vec<_> = facets.iter().map(|facet| facet.map(|[x, y, z]| [x, -y, z + 3.0])).collect();
    let (over, mirrored) = (cutter_over(&over), cutter_over(&mirrored));
    for profile in profiles() {
        for _ in 0..20 {
            let angle = random.between(0.0, TAU);
            let at = [random.between(-5.0, 5.0), random.between(-5.0, 5.0)];
            let expected = height(&drop, &profile, at);
            assert_abs_diff_eq!(height(&over, &profile, at), expected, epsilon = 2e-9);
            assert_abs_diff_eq!(height(&mirrored, &profile, [at[0], -at[1]]), expected + 3.0, epsilon = 2e-9);
            let [x, y, _] = turned_point(at, angle, 0.0);
            // Rounding of 1e-15 in positions, times the slope of the steepest facets and edges.
            assert_abs_diff_eq!(height(&cutter_over(&turned(&facets, angle)), &profile, [x, y]), expected, epsilon = 1e-8);
        }
    }
}

#[test]
fn a_guess_changes_no_height() {
    let facets = surface(10.0, 40, |x, y| (0.9 * x).sin() * (0.7 * y).cos());
    let drop = cutter_over(&facets);
    let mut random = Random(4);
    for profile in profiles() {
        for _ in 0..50 {
            let at = [random.between(-9.0, 9.0), random.between(-9.0, 9.0)];
            let expected = height(&drop, &profile, at);
            for guess in [0, 7, 1599, 3199, u32::MAX] {
                assert_abs_diff_eq!(drop.drop(&profile, at[0], at[1], Some(guess)).unwrap().height, expected, epsilon = 2e-9);
            }
        }
    }
}

#[test]
fn a_tip_is_lifted_if_the_cutter_stands_higher_and_by_a_facet_that_holds_it() {
    let mut random = Random(6);
    let facets = [scattered(&mut random, 120), surface(10.0, 20, |x, y| (0.9 * x).sin() * (0.7 * y).cos())].concat();
    let drop = cutter_over(&facets);
    for profile in profiles() {
        for _ in 0..200 {
            let [x, y] = [random.between(-9.0, 9.0), random.between(-9.0, 9.0)];
            let stands = height(&drop, &profile, [x, y]);
            for guess in [None, Some(3), Some(500)] {
                for lower in [1e-7, 0.01, 1.0, 100.0] {
                    let tip = [x, y, stands - lower];
                    let facet = drop.lifting(&profile, tip, guess).unwrap();
                    assert!(height(&cutter_over(&[drop.corners(facet)]), &profile, [x, y]) > tip[2]);
                }
                assert_eq!(drop.lifting(&profile, [x, y, stands + 1e-7], guess), None);
            }
        }
    }
    assert_eq!(drop.lifting(&Profile::torus(1.0, 0.5), [100.0, 0.0, -1e3], None), None);
}

#[test]
fn the_touch_is_where_the_cutter_is() {
    let mut random = Random(5);
    let facets = scattered(&mut random, 120);
    let drop = cutter_over(&facets);
    for profile in profiles() {
        for _ in 0..100 {
            let [x, y] = [random.between(-5.0, 5.0), random.between(-5.0, 5.0)];
            let touch = drop.drop(&profile, x, y, None).unwrap();
            let out = [touch.contact.x - x, touch.contact.y - y];
            let rho = out[0].hypot(out[1]).min(profile.outer_radius());
            assert_abs_diff_eq!(touch.contact.z - touch.height, profile.low(rho), epsilon = 1e-6);
            assert_abs_diff_eq!(touch.normal.norm(), 1.0, epsilon = 1e-12);
            // The cutter is convex: from its contact, no point of it is below the plane with this normal.
            for step in 0..=20 {
                let rho = profile.outer_radius() * f64::from(step) / 20.0;
                for turn in 0..12 {
                    let (sin, cos) = (TAU * f64::from(turn) / 12.0).sin_cos();
                    let point = Vector3::new(x + rho * cos, y + rho * sin, touch.height + profile.low(rho));
                    assert!((point - touch.contact).dot(&touch.normal) >= -1e-6);
                }
            }
        }
    }
}

#[test]
fn between_two_tips_on_one_convex_facet_the_height_is_concave() {
    // T is the largest of concave functions, one for each facet; of a single facet it is concave where the disc meets it.
    let drop = cutter_over(&[[[-4.0, -3.0, 0.5], [5.0, -1.0, 2.0], [0.0, 4.0, -1.0]]]);
    let mut random = Random(6);
    for profile in profiles() {
        for _ in 0..100 {
            let [a, b] = [0, 1].map(|_| [random.between(-3.0, 3.0), random.between(-3.0, 3.0)]);
            let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let heights = [a, middle, b].map(|at| drop.drop(&profile, at[0], at[1], None).map(|touch| touch.height));
            if let [Some(a), Some(middle), Some(b)] = heights {
                assert!(middle >= 0.5 * (a + b) - 1e-8);
            }
        }
    }
}

#[test]
fn no_facets_and_facets_without_area_are_no_fault() {
    let flat = Profile::torus(2.0, 0.0);
    assert_eq!(cutter_over(&[]).drop(&flat, 0.0, 0.0, Some(3)), None);
    assert_eq!(cutter_over(&[]).facet_over(0.0, 0.0), None);
    let point = [[1.0, 0.0, 3.0]; 3];
    assert_abs_diff_eq!(height(&cutter_over(&[point]), &flat, [0.0, 0.0]), 3.0);
    assert_eq!(cutter_over(&[point]).drop(&flat, 4.0, 0.0, None), None);
    assert_eq!(DropCutter::new(&[point], &|| true).facets(), 0);
}

#[test]
fn the_paraboloid_under_a_cutter_is_nowhere_over_its_bottom() {
    let mut random = Random(41);
    let mut bent = 0;
    for profile in profiles() {
        let bottom = Bottom::of(&profile);
        let radius = bottom.radius();
        for step in 0..400 {
            // Everywhere, and at the corners of the profile.
            let ends = profile.arcs().iter().flat_map(|arc| [arc.point(arc.from).0, arc.point(arc.to).0]).filter(|end| *end < radius);
            let corners: Vec<f64> = ends.chain([0.0]).collect();
            let rho = if step % 4 == 0 { corners[step / 4 % corners.len()].max(0.0) } else { random.between(0.0, radius) };
            let (flattest, steepest) = bottom.tangents(rho);
            let tangent = random.between(flattest, steepest.min(flattest + 3.0));
            let bend = bottom.bend(rho, tangent);
            assert!(bend >= 0.0 && bend.is_finite(), "{profile:?} {rho} {tangent}");
            bent += u32::from(bend > 0.0);
            for _ in 0..400 {
                let (at, angle) = (random.between(0.0, radius), random.between(0.0, TAU));
                let (along, beside) = (at * angle.cos() - rho, at * angle.sin());
                let under = bottom.low(rho) + tangent * along + 0.5 * bend * (along * along + beside * beside);
                assert!(under <= bottom.low(at) + 1e-9, "{profile:?} {rho} {tangent} {bend}: {under} at {at}, {angle}");
            }
        }
    }
    assert!(bent > 1000, "{bent}");
}
