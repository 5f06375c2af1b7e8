//! The OpenAPI document: what the routes say of themselves, put together, with an example for each request and answer.

use serde_json::Value;
use utoipa::openapi::{InfoBuilder, License, OpenApi, OpenApiBuilder, ServerBuilder, Tag};

/// Declares a type that stands for a request in the document: its schema is the first of `$schemas`, and the others are those it refers to.
macro_rules! described {
    ($name:ident, $schemas:expr) => {
        pub(crate) struct $name;

        impl utoipa::PartialSchema for $name {
            fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::Schema> {
                $schemas.swap_remove(0).1
            }
        }

        impl utoipa::ToSchema for $name {
            fn schemas(schemas: &mut Vec<(String, utoipa::openapi::RefOr<utoipa::openapi::Schema>)>) {
                schemas.extend($schemas.into_iter().skip(1));
            }
        }
    };
}
pub(crate) use described;

/// What the document says of the service as a whole; the routes add themselves.
pub(super) fn outline() -> OpenApi {
    let info = InfoBuilder::new()
        .title("scallopd")
        .version(env!("CARGO_PKG_VERSION"))
        .description(Some(env!("CARGO_PKG_DESCRIPTION")))
        .license(Some(License::builder().name("MIT OR Apache-2.0").identifier(Some("MIT OR Apache-2.0")).build()))
        .build();
    let tag = |name: &str, about: &str| Tag::builder().name(name).description(Some(about)).build();
    OpenApiBuilder::new()
        .info(info)
        .servers(Some([ServerBuilder::new().url("/").description(Some("this server")).build()]))
        .tags(Some([
            tag("calculations", "scallop height, largest feed and largest step-over at contacts"),
            tag("planning", "which cutter in which direction"),
            tag("service", "for operators and for people"),
        ]))
        .build()
}

/// The example of each operation: its id, request and answer.
const EXAMPLES: [(&str, &str, &str); 6] = [
    (
        "scallop_height",
        include_str!("../../openapi/examples/scallop_height.request.json"),
        include_str!("../../openapi/examples/scallop_height.answer.json"),
    ),
    (
        "scallop_height_batch",
        include_str!("../../openapi/examples/scallop_height_batch.request.json"),
        include_str!("../../openapi/examples/scallop_height_batch.answer.json"),
    ),
    ("max_feed", include_str!("../../openapi/examples/max_feed.request.json"), include_str!("../../openapi/examples/max_feed.answer.json")),
    (
        "max_feed_batch",
        include_str!("../../openapi/examples/max_feed_batch.request.json"),
        include_str!("../../openapi/examples/max_feed_batch.answer.json"),
    ),
    (
        "step_over",
        include_str!("../../openapi/examples/step_over.request.json"),
        include_str!("../../openapi/examples/step_over.answer.json"),
    ),
    (
        "step_over_batch",
        include_str!("../../openapi/examples/step_over_batch.request.json"),
        include_str!("../../openapi/examples/step_over_batch.answer.json"),
    ),
];

/// The document as JSON, with the examples of its operations.
pub(super) fn with_examples(document: &OpenApi) -> Value {
    let mut document = serde_json::to_value(document).unwrap_or_else(|error| unreachable!("the document can be written: {error}"));
    let operations = document["paths"].as_object_mut().into_iter().flat_map(|paths| paths.values_mut());
    for operation in operations.filter_map(|path| path.get_mut("post")) {
        let id = operation["operationId"].as_str();
        if let Some((_, request, answer)) = EXAMPLES.iter().find(|(example, ..)| Some(*example) == id) {
            operation["requestBody"]["content"]["application/json"]["example"] = parse(request);
            operation["responses"]["200"]["content"]["application/json"]["example"] = parse(answer);
        }
    }
    document
}

fn parse(example: &str) -> Value {
    serde_json::from_str(example).unwrap_or_else(|error| unreachable!("an example of the document is not JSON: {error}"))
}
