//! Tests of building, visibility, pieces and selection.

use super::shapes::{degrees, finish_facets, grid, mesh, noise, solid_box};
use super::*;
use crate::quantity::Angle;
use crate::surface::{Bezier, Facing, Unit};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use proptest::prelude::*;

fn build(facets: &[[[f64; 3]; 3]], facing: Facing) -> Result<Mesh, MeshError> {
    let mut builder = MeshBuilder::new();
    for &facet in facets {
        builder.facet(facet);
    }
    builder.finish(Unit::Millimetre, facing, &|| false)
}

fn shares(mesh: &Mesh) -> AreaShares {
    mesh.visibility(degrees(85.0), &|| false).shares()
}

fn area_seen_from_above(facets: &[FinishFacet]) -> f64 {
    facets.iter().map(|facet| facet.area * facet.normal[2]).sum()
}

#[test]
fn equal_corners_become_one_point() {
    let solid = mesh(&solid_box([0.0; 3], [40.0, 20.0, 10.0]));
    assert_eq!((solid.points().len(), solid.triangles().len(), solid.degenerate_facets()), (8, 12, 0));
    assert_eq!((solid.bounds().max, solid.merged_cell(), solid.from_points()), ([40.0, 20.0, 10.0], None, false));
    assert_relative_eq!((0..12).map(|facet| solid.normal_and_area(facet).1).sum::<f64>(), 2800.0);
}

#[test]
fn facets_without_area_are_counted_and_left_out() {
    let good = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let flat = [[0.0; 3], [1.0; 3], [2.0; 3]];
    let some = build(&[good, flat, [[5.0; 3]; 3]], Facing::Up).unwrap();
    assert_eq!((some.triangles().len(), some.points().len(), some.degenerate_facets()), (1, 3, 2));
    assert_eq!(build(&[flat, flat], Facing::Up).unwrap_err(), MeshError::OnlyDegenerateFacets { count: 2 });
    assert_eq!(build(&[], Facing::Up).unwrap_err(), MeshError::NoTriangulation { points: 0 });
    for wrong in [f64::NAN, f64::INFINITY, -1.1e12] {
        let mut bad = good;
        bad[2][1] = wrong;
        assert_eq!(build(&[good, bad], Facing::Any).unwrap_err(), MeshError::CoordinateOutOfRange);
    }
}

#[test]
fn an_index_list_gives_the_mesh_or_names_its_fault() {
    let points = [[0.0; 3], [25.4, 0.0, 0.0], [0.0, 1.0, 2.0], [25.4, 0.0, 0.0]];
    let mut builder = MeshBuilder::new();
    builder.indexed(&points, &[[0, 1, 2], [0, 3, 2], [1, 3, 2]]).unwrap();
    let inches = builder.finish(Unit::Inch, Facing::Up, &|| false).unwrap();
    assert_eq!((inches.points().len(), inches.triangles().len(), inches.degenerate_facets()), (3, 2, 1));
    assert_relative_eq!(inches.bounds().max[0], 25.4 * 25.4);
    let refusal = |points: &[[f64; 3]], triangles: &[[u64; 3]]| MeshBuilder::new().indexed(points, triangles).unwrap_err();
    let index = MeshError::IndexOutOfRange { triangle: 1, corner: 2, index: 4, points: 4 };
    assert_eq!(refusal(&points, &[[0, 1, 2], [0, 1, 4]]), index);
    assert_eq!(index.to_string(), "corner 2 of triangle 1 names point 4, but there are 4 points, counted from 0");
    assert!(matches!(refusal(&points, &[[u64::MAX, 1, 2]]), MeshError::IndexOutOfRange { index: u64::MAX, .. }));
    assert_eq!(refusal(&[[0.0; 3], [0.0, f64::NAN, 0.0]], &[]), MeshError::PointOutOfRange { point: 1 });
}

