//! `GET` on the single calculations: the same members as a query, the same answers, and faults that point to the
//! query's parameters.

use crate::api::requests::{CUTTING_PARAMETERS, MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, longest, shortest, with, without};
use crate::app::{Answer, TestApp};
use serde_json::{Value, json};

const SINGLES: [&str; 4] = [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER, CUTTING_PARAMETERS];

const CONTACT: &str = "cutter=toroidal&diameter_mm=10&corner_radius_mm=2&slope_deg=40&feed_angle_deg=30";

/// A JSON request as a query.
fn query_of(body: &Value) -> String {
    let mut query = Vec::new();
    let text = |value: &Value| match value {
        Value::String(text) => text.clone(),
        Value::Array(items) => items.iter().map(Value::to_string).collect::<Vec<_>>().join(","),
        other => other.to_string(),
    };
    for (name, value) in body.as_object().unwrap() {
        match value.as_object() {
            None => query.push(format!("{name}={}", text(value))),
            Some(members) => query.extend(members.iter().map(|(inner, value)| {
                let name = match (name.as_str(), inner.as_str()) {
                    ("cutter", "type") => "cutter".to_owned(),
                    ("cutter" | "contact", _) => inner.clone(),
                    _ => format!("{name}_{inner}"),
                };
                format!("{name}={}", text(value))
            })),
        }
    }
    query.join("&")
}

async fn get(app: &TestApp, path: &str, query: &str) -> (u16, Value) {
    let answer = app.get(&format!("{path}?{query}")).await;
    (answer.status().as_u16(), answer.json().await.unwrap())
}

#[tokio::test]
async fn a_query_is_answered_like_the_json_with_the_same_members() {
    let app = TestApp::start().await;
    for path in SINGLES {
        let vectors = json!({"normal": [-0.64, 0, 0.77], "feed": [1, 0, 0.84], "tool_axis": [0.1, 0, 0.99]});
        let curved = without(longest(path), "/surface_radius_mm");
        for body in [
            shortest(path),
            longest(path),
            with(shortest(path), "/contact", vectors),
            with(shortest(path), "/cutter", json!({"type": "ball_end", "diameter_mm": 20})),
            with(curved.clone(), "/surface_curvature", json!({"along_per_mm": -0.004, "across_per_mm": 0.01, "twist_per_mm": 0.001})),
            with(curved, "/surface_curvature", json!({"principal_per_mm": [0.012, -0.005], "angle_deg": 30})),
        ] {
            let (status, answer) = get(&app, path, &query_of(&body)).await;
            assert_eq!((status, answer), (200, app.answer(path, &body).await), "{path}?{}", query_of(&body));
        }
    }
    let (status, _) = get(&app, SCALLOP_HEIGHT, &format!("{CONTACT}&step_over_mm=6.87e%2D1")).await;
    assert_eq!(status, 200);
}

#[tokio::test]
async fn numbers_are_separated_by_commas_or_repeat_the_name() {
    let app = TestApp::start().await;
    let get =
        async |normal: &str| get(&app, SCALLOP_HEIGHT, &format!("cutter=ball_end&diameter_mm=6&step_over_mm=1&feed=1,0,0&{normal}")).await;
    let (status, answer) = get("normal=-0.64,0,0.77").await;
    assert_eq!(status, 200, "{answer}");
    assert_eq!(get("normal=-0.64&normal=0&normal=0.77").await, (200, answer));
    for (normal, pointer) in
        [("normal=0&normal=1", "/normal"), ("normal=0&normal=x&normal=1", "/normal/1"), ("normal=0&normal=&normal=1", "/normal")]
    {
        let (status, problem) = get(normal).await;
        assert_eq!((status, &problem["errors"][0]["pointer"]), (422, &json!(pointer)), "{normal}: {problem}");
    }
}

