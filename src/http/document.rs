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

/// The example of an operation.
struct Example {
    operation: &'static str,
    /// The body to send; `None` for an operation without a body.
    request: Option<&'static str>,
    answer: &'static str,
}

/// The example of an operation that takes a body, by the operation's id.
macro_rules! example {
    ($operation:literal) => {
        Example {
            operation: $operation,
            request: Some(include_str!(concat!("../../openapi/examples/", $operation, ".request.json"))),
            answer: include_str!(concat!("../../openapi/examples/", $operation, ".answer.json")),
        }
    };
}

const EXAMPLES: [Example; 12] = [
    example!("scallop_height"),
    example!("scallop_height_batch"),
    example!("max_feed"),
    example!("max_feed_batch"),
    example!("step_over"),
    example!("step_over_batch"),
    example!("cutting_parameters"),
    example!("cutting_parameters_batch"),
    example!("critical_slope"),
    example!("cutter_recommendation"),
    example!("cutter_recommendation_upload"),
    Example { operation: "machines", request: None, answer: include_str!("../../openapi/examples/machines.answer.json") },
];

/// The refused requests of an operation, by the operation's id.
macro_rules! refused {
    ($($operation:literal),* $(,)?) => {
        [$(($operation, include_str!(concat!("../../openapi/examples/", $operation, ".refused.json")))),*]
    };
}

/// For each operation, named requests that are refused with status 422, each with the problem that answers it.
const REFUSALS: [(&str, &str); 15] = refused![
    "scallop_height",
    "scallop_height_query",
    "scallop_height_batch",
    "max_feed",
    "max_feed_query",
    "max_feed_batch",
    "step_over",
    "step_over_query",
    "step_over_batch",
    "cutting_parameters",
    "cutting_parameters_query",
    "cutting_parameters_batch",
    "critical_slope",
    "cutter_recommendation",
    "cutter_recommendation_upload",
];

/// The document as JSON, with the examples of its operations.
pub(super) fn with_examples(document: &OpenApi) -> Value {
    let mut document = serde_json::to_value(document).unwrap_or_else(|error| unreachable!("the document can be written: {error}"));
    let operations = document["paths"].as_object_mut().into_iter().flat_map(|paths| paths.values_mut());
    for operation in operations.filter_map(Value::as_object_mut).flat_map(|path| path.values_mut()) {
        let id = operation["operationId"].as_str().unwrap_or_default();
        if let Some((_, examples)) = REFUSALS.iter().find(|(operation, _)| *operation == id) {
            operation["responses"]["422"]["content"]["application/problem+json"]["examples"] = refusals(examples);
        }
        let id = operation["operationId"].as_str().unwrap_or_default();
        // The examples of a query come from the operation with the same members in JSON.
        let (id, is_query) = id.strip_suffix("_query").map_or((id, false), |id| (id, true));
        let Some(example) = EXAMPLES.iter().find(|example| example.operation == id) else { continue };
        if let Some(request) = example.request.filter(|_| is_query) {
            let request = parse(request);
            let values = parameters_of(&request);
            for parameter in operation["parameters"].as_array_mut().into_iter().flatten() {
                if let Some((_, value)) = values.iter().find(|(name, _)| parameter["name"] == **name) {
                    parameter["example"] = (*value).clone();
                }
            }
        } else if let Some(request) = example.request {
            // An operation accepts either JSON or a form.
            let contents = operation["requestBody"]["content"].as_object_mut().into_iter().flat_map(|contents| contents.values_mut());
            contents.for_each(|content| content["example"] = parse(request));
        }
        operation["responses"]["200"]["content"]["application/json"]["example"] = parse(example.answer);
    }
    document
}

/// The examples of a response with status 422 from a file of refused requests. Each description states the request.
fn refusals(file: &str) -> Value {
    let mut examples = parse(file);
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

fn parse(example: &str) -> Value {
    serde_json::from_str(example).unwrap_or_else(|error| unreachable!("an example of the document is not JSON: {error}"))
}
