//! Parts as meshes: plates, steps, height fields, ribs, cones.

use super::surfaces::{Facet, quadrilateral};
use crate::simulation::random::Random;

/// A function of x and y on a grid of square cells, `size` mm large.
pub(crate) fn field(size: [f64; 2], cell: f64, z: impl Fn(f64, f64) -> f64) -> Vec<Facet> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "hundreds")]
    let counts = size.map(|side| (side / cell).round() as u32);
    let at = |i: u32, j: u32| {
        let [x, y] = [f64::from(i) * size[0] / f64::from(counts[0]), f64::from(j) * size[1] / f64::from(counts[1])];
        [x, y, z(x, y)]
    };
    let quad = |(i, j)| quadrilateral([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
    (0..counts[0]).flat_map(|i| (0..counts[1]).map(move |j| (i, j))).flat_map(quad).collect()
}

/// Level rectangles between the lines `xs` and `ys`, each with its height (x, then y), and vertical walls between them.
#[expect(clippy::float_cmp, reason = "a wall stands where the stated heights differ at all")]
pub(crate) fn steps(xs: &[f64], ys: &[f64], heights: &[&[f64]]) -> Vec<Facet> {
    let mut facets = Vec::new();
    for (i, x) in xs.windows(2).enumerate() {
        for (j, y) in ys.windows(2).enumerate() {
            let h = heights[i][j];
            facets.extend(quadrilateral([[x[0], y[0], h], [x[1], y[0], h], [x[1], y[1], h], [x[0], y[1], h]]));
            let mut wall = |a: [f64; 2], b: [f64; 2], other: f64| {
                let (low, high) = (h.min(other), h.max(other));
                let corners = [[a[0], a[1], low], [b[0], b[1], low], [b[0], b[1], high], [a[0], a[1], high]];
                // Seen from the open side the corners turn counter-clockwise.
                let [p, q, r, s] = corners;
                facets.extend(quadrilateral(if h > other { corners } else { [q, p, s, r] }));
            };
            if let Some(next) = heights.get(i + 1).map(|column| column[j]).filter(|next| *next != h) {
                wall([x[1], y[0]], [x[1], y[1]], next);
            }
            if let Some(&next) = heights[i].get(j + 1).filter(|next| **next != h) {
                wall([x[1], y[1]], [x[0], y[1]], next);
            }
        }
    }
    facets
}

/// A plate that rises along x.
pub(crate) fn plate(size: [f64; 2], slope_deg: f64) -> Vec<Facet> {
    let z = slope_deg.to_radians().tan() * size[0];
    quadrilateral([[0.0; 3], [size[0], 0.0, z], [size[0], size[1], z], [0.0, size[1], 0.0]]).to_vec()
}

/// A frustum on a square floor that has no opening under it, as public models have.
pub(crate) fn cone_on_floor(side: f64, [x, y]: [f64; 2], [foot, top, height]: [f64; 3]) -> Vec<Facet> {
    let mut facets = quadrilateral([[0.0; 3], [side, 0.0, 0.0], [side, side, 0.0], [0.0, side, 0.0]]).to_vec();
    let rim = |index: u32, radius: f64, z: f64| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(index) / 48.0).sin_cos();
        [x + radius * cos, y + radius * sin, z]
    };
    for index in 0..48 {
        let [a, b] = [index, (index + 1) % 48];
        facets.extend(quadrilateral([rim(a, foot, 0.0), rim(b, foot, 0.0), rim(b, top, height), rim(a, top, height)]));
        facets.push([rim(a, top, height), rim(b, top, height), [x, y, height]]);
    }
    facets
}

/// The larger of two heights with a rounding of about `k` between them.
fn smooth_max(a: f64, b: f64, k: f64) -> f64 {
    let h = (0.5 + 0.5 * (a - b) / k).clamp(0.0, 1.0);
    b * (1.0 - h) + a * h + k * h * (1.0 - h)
}

