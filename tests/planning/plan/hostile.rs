//! Degenerate meshes: all stages from facets to plans terminate, and every figure is finite.

use super::surfaces::facet;
use super::{degrees, mm, published_cutters, settings};
use proptest::prelude::*;
use scallopd::milling::{Cutter, Model};
use scallopd::planning::reach::ReachMap;
use scallopd::planning::zigzag::{CandidateCutter, Directions, NotRankedReason, SurfaceEvidence, ZigzagSettings, rank};
use scallopd::surface::mesh::Selection;
use scallopd::surface::{Facing, Mesh, MeshBuilder, Sink, Unit};

fn of_facets(facets: impl IntoIterator<Item = [[f64; 3]; 3]>) -> Mesh {
    let mut builder = MeshBuilder::new();
    facets.into_iter().for_each(|facet| builder.facet(facet));
    builder.finish(Unit::Millimetre, Facing::Up).unwrap()
}

/// The number of plans; all of their figures are checked.
fn plans_on(mesh: &Mesh) -> usize {
    let selected = mesh.selected(&Selection::all(), &mesh.pieces()).unwrap();
    let visibility = mesh.visibility(degrees(85.0));
    let facets = mesh.facets_for_finishing(&visibility, &selected);
    assert!(facets.iter().all(|facet| facet.normal[2] > 0.0 && facet.curvature.iter().all(|part| part.is_finite())));
    let reach = ReachMap::new(mesh, &mesh.seen_from_above(64), &vec![true; selected.len()]);
    for candidate in published_cutters() {
        let uncut = reach.uncut(candidate.cutter, mm(0.01));
        assert!((0.0..=1.0).contains(&uncut.share) && uncut.height.mm().is_finite());
    }
    let settings = ZigzagSettings { directions: Directions::Only(vec![degrees(0.0), degrees(40.0)]), ..settings(Model::Envelope) };
    let ranking = rank(&facets, &published_cutters(), &settings, SurfaceEvidence::default(), &|| false).unwrap();
    for plan in &ranking.plans {
        assert!(plan.time.seconds() > 0.0 && plan.time.seconds().is_finite() && plan.path_length().mm().is_finite());
    }
    ranking.plans.len()
}

/// A square of 20 mm, its corners at these heights.
fn square([a, b, c, d]: [f64; 4]) -> [[[f64; 3]; 3]; 2] {
    let [a, b, c, d] = [[0.0, 0.0, a], [20.0, 0.0, b], [20.0, 20.0, c], [0.0, 20.0, d]];
    [[a, b, c], [a, c, d]]
}

#[test]
fn a_million_coincident_points_are_one() {
    let mut builder = MeshBuilder::new();
    for index in 0..1_000_000_u32 {
        let point = if index % 250_000 == 7 { [f64::from(index) * 1e-5, f64::from(index % 3) * 10.0, 1.0] } else { [3.0, 4.0, 1.0] };
        builder.point(point);
    }
    let mesh = builder.finish(Unit::Millimetre, Facing::Up).unwrap();
    assert!(mesh.points().len() <= 5, "{}", mesh.points().len());
    assert_eq!(plans_on(&mesh), 2);
}

#[test]
fn a_point_shared_by_all_facets_takes_no_quadratic_time() {
    let rim = |index: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(index) / 20_000.0).sin_cos();
        [20.0 * cos, 20.0 * sin, 0.0]
    };
    let mesh = of_facets((0..20_000).map(|index| [[0.0, 0.0, 4.0], rim(index), rim(index + 1)]));
    assert_eq!(mesh.triangles().len(), 20_000);
    plans_on(&mesh);
}

#[test]
fn an_edge_of_many_facets_has_a_plan() {
    let wing = |index: u32| [[0.0, 0.0, 0.0], [0.0, 20.0, 0.0], [10.0, 10.0, f64::from(index) * 0.01 - 5.0]];
    let wings = (0..1000).map(wing).chain((0..1000).map(|index| wing(index).map(|[x, y, z]| [-x, y, z])));
    plans_on(&of_facets(wings));
}

#[test]
fn intersecting_sheets_are_planned_by_their_visible_parts() {
    let mesh = of_facets([square([0.0, 0.0, 6.0, 6.0]), square([6.0, 6.0, 0.0, 0.0]), square([3.0, 3.0, 3.0, 3.0])].concat());
    assert_eq!(plans_on(&mesh), 2);
}

