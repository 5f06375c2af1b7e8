//! Tests of reach: against the definition, on surfaces with a known answer, and at the limits.

use super::*;
use crate::quantity::Angle;
use crate::surface::mesh::{FacetClass, Selection};
use crate::surface::{Facing, Grid, MeshBuilder, Sink, Unit};
use approx::{assert_abs_diff_eq, assert_relative_eq};

fn mm(value: f64) -> Length {
    Length::from_mm(value).unwrap()
}

/// A mesh of the heights over the box from 0 to (w, l), on a grid of `columns` x `rows` points, and whether each facet
/// is machined.
fn surface(w: f64, l: f64, columns: u32, rows: u32, z: impl Fn(f64, f64) -> f64) -> (Mesh, Vec<bool>) {
    let mut grid = Grid::into_sink(rows as usize, columns as usize, MeshBuilder::new()).unwrap();
    for row in 0..rows {
        for column in 0..columns {
            let (x, y) = (w * f64::from(column) / f64::from(columns - 1), l * f64::from(row) / f64::from(rows - 1));
            grid.point([x, y, z(x, y)]);
        }
    }
    let mesh = grid.finish().unwrap().finish(Unit::Millimetre, Facing::Up).unwrap();
    let visibility = mesh.visibility(Angle::from_degrees(85.0).unwrap());
    let selected = mesh.selected(&Selection::all(), &mesh.pieces()).unwrap();
    let machined = selected.iter().zip(visibility.classes()).map(|(selected, class)| *selected && *class == FacetClass::Machined).collect();
    (mesh, machined)
}

fn uncut(surface: &(Mesh, Vec<bool>), cutter: Cutter) -> Uncut {
    ReachMap::new(&surface.0, &surface.0.seen_from_above(256), &surface.1).uncut(cutter, mm(0.01))
}

/// The dilation and erosion of the definition, cell by cell.
#[test]
fn tips_and_cuts_are_those_of_the_definition() {
    let surface = surface(10.0, 7.0, 31, 23, |x, y| (1.3 * x).sin() + 0.4 * (2.0 * y + x).cos());
    for cutter in [Cutter::ball_end(mm(2.0)), Cutter::toroidal(mm(3.0), mm(0.5)).unwrap(), Cutter::flat_end(mm(1.5))] {
        let map = ReachMap::new(&surface.0, &surface.0.seen_from_above(40), &surface.1);
        let (frame, radius) = (map.frame, cutter.outer_radius().mm());
        let pad = 8_i64;
        let (columns, rows) = (i64::try_from(frame.columns).unwrap(), i64::try_from(frame.rows).unwrap());
        let z = |x: i64, y: i64| {
            let inside = x >= 0 && y >= 0 && x < columns && y < rows;
            if inside { f64::from(map.heights.cells()[usize::try_from(y * columns + x).unwrap()]) } else { f64::NEG_INFINITY }
        };
        #[allow(clippy::cast_precision_loss)]
        let disc: Vec<(i64, i64, f64)> = (-pad..=pad)
            .flat_map(|dy| (-pad..=pad).map(move |dx| (dx, dy, frame.cell * (dx as f64).hypot(dy as f64))))
            .filter(|&(_, _, d)| d <= radius)
            .map(|(dx, dy, d)| (dx, dy, profile(cutter, d)))
            .collect();
        let tip = |x: i64, y: i64| disc.iter().map(|&(dx, dy, p)| z(x + dx, y + dy) - p).fold(f64::NEG_INFINITY, f64::max);
        let (left, result) = (map.uncut_heights(cutter, mm(0.01), map.frame, &|| false), map.uncut(cutter, mm(0.01)));
        for y in 0..rows {
            for x in 0..columns {
                let m = disc.iter().map(|&(dx, dy, p)| tip(x + dx, y + dy) + p).fold(f64::INFINITY, f64::min);
                let cell = usize::try_from(y * columns + x).unwrap();
                if let Some(left) = left.values[cell] {
                    // The tolerance is the rounding of heights of 2 mm in single precision. A cell that seems uncut may
                    // be reached by a tip between those of the raster.
                    let (left, on_raster) = (f64::from(left), m - z(x, y));
                    assert!(left <= on_raster + 1e-6, "{left} {on_raster}");
                    if on_raster <= result.level_error.mm() {
                        assert_abs_diff_eq!(left, on_raster, epsilon = 1e-6);
                    }
                }
            }
        }
    }
}

