//! Tests of the curvature estimate on surfaces whose curvature is known.

use super::{half_of, tangents};
use crate::surface::mesh::shapes::{finish_facets, grid, mesh, noise, solid_box};
use crate::surface::mesh::{FinishFacet, MeshBuilder};
use crate::surface::{Facing, Sink, Unit};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use std::f64::consts::PI;

/// The smallest and the largest normal curvature, by sampling directions, independently of eigenvalues.
fn extremes(facet: &FinishFacet) -> (f64, f64) {
    let (t, u) = tangents(facet.normal);
    (0..180).map(|i| f64::from(i).to_radians().sin_cos()).map(|(sin, cos)| [0, 1, 2].map(|a| cos * t[a] + sin * u[a])).fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(least, most), direction| {
            let k = facet.curvature_between(direction, direction);
            (least.min(k), most.max(k))
        },
    )
}

fn assert_in_tangent_plane(facet: &FinishFacet) {
    for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        assert_abs_diff_eq!(facet.curvature_between(axis, facet.normal), 0.0, epsilon = 1e-12);
    }
}

#[test]
fn a_sphere_is_convex_by_its_radius_in_every_direction() {
    // A cap of 60 deg of a sphere of 25 mm, as a polar net of triangles of 4 deg, uneven in size.
    let sphere = |radius: f64| {
        move |u: f64, v: f64| {
            let ((s, c), (sp, cp)) = ((-0.9 + 1.8 * u).sin_cos(), (-0.9 + 1.8 * v).sin_cos());
            [radius * s * cp, radius * sp, radius * c * cp]
        }
    };
    for facet in finish_facets(&grid(31, 31, sphere(25.0))) {
        let (least, most) = extremes(&facet);
        // The mean of the normals around a point is the sphere's up to the asymmetry of the fan, (4 deg)^2 = 0.005,
        // times a factor of order 1; at the border the normals are those of points further inside, and the neighbours'
        // equations outweigh the facet's by 250 to 1.
        assert!(least > 0.95 / 25.0 && most < 1.05 / 25.0, "{least} {most}");
        assert_in_tangent_plane(&facet);
    }
    // The same as a bowl.
    let bowl = grid(31, 31, |u, v| sphere(25.0)(u, v).map(|c| -c));
    for facet in finish_facets(&bowl) {
        let (least, most) = extremes(&facet);
        assert!(least > -1.05 / 25.0 && most < -0.95 / 25.0, "{least} {most}");
    }
}

#[test]
fn a_saddle_is_convex_one_way_and_concave_the_other_and_twisted_between() {
    // z = (x^2 - y^2)/60 has the curvature -1/30 along x, where it is concave, and 1/30 along y. z = x y/30 is the same
    // surface turned by 45 deg.
    let at = |f: fn(f64, f64) -> f64| move |u: f64, v: f64| [4.0 * u - 2.0, 4.0 * v - 2.0, f(4.0 * u - 2.0, 4.0 * v - 2.0)];
    let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    for facet in finish_facets(&grid(21, 21, at(|x, y| (x * x - y * y) / 60.0))) {
        // Slopes of up to 2 sqrt(2)/30 change curvatures by up to 1.5 * 0.009.
        assert_abs_diff_eq!(facet.curvature_between(x, x), -1.0 / 30.0, epsilon = 0.03 / 30.0);
        assert_abs_diff_eq!(facet.curvature_between(y, y), 1.0 / 30.0, epsilon = 0.03 / 30.0);
        assert_abs_diff_eq!(facet.curvature_between(x, y), 0.0, epsilon = 0.03 / 30.0);
    }
    for facet in finish_facets(&grid(21, 21, at(|x, y| x * y / 30.0))) {
        assert_abs_diff_eq!(facet.curvature_between(x, x), 0.0, epsilon = 0.03 / 30.0);
        assert_abs_diff_eq!(facet.curvature_between(x, y), -1.0 / 30.0, epsilon = 0.03 / 30.0);
    }
}

