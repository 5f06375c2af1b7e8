//! Lines over parts with walls, ridges and valleys: dense samples of T are within the tolerance of the chords.

use super::*;
use approx::assert_abs_diff_eq;

const TOLERANCE: f64 = 0.002;

fn quads(quads: &[[[f64; 3]; 4]]) -> DropCutter {
    let facets: Vec<_> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    DropCutter::new(&facets, &|| false)
}

/// A strip along y with this outline in the plane y = 0; consecutive points may be over each other.
fn extruded(outline: &[[f64; 2]]) -> DropCutter {
    let quad = |a: [f64; 2], b: [f64; 2]| [[a[0], -30.0, a[1]], [b[0], -30.0, b[1]], [b[0], 30.0, b[1]], [a[0], 30.0, a[1]]];
    quads(&outline.windows(2).map(|ends| quad(ends[0], ends[1])).collect::<Vec<_>>())
}

fn waves() -> DropCutter {
    let n = 200;
    let at = |i: i32, j: i32| {
        let [x, y] = [i, j].map(|k| 70.0 * f64::from(k) / f64::from(n) - 35.0);
        [x, y, 2.0 * (0.25 * x).sin() * (0.2 * y).cos()]
    };
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    quads(&cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect::<Vec<_>>())
}

fn profiles() -> [Profile; 4] {
    [Profile::torus(3.0, 3.0), Profile::torus(3.0, 1.0), Profile::torus(3.0, 0.0), Profile::torus(5.0, 0.5)]
}

/// The largest depth of the chords under T and their largest height over T, over places at which the chord's own place is
/// certain: 2e-4 mm away from steps, which are 1e-4 mm wide.
fn deviations(drop: &DropCutter, profile: &Profile, tips: &[Tip]) -> [f64; 2] {
    let (mut under, mut over) = (0.0_f64, 0.0_f64);
    for ends in tips.windows(2) {
        let (a, b) = (ends[0].vector(), ends[1].vector());
        let length = (b - a).xy().norm();
        let parts = (length / 0.008).ceil().max(1.0);
        let mut part = 0.5;
        while part < parts {
            let at = a + (b - a) * (part / parts);
            part += 1.0;
            let height = drop.drop(profile, at.x, at.y, None).unwrap().height;
            under = under.max(height - at.z);
            if length > 2e-4 {
                over = over.max(at.z - height);
            }
        }
    }
    [under, over]
}

fn check(drop: &DropCutter, from: [f64; 2], to: [f64; 2]) {
    for profile in profiles() {
        let tips = tips_between(drop, &profile, from, to, &Sampling::fine(&profile, TOLERANCE), None);
        for (end, tip) in [(from, tips.first()), (to, tips.last())] {
            let position = tip.unwrap().vector();
            assert!((position.x - end[0]).hypot(position.y - end[1]) < 1e-9);
        }
        let [under, over] = deviations(drop, &profile, &tips);
        assert!(under <= TOLERANCE && over <= TOLERANCE, "{profile:?}: {under} under, {over} over");
    }
}

#[test]
fn chords_over_waves_keep_the_tolerance() {
    let drop = waves();
    check(&drop, [-30.0, -20.0], [30.0, 17.0]);
    check(&drop, [-25.0, 3.0], [25.0, 3.0]);
}

#[test]
fn chords_over_ridges_valleys_and_walls_keep_the_tolerance() {
    // A valley, a ridge, a slanted wall, a step up and down, and a thin rib.
    let outline = [
        [-25.0, 0.0],
        [-18.0, 3.0],
        [-14.0, -2.0],
        [-10.0, -2.0],
        [-9.0, 4.0],
        [-2.0, 4.0],
        [-2.0, 0.0],
        [6.0, 0.0],
        [6.0, 5.0],
        [6.2, 5.0],
        [6.2, 0.0],
        [25.0, 0.0],
    ];
    let drop = extruded(&outline);
    check(&drop, [-20.0, 0.0], [20.0, 0.0]);
    check(&drop, [19.0, -7.3], [-19.0, 11.1]);
}

/// A frustum on the floor: its top turned by `angle`, its sides out of plumb by `taper`.
fn frustum([x, y]: [f64; 2], [a, b]: [f64; 2], top: f64, angle: f64, taper: f64) -> Vec<[[f64; 3]; 4]> {
    let corner = |k: usize, wider: f64, z: f64| {
        let (u, v) = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(i, j)| (i * (a + wider), j * (b + wider)))[k % 4];
        [x + u * angle.cos() - v * angle.sin(), y + u * angle.sin() + v * angle.cos(), z]
    };
    let side = |k| [corner(k, taper, 0.0), corner(k + 1, taper, 0.0), corner(k + 1, 0.0, top), corner(k, 0.0, top)];
    let mut faces: Vec<_> = (0..4).map(side).collect();
    faces.push([0, 1, 2, 3].map(|k| corner(k, 0.0, top)));
    faces
}

