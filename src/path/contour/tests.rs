//! Waterlines against closed forms, and against the drop-cutter beside their chords.

use super::*;
use crate::path::{Sampling, tips_between};
use approx::assert_abs_diff_eq;
use std::f64::consts::TAU;

const TOLERANCE: f64 = 0.004;

fn quads(quads: &[[[f64; 3]; 4]]) -> DropCutter {
    let facets: Vec<_> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    DropCutter::new(&facets, &|| false)
}

/// A floor at 0 with a pocket's walls around it: `half` the sides of the pocket, 5 mm deep in a plate.
fn pocket(half: [f64; 2]) -> DropCutter {
    let ring = |[x, y]: [f64; 2], z: f64| [[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]];
    let (floor, edge, plate) = (ring(half, 0.0), ring(half, 5.0), ring([half[0] + 9.0, half[1] + 9.0], 5.0));
    let between = |a: [[f64; 3]; 4], b: [[f64; 3]; 4]| [0, 1, 2, 3].map(|k| [a[k], a[(k + 1) % 4], b[(k + 1) % 4], b[k]]);
    quads(&[&[floor][..], &between(floor, edge), &between(edge, plate)].concat())
}

/// The surface of revolution of a line from (r0, z0) to (r1, z1), around the origin, in `n` facets around.
fn turned(outline: &[[f64; 2]], n: u32) -> DropCutter {
    let at = |[r, z]: [f64; 2], k: u32| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(n)).sin_cos();
        [r * cos, r * sin, z]
    };
    let rings = outline.windows(2).flat_map(|ends| {
        let (a, b) = (ends[0], ends[1]);
        (0..n).map(move |k| [at(a, k), at(a, k + 1), at(b, k + 1), at(b, k)])
    });
    quads(&rings.collect::<Vec<_>>())
}

fn waves() -> DropCutter {
    let n = 160;
    let at = |i: i32, j: i32| {
        let [x, y] = [i, j].map(|k| 50.0 * f64::from(k) / f64::from(n) - 25.0);
        [x, y, 2.0 * (0.4 * x).sin() * (0.3 * y).cos()]
    };
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    quads(&cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect::<Vec<_>>())
}

/// The waterlines at these levels.
fn waterlines(drop: &DropCutter, profile: &Profile, levels: &[f64], area: &Area) -> Vec<Vec<Contour>> {
    LevelMap::new(drop, profile, area, &|| false).waterlines(levels, TOLERANCE, &|| false)
}

fn square(half: f64, cell: f64) -> Area {
    Area { min: [-half; 2], max: [half; 2], cell }
}

/// Points along the chords, at most 0.05 mm apart, each with the unit vector to the left.
fn along(contour: &Contour) -> Vec<([f64; 3], [f64; 2])> {
    let mut tips: Vec<_> = contour.tips.iter().map(|tip| tip.position).collect();
    tips.extend(contour.closed.then(|| tips[0]));
    let mut points = Vec::new();
    for ends in tips.windows(2) {
        let step = [0, 1, 2].map(|axis| ends[1][axis] - ends[0][axis]);
        let length = step[0].hypot(step[1]);
        let parts = (length / 0.05).ceil().max(1.0);
        let mut part = 0.5;
        while part < parts {
            points.push(([0, 1, 2].map(|axis| ends[0][axis] + step[axis] * part / parts), [-step[1] / length, step[0] / length]));
            part += 1.0;
        }
    }
    points
}

fn length(contour: &Contour) -> f64 {
    let tips = &contour.tips;
    let closing = if contour.closed { distance(&tips[tips.len() - 1], &tips[0]) } else { 0.0 };
    tips.windows(2).map(|ends| distance(&ends[0], &ends[1])).sum::<f64>() + closing
}

/// The area inside a closed curve, positive if it runs counter-clockwise.
fn enclosed(contour: &Contour) -> f64 {
    let tips = &contour.tips;
    let cross = |k: usize| {
        let (a, b) = (tips[k].position, tips[(k + 1) % tips.len()].position);
        0.5 * (a[0] * b[1] - a[1] * b[0])
    };
    (0..tips.len()).map(cross).sum()
}

#[test]
fn the_foot_of_a_pockets_walls_is_the_rectangle_offset_by_the_radius() {
    let drop = pocket([10.0, 7.0]);
    let flat = Profile::torus(2.0, 0.0);
    let lines = waterlines(&drop, &flat, &[0.0, 2.0], &square(12.0, 0.7));
    for contours in &lines {
        assert_eq!(contours.len(), 1);
        assert!(contours[0].closed);
        // The corners at (8, 5) may be cut by the tolerance.
        assert_abs_diff_eq!(enclosed(&contours[0]), 160.0, epsilon = 52.0 * TOLERANCE);
        for ([x, y, _], _) in along(&contours[0]) {
            let off = (8.0 - x.abs()).min(5.0 - y.abs());
            assert!((-1e-9..=TOLERANCE).contains(&off), "{x} {y}");
        }
        assert!(contours[0].tips.len() <= 16, "{}", contours[0].tips.len());
    }
}