#[test]
fn slivers_beside_a_square_change_no_plan() {
    let sliver = |index: u32| {
        let y = f64::from(index) * 1e-3;
        [[0.0, y, 0.0], [20.0, y, 0.0], [10.0, y + 1e-9, 0.0]]
    };
    let mesh = of_facets(square([0.0; 4]).into_iter().chain((0..2000).map(sliver)));
    assert_eq!(plans_on(&mesh), 2);
}

#[test]
fn planning_a_part_of_a_kilometre_far_from_the_origin_terminates() {
    let far = |facet: [[f64; 3]; 3]| facet.map(|[x, y, z]| [5e4 * x + 1e8, 5e4 * y - 1e8, z]);
    plans_on(&of_facets(square([0.0, 1.0, 2.0, 0.5]).map(far)));
}

#[test]
fn a_comb_of_too_many_runs_has_no_plan_across_its_teeth_but_one_along_them() {
    // 300 teeth of 0.3 mm with gaps of 0.3 mm, wider than the cutter: across them, 25 mm / 0.0872 mm = 287 passes of
    // 300 runs each are more than 65,536; along them each pass has one run.
    let tooth = |index: u32| {
        let x = 0.6 * f64::from(index);
        let [a, b, c, d] = [[x, 0.0, 0.0], [x + 0.3, 0.0, 0.0], [x + 0.3, 25.0, 0.0], [x, 25.0, 0.0]];
        [[a, b, c], [a, c, d]]
    };
    let mesh = of_facets((0..300).flat_map(tooth));
    let selected = mesh.selected(&Selection::all(), &mesh.pieces()).unwrap();
    let facets = mesh.facets_for_finishing(&mesh.visibility(degrees(85.0)), &selected);
    let planned = |direction: f64| {
        let settings = ZigzagSettings { directions: Directions::Only(vec![degrees(direction)]), ..settings(Model::Envelope) };
        rank(&facets, &[CandidateCutter::new(Cutter::ball_end(mm(0.2)))], &settings, SurfaceEvidence::default(), &|| false).unwrap()
    };
    let across = planned(0.0);
    assert!(across.plans.is_empty());
    assert_eq!(across.not_ranked[0].reason, NotRankedReason::TooManyRuns);
    assert!(across.not_ranked[0].reason.to_string().contains("65536 runs"), "{}", across.not_ranked[0].reason);
    let along = planned(90.0);
    assert!(along.plans[0].tour.runs >= 300 && along.plans[0].tour.runs <= 1800, "{}", along.plans[0].tour.runs);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    /// Facets over and beside each other, enough of them that directions are compared on a sample.
    #[test]
    fn heaps_of_facets_of_any_shape_have_finite_plans_or_none(
        corners in prop::collection::vec(prop::array::uniform3(prop::array::uniform3(-1.0..1.0_f64)), 1_600..2_400),
        (size, width, height, facet_size) in (-2.0..5.0_f64, -9.0..0.0_f64, -9.0..0.0_f64, -6.0..0.0_f64), far in prop_oneof![Just(0.0), Just(1e6)],
    ) {
        let size = 10_f64.powf(size);
        let extents = [size, size * 10_f64.powf(width), size * 10_f64.powf(height)];
        let facet_size = 10_f64.powf(facet_size);
        let facets: Vec<_> = corners
            .iter()
            .map(|[a, b, c]| {
                let near = |p: &[f64; 3]| std::array::from_fn(|axis| far + extents[axis] * (a[axis] + facet_size * p[axis]));
                facet([near(a), near(b), near(c)], [0.0; 6])
            })
            .filter(|facet| facet.normal[2] > 1e-6 && facet.area > 0.0)
            .collect();
        let ranking = rank(&facets, &published_cutters(), &settings(Model::Envelope), SurfaceEvidence::default(), &|| false).unwrap();
        prop_assert_eq!(ranking.plans.len() + ranking.not_ranked.len(), 2);
        for plan in &ranking.plans {
            prop_assert!(plan.time.seconds() > 0.0 && plan.time.seconds().is_finite() && plan.path_length().mm().is_finite());
            prop_assert!(plan.by_direction.iter().all(|(_, time)| time.is_none_or(|time| time.seconds().is_finite())));
        }
    }
}
