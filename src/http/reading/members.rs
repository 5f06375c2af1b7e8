//! The macro `members!`, which declares the members of an object and generates its reader, its schema and the fast path
//! of batches.

use super::{Faulted, Faults, Object, ObjectSchema};
use crate::http::codes::RequestFault;

/// The members of an object. Each field is the value, or the proof that its fault is recorded.
pub(crate) trait Members: Sized {
    /// The names on the wire.
    const NAMES: &'static [&'static str];

    /// Reads the members from `object`, which may have others.
    fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Self;

    /// Reads the members that are present, to record their faults.
    fn check(object: &mut Object<'_, '_>, faults: &mut Faults);

    /// Adds the members to a schema.
    fn describe(schema: ObjectSchema<'_>) -> ObjectSchema<'_>;

    /// Adds the members to a schema in which they are one of several forms, so that none is required.
    fn describe_form(schema: ObjectSchema<'_>) -> ObjectSchema<'_>;
}

/// An object in one of two forms.
pub(crate) enum Form<A, B> {
    First(A),
    Second(B),
}

impl Object<'_, '_> {
    /// Whether one of the members `M` is present and not taken yet.
    pub(crate) fn has_any_of<M: Members>(&self) -> bool {
        M::NAMES.iter().any(|name| self.has(name))
    }

    /// Reads the members of one of two forms of an object. `forms` is the text of the fault if none or both are
    /// present.
    pub(crate) fn one_of<A: Members, B: Members>(&mut self, forms: &str, faults: &mut Faults) -> Result<Form<A, B>, Faulted> {
        match (self.has_any_of::<A>(), self.has_any_of::<B>()) {
            (true, false) => Ok(Form::First(A::read(self, faults))),
            (false, true) => Ok(Form::Second(B::read(self, faults))),
            (true, true) => {
                // Both forms are read, so that all their faults are listed.
                A::check(self, faults);
                B::check(self, faults);
                Err(faults.add(&self.path(), RequestFault::ConflictingFields, format_args!("{forms}, not both")))
            }
            (false, false) => {
                // Faults of unknown members list both forms.
                self.known.extend(A::NAMES.iter().chain(B::NAMES));
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
        M::describe_form(self)
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
/// - `struct Name for Object ("Schema", "description") -> Value` also declares the kind of an object with these members.
///   `Name::build` makes its value of them; all members of this kind share its schema.
/// - `plain struct Name / Slots` also declares the values in one pass, for members of contacts in batches.
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
            use $crate::http::reading::{Faults, Members, Object, ObjectSchema};

            impl Members for $name {
                const NAMES: &'static [&'static str] = &[$( $member.name ),*];

                #[allow(unused_variables, reason = "a struct may have no members")]
                fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Self {
                    Self { $( $field: object.$presence(&$member, faults), )* }
                }

                #[allow(unused_variables, reason = "a struct may have no members")]
                fn check(object: &mut Object<'_, '_>, faults: &mut Faults) {
                    $( let _ = object.optional(&$member, faults); )*
                }

                fn describe(schema: ObjectSchema<'_>) -> ObjectSchema<'_> {
                    schema$( .$presence(&$member) )*
                }

                fn describe_form(schema: ObjectSchema<'_>) -> ObjectSchema<'_> {
                    schema$( .optional(&$member) )*
                }
            }
        };

        $(
            #[doc = $about_object]
            $vis struct $object;

            const _: () = {
                use $crate::http::reading::{Components, Faulted, Faults, Kind, Members, Object};
                use $crate::json_text::{JsonPath, JsonText};

                impl Kind for $object {
                    type Value = $value;

                    fn read(&self, raw: JsonText<'_>, path: JsonPath<'_>, faults: &mut Faults) -> Result<$value, Faulted> {
                        Object::open(raw, path, faults)?.read(faults, |object, faults| $name::read(object, faults).build(&path, faults))
                    }

                    fn schema(&self, about: &str, components: &mut Components) -> utoipa::openapi::RefOr<utoipa::openapi::Schema> {
                        components.refer_object($schema, about, $about_object, &$name::describe)
                    }
                }
            };
        )?
    };
    ($(#[$doc:meta])* $vis:vis plain struct $name:ident / $slots:ident {
        $( $field:ident: $presence:ident $member:ident: $kind:ty $(= ($wire:literal, $of_kind:expr, $about:literal))?, )+
    }) => {
        $crate::http::reading::members! {
            $(#[$doc])* $vis struct $name { $( $field: $presence $member: $kind $(= ($wire, $of_kind, $about))?, )+ }
        }

        #[doc = concat!("The values of [`", stringify!($name), "`] in one pass.")]
        #[derive(Debug, Clone, Copy, Default, PartialEq)]
        $vis struct $slots {
            $( $field: Option<<$kind as $crate::http::reading::PlainKind>::Plain>, )+
        }

        const _: () = {
            use $crate::http::reading::{CellValue, KnownColumns, ObjectSchema, ValueSource, PlainKind, Slots};
            use $crate::json_text::Unusual;

            impl $slots {
                /// The members; `None` if a required one is missing or a value is out of bounds.
                $vis fn accept(self) -> Option<$name> {
                    Some($name { $( $field: $crate::http::reading::members!(@accept $presence $member self.$field), )+ })
                }
            }

            impl Slots for $slots {
                #[inline]
                fn fill(&mut self, name: &str, source: &mut impl ValueSource) -> Result<bool, Unusual> {
                    $(
                        if name == $member.name {
                            let value = source.value()?;
                            let is_repeated = value.is_some() && self.$field.is_some();
                            self.$field = value.or(self.$field);
                            return if is_repeated { Err(Unusual) } else { Ok(true) };
                        }
                    )+
                    Ok(false)
                }

                fn columns() -> KnownColumns {
                    vec![$( ($member.name, <$kind as PlainKind>::Plain::column_kind()) ),+]
                }

                fn describe_columns(schema: ObjectSchema<'_>, most: usize) -> ObjectSchema<'_> {
                    schema$( .column(&$member, most) )+
                }
            }
        };
    };
    (@value required $kind:ty) => { <$kind as $crate::http::reading::Kind>::Value };
    (@value optional $kind:ty) => { Option<<$kind as $crate::http::reading::Kind>::Value> };
    (@accept required $member:ident $slot:expr) => {
        Ok($crate::http::reading::PlainKind::accept(&$member.kind, $slot?)?)
    };
    (@accept optional $member:ident $slot:expr) => {
        Ok(match $slot {
            Some(plain) => Some($crate::http::reading::PlainKind::accept(&$member.kind, plain)?),
            None => None,
        })
    };
}
pub(crate) use members;
