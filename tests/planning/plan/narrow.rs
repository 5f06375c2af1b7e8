//! Surfaces narrower than a spacing, in part or everywhere: each place has a pass beside it.

use super::surfaces::facet;
use super::{in_direction, mm, ranked, settings};
use proptest::prelude::*;
use scallopd::milling::{Cutter, Model};
use scallopd::planning::zigzag::{CandidateCutter, PassPoint, ZigzagPlan, ZigzagSettings, passes};
use scallopd::quantity::Time;
use scallopd::surface::FinishFacet;

/// Quadrilaterals seen from above on the plane z = 0.1 x + 0.05 y, each as two facets.
fn quadrilaterals(corners: impl IntoIterator<Item = [[f64; 2]; 4]>) -> Vec<FinishFacet> {
    let up = |[x, y]: [f64; 2]| [x, y, 0.1 * x + 0.05 * y];
    let halves = |[a, b, c, d]: [[f64; 2]; 4]| [facet([a, b, c].map(up), [0.0; 6]), facet([a, c, d].map(up), [0.0; 6])];
    corners.into_iter().flat_map(halves).collect()
}

fn rectangle(length: f64, width: f64) -> Vec<FinishFacet> {
    quadrilaterals([[[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]]])
}

/// The face of a tube.
fn ring(radius: f64, width: f64) -> Vec<FinishFacet> {
    let at = |step: i32, radius: f64| {
        let (sin, cos) = (3.0 * f64::from(step)).to_radians().sin_cos();
        [radius * cos, radius * sin]
    };
    quadrilaterals((0..120).map(|step| [at(step, radius), at(step, radius + width), at(step + 1, radius + width), at(step + 1, radius)]))
}

/// A triangle with a long tip, and three pieces beside it that are narrower than a spacing.
fn pieces() -> Vec<FinishFacet> {
    let islands = [[70.0, 3.0], [73.1, 11.3], [71.7, 21.9]].map(|[x, y]| [[x, y], [x + 9.0, y + 0.4], [x + 9.0, y + 0.5], [x, y + 0.2]]);
    let tip = [[0.0, 0.0], [60.0, 19.8], [60.0, 20.2], [0.0, 40.0]];
    quadrilaterals(islands.into_iter().chain([tip]))
}