#[test]
fn a_plane_has_no_curvature_in_any_tessellation() {
    let mut random = noise(5);
    let mut cloud = MeshBuilder::new();
    for _ in 0..500 {
        let (x, y) = (30.0 * random(), 20.0 * random());
        cloud.point([x, y, 0.4 * x - 0.7 * y + 3.0]);
    }
    for facet in finish_facets(&cloud.finish(Unit::Millimetre, Facing::Up, &|| false).unwrap()) {
        // Normals of slivers are rounded by 1e-16 of 30 mm over their height.
        assert!(facet.curvature.iter().all(|k| k.abs() < 1e-9), "{facet:?}");
    }
}

/// Facets of a cylinder along y, with `around` flat strips of two triangles in a full turn; only the strips between the
/// angles `from` and `to`, in deg from X.
fn strips(around: u32, radius: f64, from: f64, to: f64, length: f64) -> Vec<[[f64; 3]; 3]> {
    let at = |i: u32, y: f64| {
        let (sin, cos) = (2.0 * PI * f64::from(i) / f64::from(around)).sin_cos();
        [radius * cos, y, radius * sin]
    };
    let range = |i: &u32| {
        let middle = 360.0 * (f64::from(*i) + 0.5) / f64::from(around);
        middle > from && middle < to
    };
    let quad = |i: u32| {
        let (a, b, c, d) = (at(i, 0.0), at(i, length), at(i + 1, length), at(i + 1, 0.0));
        [[a, b, c], [a, c, d]]
    };
    (0..around).filter(range).flat_map(quad).collect()
}

#[test]
fn a_cylinder_of_flat_facets_is_as_curved_as_the_cylinder_through_its_corners() {
    let y = [0.0, 1.0, 0.0];
    for around in [12, 16, 24, 36, 64, 100, 200] {
        for (radius, length) in [(10.0, 60.0), (3.0, 1.0)] {
            let facets = finish_facets(&mesh(&strips(around, radius, 0.0, 180.0, length)));
            assert!(facets.len() >= around as usize - 4, "{around}");
            for facet in facets {
                let across = [facet.normal[2], 0.0, -facet.normal[0]];
                // Chords are shorter than arcs: the normals of neighbouring points differ by 2 sin(a/2) over a chord of
                // 2 R sin(a/2), exactly 1/R; turned into the facet's plane by cos(a/2), which is 0.966 for 12 facets.
                let expected = (PI / f64::from(around)).cos() / radius;
                // The strips at both ends have one side only; there the neighbours weigh 250 times as much.
                assert_relative_eq!(facet.curvature_between(across, across), expected, max_relative = 0.05);
                assert_abs_diff_eq!(facet.curvature_between(y, y), 0.0, epsilon = 0.01 / radius);
                assert_abs_diff_eq!(facet.curvature_between(across, y), 0.0, epsilon = 0.01 / radius);
            }
        }
    }
}

#[test]
fn a_cylinder_of_too_few_facets_is_a_prism_of_planes() {
    for facet in finish_facets(&mesh(&strips(10, 5.0, 0.0, 180.0, 20.0))) {
        assert!(facet.curvature.iter().all(|k| k.abs() < 1e-12), "{facet:?}");
    }
}

#[test]
fn a_sharp_edge_does_not_curve_the_faces_beside_it() {
    let roof = |u: f64, v: f64| [20.0 * u, 10.0 * v, 10.0 - 0.8 * (20.0 * u - 10.0).abs()];
    for facet in finish_facets(&grid(9, 21, roof)).into_iter().chain(finish_facets(&mesh(&solid_box([0.0; 3], [30.0, 20.0, 10.0])))) {
        assert!(facet.curvature.iter().all(|k| k.abs() < 1e-12), "{facet:?}");
    }
}

/// A level plane of 40 x 30 mm in `quads` quads, then a concave quarter cylinder of radius 3 mm up to a wall in 16
/// strips of `rows` quads each, as CAD systems write it.
fn plane_and_fillet(quads: u32, rows: u32) -> Vec<FinishFacet> {
    let place = |i: u32| {
        if i <= quads {
            return [-40.0 + 40.0 * f64::from(i) / f64::from(quads), 0.0];
        }
        let (sin, cos) = (PI / 2.0 * f64::from(i - quads) / 16.0).sin_cos();
        [3.0 * sin, 3.0 - 3.0 * cos]
    };
    let at = |i: u32, j: u32| {
        let [x, z] = place(i);
        [x, 30.0 * f64::from(j) / f64::from(rows), z]
    };
    let quad = |i: u32, j: u32| {
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        [[a, b, c], [a, c, d]]
    };
    let facets: Vec<_> = (0..quads + 16).flat_map(|i| (0..rows).flat_map(move |j| quad(i, j))).collect();
    finish_facets(&mesh(&facets))
}

