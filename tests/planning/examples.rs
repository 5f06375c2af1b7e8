//! The examples of the OpenAPI document and of the repository agree with the service.

use crate::app::{Answer, TestApp, figure};
use reqwest::multipart::{Form, Part};
use serde_json::Value;

fn parse(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Asserts equality except in the last digits of numbers, which differ between mathematical libraries.
#[track_caller]
fn assert_alike(answer: &Value, example: &Value, place: &str) {
    match (answer, example) {
        (Value::Object(answer), Value::Object(example)) => {
            let keys = |object: &serde_json::Map<String, Value>| object.keys().cloned().collect::<Vec<_>>();
            assert_eq!(keys(answer), keys(example), "{place}");
            answer.iter().for_each(|(key, value)| assert_alike(value, &example[key], &format!("{place}/{key}")));
        }
        (Value::Array(answer), Value::Array(example)) => {
            assert_eq!(answer.len(), example.len(), "{place}");
            answer.iter().zip(example).enumerate().for_each(|(index, (one, other))| assert_alike(one, other, &format!("{place}/{index}")));
        }
        (Value::Number(one), Value::Number(other)) => {
            let (one, other) = (one.as_f64().unwrap(), other.as_f64().unwrap());
            assert!((one - other).abs() <= 1e-9 * other.abs().max(1e-3), "{place}: {one}, in the example {other}");
        }
        _ => assert_eq!(answer, example, "{place}"),
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_example_request_of_the_document_gives_its_example_answer() {
    let app = TestApp::start().await;
    let document = Answer::of(app.get("/openapi.json").await).await.ok();
    for (path, id) in [("/v1/critical-slope", "critical_slope"), ("/v1/cutter-recommendation", "cutter_recommendation")] {
        let operation = &document["paths"][path]["post"];
        assert_eq!(operation["operationId"], id);
        let answer = app.post(path, &operation["requestBody"]["content"]["application/json"]["example"]).await.ok();
        assert_alike(&answer, &operation["responses"]["200"]["content"]["application/json"]["example"], id);
    }
    let operation = &document["paths"]["/v1/machines"]["get"];
    let answer = Answer::of(app.get("/v1/machines").await).await.ok();
    assert_alike(&answer, &operation["responses"]["200"]["content"]["application/json"]["example"], "machines");

    let operation = &document["paths"]["/v1/cutter-recommendation/upload"]["post"];
    let example = &operation["requestBody"]["content"]["multipart/form-data"]["example"];
    let answer = app.upload(example["surface"].as_str().unwrap(), &example["parameters"]).await.ok();
    assert_alike(&answer, &operation["responses"]["200"]["content"]["application/json"]["example"], "upload");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn answers_and_requests_fit_the_schemas_of_the_document() {
    let app = TestApp::start().await;
    let document = Answer::of(app.get("/openapi.json").await).await.ok();
    let schema = |name: &str| {
        let mut schema = document["components"]["schemas"][name].clone();
        schema["components"] = document["components"].clone();
        jsonschema::validator_for(&schema).unwrap()
    };
    let surface_1 = parse(include_str!("../../examples/surface_1.json"));
    assert!(schema("RecommendationRequest").is_valid(&surface_1));
    for (name, answer) in [
        ("RecommendationAnswer", app.recommend(&surface_1).await.ok()),
        ("CriticalSlopeAnswer", parse(include_str!("../../openapi/examples/critical_slope.answer.json"))),
        ("Machines", Answer::of(app.get("/v1/machines").await).await.ok()),
        ("UploadRequest", parse(include_str!("../../openapi/examples/cutter_recommendation_upload.request.json"))),
    ] {
        let faults: Vec<_> = schema(name).iter_errors(&answer).map(|error| format!("{}: {error}", error.instance_path())).collect();
        assert!(faults.is_empty(), "{name}: {faults:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_files_of_surface_2_give_the_answer_of_its_patch() {
    let app = TestApp::start().await;
    let mut parameters = parse(include_str!("../../examples/surface_2.json"));
    let patch = app.recommend(&parameters).await.ok();
    parameters.as_object_mut().unwrap().remove("surface");
    let files: [(&str, &[u8], &str); 2] = [
        ("surface_2.csv", include_bytes!("../../examples/surface_2.csv"), "text"),
        ("surface_2.stl", include_bytes!("../../examples/surface_2.stl"), "stl_binary"),
    ];
    for (name, file, source) in files {
        let form = Form::new()
            .part("surface", Part::bytes(file).file_name(name).mime_str("application/octet-stream").unwrap())
            .part("parameters", Part::text(parameters.to_string()).mime_str("application/json").unwrap());
        let answer = app.upload_form(form).await.ok();
        assert_eq!(answer["surface"]["source"], source);
        assert_eq!(answer["recommended"]["name"], "toroidal");
        assert_eq!(answer["warnings"], patch["warnings"]);
        // 40 x 40 samples or quads in place of 80 x 80 samples, and weights by area in place of parameters, change
        // figures by under 1 %.
        for pointer in ["/critical_slope_deg", "/surface/slope_deg", "/surface/form_factor"] {
            approx::assert_relative_eq!(figure(&answer, pointer), figure(&patch, pointer), max_relative = 0.02);
        }
        // The points are the centres of quads, which span (39/40)^2 = 0.95 of the area, and the passes are that much
        // shorter and fewer.
        let area = if source == "text" { (39.0_f64 / 40.0).powi(2) } else { 1.0 };
        let (time, whole) = (figure(&answer, "/recommended/machining_time_s"), figure(&patch, "/recommended/machining_time_s"));
        approx::assert_relative_eq!(time / area, whole, max_relative = 0.02);
    }
}