#[test]
fn every_cutter_cuts_a_plane_whole() {
    let plane = surface(40.0, 30.0, 5, 4, |x, y| 0.6 * x - 0.9 * y);
    for cutter in [Cutter::ball_end(mm(10.0)), Cutter::toroidal(mm(12.0), mm(1.0)).unwrap(), Cutter::flat_end(mm(20.0))] {
        let uncut = uncut(&plane, cutter);
        assert_eq!(uncut.share, 0.0);
        // At the plane's border the cutter hangs over the edge; inside, only rounding is left.
        assert!(uncut.height.mm() <= 1e-5, "{uncut:?}");
    }
}

/// The groove of radius rho along y in a level top, cut by a ball: (rho - sqrt(rho^2 - a^2)) - (R - sqrt(R^2 - a^2))
/// in the middle.
#[test]
fn a_ball_rests_on_the_edges_of_a_narrow_groove() {
    let (rho, a): (f64, f64) = (3.0, 2.5);
    let depth = rho - (rho * rho - a * a).sqrt();
    // A column of points at each edge: 8 mm of top, 5 mm of groove in 100 strips, 8 mm of top.
    let groove = surface(21.0, 20.0, 421, 3, |x, _| {
        let u = x - 10.5;
        if u.abs() < a - 1e-9 { (rho - (rho * rho - u * u).sqrt()) - depth } else { 0.0 }
    });
    for radius in [4.0, 5.0, 8.0, 12.0_f64] {
        let left = depth - (radius - (radius * radius - a * a).sqrt());
        let found = uncut(&groove, Cutter::ball_end(mm(2.0 * radius)));
        assert!(
            (found.height.mm() - left).abs() <= found.height_error.mm(),
            "R {radius}: {} of {left}, error {}",
            found.height.mm(),
            found.height_error.mm()
        );
        // Cells of 21/256 mm, multiplied by the stride; edges are up to half a cell off.
        assert!(found.height_error.mm() < 0.6 * left, "{radius} {} of {left}", found.height_error.mm());
        // The groove takes 5 of 21 mm, more along its arc.
        assert!(found.share > 0.15 && found.share < 0.35, "{}", found.share);
    }
    let fits = uncut(&groove, Cutter::ball_end(mm(4.0)));
    assert!(fits.share < 1e-3, "{} {}", fits.share, fits.height.mm());
}

/// A pocket of 56 x 36 mm, its floor 8 mm under the rim, the floor meeting the walls in fillets of 3 mm; walls and
/// rim left out.
fn pocket() -> (Mesh, Vec<bool>) {
    surface(60.0, 40.0, 301, 201, |x, y| {
        // The distance to the outline of 56 x 36 mm with corners of 6 mm radius.
        let (u, v) = ((x - 30.0).abs() - 22.0, (y - 20.0).abs() - 12.0);
        let to_wall = 6.0 - u.max(0.0).hypot(v.max(0.0)) - u.max(v).min(0.0);
        if to_wall < 0.0 {
            0.0
        } else if to_wall < 3.0 {
            -5.0 - (9.0 - (3.0 - to_wall).powi(2)).sqrt()
        } else {
            -8.0
        }
    })
}

#[test]
fn fillets_of_3_mm_refuse_a_10_mm_ball_and_take_a_4_mm_one() {
    let pocket = pocket();
    let large = uncut(&pocket, Cutter::ball_end(mm(10.0)));
    // In the corner of fillet and wall: at 45 deg (sqrt 2 - 1) (5 - 3) along the normal, sqrt 2 of that and more
    // upwards.
    assert!(large.share > 0.05 && large.height.mm() > 1.0, "{} {}", large.share, large.height.mm());
    let small = uncut(&pocket, Cutter::ball_end(mm(4.0)));
    assert!(small.share < 0.005, "{} {}", small.share, small.height.mm());
    let bull = Cutter::toroidal(mm(10.0), mm(2.0)).unwrap();
    assert!(uncut(&pocket, bull).share < large.share);
    // The corner of a flat cutter follows the fillet. Only in the corners of the outline, with 3 mm at the floor, it
    // does not fit.
    let flat = uncut(&pocket, Cutter::flat_end(mm(6.0)));
    assert!(flat.share < 0.02, "{} {}", flat.share, flat.height.mm());
}