#[test]
fn chords_over_blocks_and_frustums_keep_the_tolerance() {
    for part in 0..6 {
        let mut faces = vec![[[-40.0, -40.0, 0.0], [40.0, -40.0, 0.0], [40.0, 40.0, 0.0], [-40.0, 40.0, 0.0]]];
        for block in 0..5 {
            // Sines of multiples of the golden ratio's fraction are as good as random numbers, and the same everywhere.
            let value = |which: i32| (f64::from(100 * part + 10 * block + which) * 0.618_034 * 7.0).sin();
            let half = [0, 1].map(|which| 2.1 + 1.9 * value(2 + which));
            let taper = if block % 2 == 0 { 0.0 } else { 1.5 + 1.5 * value(6) };
            faces.extend(frustum([12.0 * value(0), 12.0 * value(1)], half, 3.0 + 2.9 * value(4), 3.0 * value(5), taper));
        }
        check(&quads(&faces), [-9.0, -15.0], [-6.0, 15.0]);
        check(&quads(&faces), [14.0, -3.0], [-15.0, 4.0]);
    }
}

#[test]
fn a_step_is_two_tips_on_its_free_side() {
    let drop = extruded(&[[-20.0, 0.0], [0.0, 0.0], [0.0, 5.0], [20.0, 5.0]]);
    let flat = Profile::torus(2.0, 0.0);
    let up = tips_between(&drop, &flat, [-10.0, 1.0], [10.0, 1.0], &Sampling::fine(&flat, TOLERANCE), None);
    let down = tips_between(&drop, &flat, [10.0, 1.0], [-10.0, 1.0], &Sampling::fine(&flat, TOLERANCE), None);
    // The flat meets the wall at x = -2.
    for (tips, [first, second]) in [(&up, [0.0, 5.0]), (&down, [5.0, 0.0])] {
        let step = tips.windows(2).find(|ends| (ends[0].position[2] - ends[1].position[2]).abs() > 1.0).unwrap();
        assert_eq!(step[0].position[..2], step[1].position[..2]);
        assert!((-2.0 - 1e-4..=-2.0).contains(&step[0].position[0]), "{}", step[0].position[0]);
        assert_abs_diff_eq!(step[0].position[2], first);
        assert_abs_diff_eq!(step[1].position[2], second);
        assert!(tips.len() <= 6, "{}", tips.len());
    }
}

#[test]
fn a_plane_needs_two_tips() {
    let drop = extruded(&[[-20.0, -4.0], [20.0, 4.0]]);
    for profile in profiles() {
        assert_eq!(tips_between(&drop, &profile, [-10.0, 3.0], [10.0, -2.0], &Sampling::fine(&profile, TOLERANCE), None).len(), 2);
        assert_eq!(tips_between(&drop, &profile, [1.0, 3.0], [1.0, 3.0], &Sampling::fine(&profile, TOLERANCE), None).len(), 1);
    }
}

#[test]
fn beyond_the_part_the_tip_is_on_the_floor_or_nowhere() {
    let drop = extruded(&[[-5.0, 2.0], [5.0, 2.0]]);
    let flat = Profile::torus(2.0, 0.0);
    let without = tips_between(&drop, &flat, [-20.0, 0.0], [20.0, 0.0], &Sampling::fine(&flat, TOLERANCE), None);
    let ends = [without[0].position[0], without[without.len() - 1].position[0]];
    assert!((ends[0] + 7.0).abs() < 1e-4 && (ends[1] - 7.0).abs() < 1e-4, "{ends:?}");
    let with = tips_between(&drop, &flat, [-20.0, 0.0], [20.0, 0.0], &Sampling::fine(&flat, TOLERANCE), Some(0.0));
    assert_eq!(with.iter().map(|tip| tip.position[2]).collect::<Vec<_>>(), [0.0, 0.0, 2.0, 2.0, 0.0, 0.0]);
    assert_eq!(tips_between(&drop, &flat, [10.0, 0.0], [20.0, 0.0], &Sampling::fine(&flat, TOLERANCE), None), []);
}

/// The height at which a cutter stands on a facet beside a plane of this slope, at a place between two samples, and that of its
/// chords there: with corners and edges sought, and without.
fn height_and_chords(profile: &Profile, facet: [[f64; 3]; 3], slope: f64, at: f64) -> [f64; 3] {
    let plane = |x: f64, y: f64| [x, y, slope * x];
    let [a, b, c, d] = [plane(-20.0, -9.0), plane(20.0, -9.0), plane(20.0, 9.0), plane(-20.0, 9.0)];
    let drop = DropCutter::new(&[[a, b, c], [a, c, d], facet], &|| false);
    let fine = Sampling::fine(profile, TOLERANCE);
    let [sought, unsought] = [fine, Sampling { curvature: 0.0, ..fine }].map(|sampling| {
        let tips = tips_between(&drop, profile, [-6.06, 0.0], [5.94, 0.0], &sampling, None);
        let next = tips.iter().position(|tip| tip.position[0] > at).unwrap();
        let [[x0, _, z0], [x1, _, z1]] = [tips[next - 1].position, tips[next].position];
        z0 + (z1 - z0) * (at - x0) / (x1 - x0)
    });
    [drop.drop(profile, at, 0.0, None).unwrap().height, sought, unsought]
}

