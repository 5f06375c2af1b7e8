//! Warnings and reasons for less confidence of a recommendation.

use crate::app::{TestApp, warnings};
use crate::planning::wavy::{self, triangles};
use crate::planning::{job, with};
use crate::writers::exact;
use serde_json::{Value, json};

/// The wavy slope as a mesh, with every second triangle turned over if `is_mixed` is set.
fn mesh(is_mixed: bool) -> Value {
    let points: Vec<_> = wavy::nodes([1.5, 1.25], [0.25, 0.2]).into_iter().map(exact).collect();
    let turn = |(number, [a, b, c]): (usize, [usize; 3])| if is_mixed && number % 2 == 1 { [a, c, b] } else { [a, b, c] };
    let triangles: Vec<_> = triangles().into_iter().enumerate().map(turn).collect();
    json!({"surface": {"mesh": {"points": points, "triangles": triangles}}, "method": "surface", "directions_deg": [0]})
}

fn reasons(answer: &Value) -> Vec<&str> {
    let reasons = answer["confidence"]["reasons"].as_array().unwrap();
    reasons.iter().map(|reason| reason["code"].as_str().unwrap()).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn facets_of_both_orientations_lower_the_confidence() {
    let app = TestApp::start().await;
    let sound = app.recommend(&with(job(), mesh(false))).await.ok();
    assert!(!reasons(&sound).contains(&"inconsistent-orientation"), "{}", sound["confidence"]);
    let half = app.recommend(&with(job(), mesh(true))).await.ok();
    assert!(reasons(&half).contains(&"inconsistent-orientation"));
    assert_eq!(half["confidence"]["level"], "low");
    // The surface is the same; only the confidence is lower.
    assert_eq!(half["recommended"]["machining_time_s"], sound["recommended"]["machining_time_s"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn members_that_method_rectangle_does_not_use_are_named() {
    let app = TestApp::start().await;
    let request = with(with(job(), mesh(false)), json!({"method": "rectangle", "include": ["map", "passes"]}));
    let answer = app.recommend(&request).await.ok();
    assert_eq!(warnings(&answer).iter().filter(|code| **code == "member-unused").count(), 2);
    let details: Vec<_> = answer["warnings"].as_array().unwrap().iter().map(|warning| warning["detail"].as_str().unwrap()).collect();
    assert!(["include", "directions_deg"].iter().all(|member| details.iter().any(|detail| detail.starts_with(member))), "{details:?}");
    let answer = app.recommend(&with(job(), json!({"surface": mesh(false)["surface"]}))).await.ok();
    assert!(!warnings(&answer).contains(&"member-unused"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_spindle_speed_over_the_machines_is_named() {
    let app = TestApp::start().await;
    let cutter = |speed: u32| json!([{"name": "B6", "type": "ball_end", "diameter_mm": 6, "teeth": 2, "spindle_speed_rpm": speed}]);
    let machine = json!({"preset": "five_axis_vmc", "max_spindle_speed_rpm": 5000});
    let recommended = |speed: u32| with(with(job(), mesh(false)), json!({"cutters": cutter(speed), "machine": machine}));
    let limited = app.recommend(&recommended(12_000)).await.ok();
    assert!(warnings(&limited).contains(&"spindle-speed-limited"));
    let at_limit = app.recommend(&recommended(5000)).await.ok();
    assert!(!warnings(&at_limit).contains(&"spindle-speed-limited"));
    assert_eq!(limited["candidates"], at_limit["candidates"]);
}
