//! Critical slope, machines and cutter recommendation, called over HTTP or as a library.

mod critical_slope;
mod examples;
mod faults;
mod formats;
mod heights;
mod libraries;
mod members;
mod papers;
mod path_check;
mod plan;
mod published;
mod recommendation;
mod simulated;
mod solids;
mod surfaces;
mod upload;
mod warned;
mod wavy;

use serde_json::{Value, json};

/// The published job by the published method: two cutters of 10 mm, 10 um of scallop, the published machine.
fn job() -> Value {
    json!({
        "cutters": [
            {"name": "toroidal", "type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2},
            {"name": "ball_end", "type": "ball_end", "diameter_mm": 10},
        ],
        "scallop_height_mm": 0.01,
        "machine": {"preset": "five_axis_vmc"},
        "method": "rectangle",
    })
}

/// The same two cutters in the form of `/v1/critical-slope`.
fn pair() -> Value {
    json!({
        "toroidal": {"diameter_mm": 10, "corner_radius_mm": 2},
        "ball_end": {"diameter_mm": 10},
        "scallop_height_mm": 0.01,
        "machine": {"preset": "five_axis_vmc"},
    })
}

/// `base` with further or other members.
fn with(mut base: Value, members: Value) -> Value {
    let Value::Object(members) = members else { panic!("members come in an object") };
    base.as_object_mut().unwrap().extend(members);
    base
}
