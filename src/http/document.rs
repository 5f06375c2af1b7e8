//! The OpenAPI document: the descriptions of all routes with their examples, and what no single route describes.

use super::routes::Routes;
use super::{examples, problem_schemas};
use serde_json::Value;
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
    examples::insert(&mut document, &files);
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