#[test]
fn a_waterline_around_a_round_boss_is_its_circle_offset_by_the_radius() {
    let n = 720;
    let drop = turned(&[[9.0, 0.0], [4.0, 0.0], [4.0, 6.0], [0.0, 6.0]], n);
    // The boss is a polygon, inside the circle by 4 (1 - cos(pi/720)) = 4e-5.
    for profile in [Profile::torus(2.0, 0.0), Profile::torus(2.0, 0.5), Profile::torus(2.0, 2.0)] {
        let lines = waterlines(&drop, &profile, &[1.0], &square(9.0, 0.5));
        assert_eq!(lines[0].len(), 1);
        assert!(lines[0][0].closed);
        // The free side is outside, on the left: clockwise.
        assert!(enclosed(&lines[0][0]) < 0.0);
        for ([x, y, z], _) in along(&lines[0][0]) {
            assert_abs_diff_eq!(z, 1.0);
            assert_abs_diff_eq!(x.hypot(y), 6.0, epsilon = TOLERANCE + 4e-5);
        }
    }
}

#[test]
fn waterlines_of_a_cone_are_circles() {
    let slope = 0.9_f64;
    let drop = turned(&[[10.0, -10.0 * slope.tan()], [0.0, 0.0]], 1440);
    let ball = Profile::torus(1.5, 1.5);
    let levels = [-2.0, -5.0, -8.0];
    let lines = waterlines(&drop, &ball, &levels, &square(12.0, 0.4));
    for (level, contours) in levels.iter().zip(&lines) {
        assert_eq!(contours.len(), 1);
        // On a plane of this slope the tip is R (1/cos S - 1) over it, measured at the axis.
        let radius = (1.5 / slope.cos() - 1.5 - level) / slope.tan();
        for ([x, y, _], _) in along(&contours[0]) {
            // The cone of facets is inside by up to 10 (1 - cos(pi/1440)) = 2.4e-5.
            assert_abs_diff_eq!(x.hypot(y), radius, epsilon = TOLERANCE + 3e-5);
        }
    }
}

#[test]
fn beside_every_chord_of_a_waterline_t_is_lower_on_its_left_and_higher_on_its_right() {
    let drop = waves();
    for profile in [Profile::torus(2.0, 2.0), Profile::torus(3.0, 1.0), Profile::torus(2.0, 0.0)] {
        let lines = waterlines(&drop, &profile, &[0.7, 1.3], &square(20.0, 0.4));
        let height = |x: f64, y: f64| drop.drop(&profile, x, y, None).unwrap().height;
        for (level, contours) in [0.7, 1.3].iter().zip(&lines) {
            assert!(contours.len() > 5);
            for contour in contours {
                assert!(contour.tips.iter().all(|tip| height(tip.position[0], tip.position[1]) <= level + 1e-9));
                for ([x, y, z], [left_x, left_y]) in along(contour) {
                    assert_abs_diff_eq!(z, *level);
                    let beside = |off: f64| height(x + left_x * off, y + left_y * off);
                    assert!(beside(TOLERANCE) <= level + 1e-9 && beside(-TOLERANCE) > *level);
                }
            }
        }
    }
}

#[test]
fn curves_that_leave_the_area_are_open() {
    let drop = quads(&[[[-9.0, -9.0, -9.0], [9.0, -9.0, 9.0], [9.0, 9.0, 9.0], [-9.0, 9.0, -9.0]]]);
    let lines = waterlines(&drop, &Profile::torus(1.0, 0.0), &[0.0], &square(5.0, 0.3));
    // z = x, so that T = x + 1.
    let [line] = &lines[0][..] else { panic!("{}", lines[0].len()) };
    assert!(!line.closed);
    assert_eq!(line.tips.len(), 2);
    assert_abs_diff_eq!(length(line), 10.0, epsilon = 1e-9);
    assert!(line.tips.iter().all(|tip| (tip.position[0] + 1.0).abs() < 1e-5));
}

#[test]
fn two_regions_that_meet_at_a_saddle_are_both_bounded() {
    let at = |i: i32, j: i32| {
        let [x, y] = [i, j].map(|k| 0.1 * f64::from(k));
        [x, y, -x * y]
    };
    let cells = (-35..35).flat_map(|i| (-35..35).map(move |j| (i, j)));
    let drop = quads(&cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect::<Vec<_>>());
    let (fine, area) = (Profile::torus(1e-3, 1e-3), square(3.1, 1.0));
    let contours = waterlines(&drop, &fine, &[-0.02], &area).remove(0);
    assert_eq!(contours.len(), 2);
    for contour in &contours {
        assert!(along(contour).iter().all(|([x, y, _], _)| x * y > 0.0));
    }
    assert_eq!(LevelMap::new(&drop, &fine, &area, &|| false).waterlines(&[-0.02], TOLERANCE, &|| true), [vec![]]);
}

#[test]
fn a_line_to_the_foot_ends_on_it() {
    let drop = pocket([10.0, 7.0]);
    let flat = Profile::torus(2.0, 0.0);
    let line = tips_between(&drop, &flat, [0.0, 0.0], [12.0, 0.0], &Sampling::fine(&flat, TOLERANCE), None);
    assert!((line[1].position[0] - 8.0).abs() < 1e-4);
}
