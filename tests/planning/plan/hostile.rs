//! Degenerate meshes: all stages from facets to plans terminate, and every figure is finite.

use super::surfaces::Facet;
use super::{degrees, machined, mesh_of, published_cutters, ranked_on, settings};
use proptest::prelude::*;
use scallopd::milling::Model;
use scallopd::planning::plan::{Directions, PlanSettings, Ranking};
use scallopd::surface::{Facing, Mesh, MeshBuilder, Sink, Unit};

fn assert_finite(ranking: &Ranking) {
    for plan in &ranking.plans {
        assert!(plan.time.seconds() > 0.0 && plan.time.seconds().is_finite() && plan.least_time.seconds().is_finite(), "{plan:?}");
        assert!(plan.by_direction.iter().all(|(_, time)| time.is_none_or(|time| time.seconds().is_finite())));
        if let Some(milled) = plan.milled {
            let (tour, finish) = (milled.tour, milled.finish);
            let shares = [finish.over_tolerance_share, finish.far_over_share, finish.uncut_share, finish.used_share];
            assert!(shares.iter().all(|share| (0.0..=1.0 + 1e-9).contains(share)), "{finish:?}");
            let figures = [tour.seconds, tour.run_length, tour.link_length, finish.max.mm(), finish.uncut_height.mm(), finish.gouge.mm()];
            assert!(figures.iter().all(|figure| figure.is_finite()), "{milled:?}");
            assert!(milled.layout_ratio.is_finite() && milled.feed_rate.mm_s() > 0.0, "{milled:?}");
        }
    }
}

/// The number of plans; all of their figures are checked.
fn plans_on(mesh: &Mesh) -> usize {
    let workpiece = machined(mesh);
    let directions = Directions::Only(vec![degrees(0.0), degrees(40.0)]);
    let settings = PlanSettings { directions, max_uncut_share: 1.0, ..settings(Model::Envelope) };
    let ranking = ranked_on(&workpiece, &published_cutters(), &settings);
    assert_finite(&ranking);
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
    let mesh = builder.finish(Unit::Millimetre, Facing::Up, &|| false).unwrap();
    assert!(mesh.points().len() <= 5, "{}", mesh.points().len());
    assert_eq!(plans_on(&mesh), 2);
}

#[test]
fn a_point_shared_by_all_facets_takes_no_quadratic_time() {
    let rim = |index: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(index) / 20_000.0).sin_cos();
        [10.0 * cos, 10.0 * sin, 0.0]
    };
    let mesh = mesh_of((0..20_000).map(|index| [[0.0, 0.0, 2.0], rim(index), rim(index + 1)]));
    assert_eq!(mesh.triangles().len(), 20_000);
    plans_on(&mesh);
}

#[test]
fn an_edge_of_many_facets_has_a_plan() {
    let wing = |index: u32| [[0.0, 0.0, 0.0], [0.0, 20.0, 0.0], [10.0, 10.0, f64::from(index) * 0.01 - 5.0]];
    let wings = (0..1000).map(wing).chain((0..1000).map(|index| wing(index).map(|[x, y, z]| [-x, y, z])));
    plans_on(&mesh_of(wings));
}

#[test]
fn intersecting_sheets_are_planned_by_their_visible_parts() {
    let mesh = mesh_of([square([0.0, 0.0, 6.0, 6.0]), square([6.0, 6.0, 0.0, 0.0]), square([3.0, 3.0, 3.0, 3.0])].concat());
    assert_eq!(plans_on(&mesh), 2);
}

#[test]
fn slivers_beside_a_square_change_no_plan() {
    let sliver = |index: u32| {
        let y = f64::from(index) * 1e-3;
        [[0.0, y, 0.0], [20.0, y, 0.0], [10.0, y + 1e-9, 0.0]]
    };
    let mesh = mesh_of(square([0.0; 4]).into_iter().chain((0..2000).map(sliver)));
    assert_eq!(plans_on(&mesh), 2);
}

#[test]
fn planning_a_part_of_a_kilometre_far_from_the_origin_terminates() {
    let far = |facet: [[f64; 3]; 3]| facet.map(|[x, y, z]| [5e4 * x + 1e8, 5e4 * y - 1e8, z]);
    plans_on(&mesh_of(square([0.0, 1.0, 2.0, 0.5]).map(far)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3))]

    /// Facets over and beside each other, enough of them that directions are compared on a sample.
    #[test]
    fn heaps_of_facets_of_any_shape_have_finite_plans_or_none(
        corners in prop::collection::vec(prop::array::uniform3(prop::array::uniform3(-1.0..1.0_f64)), 300..600),
        (size, width, height, facet_size) in (-2.0..5.0_f64, -9.0..0.0_f64, -9.0..0.0_f64, -6.0..0.0_f64), far in prop_oneof![Just(0.0), Just(1e6)],
    ) {
        let size = 10_f64.powf(size);
        let extents = [size, size * 10_f64.powf(width), size * 10_f64.powf(height)];
        let facet_size = 10_f64.powf(facet_size);
        let facets: Vec<Facet> = corners
            .iter()
            .map(|[a, b, c]| {
                let near = |p: &[f64; 3]| std::array::from_fn(|axis| far + extents[axis] * (a[axis] + facet_size * p[axis]));
                [near(a), near(b), near(c)]
            })
            .collect();
        let mut builder = MeshBuilder::new();
        for facet in facets {
            builder.facet(facet);
        }
        let Ok(mesh) = builder.finish(Unit::Millimetre, Facing::Up, &|| false) else { return Ok(()) };
        let ranking = ranked_on(&machined(&mesh), &published_cutters(), &settings(Model::Envelope));
        prop_assert_eq!(ranking.plans.len() + ranking.not_ranked.len(), 2);
        assert_finite(&ranking);
    }
}
