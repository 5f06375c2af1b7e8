//! Plans on meshes whose curvatures are estimated: planes beside fillets, and waves where the floor is curved.

use super::surfaces::{Height, facet, facets};
use super::{drive, in_direction, mm, ranked, settings};
use scallopd::milling::{Cutter, Model};
use scallopd::planning::Level;
use scallopd::planning::zigzag::{CandidateCutter, Ranking, SurfaceWeakness, ZigzagPlan, heights};
use scallopd::quantity::{Angle, Length, Time};
use scallopd::surface::mesh::Selection;
use scallopd::surface::{Facing, FinishFacet, Grid, MeshBuilder, Unit};

/// The facets of a grid of points, with their curvatures as the service estimates them.
fn estimated(rows: u32, columns: u32, at: impl Fn(u32, u32) -> [f64; 3]) -> Vec<FinishFacet> {
    let mut grid = Grid::into_sink(rows as usize, columns as usize, MeshBuilder::new()).unwrap();
    for row in 0..rows {
        for column in 0..columns {
            grid.point(at(row, column));
        }
    }
    let mesh = grid.finish().unwrap().finish(Unit::Millimetre, Facing::Up).unwrap();
    let selected = mesh.selected(&Selection::all(), &mesh.pieces()).unwrap();
    mesh.facets_for_finishing(&mesh.visibility(Angle::from_degrees(85.0).unwrap()), &selected)
}

/// A floor of 40 x 30 mm in `strips` strips of quads, then a concave fillet of 10 mm radius up to 45 deg.
fn floor_and_fillet(strips: u32) -> Vec<FinishFacet> {
    let profile = |column: u32| {
        if column < strips {
            [40.0 * f64::from(column) / f64::from(strips), 0.0]
        } else {
            let (sin, cos) = (45.0 * f64::from(column - strips) / 40.0).to_radians().sin_cos();
            [40.0 + 10.0 * sin, 10.0 - 10.0 * cos]
        }
    };
    estimated(11, strips + 41, |row, column| {
        let [x, z] = profile(column);
        [x, 3.0 * f64::from(row), z]
    })
}

#[test]
fn a_floor_of_a_few_large_facets_beside_a_fillet_takes_flat_and_bull_nose_cutters() {
    let cutters = [Cutter::toroidal(mm(10.0), mm(1.0)).unwrap(), Cutter::flat_end(mm(10.0)), Cutter::ball_end(mm(10.0))];
    let times = |strips: u32| -> Vec<f64> {
        let ranking = ranked(&floor_and_fillet(strips), &cutters.map(CandidateCutter::new), &settings(Model::Envelope));
        assert_eq!(ranking.plans.len(), 3, "{strips} strips: {:?}", ranking.not_ranked);
        (0..3).map(|cutter| ranking.plans.iter().find(|plan| plan.candidate == cutter).unwrap().time.seconds()).collect()
    };
    let fine = times(160);
    for strips in [1, 4, 40] {
        for (coarse, fine) in times(strips).into_iter().zip(&fine) {
            // The surface is the same; the plans may differ by a pass at the border of floor and fillet.
            assert!((coarse / fine - 1.0).abs() < 0.03, "{strips} strips: {coarse} s, {fine} s");
        }
    }
}

/// Waves on a grid of 1 mm, with a level saddle and level tops, at which the curvature is not small compared with that
/// of the cutter's body.
fn waves() -> Vec<FinishFacet> {
    estimated(46, 61, |row, column| {
        let (x, y) = (f64::from(column), f64::from(row));
        [x, y, 0.15 * x + 6.0 * (x / 18.0).sin() * (y / 22.0).cos() + 0.004 * y * y]
    })
}

/// The shares of the area that exceed the tolerance of 10 um by more than 3 %, and that have no height.
fn over(plan: &ZigzagPlan, facets: &[FinishFacet], candidate: &CandidateCutter) -> [f64; 2] {
    let all: Vec<u32> = (0..u32::try_from(facets.len()).unwrap()).collect();
    let heights = heights(plan, facets, candidate, &settings(Model::Envelope), &all, &|| false);
    let share = |is_in: &dyn Fn(Option<f64>) -> bool| {
        let of = facets.iter().zip(&heights).filter(|(_, height)| is_in(height.map(Length::mm)));
        of.map(|(facet, _)| facet.area).sum::<f64>() / facets.iter().map(|facet| facet.area).sum::<f64>()
    };
    [share(&|height| height.is_some_and(|height| height > 0.0103)), share(&|height| height.is_none())]
}

