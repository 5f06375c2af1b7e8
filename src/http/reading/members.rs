//! Named members of requests and the kinds of their values, and the macro `members!`, which declares the members of an object. One declaration
//! defines both the reader and the schema.

use super::{Components, Faulted, Faults, JsonPath, Object, ObjectSchema};
use crate::http::codes::RequestFault;
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

impl Object<'_, '_> {
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

impl ObjectSchema<'_> {
    /// Adds the members `M`.
    pub(crate) fn with<M: Members>(self) -> Self {
        M::describe(self)
    }

    /// Adds the members `M`, none of them required: one form of several.
    pub(crate) fn with_form<M: Members>(self) -> Self {
        M::DECLARED.iter().fold(self, |schema, declared| schema.member(declared.member, false))
    }
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
