//! The OpenAPI document: the descriptions of all routes, with an example for each request and answer.

use super::problem;
use super::query::parameters_of;
use serde_json::{Value, json};
use utoipa::openapi::{Components, InfoBuilder, License, OpenApi, OpenApiBuilder, ServerBuilder, Tag};

/// Declares a type that represents a request or an answer in the document; `$describe` returns its schema.
macro_rules! described {
    ($name:ident, $describe:expr) => {
        pub(crate) struct $name;

        impl utoipa::PartialSchema for $name {
            fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::Schema> {
                $describe(&mut $crate::http::reading::Components::default())
            }
        }

        impl utoipa::ToSchema for $name {
            fn schemas(schemas: &mut Vec<(String, utoipa::openapi::RefOr<utoipa::openapi::Schema>)>) {
                let mut components = $crate::http::reading::Components::default();
                let _ = $describe(&mut components);
                schemas.extend(components.into_named());
            }
        }
    };
}
pub(crate) use described;

/// The document of the service as a whole, to which the routes are added.
pub(super) fn outline() -> OpenApi {
    let info = InfoBuilder::new()
        .title("scallopd")
        .version(env!("CARGO_PKG_VERSION"))
        .description(Some(env!("CARGO_PKG_DESCRIPTION")))
        .license(Some(License::builder().name("MIT OR Apache-2.0").identifier(Some("MIT OR Apache-2.0")).build()))
        .build();
    let tag = |name: &str, about: &str| Tag::builder().name(name).description(Some(about)).build();
    let components = problem::schemas().into_iter().fold(Components::builder(), |all, (name, schema)| all.schema(name, schema));
    OpenApiBuilder::new()
        .info(info)
        .components(Some(components.build()))
        .servers(Some([ServerBuilder::new().url("/").description(Some("this server")).build()]))
        .tags(Some([
            tag("calculations", "scallop height, largest feed, largest step-over and fastest cutting parameters at contacts"),
            tag("planning", "which cutter finishes a surface soonest, in which direction, with which step-over and feed"),
            tag("service", "probes, metrics and documentation"),
        ]))
        .build()
}

/// Embeds an example of one kind for each operation, by the operation's id.
macro_rules! examples {
    ($kind:literal: $($operation:literal),+ $(,)?) => {
        &[$(($operation, include_str!(concat!("../../openapi/examples/", $operation, ".", $kind, ".json")))),+]
    };
}

/// The body to send to each operation that takes one.
const REQUESTS: &[(&str, &str)] = examples! {
    "request": "scallop_height", "scallop_height_batch", "max_feed", "max_feed_batch", "step_over", "step_over_batch",
    "cutting_parameters", "cutting_parameters_batch", "critical_slope", "cutter_recommendation", "cutter_recommendation_upload",
};

/// The answer of each operation.
const ANSWERS: &[(&str, &str)] = examples! {
    "answer": "scallop_height", "scallop_height_batch", "max_feed", "max_feed_batch", "step_over", "step_over_batch",
    "cutting_parameters", "cutting_parameters_batch", "critical_slope", "cutter_recommendation", "cutter_recommendation_upload", "machines",
};

/// For each operation, named requests that are refused with status 422, each with the problem that answers it.
const REFUSALS: &[(&str, &str)] = examples! {
    "refused": "scallop_height", "scallop_height_query", "scallop_height_batch", "max_feed", "max_feed_query", "max_feed_batch",
    "step_over", "step_over_query", "step_over_batch", "cutting_parameters", "cutting_parameters_query", "cutting_parameters_batch",
    "critical_slope", "cutter_recommendation", "cutter_recommendation_upload",
};

/// The example for an operation.
fn example(of_kind: &[(&str, &str)], operation: &str) -> Option<Value> {
    let (_, example) = of_kind.iter().find(|(id, _)| *id == operation)?;
    Some(serde_json::from_str(example).unwrap_or_else(|error| unreachable!("an example of the document is not JSON: {error}")))
}

/// The document as JSON, with the examples of its operations.
pub(super) fn with_examples(document: &OpenApi) -> Value {
    let mut document = serde_json::to_value(document).unwrap_or_else(|error| unreachable!("the document can be written: {error}"));
    let operations = document["paths"].as_object_mut().into_iter().flat_map(|paths| paths.values_mut());
    for operation in operations.filter_map(Value::as_object_mut).flat_map(|path| path.values_mut()) {
        let id = operation["operationId"].as_str().unwrap_or_default().to_owned();
        if let Some(examples) = example(REFUSALS, &id) {
            operation["responses"]["422"]["content"]["application/problem+json"]["examples"] = refusals(examples);
        }
        // The examples of a query come from the operation with the same members in JSON.
        let id = id.strip_suffix("_query").unwrap_or(&id);
        let Some(answer) = example(ANSWERS, id) else { continue };
        if let Some(request) = example(REQUESTS, id) {
            let values = parameters_of(&request);
            for parameter in operation.get_mut("parameters").and_then(Value::as_array_mut).into_iter().flatten() {
                if let Some((_, value)) = values.iter().find(|(name, _)| parameter["name"] == **name) {
                    parameter["example"] = (*value).clone();
                }
            }
            // An operation accepts either JSON or a form.
            let contents = operation.get_mut("requestBody").and_then(|body| body["content"].as_object_mut());
            contents.into_iter().flat_map(|contents| contents.values_mut()).for_each(|content| content["example"] = request.clone());
        }
        operation["responses"]["200"]["content"]["application/json"]["example"] = answer;
    }
    document
}

/// The examples of a response with status 422 from refused requests. Each description states the request.
fn refusals(mut examples: Value) -> Value {
    for example in examples.as_object_mut().into_iter().flat_map(|examples| examples.values_mut()) {
        let request = match &example["request"] {
            Value::String(query) => query.clone(),
            body => body.to_string(),
        };
        *example = json!({
            "summary": example["summary"],
            "description": format!("The answer to `{request}`"),
            "value": example["problem"],
        });
    }
    examples
}