#[test]
fn the_height_is_kept_on_all_but_a_thousandth_of_the_area_or_the_confidence_is_lower() {
    let facets = waves();
    let sharp = CandidateCutter { drive: Some(drive(4, 8000.0)), ..CandidateCutter::new(Cutter::toroidal(mm(8.0), mm(1.0)).unwrap()) };
    let candidates = [
        CandidateCutter::new(Cutter::toroidal(mm(10.0), mm(2.0)).unwrap()),
        CandidateCutter::new(Cutter::toroidal(mm(10.0), mm(0.5)).unwrap()),
        sharp,
    ];
    for candidate in candidates {
        let ranking = ranked(&facets, &[candidate], &settings(Model::Envelope));
        let plan = &ranking.plans[0];
        let [over, without] = over(plan, &facets, &candidate);
        let confidence = ranking.confidence.as_ref().unwrap();
        let says_so = confidence.reasons().iter().any(|reason| reason.weakness == SurfaceWeakness::OverTolerance);
        let figures = plan.scallop_height;
        println!(
            "{:?}: {over:.5} over, {without:.5} without; stated {} and {}",
            candidate.cutter, figures.far_over_share, figures.without_height_share
        );
        assert!(over <= 0.001 || (says_so && confidence.level() != Level::High), "{over} {figures:?}");
        assert!(over <= 0.005, "{over}");
    }
}

#[test]
fn facets_many_strips_wide_lower_the_confidence_as_far_as_they_change_the_time() {
    // The wavy surface in quads of 2.4, 1.2 and 0.6 mm. The first are 11 um from the surface, the second 2.6 um.
    let surface = |x: f64, y: f64| {
        let ((sx, cx), (sy, cy)) = ((x / 18.0).sin_cos(), (y / 22.0).sin_cos());
        let [xx, xy, yy] = [-6.0 * sx * cy / (18.0 * 18.0), -6.0 * cx * sy / (18.0 * 22.0), -6.0 * sx * cy / (22.0 * 22.0) + 0.008];
        [6.0 * sx * cy + 0.15 * x + 0.004 * y * y, 6.0 * cx * cy / 18.0 + 0.15, -6.0 * sx * sy / 22.0 + 0.008 * y, xx, xy, yy]
    };
    let ranking = |quads: usize| {
        let facets = facets(&Height { low: [0.0; 2], high: [60.0, 44.0], surface }, quads, quads * 74 / 100);
        ranked(&facets, &[CandidateCutter::new(Cutter::flat_end(mm(6.0)))], &in_direction(Model::Envelope, 27.0))
    };
    let coarse_level = |ranking: &Ranking| {
        let reasons = ranking.confidence.as_ref().unwrap().reasons();
        reasons.iter().find(|reason| reason.weakness == SurfaceWeakness::CoarseTessellation).map(|reason| reason.level)
    };
    let [coarse, middle, fine] = [25, 50, 100].map(ranking);
    assert_eq!([&coarse, &middle, &fine].map(coarse_level), [Some(Level::Low), Some(Level::Moderate), None]);
    let time = |ranking: &Ranking| ranking.plans[0].time.seconds();
    assert!((time(&middle) / time(&fine) - 1.0).abs() < 0.01, "{} s, {} s", time(&middle), time(&fine));
    assert!((time(&coarse) / time(&fine) - 1.0).abs() < 0.08, "{} s, {} s", time(&coarse), time(&fine));
}

#[test]
fn no_direction_in_the_list_is_faster_than_the_plan() {
    let facets = waves();
    for cutter in [Cutter::toroidal(mm(10.0), mm(0.5)).unwrap(), Cutter::toroidal(mm(8.0), mm(1.0)).unwrap(), Cutter::ball_end(mm(6.0))] {
        let plan = ranked(&facets, &[CandidateCutter::new(cutter)], &settings(Model::Envelope)).plans.remove(0);
        let least = plan.by_direction.iter().filter_map(|(_, time)| *time).map(Time::seconds).fold(f64::INFINITY, f64::min);
        assert!(plan.time.seconds() <= least * (1.0 + 1e-12), "{} s, {least} s", plan.time.seconds());
        let own = plan.by_direction.iter().find(|(direction, _)| *direction == plan.direction).unwrap().1.unwrap();
        assert_eq!(own, plan.time);
    }
}

