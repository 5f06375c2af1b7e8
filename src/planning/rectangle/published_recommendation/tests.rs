//! Tests of the confidence, on surfaces with one weakness each.

use super::*;
use crate::milling::{Cutter, Model};
use crate::motion::Preset;
use crate::planning::recommend;
use crate::quantity::{Angle, Area, Length};
use crate::surface::{Facing, Grid, Unit};

fn mm(value: f64) -> Length {
    Length::from_mm(value).unwrap()
}

/// The published cutters with another scallop height.
fn job(scallop_height: f64, machine: &str) -> CutterComparison {
    let toroidal = Cutter::toroidal(mm(10.0), mm(2.0)).unwrap();
    let machine = Preset::named(machine).unwrap().limits;
    CutterComparison::new(toroidal, Cutter::ball_end(mm(10.0)), mm(scallop_height), machine, Model::Analytic).unwrap()
}

/// A surface of 41 x 41 points over parameters from -1/2 to 1/2.
fn surface(at: impl Fn(f64, f64) -> [f64; 3]) -> Shape {
    let mut grid = Grid::new(41, 41).unwrap();
    for (i, j) in (0..41_u8).flat_map(|i| (0..41_u8).map(move |j| (i, j))) {
        grid.point(at(f64::from(i) / 40.0 - 0.5, f64::from(j) / 40.0 - 0.5));
    }
    grid.finish().unwrap().shape(Unit::Millimetre, Facing::Up).unwrap()
}

/// A rectangle, its first side along X turned by `turn` in its own plane, which is inclined about X by `slope`, both
/// in deg.
fn plane(width: f64, height: f64, slope: f64, turn: f64) -> Shape {
    let ((sin, cos), (turn_sin, turn_cos)) = (slope.to_radians().sin_cos(), turn.to_radians().sin_cos());
    surface(|u, v| {
        let (x, y) = (width * u, height * v);
        let (x, y) = (turn_cos * x - turn_sin * y, turn_sin * x + turn_cos * y);
        [x, y * cos, y * sin]
    })
}

fn weaknesses(job: &CutterComparison, shape: &Shape) -> (Level, Vec<(Weakness, Level)>) {
    let confidence = recommend(job, shape).unwrap().confidence;
    (confidence.level(), confidence.reasons().iter().map(|reason| (reason.weakness, reason.level)).collect())
}

/// The weaknesses of a surface with the published job.
fn published(shape: &Shape) -> (Level, Vec<(Weakness, Level)>) {
    weaknesses(&job(0.01, "five_axis_vmc"), shape)
}

#[test]
fn an_inclined_rectangle_away_from_its_critical_slope_is_trusted() {
    assert_eq!(published(&plane(80.0, 40.0, 15.0, 0.0)), (Level::High, vec![]));
    assert_eq!(published(&plane(80.0, 40.0, 70.0, 0.0)), (Level::High, vec![]));
}

#[test]
fn oblique_directions_weaken_the_answer() {
    use Weakness::DirectionsNotPerpendicular as Oblique;
    for (turn, expected) in [(10.0, None), (20.0, Some(Level::Moderate)), (40.0, Some(Level::Low))] {
        let expected_reasons: Vec<_> = expected.map(|level| (Oblique, level)).into_iter().collect();
        let found = published(&plane(80.0, 40.0, 10.0, turn));
        assert_eq!(found, (expected.unwrap_or(Level::High), expected_reasons), "turned by {turn} deg");
    }
}

#[test]
fn squares_have_no_or_hardly_a_principal_direction() {
    let almost = published(&plane(61.0, 58.0, 30.0, 0.0));
    assert_eq!(almost, (Level::Moderate, vec![(Weakness::FormFactorNearOne, Level::Moderate)]));
    let square = published(&plane(60.0, 60.0, 30.0, 0.0));
    assert_eq!(square, (Level::Low, vec![(Weakness::NoPrincipalDirection, Level::Low)]));
}

#[test]
fn domes_are_graded_by_the_inclination_of_their_normals() {
    use Weakness::NotFlat;
    // The cap of a ball of 60 mm, its axis leaning by 15 deg.
    let dome = |half_angle: f64| {
        let (sin, cos) = 15.0_f64.to_radians().sin_cos();
        surface(|u, v| {
            let (around, off_axis) = (std::f64::consts::TAU * u, half_angle.to_radians() * (v + 0.5));
            let (x, y) = (60.0 * off_axis.sin() * around.cos(), 60.0 * off_axis.sin() * around.sin());
            let z = 60.0 * off_axis.cos();
            [x, y * cos - z * sin, y * sin + z * cos]
        })
    };
    for (half_angle, expected) in [(28.0, None), (32.0, Some(Level::Moderate)), (43.0, Some(Level::Moderate)), (47.0, Some(Level::Low))] {
        let shape = dome(half_angle);
        // On a sphere, area is evenly distributed over height: with c = cos(half angle), the variances are (1 - c)^2/12
        // and (1 - (1 + c + c^2)/3)/2. Polygons of 40 x 40 are smaller than the sphere by (2 pi/40)^2/8 = 0.3 %.
        let c = f64::cos(half_angle.to_radians());
        let flatness = (1.0 - c) / 12.0_f64.sqrt() / ((1.0 - (1.0 + c + c * c) / 3.0) / 2.0).sqrt();
        approx::assert_relative_eq!(shape.flatness, flatness, max_relative = 0.01);
        let mut found = published(&shape).1;
        found.retain(|(weakness, _)| *weakness == NotFlat);
        assert_eq!(found, expected.map(|level| (NotFlat, level)).into_iter().collect::<Vec<_>>(), "{half_angle} deg");
    }
}

