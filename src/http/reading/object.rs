//! Objects in requests: their named members, the kinds of their values, the reader, the schema, and the macro `members!`. One
//! declaration defines both the reader and the schema, and all faults are recorded.

use super::{Faulted, Faults, JsonPath, describe, meant};
use crate::http::codes::RequestFault;
use crate::json::JsonError;
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, Visitor};
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::fmt;
use utoipa::ToSchema;
use utoipa::openapi::schema::{AdditionalProperties, ArrayBuilder, ObjectBuilder, OneOfBuilder, RefBuilder, Type};
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

/// The members of an object. Each field is the value, or the proof that its fault is recorded.
pub(crate) trait Members: Sized {
    /// The members in their order.
    const DECLARED: &'static [Declared];

    /// Reads the members from `object`, which may have others.
    fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Self;

    /// The names on the wire.
    fn names() -> impl Iterator<Item = &'static str> {
        Self::DECLARED.iter().map(|declared| declared.member.name())
    }

    /// Adds the members to a schema.
    fn describe(schema: ObjectSchema<'_>) -> ObjectSchema<'_> {
        schema.with_members(Self::DECLARED)
    }
}

/// An object in one of two forms.
pub(crate) enum Form<A, B> {
    First(A),
    Second(B),
}

/// The value of two members of which at most one may be given; `None` if both are.
pub(crate) fn at_most_one<T>(one: Result<Option<T>, Faulted>, other: Result<Option<T>, Faulted>) -> Option<Result<Option<T>, Faulted>> {
    match (one, other) {
        (Ok(Some(_)) | Err(_), Ok(Some(_)) | Err(_)) => None,
        (one, Ok(None)) => Some(one),
        (Ok(None), other) => Some(other),
    }
}

/// Declares members and their struct:
/// `members! { struct Name { field: required MEMBER: Kind = ("name", kind, "what it is"), ... } }`. A member that several
/// structs share is declared in one of them.
/// `struct Name for Object ("Schema", "description") -> Value` also declares the kind of an object with these members.
/// `Name::build` makes its value of them; all members of this kind share its schema.
macro_rules! members {
    ($(#[$doc:meta])* $vis:vis struct $name:ident $(for $object:ident ($schema:literal, $about_object:literal) -> $value:ty)? {
        $( $field:ident: $presence:ident $member:ident: $kind:ty $(= ($wire:literal, $of_kind:expr, $about:literal))?, )*
    }) => {
        $($(
            $vis const $member: $crate::http::reading::Member<$kind> =
                $crate::http::reading::Member::new($wire, $about, $of_kind);
        )?)*

        $(#[$doc])*
        #[derive(Debug)]
        $vis struct $name {
            $( $vis $field: Result<$crate::http::reading::members!(@value $presence $kind), $crate::http::reading::Faulted>, )*
        }

        const _: () = {
            use $crate::http::reading::{Declared, Faults, Members, Object};

            impl Members for $name {
                const DECLARED: &'static [Declared] = &[$(
                    Declared { member: &$member, is_required: $crate::http::reading::members!(@is_required $presence) },
                )*];

                #[allow(unused_variables, reason = "a struct may have no members")]
                fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Self {
                    object.declare(Self::DECLARED);
                    Self { $( $field: object.$presence(&$member, faults), )* }
                }
            }
        };

        $(
            #[doc = $about_object]
            $vis struct $object;

            const _: () = {
                use $crate::http::reading::{Components, Faulted, Faults, JsonPath, Kind, Members, Object};
                use serde_json::value::RawValue;

                impl Kind for $object {
                    type Value = $value;

                    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<$value, Faulted> {
                        Object::open(raw, path, faults)?.read(faults, |object, faults| $name::read(object, faults).build(&path, faults))
                    }

                    fn schema(&self, about: &str, components: &mut Components) -> utoipa::openapi::RefOr<utoipa::openapi::Schema> {
                        components.refer_object($schema, about, $about_object, &$name::describe)
                    }
                }
            };
        )?
    };
    (@value required $kind:ty) => { <$kind as $crate::http::reading::Kind>::Value };
    (@value optional $kind:ty) => { Option<<$kind as $crate::http::reading::Kind>::Value> };
    (@is_required required) => { true };
    (@is_required optional) => { false };
}
pub(crate) use members;

/// A JSON object whose members are taken one by one. The members left at the end are unknown fields.
pub(crate) struct Object<'a, 'p> {
    path: JsonPath<'p>,
    members: Vec<(Cow<'a, str>, &'a RawValue)>,
    unkept: usize,
    pub(super) known: Vec<&'static str>,
    declared: Vec<&'static [Declared]>,
}