/// The facets of a block of 60 x 40 mm with a chamfer of 45 deg all round, each facet divided into four as often as stated.
fn chamfered_block(divisions: u32) -> Vec<FinishFacet> {
    let [outer, inner] = [(30.0, 20.0, 0.0), (27.0, 17.0, 3.0)].map(|(x, y, z)| [[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]]);
    let mut triangles = vec![[inner[0], inner[1], inner[2]], [inner[0], inner[2], inner[3]]];
    for corner in 0..4 {
        let next = (corner + 1) % 4;
        triangles.extend([[outer[corner], outer[next], inner[next]], [outer[corner], inner[next], inner[corner]]]);
    }
    let middle = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|axis| f64::midpoint(a[axis], b[axis]));
    for _ in 0..divisions {
        let parts = |[a, b, c]: [[f64; 3]; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(parts).collect();
    }
    triangles.into_iter().map(|corners| facet(corners, [0.0; 6])).collect()
}

/// On samples of thin facets, runs seemed interrupted, and their ends were those of the sample: the direction along the block
/// seemed 15 % slower than it is, and was not chosen.
#[test]
fn a_finely_meshed_block_takes_the_time_of_a_coarse_one_in_every_direction() {
    let candidates = [Cutter::ball_end(mm(10.0)), Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(), Cutter::flat_end(mm(8.0))];
    let plans = |divisions: u32| {
        let mut plans = ranked(&chamfered_block(divisions), &candidates.map(CandidateCutter::new), &settings(Model::Envelope)).plans;
        plans.sort_by_key(|plan| plan.candidate);
        plans
    };
    let coarse = plans(0);
    for divisions in [4, 6] {
        for (fine, coarse) in plans(divisions).iter().zip(&coarse) {
            let ratio = fine.time.seconds() / coarse.time.seconds();
            assert!((ratio - 1.0).abs() < 0.001, "{divisions} divisions: {} and {} s", fine.time.seconds(), coarse.time.seconds());
            assert_eq!(fine.direction, coarse.direction);
            for (direction, seconds) in &fine.by_direction {
                let Some((_, Some(exact))) = coarse.by_direction.iter().find(|(other, _)| other == direction) else { continue };
                let ratio = seconds.unwrap().seconds() / exact.seconds();
                // A sample can miss the thin facets at which a flat-end cutter has narrow step-overs.
                let error = if fine.candidate == 2 { 0.15 } else { 0.03 };
                assert!((ratio - 1.0).abs() < error, "{divisions} divisions, {} deg: {ratio}", direction.degrees());
            }
        }
    }
}

/// The check drew facets at even distances in the order of the file. On a regular mesh these are the same places of each row.
#[test]
fn grooves_that_are_tighter_than_the_ball_lower_the_confidence_on_a_regular_mesh() {
    // Grooves of 4 mm radius, 30 deg at their ends, in a plate, every 40 mm: an arc of 4 mm in 20 steps, then a plane.
    let profile = |column: u32| {
        let (groove, step) = (f64::from(column / 25), column % 25);
        let (sin, cos) = (-30.0 + 3.0 * f64::from(step.min(20))).to_radians().sin_cos();
        let beyond = if step > 20 { 36.0 * f64::from(step - 20) / 5.0 } else { 0.0 };
        [40.0 * groove + 4.0 * sin + beyond, 4.0 - 4.0 * cos]
    };
    for rows in [41, 64, 101] {
        let facets = estimated(rows, 6 * 25, |row, column| {
            let [x, z] = profile(column);
            [x, 100.0 * f64::from(row) / f64::from(rows - 1), z]
        });
        let tight = |facet: &&FinishFacet| facet.curvature[0] < -0.2;
        let area = |facets: &[FinishFacet]| facets.iter().map(|facet| facet.area).sum::<f64>();
        let share = facets.iter().filter(tight).map(|facet| facet.area).sum::<f64>() / area(&facets);
        let ranking = ranked(&facets, &[CandidateCutter::new(Cutter::ball_end(mm(10.0)))], &in_direction(Model::Envelope, 90.0));
        let found = ranking.plans[0].scallop_height.without_height_share;
        assert!((found - share).abs() < 0.03 && share > 0.05, "{rows} rows: {found}, {share}");
        assert!(ranking.confidence.unwrap().reasons().iter().any(|reason| reason.weakness == SurfaceWeakness::OverTolerance));
    }
}