#[test]
fn the_top_of_a_closed_box_is_machined_and_its_walls_are_steep() {
    let solid = mesh(&solid_box([0.0; 3], [40.0, 20.0, 10.0]));
    let AreaShares { hidden, overhanging, steep, machined } = shares(&solid);
    assert_eq!(hidden, 0.0);
    assert_relative_eq!(overhanging, 800.0 / 2800.0);
    assert_relative_eq!(steep, 1200.0 / 2800.0);
    assert_relative_eq!(machined, 800.0 / 2800.0);
    let facets = finish_facets(&solid);
    assert_eq!(facets.len(), 2);
    assert!(facets.iter().all(|facet| facet.normal == [0.0, 0.0, 1.0] && facet.area == 400.0 && facet.slope().radians() == 0.0));
}

#[test]
fn a_roof_hides_what_is_below_it() {
    let mut facets = solid_box([0.0; 3], [40.0, 20.0, 10.0]);
    facets.extend(solid_box([0.0, 0.0, 15.0], [40.0, 20.0, 16.0]));
    let two = mesh(&facets);
    // Two tops, one of them hidden; two bottoms; walls of 1200 mm^2 and 120 mm^2.
    let area = 2800.0 + 1600.0 + 120.0;
    assert_relative_eq!(shares(&two).hidden, 800.0 / area);
    assert_relative_eq!(shares(&two).overhanging, 1600.0 / area);
    assert_relative_eq!(shares(&two).machined, 800.0 / area);
    assert_eq!(two.pieces(&|| false).count(), 2);
}

#[test]
fn floors_narrower_than_a_cell_are_visible_unless_something_is_above_them() {
    // Ten slots of 1 mm in a plate of 500 mm, a raster of 256 cells: 2 mm each.
    let level = |x: [f64; 2], z: f64| {
        let at = |x: f64, y: f64| [x, y, z];
        [[at(x[0], 0.0), at(x[1], 0.0), at(x[1], 200.0)], [at(x[0], 0.0), at(x[1], 200.0), at(x[0], 200.0)]]
    };
    let starts = (0..10).map(|slot| 50.0 * f64::from(slot));
    let slots: Vec<_> = starts.clone().flat_map(|x| [level([x, x + 49.0], 0.0), level([x + 49.0, x + 50.0], -5.0)]).flatten().collect();
    assert_eq!((shares(&mesh(&slots)).hidden, shares(&mesh(&slots)).machined), (0.0, 1.0));
    let wall = |x: f64| [[[x, 0.0, -5.0], [x, 200.0, -5.0], [x, 200.0, 0.0]], [[x, 0.0, -5.0], [x, 200.0, 0.0], [x, 0.0, 0.0]]];
    let walls = starts.clone().flat_map(|x| [wall(x + 49.0), wall(x + 50.0)]).flatten();
    let with_walls = mesh(&slots.iter().copied().chain(walls).collect::<Vec<_>>());
    assert_relative_eq!(shares(&with_walls).steep, 20.0 / 120.0, epsilon = 1e-12);
    assert_eq!(shares(&with_walls).hidden, 0.0);
    // Bridges over five of them, and over half a millimetre of the plate on both sides.
    let bridges = starts.step_by(2).flat_map(|x| level([x + 48.5, x + 50.5], 3.0));
    let bridged = mesh(&slots.iter().copied().chain(bridges).collect::<Vec<_>>());
    let area = 200.0 * (500.0 + 10.0);
    assert_abs_diff_eq!(shares(&bridged).hidden, 5.0 * 2.0 * 200.0 / area, epsilon = 0.003);
}

#[test]
fn the_walls_of_a_closed_cavity_are_hidden() {
    let mut facets = solid_box([0.0; 3], [40.0, 40.0, 40.0]);
    // Turned inside out, as the surface of a hole is.
    facets.extend(solid_box([15.0; 3], [25.0; 3]).into_iter().map(|[a, b, c]| [a, c, b]));
    let hollow = mesh(&facets);
    let area = 6.0 * (1600.0 + 100.0);
    // Its floor and four walls; its ceiling points down.
    assert_relative_eq!(shares(&hollow).hidden, 500.0 / area);
    assert_relative_eq!(shares(&hollow).overhanging, 1700.0 / area);
    assert_relative_eq!(shares(&hollow).machined, 1600.0 / area);
}

