//! Schemas of request objects, put together from the members that the readers take.

use super::{Kind, Member};
use utoipa::openapi::schema::{AdditionalProperties, Object, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// The schema of an object that takes its members and no others.
pub(crate) struct ObjectSchema(ObjectBuilder);

impl ObjectSchema {
    pub(crate) fn new(about: &str) -> Self {
        Self(
            ObjectBuilder::new()
                .schema_type(Type::Object)
                .description(Some(about))
                .additional_properties(Some(AdditionalProperties::FreeForm(false))),
        )
    }

    /// With a member that must be there.
    pub(crate) fn required<K: Kind>(self, member: &Member<K>) -> Self {
        Self(self.0.property(member.name, member.kind.schema(member.about)).required(member.name))
    }

    /// With a member that may be absent.
    pub(crate) fn optional<K: Kind>(self, member: &Member<K>) -> Self {
        Self(self.0.property(member.name, member.kind.schema(member.about)))
    }

    pub(crate) fn build(self) -> RefOr<Schema> {
        RefOr::T(Schema::Object(Object::from(self.0)))
    }
}
