//! The files in `examples/` agree with the service.

use crate::api::openapi::{assert_valid, document, validator};
use crate::app::{TestApp, figure};
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

fn parse(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_patch_of_surface_1_and_its_answer_fit_the_schemas_of_the_document() {
    let (app, document) = (TestApp::start().await, document());
    let schema = |name: &str| validator(&document, &json!({"$ref": format!("#/components/schemas/{name}")}));
    let surface_1 = parse(include_str!("../../examples/surface_1.json"));
    assert_valid(&schema("RecommendationRequest"), &surface_1);
    assert_valid(&schema("RecommendationAnswer"), &app.recommend(&surface_1).await.ok());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_files_of_surface_2_give_the_answer_of_its_patch() {
    let app = TestApp::start().await;
    let mut parameters = parse(include_str!("../../examples/surface_2.json"));
    // The files have 40 x 40 samples or quads. The path is milled on facets, which at that size are up to half of the
    // scallop height from the patch, so that the patch is sampled like them.
    parameters["surface"]["samples"] = json!(40);
    parameters["directions_deg"] = json!([0]);
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
        // shorter and fewer. Which places of the coarse mesh were drawn moves the number of lines by some 2 %: 102 on the patch,
        // 104 on the same facets as STL.
        let area = if source == "text" { (39.0_f64 / 40.0).powi(2) } else { 1.0 };
        let ball = |answer: &Value| {
            let candidates = answer["candidates"].as_array().unwrap();
            figure(candidates.iter().find(|candidate| candidate["type"] == "ball_end").unwrap(), "/machining_time_s")
        };
        approx::assert_relative_eq!(ball(&answer) / area, ball(&patch), max_relative = 0.03);
    }
}