#[test]
fn gentle_slopes_and_level_surfaces_weaken_the_answer() {
    use Weakness::SlopeNearZero;
    assert!(published(&plane(80.0, 40.0, 0.9, 0.0)).1.contains(&(SlopeNearZero, Level::Moderate)));
    let nearly_level = published(&plane(80.0, 40.0, 0.05, 0.0)).1;
    assert!(nearly_level.contains(&(SlopeNearZero, Level::Low)));
    let level = published(&plane(80.0, 40.0, 0.0, 0.0));
    assert!(level.0 == Level::Low && level.1.contains(&(SlopeNearZero, Level::Low)), "{level:?}");
}

#[test]
fn a_slope_near_the_critical_slope_decides_little() {
    // mu = 2, chi = 3200: between the published critical slopes for 1568 and 3315, 34 and 39 deg.
    let (level, reasons) = published(&plane(80.0, 40.0, 38.0, 0.0));
    assert_eq!(level, Level::Low);
    assert_eq!(reasons, [(Weakness::TimesNearlyEqual, Level::Low), (Weakness::SlopeNearCritical, Level::Moderate)]);
}

#[test]
fn small_surfaces_break_the_assumptions() {
    // Passes of 4 mm do not reach the feed rate within 7.6 mm, and make 36 mm^2.
    let found = published(&plane(9.0, 4.0, 70.0, 0.0)).1;
    for weakness in [Weakness::ShortPasses, Weakness::SmallSurface, Weakness::FewPasses] {
        assert!(found.contains(&(weakness, Level::Moderate)), "{weakness:?} in {found:?}");
    }
    let few = published(&plane(9.0, 2.5, 70.0, 0.0)).1;
    assert!(few.contains(&(Weakness::FewPasses, Level::Low)));
}

#[test]
fn steps_that_reach_the_acceleration_are_named() {
    // The hobby router reaches its acceleration after 2 A^3/J^2 = 2 * 0.4^3/8^2 m = 2 mm; a scallop of 0.2 mm allows
    // steps of 3.9 mm (R_eff = 3/sin(15 deg) + 2 = 13.6 mm; sqrt(8 * 0.2 * 13.6) = 4.7 mm).
    let found = weaknesses(&job(0.2, "hobby_router"), &plane(200.0, 100.0, 15.0, 0.0)).1;
    assert!(found.contains(&(Weakness::LongSteps, Level::Moderate)), "{found:?}");
}

#[test]
fn a_mean_slope_on_the_other_side_is_named() {
    // A gutter along X, steep on both sides: its best-fit plane has a gentle slope, its facets have not.
    let gutter = surface(|u, v| [80.0 * u, 40.0 * v, 4.0 * v + 60.0 * v.abs()]);
    assert!(published(&gutter).1.contains(&(Weakness::MeanSlopeDisagrees, Level::Moderate)));
}

#[test]
fn reasons_are_sorted_by_level_and_have_a_text() {
    let confidence = recommend(&job(0.01, "five_axis_vmc"), &plane(80.0, 40.0, 38.0, 0.0)).unwrap().confidence;
    assert!(confidence.reasons().is_sorted_by_key(|reason| std::cmp::Reverse(reason.level)));
    let said = confidence.reasons()[0].to_string();
    assert!(said.contains("less than the 5 %"), "{said}");
}

#[test]
fn evidence_from_the_surface_weakens_the_answer_where_it_disagrees() {
    let (job, shape) = (job(0.01, "five_axis_vmc"), plane(80.0, 40.0, 15.0, 0.0));
    let recommendation = recommend(&job, &shape).unwrap();
    let plan = recommendation.plan;
    let times = [plan.toroidal.zigzag.time, plan.ball_end.zigzag.time];
    let agreeing = Evidence { mean_slope: shape.slope, area: shape.characteristic_size, pieces: 1 };
    // The torus is recommended.
    let with = |evidence: Evidence, simulated: [Time; 2]| {
        let confidence = recommendation.confidence.clone().with_surface(&shape, &evidence);
        let confidence = confidence.with_simulation(&[(times[0], simulated[0]), (times[1], simulated[1])]);
        (confidence.level(), confidence.reasons().iter().map(|reason| reason.weakness).collect::<Vec<_>>())
    };
    assert_eq!(with(agreeing, times), (Level::High, vec![]));
    let steeper = Evidence { mean_slope: Angle::from_degrees(22.0).unwrap(), ..agreeing };
    assert_eq!(with(steeper, times), (Level::Moderate, vec![Weakness::MeanSlopeFarFromPlane]));
    let larger = Evidence { area: Area::from_mm2(1.5 * shape.characteristic_size.mm2()).unwrap(), ..agreeing };
    assert_eq!(with(larger, times), (Level::Low, vec![Weakness::AreaFarFromSize]));
    assert_eq!(with(Evidence { pieces: 2, ..agreeing }, times), (Level::Low, vec![Weakness::SeveralPieces]));
    let slower = times.map(|time| Time::computed(1.2 * time.seconds()));
    assert_eq!(with(agreeing, slower), (Level::Moderate, vec![Weakness::SimulationDisagrees]));
    // In the simulation, the torus is 10 % slower than the ball.
    let other = [Time::computed(1.1 * times[1].seconds()), times[1]];
    let (level, weaknesses) = with(agreeing, other);
    assert_eq!(level, Level::Low);
    assert!(weaknesses.contains(&Weakness::SimulationPrefersOther));
}
