//! The published figures of Herraz et al. 2020, computed by the library.
#![allow(clippy::float_cmp)] // exact by construction where compared for equality

use approx::{assert_abs_diff_eq, assert_relative_eq};
use scallopd::milling::{Cutter, Model};
use scallopd::motion::Preset;
use scallopd::planning::{CutterChoice, CutterComparison, InclinedRectangle, Level, Weakness, critical_slope, plan, recommend};
use scallopd::quantity::{Acceleration, Angle, Area, FormFactor, Jerk, Length, Speed};
use scallopd::surface::{Bezier, Facing, Shape, Unit};
use serde_json::Value;

fn published() -> Value {
    serde_json::from_str(include_str!("../data/herraz_2020.json")).unwrap()
}

fn figure(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("{name} is a number"))
}

fn patch(surface: &Value) -> Bezier {
    let coordinates = |point: &Value| [0, 1, 2].map(|axis| point[axis].as_f64().unwrap());
    let rows = surface["control_points_mm"].as_array().unwrap().iter();
    let net: Vec<Vec<[f64; 3]>> = rows.map(|row| row.as_array().unwrap().iter().map(coordinates).collect()).collect();
    Bezier::new(&net).unwrap()
}

/// The shape of a published surface, sampled as the paper does, 80 x 80.
fn shape(index: usize) -> (Value, Shape) {
    let surface = published()["surfaces"][index].clone();
    let shape = patch(&surface).sampled(80, &|| false).unwrap().shape(Unit::Millimetre, Facing::Up).unwrap();
    (surface, shape)
}

#[test]
fn surface_2_has_its_printed_shape() {
    let (printed, shape) = shape(1);
    // Eigenvalues and form factor to half a unit of their last digit; the size is printed truncated to an integer.
    for (rank, eigenvalue) in [312.07, 219.02, 3.21].into_iter().enumerate() {
        assert_abs_diff_eq!(shape.eigenvalues[rank].mm2(), eigenvalue, epsilon = 0.005);
    }
    assert_eq!(printed["eigenvalues_mm2"][0], 312.07);
    assert_abs_diff_eq!(shape.form_factor.ratio(), figure(&printed, "form_factor"), epsilon = 0.005);
    assert_eq!(shape.characteristic_size.mm2().floor(), figure(&printed, "characteristic_size_mm2"));
    // 17.18 deg against 17.13 printed.
    assert_abs_diff_eq!(shape.slope.degrees(), figure(&printed, "slope_deg"), epsilon = 0.06);
    assert_abs_diff_eq!(shape.principal_direction.unwrap().degrees(), 90.0, epsilon = 1e-9);
    assert_eq!(shape.steepest_direction.unwrap().degrees(), 0.0);
    assert_abs_diff_eq!(shape.direction_gap.unwrap().degrees(), 90.0, epsilon = 1e-9);
    assert_abs_diff_eq!(shape.flatness, 0.101, epsilon = 0.0005);
    assert_abs_diff_eq!(shape.area.unwrap().mm2(), 3240.8, epsilon = 0.05);
    assert_abs_diff_eq!(shape.mean_slope.unwrap().degrees(), 23.63, epsilon = 0.005);
    assert_eq!(shape.elements, 6400);
}

#[test]
fn surface_1_has_its_printed_shape_to_the_precision_of_its_printed_points() {
    let (printed, shape) = shape(0);
    // Control points printed to 0.01 mm of some 10 mm: a part in a thousand.
    for rank in 0..2 {
        assert_relative_eq!(shape.eigenvalues[rank].mm2(), printed["eigenvalues_mm2"][rank].as_f64().unwrap(), max_relative = 1e-3);
    }
    assert_relative_eq!(shape.form_factor.ratio(), figure(&printed, "form_factor"), max_relative = 2e-3);
    assert_relative_eq!(shape.characteristic_size.mm2(), figure(&printed, "characteristic_size_mm2"), max_relative = 1e-3);
    assert_abs_diff_eq!(shape.slope.degrees(), figure(&printed, "slope_deg"), epsilon = 0.06);
    assert_abs_diff_eq!(shape.steepest_direction.unwrap().degrees(), figure(&printed, "steepest_direction_deg"), epsilon = 0.06);
    // -9.94 deg against -9.74 printed, here as 170.06 deg.
    let printed_direction = figure(&printed, "principal_direction_deg").rem_euclid(180.0);
    assert_abs_diff_eq!(shape.principal_direction.unwrap().degrees(), printed_direction, epsilon = 0.21);
}

fn mm(value: f64) -> Length {
    Length::from_mm(value).unwrap()
}

/// The paper's cutters, scallop height and machine.
fn job() -> CutterComparison {
    let published = published();
    let radius = |name| figure(&published["cutters"], name);
    let toroidal = Cutter::toroidal(mm(2.0 * radius("outer_radius_mm")), mm(radius("corner_radius_mm"))).unwrap();
    let ball_end = Cutter::ball_end(mm(2.0 * radius("outer_radius_mm")));
    let machine = Preset::named("five_axis_vmc").unwrap().limits;
    CutterComparison::new(toroidal, ball_end, mm(figure(&published, "scallop_height_mm")), machine, Model::Analytic).unwrap()
}