#[test]
fn solids_are_closed_and_have_their_facets_outside_or_inside() {
    let solid = solid_box([3.0, -5.0, 2.0], [40.0, 20.0, 10.0]);
    let turned = |facets: &[[[f64; 3]; 3]]| facets.iter().map(|&[a, b, c]| [a, c, b]).collect::<Vec<_>>();
    let closures = |facets: &[[[f64; 3]; 3]]| mesh(facets).pieces(&|| false).closures().to_vec();
    assert_eq!(closures(&solid), [Closure::Outwards]);
    assert_eq!(closures(&turned(&solid)), [Closure::Inwards]);
    for facet in 0..solid.len() {
        let (mut without, mut one_turned) = (solid.clone(), solid.clone());
        without.remove(facet);
        one_turned[facet].swap(0, 1);
        assert_eq!((closures(&without), closures(&one_turned)), (vec![Closure::Open], vec![Closure::Open]));
    }
    let sheet = grid(9, 9, |u, v| [50.0 * u, 40.0 * v, (6.0 * u).sin() * (5.0 * v).cos()]);
    assert_eq!(sheet.pieces(&|| false).closures(), [Closure::Open]);
    // A sheet with each facet in both orientations encloses nothing.
    let corners = |facet| sheet.corners(facet);
    let both: Vec<_> = (0..sheet.triangles().len()).map(corners).flat_map(|[a, b, c]| [[a, b, c], [a, c, b]]).collect();
    assert_eq!(closures(&both), [Closure::Open]);
    let beside = solid_box([60.0, 0.0, 0.0], [70.0, 10.0, 10.0]);
    assert_eq!(closures(&[solid, turned(&beside)].concat()), [Closure::Outwards, Closure::Inwards]);
}

#[test]
fn solids_with_a_hole_above_lack_its_area() {
    // A box whose upper side is a grid of facets.
    let top = grid(20, 20, |u, v| [40.0 * u, 20.0 * v, 10.0]);
    let below = solid_box([0.0; 3], [40.0, 20.0, 10.0]).into_iter().filter(|facet| facet.iter().any(|corner| corner[2] == 0.0));
    let solid: Vec<_> = (0..top.triangles().len()).map(|facet| top.corners(facet)).chain(below).collect();
    let missing = |facets: &[[[f64; 3]; 3]]| mesh(facets).pieces(&|| false).missing_areas().to_vec();
    assert_relative_eq!(missing(&solid)[..], [0.0][..], epsilon = 1e-9);
    let (_, area) = top.normal_and_area(100);
    let mut with_hole = solid.clone();
    with_hole.remove(100);
    assert_relative_eq!(missing(&with_hole)[..], [area][..], max_relative = 1e-9);
    let inwards: Vec<_> = with_hole.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert_relative_eq!(missing(&inwards)[..], [area][..], max_relative = 1e-9);
    // Upside down the hole is below what is milled.
    let below: Vec<_> = with_hole.iter().map(|&[a, b, c]| [a, c, b].map(|[x, y, z]| [x, y, -z])).collect();
    assert_eq!(missing(&below), [0.0]);
    // A box without its lid is a skin.
    let open: Vec<_> = solid.iter().copied().filter(|facet| facet.iter().any(|corner| corner[2] == 0.0)).collect();
    assert_eq!(missing(&open), [0.0]);
}

#[test]
fn solids_are_turned_outwards() {
    let inwards: Vec<_> = solid_box([0.0; 3], [40.0, 20.0, 10.0]).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let mut solid = mesh(&inwards);
    let pieces = solid.pieces(&|| false);
    assert_eq!(pieces.closures(), [Closure::Inwards]);
    solid.turn_solids_outwards(&pieces);
    assert_eq!(solid.pieces(&|| false).closures(), [Closure::Outwards]);
    solid.turn_solids_outwards(&solid.pieces(&|| false));
    assert_eq!(solid.pieces(&|| false).closures(), [Closure::Outwards]);
}