#[test]
fn a_fillet_keeps_its_curvature_beside_a_plane_and_the_plane_has_none() {
    for (quads, rows) in [(1, 1), (1, 5), (4, 1), (40, 3), (160, 11)] {
        let facets = plane_and_fillet(quads, rows);
        // The strip at 87 deg is steep, but no wall.
        assert_eq!(facets.len(), 2 * ((quads + 16) * rows) as usize);
        for facet in &facets {
            let across = [facet.normal[2], 0.0, -facet.normal[0]];
            let k = facet.curvature_between(across, across);
            match facet.slope().degrees() {
                // This also holds at the border, and for any tessellation of the plane: with any curvature, flat-end
                // cutters would be refused.
                0.0 => assert!(facet.curvature.iter().all(|&k| k == 0.0), "{quads} {rows}: {facet:?}"),
                // The chord's curvature, cos(2.8 deg)/3; the strips at both ends have neighbours on one side only.
                slope => assert!((k * 3.0 + 1.0).abs() < 0.05, "{quads} {rows} at {slope}: {k}"),
            }
        }
    }
}

#[test]
fn a_plane_rounded_to_single_precision_has_no_curvature() {
    #[expect(clippy::cast_possible_truncation, reason = "the rounding is what is tested")]
    let single = |value: f64| f64::from(value as f32);
    let plane = grid(41, 51, |u, v| [50.0 * u, 40.0 * v, single(0.3 * 50.0 * u - 0.2 * 40.0 * v + 70.0)]);
    let curved = finish_facets(&plane).iter().filter(|facet| facet.curvature.iter().any(|&k| k != 0.0)).count();
    assert_eq!(curved, 0);
}

#[test]
fn only_facets_much_smaller_than_their_flat_region_lose_the_curvature_of_noise() {
    // Errors of 1e-5 mm turn the normals of facets of 1 mm by some 1e-5 rad, so that all facets are one flat region, of
    // 2 facets for each quad. The region is at least 8 times as large as a facet from 5 quads on.
    let curved = |columns: u32| {
        let mut next = noise(3);
        let z: Vec<f64> = (0..2 * (columns + 1)).map(|_| 2e-5 * next()).collect();
        let mut points = z.into_iter();
        let mut facets = Vec::new();
        let mut row = || (0..=columns).map(|column| [f64::from(column), 0.0, points.next().unwrap()]).collect::<Vec<_>>();
        let (low, high) = (row(), row());
        let high: Vec<[f64; 3]> = high.into_iter().map(|[x, _, z]| [x, 1.0, z]).collect();
        for column in 0..columns as usize {
            let [a, b, c, d] = [low[column], low[column + 1], high[column + 1], high[column]];
            facets.extend([[a, b, c], [a, c, d]]);
        }
        finish_facets(&mesh(&facets)).iter().filter(|facet| facet.curvature.iter().any(|&k| k != 0.0)).count()
    };
    assert!(curved(3) > 0);
    assert_eq!([5, 6, 12].map(curved), [0; 3]);
}

#[test]
fn sine_and_cosine_of_half_an_angle_are_those_of_the_arc_tangent() {
    for degrees in -180..=180 {
        let (y, x) = f64::from(degrees).to_radians().sin_cos();
        for length in [1e-9, 1.0, 7.0] {
            let (y, x) = (y * length, x * length);
            let (sin, cos) = half_of(y, x);
            let half = 0.5 * y.atan2(x);
            assert_abs_diff_eq!(sin, half.sin(), epsilon = 1e-15);
            assert_abs_diff_eq!(cos, half.cos(), epsilon = 1e-15);
        }
    }
    assert_eq!(half_of(0.0, 0.0), (0.0, 1.0));
}