/// A level floor, a wall of 70 deg with a fillet of 6 mm at its foot and an edge of 4 mm at its top, wavy along y.
pub(crate) fn fillet_wall(x: f64, y: f64) -> f64 {
    let (foot, edge, height, slope) = (6.0_f64, 4.0_f64, 12.0, 70_f64.to_radians());
    let u = x - 14.0 - 2.0 * (y / 12.0).sin();
    let begin = -foot * (slope / 2.0).tan();
    let end = height / slope.tan() + edge * (slope / 2.0).tan();
    if u < begin {
        0.0
    } else if u < begin + foot * slope.sin() {
        foot - (foot * foot - (u - begin).powi(2)).sqrt()
    } else if u < end - edge * slope.sin() {
        slope.tan() * u
    } else if u < end {
        height - edge + (edge * edge - (u - end).powi(2)).sqrt()
    } else {
        height
    }
}

/// A cavity with walls of 60 deg, rounded at its foot, rim and corners.
pub(crate) fn cavity(x: f64, y: f64) -> f64 {
    let outside = smooth_max((x - 20.0).abs() - 13.0, (y - 16.0).abs() - 9.0, 8.0);
    let z = smooth_max(60_f64.to_radians().tan() * outside, -8.0, 4.0);
    -smooth_max(-z, 0.0, 5.0)
}

/// A blade: thin and twisted, its sides falling off to both borders.
pub(crate) fn blade(x: f64, y: f64) -> f64 {
    let twist = (15.0 + 0.5 * x).to_radians();
    let camber = 3.0 - 0.03 * (y - 10.0).powi(2);
    camber + (y - 10.0) * twist.tan()
}

/// Strokes in relief: a level field of squares, every third one raised.
pub(crate) fn relief() -> Vec<Facet> {
    let lines: Vec<f64> = (0..=10).map(|line| 3.0 * f64::from(line)).collect();
    let rows: Vec<Vec<f64>> = (0..10)
        .map(|i: u32| {
            let raised = |j: u32| match (i, j) {
                (2, 2..=7) | (3..=4, 7) | (6, 2) | (7, 2..=5) => 1.0,
                _ => 0.0,
            };
            (0..10).map(raised).collect()
        })
        .collect();
    let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    steps(&lines, &lines, &rows)
}

/// A dome on a level flange, with a sharp edge between them.
pub(crate) fn dome_on_flange(x: f64, y: f64) -> f64 {
    let squared = (x - 16.0).powi(2) + (y - 16.0).powi(2);
    if squared < 121.0 { (400.0_f64 - squared).sqrt() - (400.0_f64 - 121.0).sqrt() } else { 0.0 }
}

/// A plate with round holes, their walls vertical: a ring of facets around each hole in a square.
pub(crate) fn holes() -> Vec<Facet> {
    let mut facets = Vec::new();
    for centre in [[8.0, 8.0], [24.0, 8.0], [8.0, 24.0], [24.0, 24.0]] {
        let on_square = |index: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(index) / 32.0).sin_cos();
            let scale = 8.0 / f64::max(sin.abs(), cos.abs());
            [centre[0] + scale * cos, centre[1] + scale * sin, 0.0]
        };
        let on_hole = |index: u32, z: f64| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(index) / 32.0).sin_cos();
            [centre[0] + 4.0 * cos, centre[1] + 4.0 * sin, z]
        };
        for index in 0..32 {
            let [a, b] = [index, (index + 1) % 32];
            facets.extend(quadrilateral([on_hole(a, 0.0), on_square(a), on_square(b), on_hole(b, 0.0)]));
            facets.extend(quadrilateral([on_hole(b, -6.0), on_hole(a, -6.0), on_hole(a, 0.0), on_hole(b, 0.0)]));
        }
    }
    facets
}