#[test]
fn a_facet_below_the_common_edge_of_two_is_hidden() {
    let level = |[a, b, c]: [[f64; 2]; 3], z: f64| [a, b, c].map(|[x, y]| [x, y, z]);
    // A roof of two facets, and below its diagonal a facet too small for the raster, with its centroid on the diagonal.
    let (low, high) = ([0.0, 0.0], [3000.0, 3000.0]);
    let roof = [level([low, [3000.0, 0.0], high], 10.0), level([low, high, [0.0, 3000.0]], 10.0)];
    let below = level([[100.0, 100.0], [100.75, 100.25], [100.25, 100.75]], 0.0);
    let classes = mesh(&[roof[0], roof[1], below]).visibility(Angle::from_degrees(85.0).unwrap(), &|| false).classes().to_vec();
    assert_eq!(classes, [FacetClass::Machined, FacetClass::Machined, FacetClass::Hidden]);
}

#[test]
fn the_visible_part_of_a_facet_mostly_under_a_roof_is_machined() {
    let level = |[x0, x1]: [f64; 2], z: f64| {
        let [a, b, c, d] = [[x0, 0.0, z], [x1, 0.0, z], [x1, 40.0, z], [x0, 40.0, z]];
        [[a, b, c], [a, c, d]]
    };
    let under_roof = |roof: [f64; 2]| {
        let mesh = mesh(&[level([0.0, 60.0], 0.0), level(roof, 20.0)].concat());
        (mesh.visibility(degrees(85.0), &|| false), (roof[1] - roof[0]) / 60.0)
    };
    for roof in [[10.0, 50.0], [3.0, 60.0], [0.0, 30.0]] {
        let (visibility, covered) = under_roof(roof);
        assert_eq!(visibility.classes(), [FacetClass::Machined; 4]);
        let visible = f64::midpoint(visibility.visible_share(0), visibility.visible_share(1));
        assert_abs_diff_eq!(visible, 1.0 - covered, epsilon = 0.02);
        assert_abs_diff_eq!(visibility.shares().hidden, covered / (1.0 + covered), epsilon = 0.02);
    }
    // Less than a cell beside the roof is not seen.
    assert_eq!(under_roof([0.0, 59.9]).0.classes()[..2], [FacetClass::Hidden; 2]);
}

#[test]
fn a_surface_upside_down_is_turned_over_and_single_facets_too() {
    let wave = grid(30, 30, |u, v| [50.0 * u, 40.0 * v, 3.0 * (6.0 * u).sin() * (5.0 * v).cos()]);
    let facets: Vec<_> = (0..wave.triangles().len()).map(|facet| wave.corners(facet)).collect();
    let over: Vec<_> = facets.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let mut random = noise(3);
    let mixed: Vec<_> = facets.iter().zip(&over).map(|(up, down)| if random() < 0.4 { *down } else { *up }).collect();
    let expected = finish_facets(&wave);
    assert_eq!(expected.len(), facets.len());
    for other in [over, mixed] {
        let found = finish_facets(&mesh(&other));
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            for axis in 0..3 {
                assert_abs_diff_eq!(found.normal[axis], expected.normal[axis], epsilon = 1e-14);
            }
            // The same corners in another order: curvatures of 0.5/mm agree within rounding.
            for (found, expected) in found.curvature.iter().zip(expected.curvature) {
                assert_abs_diff_eq!(*found, expected, epsilon = 1e-10);
            }
        }
    }
}

#[test]
fn every_facet_of_a_smooth_sheet_is_seen_whatever_the_raster() {
    // Facets smaller than a cell, on cell centres, and steep ones.
    for (rows, columns) in [(2, 2), (3, 200), (65, 65), (129, 129)] {
        let sheet = grid(rows, columns, |u, v| [64.0 * u, 64.0 * v, 20.0 * u * u + 60.0 * (v - 0.3) * v]);
        let facets = finish_facets(&sheet);
        assert_eq!(facets.len(), sheet.triangles().len(), "{rows} x {columns}");
        assert_relative_eq!(area_seen_from_above(&facets), 4096.0, max_relative = 1e-12);
    }
}