#[test]
fn the_five_axis_preset_is_the_published_machine() {
    let machine = &published()["machine"];
    let limits = Preset::named("five_axis_vmc").unwrap().limits;
    assert_eq!(limits.feed_rate, Speed::from_mm_min(figure(machine, "feed_rate_mm_min")).unwrap());
    assert_eq!(limits.acceleration, Acceleration::from_m_s2(figure(machine, "acceleration_m_s2")).unwrap());
    assert_eq!(limits.jerk, Jerk::from_m_s3(figure(machine, "jerk_m_s3")).unwrap());
}

#[test]
fn critical_slopes_follow_from_the_printed_form_factors_and_sizes() {
    let published = published();
    for (entry, exact) in [(&published["surfaces"][0], 38.90), (&published["surfaces"][1], 62.61)] {
        let mu = FormFactor::new(figure(entry, "form_factor")).unwrap();
        let rectangle = InclinedRectangle::from_form(mu, Area::from_mm2(figure(entry, "characteristic_size_mm2")).unwrap()).unwrap();
        let slope = critical_slope(&job(), rectangle).unwrap().angle().degrees();
        assert_abs_diff_eq!(slope, exact, epsilon = 0.005);
        // Printed truncated to a tenth.
        assert_eq!((slope * 10.0).floor() / 10.0, figure(entry, "critical_slope_deg"));
    }
}

#[test]
fn the_plane_of_table_1_has_its_times_and_lengths() {
    let published = published();
    let entry = &published["plane"];
    let rectangle = InclinedRectangle::from_sides(mm(figure(entry, "width_mm")), mm(figure(entry, "height_mm"))).unwrap();
    let plan = plan(&job(), rectangle, Angle::from_degrees(figure(entry, "slope_deg")).unwrap()).unwrap();
    // 33.8558 deg by bisection in an independent program; the printed value is truncated to a tenth.
    let critical = plan.critical_slope.angle().degrees();
    assert_abs_diff_eq!(critical, 33.8558, epsilon = 0.00005);
    assert_eq!((critical * 10.0).floor() / 10.0, figure(entry, "critical_slope_deg"));
    assert_eq!(plan.recommended, CutterChoice::BallEnd);
    // sod = 2 sqrt(2 sh R_eff - sh^2), so R_eff = sod^2/8sh + sh/2; printed with two decimals.
    let effective_radius = |step_over: Length| step_over.mm().powi(2) / (8.0 * 0.01) + 0.01 / 2.0;
    for (candidate, name, time, length) in [(plan.toroidal, "toroidal", 43.06, 2429.0), (plan.ball_end, "ball_end", 37.34, 2508.0)] {
        let printed = &entry[name];
        assert_abs_diff_eq!(effective_radius(candidate.zigzag.step_over), figure(printed, "effective_radius_mm"), epsilon = 0.005);
        // The model's figures, computed by an independent program to the digits given.
        assert_abs_diff_eq!(candidate.zigzag.time.seconds(), time, epsilon = 0.005);
        assert_abs_diff_eq!(candidate.zigzag.path_length.mm(), length, epsilon = 0.5);
        // The paper's own simulation, within the 5 % that it states for its model.
        assert_relative_eq!(candidate.zigzag.time.seconds(), figure(printed, "simulated_time_s"), max_relative = 0.05);
        assert_relative_eq!(candidate.zigzag.path_length.mm(), figure(printed, "simulated_length_mm"), max_relative = 0.05);
    }
}

#[test]
fn both_surfaces_get_the_published_recommendation() {
    for (index, cutter, name) in [(0, CutterChoice::BallEnd, "ball_end"), (1, CutterChoice::Toroidal, "toroidal")] {
        let (printed, shape) = shape(index);
        let recommendation = recommend(&job(), &shape).unwrap();
        assert_eq!(recommendation.plan.recommended, cutter);
        assert_eq!(printed["recommended"], name);
        assert_eq!(recommendation.plan.toroidal.direction, shape.steepest_direction);
        assert_eq!(recommendation.plan.ball_end.direction, shape.principal_direction);
    }
}

#[test]
fn the_recommendation_for_surface_2_has_its_figures() {
    let (_, shape) = shape(1);
    let recommendation = recommend(&job(), &shape).unwrap();
    let best = recommendation.plan.recommended();
    assert_abs_diff_eq!(best.zigzag.step_over.mm(), 0.9859, epsilon = 0.00005);
    assert_abs_diff_eq!(best.zigzag.time.seconds(), 49.58, epsilon = 0.005);
    assert_abs_diff_eq!(recommendation.plan.critical_slope.angle().degrees(), 62.39, epsilon = 0.005);
    assert_abs_diff_eq!(recommendation.plan.critical_form_factor.form_factor().ratio(), 6.79, epsilon = 0.005);
    assert_eq!(recommendation.confidence.level(), Level::High);
    assert_eq!(recommendation.confidence.reasons(), []);
}

#[test]
fn surface_1_is_a_close_decision() {
    let (_, shape) = shape(0);
    let recommendation = recommend(&job(), &shape).unwrap();
    // The slope is 42.3 deg and the critical slope 38.9 deg; the times differ by 2.3 %.
    let weaknesses: Vec<_> = recommendation.confidence.reasons().iter().map(|reason| reason.weakness).collect();
    assert_eq!(weaknesses, [Weakness::TimesNearlyEqual, Weakness::SlopeNearCritical]);
    assert_eq!(recommendation.confidence.level(), Level::Low);
}