/// The distance of a point from the segment between two others, seen from above.
fn distance(point: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let [line, out] = [to, point].map(|end| [end[0] - from[0], end[1] - from[1]]);
    let squared = line[0] * line[0] + line[1] * line[1];
    let share = if squared > 0.0 { ((line[0] * out[0] + line[1] * out[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (out[0] - share * line[0]).hypot(out[1] - share * line[1])
}

/// The largest distance of a place of the surface from the nearest pass, in mm.
fn farthest(plan: &ZigzagPlan, facets: &[FinishFacet], candidate: &CandidateCutter, settings: &ZigzagSettings) -> f64 {
    let passes = passes(plan, facets, candidate, settings, &|tip| tip[2], 200_000).unwrap();
    let place = |point: &PassPoint| point.contact.unwrap();
    let ends = passes.run_starts[1..].iter().copied().chain([passes.points.len()]);
    let runs: Vec<&[PassPoint]> = passes.run_starts.iter().copied().zip(ends).map(|(start, end)| &passes.points[start..end]).collect();
    let nearest = |at: [f64; 3]| {
        let segments = runs.iter().flat_map(|run| run.windows(2));
        segments.map(|pair| distance(at, place(&pair[0]), place(&pair[1]))).fold(f64::INFINITY, f64::min)
    };
    let mut farthest = 0.0_f64;
    for facet in facets {
        let [a, b, c] = facet.corners;
        for i in 0..=20 {
            for j in 0..=20 - i {
                let at = [0, 1, 2].map(|axis| {
                    let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                    a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis])
                });
                farthest = farthest.max(nearest(at));
            }
        }
    }
    farthest
}

/// The largest distance that is accepted, in spacings: one to the neighbouring pass, and half of one beyond its end, with the
/// rounding of samples.
const FARTHEST: f64 = 1.118_034 + 0.01;

fn candidates() -> [CandidateCutter; 2] {
    [Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(), Cutter::ball_end(mm(6.0))].map(CandidateCutter::new)
}

#[test]
fn each_place_of_a_narrow_surface_is_near_a_pass() {
    let surfaces = [
        ("rib", rectangle(100.0, 0.1)),
        ("strip", rectangle(100.0, 5.0)),
        ("ring", ring(30.0, 0.3)),
        ("ring", ring(20.0, 1.7)),
        ("pieces", pieces()),
    ];
    for (name, facets) in &surfaces {
        for candidate in candidates() {
            for direction in [0.0, 0.4, 1.0, 3.0, 18.0, 45.0, 88.9, 91.3, 161.6, 179.2] {
                let farthest = farthest_in_spacings(facets, candidate, direction);
                assert!(farthest < FARTHEST, "{name} at {direction} deg: {farthest}");
            }
        }
    }
}

#[test]
fn a_narrow_rib_is_cut_by_one_pass_along_itself() {
    // With passes that end where they leave the rib, some degrees off its edges would take the least time.
    let facets = rectangle(100.0, 0.1);
    for candidate in candidates() {
        let plan = ranked(&facets, &[candidate], &settings(Model::Envelope)).plans.remove(0);
        let degrees = plan.direction.degrees();
        assert!(degrees.min(180.0 - degrees) <= 0.5, "{degrees}");
        assert_eq!(plan.tour.runs, 1);
        assert!((plan.tour.run_length - 100.0_f64.hypot(10.0)).abs() < 0.1, "{:?}", plan.tour);
    }
}

#[test]
fn a_finely_meshed_rib_is_planned_as_a_coarse_one() {
    // The search for the direction takes a sample of the facets.
    let quads = |count: i32| (0..count).map(move |i| [i, i + 1].map(|i| 100.0 * f64::from(i) / f64::from(count)));
    let rib = |count: i32| quadrilaterals(quads(count).map(|[from, to]| [[from, 0.0], [to, 0.0], [to, 0.1], [from, 0.1]]));
    let [coarse, fine] = [rib(1), rib(10_000)];
    for candidate in candidates() {
        let plan = |facets| ranked(facets, &[candidate], &settings(Model::Envelope)).plans.remove(0);
        let [coarse, fine] = [plan(&coarse), plan(&fine)];
        let degrees = fine.direction.degrees();
        assert!(degrees.min(180.0 - degrees) <= 0.5, "{degrees}");
        assert!((fine.time.seconds() / coarse.time.seconds() - 1.0).abs() < 0.01, "{:?} {:?}", fine.time, coarse.time);
    }
}

#[test]
fn walls_beside_a_surface_add_no_pass() {
    // Slopes of 89.9 and 89.99 deg behind the ends of the passes, each between two planes.
    let wall = |y: f64, rise: f64| facet([[110.0, y, 0.0], [210.0, y + 0.01, 0.0], [160.0, y + 0.02, rise]], [0.0; 6]);
    let bare = rectangle(100.0, 60.0);
    let with_walls: Vec<FinishFacet> = bare.iter().copied().chain([wall(10.3, 9.0), wall(30.1, 90.0)]).collect();
    for candidate in candidates() {
        let [without, with] = [&bare, &with_walls].map(|facets| {
            let plan = ranked(facets, &[candidate], &in_direction(Model::Envelope, 0.0)).plans.remove(0);
            (plan.tour.runs, plan.tour.run_length)
        });
        assert_eq!(with.0, without.0);
        assert!((with.1 - without.1).abs() < 1e-6, "{} mm, {} mm without walls", with.1, without.1);
    }
}

#[test]
fn the_passes_over_slivers_take_the_time_of_their_plan() {
    for facets in [rectangle(100.0, 0.1), ring(30.0, 0.3), pieces()] {
        for direction in [0.4, 45.0, 161.6] {
            let candidate = candidates()[1];
            let settings = in_direction(Model::Envelope, direction);
            let plan = ranked(&facets, &[candidate], &settings).plans.remove(0);
            let passes = passes(&plan, &facets, &candidate, &settings, &|tip| tip[2], 200_000).unwrap();
            assert_eq!(passes.run_starts.len(), plan.tour.runs);
            // On a plane tips have the distances of their contacts.
            let [planned, stated] = [plan.time, passes.time].map(Time::seconds);
            assert!((stated / planned - 1.0).abs() < 0.02, "{direction}: {planned} s, {stated} s of the passes");
        }
    }
}

/// A star around the origin. Each corner has an angle within its sector and a radius, both as shares. The star is `flat`
/// times as wide in y as in x, and each of its sectors has this many rows of facets.
fn star(corners: &[(f64, f64)], size: f64, flat: f64, rows: u8) -> Vec<FinishFacet> {
    let numbers = std::iter::successors(Some(0.0), |number| Some(number + 1.0));
    let sector = std::f64::consts::TAU / numbers.clone().nth(corners.len()).unwrap_or_default();
    let place = |((turn, radius), number): (&(f64, f64), f64)| {
        let (sin, cos) = (sector * (number + 0.8 * turn)).sin_cos();
        [size * radius * cos, flat * size * radius * sin]
    };
    let corners: Vec<[f64; 2]> = corners.iter().zip(numbers).map(place).collect();
    let sectors = corners.iter().zip(corners.iter().cycle().skip(1)).filter(|(a, b)| a[0] * b[1] > a[1] * b[0] + 1e-6);
    let share = |row: u8, corner: &[f64; 2]| corner.map(|part| part * f64::from(row) / f64::from(rows));
    let row_of = |(a, b), row| [share(row, a), share(row + 1, a), share(row + 1, b), share(row, b)];
    let facets = quadrilaterals(sectors.flat_map(|sector| (0..rows).map(move |row| row_of(sector, row))));
    // Those of the first row are triangles.
    facets.into_iter().filter(|facet| facet.area > 1e-9).collect()
}

/// The distance from the farthest place of a surface to the nearest pass in a direction, in spacings of a wide surface.
fn farthest_in_spacings(facets: &[FinishFacet], candidate: CandidateCutter, direction: f64) -> f64 {
    let settings = in_direction(Model::Envelope, direction);
    let plan = ranked(facets, &[candidate], &settings).plans.remove(0);
    // All surfaces have the same slope, so that the planes of a wide one are as far apart as they may be.
    let spacing = ranked(&rectangle(100.0, 60.0), &[candidate], &settings).plans[0].step_over.max.mm();
    farthest(&plan, facets, &candidate, &settings) / spacing
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn each_place_of_a_star_is_near_a_pass(
        corners in prop::collection::vec((0.0..1.0, 0.02..1.0), 3..12),
        (size, flat, rows) in (2.0..40.0, 0.02..1.0, 1_u8..7),
        direction in 0.0..180.0,
        cutter in 0_usize..2,
    ) {
        let facets = star(&corners, size, flat, rows);
        prop_assume!(!facets.is_empty());
        let farthest = farthest_in_spacings(&facets, candidates()[cutter], direction);
        prop_assert!(farthest < FARTHEST, "{}", farthest);
    }
}

#[test]
fn the_end_of_a_horn_is_near_a_pass() {
    // The horn ends just before a plane, more than half a spacing beyond the end of the pass before it.
    let flat = (0.0, 0.02);
    let corners = [(0.56, 0.489), flat, flat, (0.0, 0.4565), flat, (0.4165, 0.5134), flat, flat];
    let farthest = farthest_in_spacings(&star(&corners, 29.32, 0.064, 1), candidates()[1], 51.76);
    assert!(farthest < FARTHEST, "{farthest}");
}