impl<'a, 'p> Object<'a, 'p> {
    /// Opens `raw`, which is at `path`, as an object.
    pub(crate) fn open(raw: &'a RawValue, path: JsonPath<'p>, faults: &mut Faults) -> Result<Self, Faulted> {
        match raw.deserialize_map(MembersVisitor) {
            Ok(RawMembers { kept, unkept }) => Ok(Self { unkept, ..Self::of_members(kept, path) }),
            // The syntax has been checked, so a name is not valid text.
            Err(error) if raw.get().starts_with('{') => Err(faults.add(&path, RequestFault::Unreadable, JsonError::from(&error))),
            Err(_) => Err(faults.add(&path, RequestFault::WrongType, format_args!("expected an object, found {}", describe(raw)))),
        }
    }

    /// Opens a whole body as an object. The outer error means that the body is not JSON.
    pub(crate) fn open_body(json: &'a [u8], faults: &mut Faults) -> Result<Result<Self, Faulted>, JsonError> {
        // Reading the members checks the syntax of the whole body.
        if let Ok(RawMembers { kept, unkept }) = serde_json::from_slice(json) {
            return Ok(Ok(Self { unkept, ..Self::of_members(kept, JsonPath::Root) }));
        }
        let raw: &RawValue = serde_json::from_slice(json).map_err(|error| JsonError::from(&error))?;
        Ok(Self::open(raw, JsonPath::Root, faults))
    }

    /// The object of these members.
    pub(super) fn of_members(members: Vec<(Cow<'a, str>, &'a RawValue)>, path: JsonPath<'p>) -> Self {
        Self { path, members, unkept: 0, known: Vec::with_capacity(12), declared: Vec::new() }
    }

    /// The path to the object.
    pub(crate) fn path(&self) -> JsonPath<'p> {
        self.path
    }

    /// Keeps the members of the request's outer objects, for the faults of misplaced ones.
    pub(crate) fn declare(&mut self, members: &'static [Declared]) {
        if self.path.is_outer() {
            self.declared.push(members);
        }
    }

    /// Whether a member is present and not taken yet.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.members.iter().any(|(key, _)| key == name)
    }

    /// Takes the member `name` unparsed. A repeated name is a fault.
    pub(crate) fn take(&mut self, name: &'static str, faults: &mut Faults) -> Option<&'a RawValue> {
        self.known.push(name);
        let found = self.members.iter().position(|(key, _)| key == name).map(|index| self.members.remove(index).1);
        while let Some(again) = self.members.iter().position(|(key, _)| key == name) {
            self.members.remove(again);
            faults.add(&self.path.member(name), RequestFault::RepeatedField, "the field is given more than once");
        }
        found
    }

    /// All members, of an object whose names are free.
    pub(crate) fn into_members(self, faults: &mut Faults) -> Result<Vec<(Cow<'a, str>, &'a RawValue)>, Faulted> {
        if self.unkept > 0 {
            let detail = format_args!("at most {MOST_MEMBERS} fields, found {}", self.members.len() + self.unkept);
            return Err(faults.add(&self.path, RequestFault::TooManyFields, detail));
        }
        Ok(self.members)
    }

    /// Takes a required member unparsed.
    pub(crate) fn required_raw<K>(&mut self, member: &Member<K>, faults: &mut Faults) -> Result<&'a RawValue, Faulted> {
        self.take(member.name, faults).ok_or_else(|| {
            let detail = format_args!("the field is missing: {}", member.about);
            faults.add(&self.path.member(member.name), RequestFault::MissingField, detail)
        })
    }

    /// Takes a required member.
    pub(crate) fn required<K: Kind>(&mut self, member: &Member<K>, faults: &mut Faults) -> Result<K::Value, Faulted> {
        let raw = self.required_raw(member, faults)?;
        member.kind.read(raw, self.path.member(member.name), faults)
    }

    /// Takes a member that may be absent.
    pub(crate) fn optional<K: Kind>(&mut self, member: &Member<K>, faults: &mut Faults) -> Result<Option<K::Value>, Faulted> {
        let Some(raw) = self.take(member.name, faults) else {
            return Ok(None);
        };
        member.kind.read(raw, self.path.member(member.name), faults).map(Some)
    }

    /// Takes a member to record its faults.
    pub(crate) fn check(&mut self, member: &dyn AnyMember, faults: &mut Faults) {
        if let Some(raw) = self.take(member.name(), faults) {
            member.check(raw, self.path.member(member.name()), faults);
        }
    }

    /// Reads the whole object with `read`; members that `read` does not take are faults.
    pub(crate) fn read<T>(
        mut self,
        faults: &mut Faults,
        read: impl FnOnce(&mut Self, &mut Faults) -> Result<T, Faulted>,
    ) -> Result<T, Faulted> {
        let result = read(&mut self, faults);
        self.close(faults)?;
        result
    }

    /// Ends the reading: members that were not taken are unknown.
    pub(crate) fn close(self, faults: &mut Faults) -> Result<(), Faulted> {
        let mut result = Ok(());
        if self.unkept > 0 {
            let detail = format!("the object has {} fields more than the {} that are read", self.unkept, MOST_MEMBERS);
            result = Err(faults.add(&self.path, RequestFault::TooManyFields, detail));
        }
        let known = if self.members.is_empty() { String::new() } else { self.known.join(", ") };
        for (index, (name, _)) in self.members.iter().enumerate() {
            let path = self.path.member(name);
            result = Err(match meant(name, self.known.iter().copied()) {
                Some(meant) => faults.add(&path, RequestFault::UnknownField, format_args!("unknown field; did you mean {meant}?")),
                None if index < MOST_WITH_KNOWN => {
                    faults.add(&path, RequestFault::UnknownField, format_args!("unknown field; known here: {known}"))
                }
                None => faults.add(&path, RequestFault::UnknownField, "unknown field"),
            });
        }
        if result.is_err() {
            // A misplaced member may belong in an object that is not there. Reading an empty one records the names that it may have.
            for member in self.declared.into_iter().flatten().map(|declared| declared.member) {
                let path = self.path.member(member.name());
                if !faults.knows_object(&path) {
                    let mut of_empty = Faults::default();
                    member.check(serde_json::from_str("{}").unwrap_or(RawValue::NULL), path, &mut of_empty);
                    faults.take_in_objects(of_empty);
                }
            }
        }
        faults.object_knows(&self.path, self.known);
        result
    }

    /// Whether one of the members `M` is present and not taken yet.
    pub(crate) fn has_any_of<M: Members>(&self) -> bool {
        M::names().any(|name| self.has(name))
    }

    /// Reads the members of one of two forms of an object. `forms` is the text of the fault if none or both are
    /// present.
    pub(crate) fn one_of<A: Members, B: Members>(&mut self, forms: &str, faults: &mut Faults) -> Result<Form<A, B>, Faulted> {
        match (self.has_any_of::<A>(), self.has_any_of::<B>()) {
            (true, false) => Ok(Form::First(A::read(self, faults))),
            (false, true) => Ok(Form::Second(B::read(self, faults))),
            (true, true) => {
                // Both forms are read, so that all their faults are listed.
                A::DECLARED.iter().chain(B::DECLARED).for_each(|declared| self.check(declared.member, faults));
                Err(faults.add(&self.path(), RequestFault::ConflictingFields, format_args!("{forms}, not both")))
            }
            (false, false) => {
                // Faults of unknown members list both forms.
                self.known.extend(A::names().chain(B::names()));
                Err(faults.add(&self.path(), RequestFault::MissingField, forms))
            }
        }
    }
}

