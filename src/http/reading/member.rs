//! Named members of requests and the kinds of their values. One declaration defines both the reader and the schema.

use super::{Components, Faulted, Faults, JsonPath};
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, Type};
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
    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted>;

    /// The schema, with `about` as the description; schemas that it refers to are added to `components`.
    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema>;

    /// The members of a kind of object that batches take as an object of columns in place of a column of objects.
    fn columns(&self) -> Option<Vec<&'static dyn AnyMember>> {
        None
    }

    /// The schema of a column of at most `most` values, null where a row has none.
    fn column_schema(&self, about: &str, most: usize, components: &mut Components) -> RefOr<Schema> {
        let null = ObjectBuilder::new().schema_type(Type::Null);
        let item = OneOfBuilder::new().item(self.schema("", components)).item(null);
        ArrayBuilder::new().items(item).max_items(Some(most)).description(Some(about)).into()
    }
}

/// A member of any kind.
pub(crate) trait AnyMember: Sync {
    /// The name on the wire.
    fn name(&self) -> &'static str;

    /// Reads a value that is at `path`, to record its faults.
    fn check(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults);

    /// The schema of its values.
    fn schema(&self, components: &mut Components) -> RefOr<Schema>;

    /// The members of its values, as [`Kind::columns`].
    fn columns(&self) -> Option<Vec<&'static dyn AnyMember>>;

    /// The schema of a column of at most `most` of its values.
    fn column_schema(&self, most: usize, components: &mut Components) -> RefOr<Schema>;
}

impl<K: Kind + Sync> AnyMember for Member<K> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn check(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) {
        let _recorded = self.kind.read(raw, path, faults);
    }

    fn schema(&self, components: &mut Components) -> RefOr<Schema> {
        self.kind.schema(self.about, components)
    }

    fn columns(&self) -> Option<Vec<&'static dyn AnyMember>> {
        self.kind.columns()
    }

    fn column_schema(&self, most: usize, components: &mut Components) -> RefOr<Schema> {
        self.kind.column_schema(self.about, most, components)
    }
}

/// A member as a struct of `members!` declares it.
pub(crate) struct Declared {
    pub(crate) member: &'static dyn AnyMember,
    pub(crate) is_required: bool,
}
