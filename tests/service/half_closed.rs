//! Clients that close their sending side after the request: all kinds of requests are answered as for other clients.

use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};

use crate::app::{Answer, PATIENCE, TestApp};

const CONTACT: &str = "cutter=toroidal&diameter_mm=10&corner_radius_mm=2&slope_deg=40&feed_angle_deg=30";

/// The request for a path, as bytes without its head.
fn posts() -> Vec<(&'static str, Value)> {
    let cutter = json!({"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2, "teeth": 4});
    let contact = json!({"slope_deg": 40, "feed_angle_deg": 30});
    let columns = json!({"slope_deg": [5, 40, 80], "feed_angle_deg": [0, 30, 200]});
    let fastest = json!({"cutter": cutter, "scallop_tolerance_mm": 0.01, "spindle_speed_rpm": 10_000, "max_feed_per_tooth_mm": 0.2});
    let with = |request: &Value, name: &str, value: &Value| {
        let mut request = request.clone();
        request[name] = value.clone();
        request
    };
    let heights = json!({"cutter": cutter, "step_over_mm": 0.6, "feed_per_tooth_mm": 0.1, "model": "envelope", "contacts": columns});
    let surface = json!({"points": (0..400).map(|i| [f64::from(i % 20), f64::from(i / 20), f64::from(i % 20) / 4.0]).collect::<Vec<_>>()});
    let recommendation = json!({
        "surface": surface, "cutters": [{"type": "ball_end", "diameter_mm": 6}], "scallop_height_mm": 0.01,
        "machine": {"preset": "five_axis_vmc"}, "include": ["map", "passes"],
    });
    vec![
        ("/v1/cutting-parameters", with(&fastest, "contact", &contact)),
        ("/v1/cutting-parameters/batch", with(&fastest, "contacts", &columns)),
        ("/v1/scallop-height/batch", with(&heights, "columns", &json!(["scallop_height_mm"]))),
        ("/v1/max-feed/batch", json!({"cutter": cutter, "scallop_tolerance_mm": 0.01, "step_over_mm": 0.1, "contacts": columns})),
        ("/v1/cutter-recommendation", recommendation),
    ]
}

/// The answer to a client that closes its sending side after `request`.
async fn answer_after_closing(app: &TestApp, request: &str) -> (u16, Value) {
    let mut stream = app.connect().await;
    stream.write_all(request.as_bytes()).await.unwrap();
    stream.shutdown().await.unwrap();
    let mut answer = String::new();
    tokio::time::timeout(PATIENCE, stream.read_to_string(&mut answer)).await.expect("an answer").unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap_or_else(|| panic!("no answer: {answer:?}"));
    (head[9..12].parse().unwrap(), serde_json::from_str(body).unwrap())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_half_closed_client_gets_the_answer_to_every_kind_of_request() {
    let app = TestApp::start().await;
    for (path, body) in posts() {
        let Answer { status, body: expected, .. } = app.post(path, &body).await;
        assert_eq!(status, 200, "{path}: {expected}");
        let body = body.to_string();
        let head =
            format!("POST {path} HTTP/1.1\r\nhost: test\r\ncontent-type: application/json\r\ncontent-length: {}\r\n\r\n", body.len());
        assert_eq!(answer_after_closing(&app, &(head + &body)).await, (status, expected), "{path}");
    }
    for path in [
        format!("/v1/scallop-height?{CONTACT}&step_over_mm=0.687&feed_per_tooth_mm=0.3"),
        format!("/v1/max-feed?{CONTACT}&step_over_mm=0.5&scallop_tolerance_mm=0.02"),
        format!("/v1/step-over?{CONTACT}&scallop_tolerance_mm=0.02"),
        format!("/v1/cutting-parameters?{CONTACT}&scallop_tolerance_mm=0.02&max_feed_per_tooth_mm=0.2&teeth=4&spindle_speed_rpm=9000"),
    ] {
        let expected = Answer::of(app.get(&path).await).await;
        assert_eq!(expected.status, 200, "{path}: {}", expected.body);
        let request = format!("GET {path} HTTP/1.1\r\nhost: test\r\n\r\n");
        assert_eq!(answer_after_closing(&app, &request).await, (expected.status, expected.body), "{path}");
    }
}
