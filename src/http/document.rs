//! The OpenAPI document: the descriptions of all routes, for each operation the examples of a request, of its answer and of
//! refused requests, and what no single route describes.

use super::problem_schemas;
use super::query::parameters_of;
use super::routes::Routes;
use serde_json::{Map, Value, json};
use utoipa::openapi::{Components, Contact, InfoBuilder, License, OpenApi, OpenApiBuilder, ServerBuilder, Tag};

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

/// The document that describes `routes`.
pub(super) fn of(routes: Routes) -> Value {
    let (document, files) = routes.openapi(outline());
    let mut document = serde_json::to_value(document).unwrap_or_else(|error| unreachable!("the document can be written: {error}"));
    insert_examples(&mut document, &files);
    document
}

/// The document of the service as a whole, to which the routes are added.
fn outline() -> OpenApi {
    let info = InfoBuilder::new()
        .title("scallopd")
        .version(env!("CARGO_PKG_VERSION"))
        .description(Some(env!("CARGO_PKG_DESCRIPTION")))
        .contact(Some(Contact::builder().name(Some("the maintainers of scallopd")).build()))
        .license(Some(License::builder().name("MIT OR Apache-2.0").identifier(Some("MIT OR Apache-2.0")).build()))
        .build();
    let tag = |name: &str, about: &str| Tag::builder().name(name).description(Some(about)).build();
    let components = problem_schemas::schemas().into_iter().fold(Components::builder(), |all, (name, schema)| all.schema(name, schema));
    OpenApiBuilder::new()
        .info(info)
        // No operation needs credentials.
        .security(Some([]))
        .components(Some(components.build()))
        .servers(Some([ServerBuilder::new().url("/").description(Some("this server")).build()]))
        .tags(Some([
            tag("calculations", "scallop height, largest feed, largest step-over and fastest cutting parameters at contacts"),
            tag("planning", "which cutter finishes a surface soonest, in which direction, with which step-over and feed"),
            tag("service", "probes, metrics and documentation"),
        ]))
        .build()
}

/// Embeds an endpoint's file from `openapi/examples/`. It maps the id of each operation to an object with the members
/// `request`, `answer` and `refused`, of which each may be absent.
macro_rules! examples {
    ($endpoint:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/openapi/examples/", $endpoint, ".json"))
    };
}
pub(crate) use examples;

/// Adds the examples in `files` to the operations of `document`.
fn insert_examples(document: &mut Value, files: &[&str]) {
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
