//! Schemas of request objects, built from the declarations of their members, and named schemas, to which others refer.

use super::{AnyMember, Declared, Kind, Member};
use utoipa::ToSchema;
use utoipa::openapi::schema::{AdditionalProperties, ObjectBuilder, OneOfBuilder, RefBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

impl Components {
    /// A reference to the schema `name` of an object, described as `about`, with the members that `add` adds. `at` is
    /// the description at the reference.
    pub(crate) fn refer_object(&mut self, name: &str, at: &str, about: &str, add: AddMembers<'_>) -> RefOr<Schema> {
        self.refer(name, at, |components| add(ObjectSchema::new(about, components)).build())
    }

    /// The union of objects, each given as name, description and members.
    pub(crate) fn one_of(&mut self, about: &str, forms: &[(&str, &str, AddMembers<'_>)]) -> OneOfBuilder {
        let any = OneOfBuilder::new().description(Some(about));
        forms.iter().fold(any, |any, (name, about, add)| any.item(self.refer_object(name, "", about, add)))
    }
}

/// Adds members to a schema.
pub(crate) type AddMembers<'f> = &'f dyn Fn(ObjectSchema<'_>) -> ObjectSchema<'_>;

/// The schema of an object that allows only its own members.
pub(crate) struct ObjectSchema<'c> {
    builder: ObjectBuilder,
    components: &'c mut Components,
}

impl<'c> ObjectSchema<'c> {
    pub(crate) fn new(about: &str, components: &'c mut Components) -> Self {
        let builder = ObjectBuilder::new().schema_type(Type::Object).description(Some(about));
        Self { builder: builder.additional_properties(Some(AdditionalProperties::FreeForm(false))), components }
    }

    /// Adds a required member.
    pub(crate) fn required<K: Kind + Sync>(self, member: &Member<K>) -> Self {
        self.member(member, true)
    }

    /// Adds a member that may be absent.
    pub(crate) fn optional<K: Kind + Sync>(self, member: &Member<K>) -> Self {
        self.member(member, false)
    }

    /// Adds a member.
    pub(super) fn member(self, member: &dyn AnyMember, is_required: bool) -> Self {
        let schema = member.schema(self.components);
        if is_required { self.required_property(member.name(), schema) } else { self.property(member.name(), schema) }
    }

    /// Adds a member of the schema `schema` that may be absent.
    pub(crate) fn property(self, name: &str, schema: impl Into<RefOr<Schema>>) -> Self {
        Self { builder: self.builder.property(name, schema), components: self.components }
    }

    /// Adds a required member of the schema `schema`.
    pub(crate) fn required_property(self, name: &str, schema: impl Into<RefOr<Schema>>) -> Self {
        let Self { builder, components } = self.property(name, schema);
        Self { builder: builder.required(name), components }
    }

    /// Adds members.
    pub(crate) fn with_members<'m>(self, members: impl IntoIterator<Item = &'m Declared>) -> Self {
        members.into_iter().fold(self, |schema, declared| schema.member(declared.member, declared.is_required))
    }

    /// Adds columns of at most `most` values of members. None is required.
    pub(crate) fn with_columns(self, members: impl IntoIterator<Item = &'static dyn AnyMember>, most: usize) -> Self {
        members.into_iter().fold(self, |schema, member| {
            let column = member.column_schema(most, schema.components);
            schema.property(member.name(), column)
        })
    }

    pub(crate) fn build(self) -> RefOr<Schema> {
        self.builder.into()
    }
}

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