/// A round pocket, 5 mm deep, in a plate, with walls of 80 deg of so few facets that these are some 4 um off the cone.
pub(crate) fn round_pocket() -> Vec<Facet> {
    let count = 96;
    let turned = |index: u32| (std::f64::consts::TAU * f64::from(index) / f64::from(count)).sin_cos();
    let rim = |index: u32, radius: f64, z: f64| {
        let (sin, cos) = turned(index);
        [12.0 + radius * cos, 12.0 + radius * sin, z]
    };
    let on_square = |index: u32| {
        let (sin, cos) = turned(index);
        rim(index, 12.0 / f64::max(sin.abs(), cos.abs()), 0.0)
    };
    let (floor, depth) = (7.0, 5.0);
    let mouth = floor + depth / 80_f64.to_radians().tan();
    let between = |[a, b]: [u32; 2]| {
        let wall = quadrilateral([rim(a, floor, -depth), rim(a, mouth, 0.0), rim(b, mouth, 0.0), rim(b, floor, -depth)]);
        let plate = quadrilateral([rim(a, mouth, 0.0), on_square(a), on_square(b), rim(b, mouth, 0.0)]);
        let floor = [[12.0, 12.0, -depth], rim(a, floor, -depth), rim(b, floor, -depth)];
        wall.into_iter().chain(plate).chain([floor])
    };
    (0..count).map(|index| [index, (index + 1) % count]).flat_map(between).collect()
}

/// A closed groove 4 mm deep around a middle, with this mean radius and width.
#[expect(clippy::float_cmp, reason = "in the middle two corners are the same point")]
pub(crate) fn ring_groove(radius: f64, width: f64) -> Vec<Facet> {
    let count = 180;
    let rim = |index: u32, radius: f64, z: f64| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(index) / f64::from(count)).sin_cos();
        [radius * cos, radius * sin, z]
    };
    let [inner, outer] = [radius - width / 2.0, radius + width / 2.0];
    let outline = [[0.0, 4.0], [inner, 4.0], [inner, 0.0], [outer, 0.0], [outer, 4.0], [outer + 8.0, 4.0]];
    let between = |[a, b]: [u32; 2]| {
        let strip = move |ends: &[[f64; 2]]| {
            let [[from, low], [to, high]] = [ends[0], ends[1]];
            quadrilateral([rim(a, from, low), rim(a, to, high), rim(b, to, high), rim(b, from, low)])
        };
        outline.windows(2).flat_map(strip).collect::<Vec<_>>()
    };
    (0..count)
        .map(|index| [index, (index + 1) % count])
        .flat_map(between)
        .filter(|facet| facet[0] != facet[1] && facet[2] != facet[0])
        .collect()
}

/// A profile of straight lines along x, each point with its height, over a width of `width` mm along y.
pub(crate) fn profile(points: &[[f64; 2]], width: f64) -> Vec<Facet> {
    let quad = |pair: &[[f64; 2]]| {
        let [[x0, z0], [x1, z1]] = [pair[0], pair[1]];
        quadrilateral([[x0, 0.0, z0], [x1, 0.0, z1], [x1, width, z1], [x0, width, z0]])
    };
    points.windows(2).flat_map(quad).collect()
}

/// A roof along y that falls by `grade` on both sides, with pyramids of random sizes on it whose points are along its normals.
pub(crate) fn sharp_points_on_a_roof(grade: f64, count: usize) -> Vec<Facet> {
    let on = |x: f64, y: f64| [x, y, -grade * x.abs()];
    let mut facets = quadrilateral([on(0.0, -15.0), on(12.0, -15.0), on(12.0, 15.0), on(0.0, 15.0)]).to_vec();
    facets.extend(quadrilateral([on(-12.0, -15.0), on(0.0, -15.0), on(0.0, 15.0), on(-12.0, 15.0)]));
    let mut random = Random(2);
    for _ in 0..count {
        let side = if random.unit() < 0.5 { -1.0 } else { 1.0 };
        let [x, y, half, height] =
            [[2.0, 10.0], [-13.0, 13.0], [0.1, 0.8], [0.05, 0.6]].map(|[from, to]| from + (to - from) * random.unit());
        let unit_rise = height / grade.hypot(1.0);
        let point = [side * (x + grade * unit_rise), y, unit_rise - grade * x];
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]].map(|[dx, dy]| on(side * x + dx, y + dy));
        facets.extend([0, 1, 2, 3].map(|corner| [corners[corner], corners[(corner + 1) % 4], point]));
    }
    facets
}