/// The members of an object in the order sent, each with its name and its unparsed value.
struct RawMembers<'a> {
    /// The first members.
    kept: Vec<(Cow<'a, str>, &'a RawValue)>,
    /// The number of members beyond those that are kept.
    unkept: usize,
}

impl<'de> Deserialize<'de> for RawMembers<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(MembersVisitor)
    }
}

struct MembersVisitor;

impl<'de> Visitor<'de> for MembersVisitor {
    type Value = RawMembers<'de>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RawMembers<'de>, A::Error> {
        /// A name, borrowed unless it is written with escapes.
        #[derive(Deserialize)]
        struct Name<'a>(#[serde(borrow)] Cow<'a, str>);

        let mut members = RawMembers { kept: Vec::with_capacity(8), unkept: 0 };
        while members.kept.len() < MOST_MEMBERS {
            let Some((Name(name), value)) = map.next_entry()? else { return Ok(members) };
            members.kept.push((name, value));
        }
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {
            members.unkept += 1;
        }
        Ok(members)
    }
}

/// The largest number of members stored, more than ten times that of any object. Further ones are counted, so that the
/// memory of a body does not exceed its length.
const MOST_MEMBERS: usize = 256;

/// The largest number of unknown members of an object whose faults list the known members. The limit keeps an answer
/// from being much longer than its request.
const MOST_WITH_KNOWN: usize = 4;

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

    /// Adds the members `M`.
    pub(crate) fn with<M: Members>(self) -> Self {
        M::describe(self)
    }

    /// Adds the members `M`, none of them required: one form of several.
    pub(crate) fn with_form<M: Members>(self) -> Self {
        M::DECLARED.iter().fold(self, |schema, declared| schema.member(declared.member, false))
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

/// `about` as a description, which is left out if it is empty.
pub(super) fn description(about: &str) -> Option<&str> {
    (!about.is_empty()).then_some(about)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_beyond_the_limit_are_counted_not_kept() {
        let body = format!("{{{}}}", (0..1000).map(|index| format!("\"m{index}\":{index}")).collect::<Vec<_>>().join(","));
        let raw = serde_json::from_str(&body).unwrap();
        let mut faults = Faults::default();
        let object = Object::open(raw, JsonPath::Root, &mut faults).unwrap();
        assert_eq!(object.members.len(), MOST_MEMBERS);
        assert_eq!(object.close(&mut faults), Err(Faulted));
        let listed = faults.into_listed();
        assert_eq!(listed.len(), 1 + MOST_MEMBERS);
        assert!(listed[0].detail.contains("744 fields more"), "{}", listed[0].detail);
    }
}
