//! The examples of the OpenAPI document: for each operation a request, its answer, and requests that are refused.

use super::query::parameters_of;
use serde_json::{Map, Value, json};

/// Embeds an endpoint's file from `openapi/examples/`. It maps the id of each operation to an object with the members
/// `request`, `answer` and `refused`, of which each may be absent.
macro_rules! examples {
    ($endpoint:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/openapi/examples/", $endpoint, ".json"))
    };
}
pub(crate) use examples;

/// Adds the examples in `files` to the operations of `document`.
pub(super) fn insert(document: &mut Value, files: &[&str]) {
    let parse = |file: &&str| serde_json::from_str(file).unwrap_or_else(|error| unreachable!("an embedded file is not JSON: {error}"));
    let files: Vec<Map<String, Value>> = files.iter().map(parse).collect();
    let examples_of = |operation: &str| files.iter().find_map(|file| file.get(operation));
    let operations = document["paths"].as_object_mut().into_iter().flat_map(|paths| paths.values_mut());
    for operation in operations.filter_map(Value::as_object_mut).flat_map(|path| path.values_mut()) {
        let id = operation["operationId"].as_str().unwrap_or_default().to_owned();
        if let Some(refused) = examples_of(&id).and_then(|examples| examples["refused"].as_object()) {
            operation["responses"]["422"]["content"]["application/problem+json"]["examples"] = refusals(refused);
        }
        // The example of a query is that of the operation with the same members in JSON.
        if let Some(examples) = examples_of(id.strip_suffix("_query").unwrap_or(&id)) {
            insert_accepted(operation, &examples["request"], &examples["answer"]);
        }
    }
}

/// Adds a request and its answer to an operation. The request is null if the operation takes none.
fn insert_accepted(operation: &mut Value, request: &Value, answer: &Value) {
    let values = parameters_of(request);
    for parameter in operation.get_mut("parameters").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some((_, value)) = values.iter().find(|(name, _)| parameter["name"] == **name) {
            parameter["example"] = (*value).clone();
        }
    }
    // An operation accepts either JSON or a form.
    let contents = operation.get_mut("requestBody").and_then(|body| body["content"].as_object_mut());
    contents.into_iter().flat_map(|contents| contents.values_mut()).for_each(|content| content["example"] = request.clone());
    operation["responses"]["200"]["content"]["application/json"]["example"] = answer.clone();
}

/// The examples of a response with status 422. Each description states the request.
fn refusals(refused: &Map<String, Value>) -> Value {
    let shown = refused.iter().map(|(name, example)| {
        let request = match &example["request"] {
            Value::String(query) => query.clone(),
            body => body.to_string(),
        };
        let shown = json!({
            "summary": example["summary"],
            "description": format!("The answer to `{request}`"),
            "value": example["problem"],
        });
        (name.clone(), shown)
    });
    shown.collect()
}