#[test]
fn a_larger_ball_never_leaves_less() {
    let waves = surface(50.0, 40.0, 101, 81, |x, y| 2.0 * (0.5 * x).sin() * (0.4 * y).cos());
    // Up to R = 16 cells all use the same raster.
    let heights = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|diameter| uncut(&waves, Cutter::ball_end(mm(diameter))));
    assert!(heights.windows(2).all(|pair| pair[1].share >= pair[0].share - 1e-9), "{:?}", heights.map(|uncut| uncut.share));
}

#[test]
fn only_the_machined_area_counts() {
    let (mesh, mut machined) = pocket();
    // Only the level floor, whose corners have a radius of 3 mm: a flat cutter cuts all of it, a ball rests on the
    // fillet along its border.
    for (facet, machined) in machined.iter_mut().enumerate() {
        let (normal, _) = mesh.normal_and_area(facet);
        *machined = normal[2] > 0.999_999 && mesh.corners(facet)[0][2] < -7.99;
    }
    let floor = (mesh, machined);
    assert!(uncut(&floor, Cutter::flat_end(mm(4.0))).share < 1e-3);
    assert!(uncut(&floor, Cutter::ball_end(mm(10.0))).share < 0.2);
    let nothing = (floor.0.clone(), vec![false; floor.1.len()]);
    assert_eq!(uncut(&nothing, Cutter::ball_end(mm(10.0))).share, 0.0);
}

#[test]
fn the_lowest_tip_clears_the_surface() {
    // On a plane of slope S, a ball's tip is R (1/cos S - 1) above the plane.
    let (plane, _) = surface(40.0, 30.0, 5, 4, |x, _| 0.75 * x);
    let resting = RestingHeights::new(&plane.seen_from_above(512));
    let ball = Cutter::ball_end(mm(8.0));
    let tip = resting.raised(ball, [20.0, 15.0, f64::NEG_INFINITY]);
    // 1/cos S = 1.25; e^2/(2 R cos^3 S) with e = 40/512/sqrt 2.
    let error = (40.0 / 512.0_f64).powi(2) / 2.0 / (2.0 * 4.0) * 1.25_f64.powi(3);
    assert!(tip <= 15.0 + 1.0 + 1e-9 && tip >= 16.0 - error, "{tip} {error}");
    assert_eq!(resting.raised(ball, [-5.0, 15.0, -3.0]), -3.0);
    assert_eq!(resting.raised(ball, [1e300, 1e300, -3.0]), -3.0);
    // A toroidal cutter: (R - r) tan S + r (1/cos S - 1).
    let bull = resting.raised(Cutter::toroidal(mm(8.0), mm(1.0)).unwrap(), [20.0, 15.0, f64::NEG_INFINITY]);
    assert_relative_eq!(bull, 15.0 + 3.0 * 0.75 + 0.25, epsilon = 0.02);
}

/// Blocks only save work: the heights are those of all cells below the cutter.
#[test]
fn resting_heights_are_the_highest_of_all_cells() {
    let (waves, _) = surface(13.0, 7.0, 41, 23, |x, y| (1.3 * x).sin() + 0.4 * (2.0 * y + x).cos());
    let view = waves.seen_from_above(97);
    let resting = RestingHeights::new(&view);
    for cutter in [Cutter::ball_end(mm(2.0)), Cutter::toroidal(mm(3.0), mm(0.5)).unwrap(), Cutter::flat_end(mm(9.0))] {
        for at in [[0.3, 0.2], [6.1, 3.3], [12.9, 6.9], [-0.7, 7.4]] {
            let cells = (0..view.frame.cells()).map(|cell| (cell, view.frame.centre(cell % view.frame.columns, cell / view.frame.columns)));
            let under = cells.filter_map(|(cell, [x, y])| {
                let d = (x - at[0]).hypot(y - at[1]);
                (d <= cutter.outer_radius().mm()).then(|| view.heights[cell] - profile(cutter, d))
            });
            let highest = under.fold(f64::NEG_INFINITY, f64::max);
            // Heights of 1.4 mm in single precision.
            assert_abs_diff_eq!(resting.raised(cutter, [at[0], at[1], f64::NEG_INFINITY]), highest, epsilon = 2e-7);
            assert_abs_diff_eq!(resting.raised(cutter, [at[0], at[1], highest - 0.5]), highest, epsilon = 2e-7);
            assert_eq!(resting.raised(cutter, [at[0], at[1], highest + 0.5]), highest + 0.5);
        }
    }
}

