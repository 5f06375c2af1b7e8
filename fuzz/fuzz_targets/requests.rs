//! Fuzz target: JSON requests to every operation that accepts them. Every answer must be JSON without a status of 500.
//! The first line of an input is the path; the rest is the body.

#![no_main]

mod service;

use std::sync::LazyLock;

use serde_json::Value;

/// The paths of the OpenAPI document that take a JSON body.
static PATHS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let document: Value = serde_json::from_str(&scallopd::http::openapi_json()).expect("the document is JSON");
    let paths = document["paths"].as_object().expect("the document has paths");
    let takes_json = |item: &Value| item["post"]["requestBody"]["content"]["application/json"].is_object();
    paths.iter().filter(|(_, item)| takes_json(item)).map(|(path, _)| path.clone()).collect()
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some(end) = bytes.iter().position(|byte| *byte == b'\n') else { return };
    let (path, body) = (&bytes[..end], &bytes[end + 1..]);
    // A line that is no path stands for the path of its length's number, so that mutations of it reach other operations.
    let path = PATHS.iter().find(|known| known.as_bytes() == path).unwrap_or(&PATHS[end % PATHS.len()]);
    service::post(path, "application/json", body);
});
