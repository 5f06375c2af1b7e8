//! Named schemas, to which other schemas refer.

use utoipa::ToSchema;
use utoipa::openapi::schema::RefBuilder;
use utoipa::openapi::{RefOr, Schema};

/// Named schemas. A schema is added at the first reference to it.
#[derive(Default)]
pub(crate) struct Components(Vec<(String, RefOr<Schema>)>);

impl Components {
    /// A reference to the schema `name`, which `build` builds. `about` is the description at the reference.
    pub(crate) fn refer(&mut self, name: &str, about: &str, build: impl FnOnce(&mut Self) -> RefOr<Schema>) -> RefOr<Schema> {
        if !self.0.iter().any(|(known, _)| known == name) {
            let schema = build(self);
            self.0.push((name.to_owned(), schema));
        }
        RefBuilder::new().ref_location_from_schema_name(name).description(description(about)).build().into()
    }

    /// A reference to the schema of a type that derives it.
    pub(crate) fn refer_type<T: ToSchema>(&mut self) -> RefOr<Schema> {
        let name = T::name();
        self.refer(&name, "", |components| {
            T::schemas(&mut components.0);
            T::schema()
        })
    }

    pub(crate) fn into_named(self) -> Vec<(String, RefOr<Schema>)> {
        self.0
    }
}

/// `about` as a description, which is left out if it is empty.
pub(super) fn description(about: &str) -> Option<&str> {
    (!about.is_empty()).then_some(about)
}