/// A ball that just fits, in grooves of nearly its radius: the tips of the raster alone leave a tenth of a millimetre
/// there.
#[test]
fn a_ball_that_just_fits_reaches_the_whole_groove() {
    let (rho, a): (f64, f64) = (4.0, 3.5);
    let edge = (rho * rho - a * a).sqrt();
    for (side, columns) in [(60.0, 1201), (20.0, 401)] {
        let groove = surface(side, 40.0, columns, 3, |x, _| {
            let u = x - side / 2.0;
            if u.abs() < a - 1e-9 { edge - (rho * rho - u * u).sqrt() } else { 0.0 }
        });
        for radius in [2.5, 3.5, 3.7, 3.9, 3.99] {
            let found = uncut(&groove, Cutter::ball_end(mm(2.0 * radius)));
            assert!(found.share < 1e-3, "{side}, R {radius}: {} {}", found.share, found.height.mm());
        }
        // A ball a little wider than the groove rests on its edges.
        let left = (rho - edge) - (4.2 - (4.2_f64 * 4.2 - a * a).sqrt());
        let found = uncut(&groove, Cutter::ball_end(mm(8.4)));
        assert!((found.height.mm() - left).abs() <= found.height_error.mm(), "{} {left}", found.height.mm());
    }
}

#[test]
fn cutters_of_any_size_have_an_answer() {
    let waves = surface(20.0, 10.0, 21, 11, |x, y| (x * y * 0.05).sin());
    for diameter in [Length::SMALLEST, 1e-3, 1.0, 1e3, Length::LARGEST] {
        let found = uncut(&waves, Cutter::ball_end(mm(diameter)));
        assert!((0.0..=1.0).contains(&found.share) && found.height.mm().is_finite());
    }
}

/// The work is bounded by the raster, not by the ratio of the cutter's size to the surface's.
#[test]
fn a_surface_far_smaller_than_any_rounding_of_the_cutter_is_reached() {
    for side in [1e-3, 1e-12, 1e-30] {
        let surface = surface(side, side, 3, 3, |_, _| 0.0);
        assert_eq!(uncut(&surface, Cutter::ball_end(mm(500.0))).share, 0.0, "{side}");
    }
}

/// A channel with level floor, vertical walls and fillets of 3 mm between them, from facets, as CAD systems write it.
fn channel() -> (Mesh, Vec<bool>) {
    let (half, fillet, parts, rows) = (15.0, 3.0, 60_u32, 20_u32);
    let arc = |part: u32| (std::f64::consts::FRAC_PI_2 * f64::from(part) / f64::from(parts)).sin_cos();
    let mut right: Vec<[f64; 2]> = (0..=parts).map(arc).map(|(sin, cos)| [half - fillet + fillet * sin, fillet - fillet * cos]).collect();
    right.extend([[half, 10.0], [half + 8.0, 10.0]]);
    let profile: Vec<[f64; 2]> = right.iter().rev().map(|&[x, z]| [-x, z]).chain(right.iter().copied()).collect();
    let mut builder = MeshBuilder::new();
    for pair in profile.windows(2) {
        for row in 0..rows {
            let at = |[x, z]: [f64; 2], row: u32| [x, 2.0 * f64::from(row), z];
            let [a, b, c, d] = [at(pair[0], row), at(pair[1], row), at(pair[1], row + 1), at(pair[0], row + 1)];
            builder.facet([a, b, c]);
            builder.facet([a, c, d]);
        }
    }
    let mesh = builder.finish(Unit::Millimetre, Facing::Up).unwrap();
    let visibility = mesh.visibility(Angle::from_degrees(85.0).unwrap());
    let machined = visibility.classes().iter().map(|class| *class == FacetClass::Machined).collect();
    (mesh, machined)
}

#[test]
fn a_ball_of_nearly_the_radius_of_the_fillets_reaches_the_channel() {
    let channel = channel();
    for diameter in [4.0, 5.0, 5.5, 5.9] {
        let found = uncut(&channel, Cutter::ball_end(mm(diameter)));
        println!("{diameter}: {} {}", found.share, found.height.mm());
        assert!(found.share < 0.005, "{diameter}: {} {}", found.share, found.height.mm());
    }
    let large = uncut(&channel, Cutter::ball_end(mm(8.0)));
    println!("8: {} {}", large.share, large.height.mm());
    assert!(large.share > 0.05, "{} {}", large.share, large.height.mm());
}