#[test]
fn a_flat_end_clears_a_corner_that_its_edge_passes_between_two_samples() {
    // Down a plane, beside which a corner is under the edge of the flat for 0.15 mm, over the tip for the last 0.1 of them.
    let flat = Profile::torus(3.0, 0.0);
    let corner = [0.0, 2.999, 0.604];
    let [height, sought, unsought] = height_and_chords(&flat, [[0.01, 3.1, 0.0], corner, [-0.01, 3.1, 0.0]], -0.2, 0.07);
    assert_abs_diff_eq!(height, corner[2]);
    assert_abs_diff_eq!(sought, height, epsilon = TOLERANCE);
    assert!(unsought < height - 2.0 * TOLERANCE, "{unsought}");
}

#[test]
fn a_flat_end_clears_an_edge_that_its_rim_touches_between_two_samples() {
    // Up a plane, beside which a level edge comes under the flat between its corners and is over the tip for the first 0.075 mm.
    let flat = Profile::torus(3.0, 0.0);
    let [x, y] = [3.0_f64, 3.0].map(|radius| radius * 0.5_f64.sqrt());
    let edge = [[x + 2.0, y - 2.0, 0.615], [x - 2.0, y + 2.0, 0.615], [x + 3.0, y + 3.0, 0.615]];
    let [height, sought, unsought] = height_and_chords(&flat, edge, 0.2, 0.02);
    assert_abs_diff_eq!(height, 0.615);
    assert_abs_diff_eq!(sought, height, epsilon = TOLERANCE);
    assert!(unsought < height - 2.0 * TOLERANCE, "{unsought}");
}

#[test]
fn a_bull_nose_with_a_small_corner_clears_a_point_between_two_samples() {
    // Up a plane of 45 deg, over which a point stands out by 0.015 mm; the corner of 0.05 mm touches it where it is as steep.
    let bull_nose = Profile::torus(3.0, 0.05);
    let point = [2.99, 0.0, 2.99 + 0.015];
    let at = 2.99 - (2.95 + 0.05 * 0.5_f64.sqrt());
    let [height, sought, unsought] = height_and_chords(&bull_nose, [[3.5, 0.5, 0.0], point, [3.5, -0.5, 0.0]], 1.0, at);
    assert_abs_diff_eq!(height, point[2] - 0.05 * (1.0 - 0.5_f64.sqrt()), epsilon = 1e-9);
    assert_abs_diff_eq!(sought, height, epsilon = TOLERANCE);
    assert!(unsought < height - 2.0 * TOLERANCE, "{unsought}");
}

#[test]
fn chords_up_steep_slopes_cut_little_into_points_between_samples() {
    for (slope, profile) in [2.5, 5.0].into_iter().flat_map(|slope| profiles().map(|profile| (slope, profile))) {
        let plane = |x: f64, y: f64| [x, y, slope * x];
        let [a, b, c, d] = [plane(-20.0, -12.0), plane(20.0, -12.0), plane(20.0, 12.0), plane(-20.0, 12.0)];
        let mut facets = vec![[a, b, c], [a, c, d]];
        for pin in 0..200 {
            // As random as the sines of the blocks above.
            let value = |which: i32| (f64::from(10 * pin + which) * 0.618_034 * 7.0).sin();
            let ([x, y], half) = ([10.0 * value(0), 7.0 * value(1)], 0.15 + 0.1 * value(2));
            let [_, _, under] = plane(x, y);
            let base = [plane(x - half, y - half), plane(x + half, y - half), plane(x + half, y + half), plane(x - half, y + half)];
            let point = [x, y, under + slope.hypot(1.0) * (0.012 + 0.01 * value(3))];
            facets.extend((0..4).map(|k| [base[k], base[(k + 1) % 4], point]));
        }
        let drop = DropCutter::new(&facets, &|| false);
        let fine = Sampling::fine(&profile, TOLERANCE);
        // Depths along the normal of the slope.
        let [sought, unsought] = [fine, Sampling { curvature: 0.0, ..fine }].map(|sampling| {
            let lines = (-30_i32..30).map(|line| 0.2 * f64::from(line)).map(|y| [[-11.0, y], [11.0, y + 1.7]]);
            let under = lines.map(|[from, to]| deviations(&drop, &profile, &tips_between(&drop, &profile, from, to, &sampling, None))[0]);
            under.fold(0.0, f64::max) / slope.hypot(1.0)
        });
        assert!(sought <= (MOST_MISSED + 1.0) * TOLERANCE, "{slope}, {profile:?}: {sought}");
        assert!(unsought > 2.0 * sought, "{slope}, {profile:?}: {unsought} and {sought}");
    }
}