#[test]
fn a_sphere_shows_its_upper_half() {
    let at = |i: u32, j: u32| {
        let ((sp, cp), (st, ct)) =
            ((std::f64::consts::TAU * f64::from(i % 48) / 48.0).sin_cos(), (std::f64::consts::PI * f64::from(j) / 24.0).sin_cos());
        if j == 0 || j == 24 { [0.0, 0.0, 10.0 * ct.signum()] } else { [10.0 * st * cp, 10.0 * st * sp, 10.0 * ct] }
    };
    let mut facets = Vec::new();
    for i in 0..48 {
        for j in 0..24 {
            let (a, b, c, d) = (at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
            facets.extend([[a, b, c], [a, c, d]]);
        }
    }
    let sphere = mesh(&facets);
    assert_eq!((sphere.degenerate_facets(), sphere.triangles().len(), sphere.pieces(&|| false).count()), (96, 48 * 46, 1));
    let shares = shares(&sphere);
    assert_abs_diff_eq!(shares.machined + shares.steep, 0.5, epsilon = 1e-12);
    assert_abs_diff_eq!(shares.overhanging, 0.5, epsilon = 1e-12);
    for facet in finish_facets(&sphere) {
        let along = [facet.normal[2], 0.0, -facet.normal[0]];
        let length = along[0].hypot(along[2]);
        let along = along.map(|part| part / length);
        // Facets of 7.5 deg; at the poles triangles fan out.
        assert_abs_diff_eq!(facet.curvature_between(along, along), 0.1, epsilon = 0.006);
    }
}

#[test]
fn a_selected_facet_meets_all_conditions() {
    let mut facets = solid_box([0.0; 3], [10.0, 10.0, 5.0]);
    facets.extend(solid_box([20.0, 0.0, 0.0], [30.0, 10.0, 8.0]));
    facets.extend([[[40.0, 0.0, 0.0], [50.0, 0.0, 10.0], [40.0, 10.0, 0.0]]]);
    let parts = mesh(&facets);
    let (pieces, visibility) = (parts.pieces(&|| false), parts.visibility(degrees(85.0), &|| false));
    assert_eq!(pieces.count(), 3);
    let count =
        |selection: Selection| parts.facets_for_finishing(&visibility, &parts.selected(&selection, &pieces).unwrap(), &|| false).len();
    assert_eq!(count(Selection::all()), 5);
    assert_eq!(count(Selection::all().with_pieces(vec![1, 2]).unwrap()), 3);
    assert_eq!(count(Selection::all().with_slopes(degrees(0.0), degrees(10.0)).unwrap()), 4);
    assert_eq!(count(Selection::all().with_slopes(degrees(45.0), degrees(45.1)).unwrap()), 1);
    assert_eq!(count(Selection::all().with_box([15.0, 0.0, 0.0], [60.0, 10.0, 9.0]).unwrap()), 3);
    let all = Selection::all().with_pieces(vec![1]).unwrap().with_slopes(degrees(0.0), degrees(10.0)).unwrap();
    assert_eq!(count(all.clone()), 2);
    assert_eq!(count(all.with_box([15.0, 0.0, 0.0], [60.0, 10.0, 5.0]).unwrap()), 0);
    assert_eq!(Selection::all().with_slopes(degrees(20.0), degrees(10.0)), Err(SelectionError::SlopeBand));
    assert_eq!(Selection::all().with_box([0.0; 3], [1.0, f64::NAN, 1.0]), Err(SelectionError::Box));
    assert_eq!(Selection::all().with_pieces(vec![]), Err(SelectionError::NoPieces));
    let unknown = parts.selected(&Selection::all().with_pieces(vec![0, 3]).unwrap(), &pieces);
    assert_eq!(unknown, Err(SelectionError::UnknownPiece { piece: 3, count: 3 }));
}

#[test]
fn a_patch_gives_its_facets_facing_up() {
    let net = [vec![[0.0; 3], [0.0, 30.0, 30.0]], vec![[40.0, 0.0, 0.0], [40.0, 30.0, 30.0]]];
    let patch = Bezier::new(&net)
        .unwrap()
        .tessellate(20, MeshBuilder::new(), &|| false)
        .unwrap()
        .finish(Unit::Millimetre, Facing::Up, &|| false)
        .unwrap();
    assert_eq!((patch.points().len(), patch.triangles().len()), (441, 800));
    let facets = finish_facets(&patch);
    assert_relative_eq!(facets.iter().map(|facet| facet.area).sum::<f64>(), 1200.0 * 2.0_f64.sqrt(), max_relative = 1e-12);
    assert!(facets.iter().all(|facet| (facet.slope().degrees() - 45.0).abs() < 1e-9));
}

#[test]
fn facets_beyond_the_limit_become_heights_on_a_lattice() {
    let height = |x: f64, y: f64| 0.3 * x + 2.0 * (0.2 * y).sin();
    let mut builder = MeshBuilder::with_facet_limit(5000);
    let fine = grid(101, 151, |u, v| [60.0 * u, 40.0 * v, height(60.0 * u, 40.0 * v)]);
    (0..fine.triangles().len()).for_each(|facet| builder.facet(fine.corners(facet)));
    let merged = builder.finish(Unit::Inch, Facing::Up, &|| false).unwrap();
    let cell = merged.merged_cell().unwrap();
    // 50 nodes along 60 units: a spacing of 2 and no less.
    assert_relative_eq!(cell, 2.0 * 25.4);
    assert_eq!(merged.triangles().len(), 2 * 30 * 20);
    for point in merged.points() {
        let [x, y, z] = point.map(|c| c / 25.4);
        // Facets of 0.4 mm approximate a curvature of 0.08/mm within 0.4^2/8 * 0.08.
        assert_abs_diff_eq!(z, height(x, y), epsilon = 0.0017);
    }
    let seen = area_seen_from_above(&finish_facets(&merged));
    assert_relative_eq!(seen, 2400.0 * 25.4 * 25.4, max_relative = 1e-12);
}

#[test]
fn the_order_of_the_facets_does_not_change_what_is_merged() {
    let fine = grid(61, 61, |u, v| [30.0 * u - 11.0, 30.0 * v + 7.0, (9.0 * u * v).sin()]);
    let count = fine.triangles().len();
    let merged = |order: &dyn Fn(usize) -> usize| {
        let mut builder = MeshBuilder::with_facet_limit(600);
        (0..count).for_each(|i| builder.facet(fine.corners(order(i))));
        builder.finish(Unit::Millimetre, Facing::Up, &|| false).unwrap()
    };
    let (forward, backward) = (merged(&|i| i), merged(&|i| count - 1 - i));
    // 3547 is prime, so that its multiples visit every facet, spread over the surface from the start.
    let scattered = merged(&|i| (i * 3547) % count);
    for other in [backward, scattered] {
        assert_eq!(
            (forward.points(), forward.triangles(), forward.merged_cell()),
            (other.points(), other.triangles(), other.merged_cell())
        );
    }
}

#[test]
fn walls_alone_beyond_the_bound_are_refused() {
    let mut builder = MeshBuilder::with_facet_limit(8);
    (0..20_u32).map(f64::from).for_each(|i| builder.facet([[0.3, i, 0.0], [0.3, i + 0.2, 0.0], [0.3, i, 1.0]]));
    assert_eq!(builder.finish(Unit::Millimetre, Facing::Up, &|| false).unwrap_err(), MeshError::NothingFromAbove);
}

#[test]
fn values_of_the_facets_seen_form_a_raster() {
    let plane = grid(5, 5, |u, v| [20.0 * u, 10.0 * v, 10.0 * u]);
    let view = plane.seen_from_above(40, &|| false);
    assert_eq!((view.frame.columns, view.frame.rows, view.frame.cell), (40, 20, 0.5));
    let slopes = view.of_facets(|facet| plane.normal_and_area(facet).0[2]);
    assert!(slopes.values.iter().all(|slope| (slope.unwrap() - (0.8_f64).sqrt()).abs() < 1e-12));
    for row in 0..20 {
        for column in 0..40 {
            assert_abs_diff_eq!(view.heights[view.frame.index(column, row)], view.frame.centre(column, row)[0] / 2.0, epsilon = 1e-12);
        }
    }
    let hole = mesh(&[solid_box([0.0; 3], [1.0; 3]), solid_box([9.0, 0.0, 0.0], [10.0, 1.0, 1.0])].concat()).seen_from_above(10, &|| false);
    assert_eq!((0..10).map(|cell| hole.facet(cell).is_some()).collect::<Vec<_>>(), [[true].as_slice(), &[false; 8], &[true]].concat());
}

/// Calls every function of a mesh and checks that all numbers are finite.
fn examine(mesh: &Mesh) {
    let pieces = mesh.pieces(&|| false);
    assert!(pieces.count() >= 1 && pieces.of_facets().iter().all(|&piece| piece < pieces.count()));
    let visibility = mesh.visibility(degrees(85.0), &|| false);
    let AreaShares { hidden, overhanging, steep, machined } = visibility.shares();
    assert!([hidden, overhanging, steep, machined].iter().all(|share| (0.0..=1.0 + 1e-9).contains(share)));
    assert_abs_diff_eq!(hidden + overhanging + steep + machined, 1.0, epsilon = 1e-9);
    let selected = mesh.selected(&Selection::all(), &pieces).unwrap();
    for facet in mesh.facets_for_finishing(&visibility, &selected, &|| false) {
        assert!(facet.normal[2] > 0.0 && facet.area >= 0.0 && facet.area.is_finite());
        assert!(facet.curvature.iter().chain(&facet.normal).all(|part| part.is_finite()), "{facet:?}");
    }
    assert!(mesh.seen_from_above(256, &|| false).heights.iter().all(|z| !z.is_nan() && *z < f64::INFINITY));
}

/// Facets with corners on a small lattice, at several scales, so that points coincide or are collinear and facets
/// overlap.
fn soups() -> impl Strategy<Value = Vec<[[f64; 3]; 3]>> {
    let scale = prop::sample::select(vec![1e-30, 1e-6, 1.0, 1e6, 1e11]);
    let shift = prop::sample::select(vec![0.0, 0.1, 1e3, 9e11]);
    let facets = prop::collection::vec(prop::array::uniform9(-4_i32..=4), 1..120);
    (scale, shift, facets).prop_map(|(scale, shift, facets)| {
        let corner = |c: &[i32]| [0, 1, 2].map(|axis| scale * f64::from(c[axis]) / 4.0 + shift);
        facets.iter().map(|c| [corner(&c[..3]), corner(&c[3..6]), corner(&c[6..])]).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn soups_of_facets_are_examined_without_a_panic(soup in soups(), limit in prop::sample::select(vec![8_usize, 50, 2_000_000])) {
        for facing in [Facing::Up, Facing::Any] {
            let mut builder = MeshBuilder::with_facet_limit(limit);
            for &facet in &soup {
                builder.facet(facet);
            }
            if let Ok(mesh) = builder.finish(Unit::Metre, facing, &|| false) {
                prop_assert!(mesh.triangles().len() <= limit);
                examine(&mesh);
            }
        }
    }

    #[test]
    fn soups_of_points_are_triangulated_without_a_panic(soup in soups(), limit in prop::sample::select(vec![8_usize, 50, 2_000_000])) {
        let mut builder = MeshBuilder::with_facet_limit(limit);
        soup.iter().flatten().for_each(|&point| builder.point(point));
        if let Ok(mesh) = builder.finish(Unit::Inch, Facing::Up, &|| false) {
            prop_assert!(mesh.triangles().len() <= limit && mesh.from_points());
            examine(&mesh);
        }
    }
}

#[test]
fn facets_with_the_same_corners_count_once() {
    let facets = shapes::solid_box([0.0; 3], [40.0, 20.0, 10.0]);
    let mut builder = MeshBuilder::new();
    for &facet in &facets {
        builder.facet(facet);
    }
    // Again, from another corner on; and the back of one.
    for &[a, b, c] in &facets {
        builder.facet([b, c, a]);
    }
    let [a, b, c] = facets[0];
    builder.facet([a, c, b]);
    let mut left_out = Vec::new();
    builder.leave_out_duplicates(|corners| left_out.push(corners));
    assert_eq!((left_out.len(), builder.duplicate_facets()), (12, 12));
    assert_eq!(left_out[0], [b, c, a]);
    assert_eq!(builder.finish(Unit::Millimetre, Facing::Any, &|| false).unwrap().triangles().len(), 13);
}
