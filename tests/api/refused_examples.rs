//! The refused requests of the OpenAPI document: each is answered with the problem listed with it.
//!
//! After an intended change, `docs/renew-examples` updates the problems.

use crate::api::document::{assert_same, assert_valid, document, problem_of, validator};
use crate::app::TestApp;
use reqwest::RequestBuilder;
use reqwest::multipart::{Form, Part};
use serde_json::Value;

/// The refused requests of an operation, from its file in `openapi/examples/`.
fn refused(operation: &str) -> Value {
    let file = format!("{}/openapi/examples/{operation}.refused.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{file}: {error}"));
    serde_json::from_str(&text).unwrap()
}

fn request_of(app: &TestApp, path: &str, operation: &Value, request: &Value) -> RequestBuilder {
    if let Some(query) = request.as_str() {
        return app.client.get(app.url(&format!("{path}?{query}")));
    }
    let post = app.client.post(app.url(path));
    if operation["requestBody"]["content"]["multipart/form-data"].is_null() {
        return post.json(request);
    }
    let file = Part::text(request["surface"].as_str().unwrap().to_owned()).file_name("surface.csv");
    post.multipart(Form::new().part("surface", file).text("parameters", request["parameters"].to_string()))
}

#[tokio::test]
async fn every_operation_with_problems_has_refused_examples_that_hold() {
    let (app, document) = (TestApp::start().await, document());
    let mut operations = 0;
    for (path, item) in document["paths"].as_object().unwrap() {
        for operation in item.as_object().unwrap().values().filter(|operation| !operation["responses"]["422"].is_null()) {
            let id = operation["operationId"].as_str().unwrap();
            let shown = &operation["responses"]["422"]["content"]["application/problem+json"]["examples"];
            let schema = validator(&document, problem_of(operation, "422"));
            for (name, example) in refused(id).as_object().unwrap() {
                let answer = request_of(&app, path, operation, &example["request"]).send().await.unwrap();
                assert_eq!(answer.status(), 422, "{id} {name}");
                let mut problem: Value = answer.json().await.unwrap();
                problem.as_object_mut().unwrap().remove("request_id").unwrap();
                assert_same(&problem, &shown[name]["value"], &format!("{id} {name}"));
                assert_valid(&schema, &shown[name]["value"]);
            }
            operations += 1;
        }
    }
    assert!(operations > 0);
}
