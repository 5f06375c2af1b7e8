//! Named members of requests and the kinds of their values. One declaration defines both the reader and the schema.

use super::{Components, Faulted, Faults};
use crate::json_text::{JsonPath, JsonText};
use utoipa::openapi::{RefOr, Schema};

/// A named member of a request.
pub(crate) struct Member<K> {
    /// The name on the wire, with its unit.
    pub(crate) name: &'static str,
    /// The description, for the OpenAPI document and the fault of a missing member.
    pub(crate) about: &'static str,
    /// The kind of its values.
    pub(crate) kind: K,
}

impl<K> Member<K> {
    pub(crate) const fn new(name: &'static str, about: &'static str, kind: K) -> Self {
        Self { name, about, kind }
    }
}

/// A kind of value.
pub(crate) trait Kind {
    /// The checked value.
    type Value;

    /// Reads the value and records every fault.
    fn read(&self, raw: JsonText<'_>, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted>;

    /// The schema, with `about` as the description; schemas that it refers to are added to `components`.
    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema>;
}
