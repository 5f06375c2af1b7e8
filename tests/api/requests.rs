//! Basic requests of the calculations, which the tests modify.

use serde_json::{Value, json};

pub(crate) const SCALLOP_HEIGHT: &str = "/v1/scallop-height";
pub(crate) const MAX_FEED: &str = "/v1/max-feed";
pub(crate) const STEP_OVER: &str = "/v1/step-over";
pub(crate) const CUTTING_PARAMETERS: &str = "/v1/cutting-parameters";

/// The cutter of Segonds 2017.
pub(crate) fn toroidal() -> Value {
    json!({"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4})
}

pub(crate) fn ball_end(diameter: f64) -> Value {
    json!({"type": "ball_end", "diameter_mm": diameter})
}

pub(crate) fn angles(slope: f64, feed_angle: f64) -> Value {
    json!({"slope_deg": slope, "feed_angle_deg": feed_angle})
}

/// A request for each of the single calculations, with the fewest members that it needs.
pub(crate) fn shortest(path: &str) -> Value {
    let body = json!({"cutter": toroidal(), "contact": angles(40.0, 30.0)});
    match path {
        SCALLOP_HEIGHT => with(body, "/step_over_mm", 0.687),
        MAX_FEED => with(with(body, "/step_over_mm", 0.687), "/scallop_tolerance_mm", 0.013),
        STEP_OVER | CUTTING_PARAMETERS => with(body, "/scallop_tolerance_mm", 0.013),
        _ => panic!("{path} is not a single calculation"),
    }
}

/// The same request with every member that it can have at once.
pub(crate) fn longest(path: &str) -> Value {
    let body = with(shortest(path), "/runout", json!({"radial_mm": 0.005, "axial_mm": 0.002}));
    let body = with(with(body, "/model", "analytic"), "/surface_radius_mm", 120);
    if path == SCALLOP_HEIGHT || path == STEP_OVER {
        return with(body, "/feed_per_tooth_mm", 0.1);
    }
    let body = with(body, "/spindle_speed_rpm", 10_000);
    let body = with(with(body, "/max_feed_per_tooth_mm", 0.35), "/max_feed_rate_mm_min", 15_000);
    if path == MAX_FEED { body } else { with(with(body, "/min_step_over_mm", 0.1), "/max_step_over_mm", 1.5) }
}

/// A batch of two contacts with the members of a single request.
pub(crate) fn batch_of(single: Value) -> Value {
    let contact = single["contact"].clone();
    with(without(single, "/contact"), "/contacts", json!([contact, angles(20.0, 0.0)]))
}

/// `body` with the member at `pointer` set.
pub(crate) fn with(mut body: Value, pointer: &str, value: impl Into<Value>) -> Value {
    let (parent, name) = pointer.rsplit_once('/').unwrap();
    let parent = body.pointer_mut(parent).unwrap().as_object_mut().unwrap();
    parent.insert(name.to_owned(), value.into());
    body
}

/// `body` without the member at `pointer`.
pub(crate) fn without(mut body: Value, pointer: &str) -> Value {
    let (parent, name) = pointer.rsplit_once('/').unwrap();
    let removed = body.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(name);
    assert!(removed.is_some(), "{pointer} is not there");
    body
}

/// The pointers of all members of `body`, including those of nested objects.
pub(crate) fn members(body: &Value) -> Vec<String> {
    let mut found = Vec::new();
    for (name, value) in body.as_object().into_iter().flatten() {
        found.push(format!("/{name}"));
        found.extend(members(value).into_iter().map(|inner| format!("/{name}{inner}")));
    }
    found
}

/// `body` as text, with `literal` in place of the member at `pointer`, for texts that are not JSON values.
pub(crate) fn with_literal(body: Value, pointer: &str, literal: &str) -> String {
    const MARK: &str = "stands for the literal";
    with(body, pointer, MARK).to_string().replacen(&format!("\"{MARK}\""), literal, 1)
}