#[tokio::test]
async fn faults_point_to_the_parameters() {
    let app = TestApp::start().await;
    for (query, expected) in [
        (format!("{CONTACT}&step_over_mm="), json!([["/step_over_mm", "wrong-type"]])),
        (format!("{CONTACT}&step_over_mm=1&step_over_mm=1"), json!([["/step_over_mm", "repeated-field"]])),
        (format!("{CONTACT}&step_over_mm=1&stepover=1"), json!([["/stepover", "unknown-field"]])),
        (format!("{CONTACT}&step_over_mm=one"), json!([["/step_over_mm", "wrong-type"]])),
        (format!("{CONTACT}&step_over_mm=nan"), json!([["/step_over_mm", "not-finite"]])),
        (format!("{CONTACT}&step_over_mm=-inf"), json!([["/step_over_mm", "not-finite"]])),
        (format!("{CONTACT}&step_over_mm=1e999"), json!([["/step_over_mm", "out-of-range"]])),
        (format!("{CONTACT}&step_over_mm=1&runout_radial_mm=-1"), json!([["/runout_radial_mm", "out-of-range"]])),
        (format!("{CONTACT}&step_over_mm=1&step_over_xy_mm=1"), json!([["/step_over_xy_mm", "conflicting-fields"]])),
        (format!("{CONTACT}&step_over_mm=1&model=exact"), json!([["/model", "unknown-value"]])),
        (
            format!("{CONTACT}&step_over_mm=1&surface_curvature_across_per_mm=-0.5"),
            json!([["/surface_curvature_across_per_mm", "gouging"]]),
        ),
        (format!("{CONTACT}&step_over_mm=1&surface_radius_mm=-2"), json!([["/surface_radius_mm", "gouging"]])),
        (CONTACT.replace("40", "0") + "&step_over_mm=1", json!([["/slope_deg", "flat-floor"]])),
        (CONTACT.replace("toroidal", "drill") + "&step_over_mm=1", json!([["/cutter", "unknown-value"]])),
        (CONTACT.replace("toroidal", "ball_end") + "&step_over_mm=1", json!([["/corner_radius_mm", "unknown-field"]])),
        (
            "step_over_mm=1&slope_deg=40&feed_angle_deg=30".to_owned(),
            json!([["/cutter", "missing-field"], ["/diameter_mm", "missing-field"]]),
        ),
        ("cutter=ball_end&diameter_mm=6&step_over_mm=1".to_owned(), json!([["", "missing-field"]])),
        ("cutter=ball_end&diameter_mm=6&step_over_mm=1&normal=0,0,0&feed=1,0,0".to_owned(), json!([["/normal", "no-direction"]])),
        (
            "cutter=ball_end&diameter_mm=6&step_over_mm=1&normal=0,x,1&feed=1,0".to_owned(),
            json!([["/normal/1", "wrong-type"], ["/feed", "wrong-type"]]),
        ),
    ] {
        let (status, problem) = get(&app, SCALLOP_HEIGHT, &query).await;
        assert_eq!(status, 422, "{query}: {problem}");
        let found: Vec<_> = problem["errors"].as_array().unwrap().iter().map(|error| json!([error["pointer"], error["code"]])).collect();
        assert_eq!(json!(found), expected, "{query}: {problem}");
    }
    let (_, problem) = get(&app, MAX_FEED, &format!("{CONTACT}&step_over_mm=0.5&scallop_tolerance_mm=0.01&max_feed_rate_mm_min=500")).await;
    let found: Vec<_> = problem["errors"].as_array().unwrap().iter().map(|error| error["pointer"].as_str().unwrap()).collect();
    assert_eq!(found, ["/spindle_speed_rpm", "/teeth"]);
}

#[tokio::test]
async fn the_documented_parameters_are_those_that_the_service_accepts() {
    let app = TestApp::start().await;
    let document: Value = serde_json::from_str(&scallopd::http::openapi_json()).unwrap();
    for path in SINGLES {
        let parameters = document["paths"][path]["get"]["parameters"].as_array().unwrap();
        let documented: Vec<_> = parameters.iter().map(|parameter| parameter["name"].as_str().unwrap()).collect();
        let (_, problem) = get(&app, path, "zz=1").await;
        let detail = problem["errors"][0]["detail"].as_str().unwrap();
        assert_eq!(detail.split_once("known here: ").unwrap().1, documented.join(", "));
        let required =
            parameters.iter().filter(|parameter| parameter["required"] == true).map(|parameter| parameter["name"].as_str().unwrap());
        // A roughness may stand in place of the tolerance, and a profile has no diameter.
        assert_eq!(required.collect::<Vec<_>>(), ["cutter"], "{path}");
        assert!(
            parameters
                .iter()
                .all(|parameter| parameter["in"] == "query" && parameter["description"].is_string() && parameter["schema"].is_object())
        );
    }
}

#[tokio::test]
async fn the_documented_example_of_each_query_gives_its_answer() {
    let app = TestApp::start().await;
    let document: Value = serde_json::from_str(&scallopd::http::openapi_json()).unwrap();
    for path in SINGLES {
        let operation = &document["paths"][path]["get"];
        let examples: serde_json::Map<_, _> = operation["parameters"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|parameter| Some((parameter["name"].as_str()?.to_owned(), parameter.get("example")?.clone())))
            .collect();
        let (status, answer) = get(&app, path, &query_of(&examples.into())).await;
        let Answer { body: expected, .. } =
            app.post(path, &document["paths"][path]["post"]["requestBody"]["content"]["application/json"]["example"]).await;
        assert_eq!((status, &answer), (200, &expected), "{path}");
        let shown = &operation["responses"]["200"]["content"]["application/json"]["example"];
        assert_eq!(shown["model"], answer["model"], "{path}");
    }
}
