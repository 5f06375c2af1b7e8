//! The macro `members!`, which declares the members of an object and generates its reader, its schema and the fast path
//! of batches.

use super::{Faults, JsonPath, Object, ObjectSchema, PlainColumns, PlainJson, RowText, Rows, Unusual};

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

/// Members of a contact in a batch, which are read in one pass as long as there is no fault.
pub(crate) trait PlainMembers: Members {
    /// The values of the members, each `None` until it is read.
    type Slots: Default + Copy;
    /// A column of values for each member.
    type Columns: Default;

    /// Reads the value of `name` into its slot. Returns false if no member has this name, and an error for a value of
    /// another type or a repeated name.
    fn fill(slots: &mut Self::Slots, name: &str, json: &mut PlainJson<'_>) -> Result<bool, Unusual>;

    /// Whether no slot is filled.
    fn are_absent(slots: &Self::Slots) -> bool;

    /// The members; `None` if a required one is missing or a value is out of bounds.
    fn accept(slots: Self::Slots) -> Option<Self>;

    /// Reads columns of at most `most` rows from `object`, which may have other members.
    fn read_columns(object: &mut Object<'_, '_>, most: usize, faults: &mut Faults) -> Self::Columns;

    /// Whether there are no columns.
    fn columns_are_absent(columns: &Self::Columns) -> bool;

    /// Takes columns of at most `most` rows from `columns`, which may have others; `None` if one is unusual.
    fn read_plain_columns(columns: &mut PlainColumns<'_>, most: usize) -> Option<Self::Columns>;

    /// Adds columns of at most `most` rows to a schema; none is required.
    fn describe_columns(schema: ObjectSchema<'_>, most: usize) -> ObjectSchema<'_>;

    /// Compares the number of rows of all columns of the object at `path`.
    fn check_rows(columns: &Self::Columns, path: &JsonPath<'_>, rows: &mut Rows, faults: &mut Faults);

    /// The values of a row; `None` if one is of another type.
    fn row(columns: &Self::Columns, index: usize) -> Option<Self::Slots>;

    /// Writes a row as members of an object.
    fn write_row(columns: &Self::Columns, index: usize, row: &mut RowText);
}

/// An object in one of two forms.
pub(crate) enum Form<A, B> {
    First(A),
    Second(B),
}

/// Declares members and their struct:
/// `members! { struct Name { field: required MEMBER: Kind = ("name", kind, "what it is"), ... } }`, with
/// `plain struct Name / Slots / Columns` for members of contacts in batches. A member that several structs share is
/// declared in one of them.
macro_rules! members {
    ($(#[$doc:meta])* $vis:vis struct $name:ident {
        $( $field:ident: $presence:ident $member:ident: $kind:ty $(= ($wire:literal, $of_kind:expr, $about:literal))?, )*
    }) => {
        $($(
            $vis const $member: $crate::http::reading::Member<$kind> =
                $crate::http::reading::Member { name: $wire, about: $about, kind: $of_kind };
        )?)*

        $(#[$doc])*
        #[derive(Debug)]
        $vis struct $name {
            $( $vis $field: Result<$crate::http::reading::members!(@value $presence $kind), $crate::http::reading::Faulted>, )*
        }

        impl $crate::http::reading::Members for $name {
            const NAMES: &'static [&'static str] = &[$( $member.name ),*];

            #[allow(unused_variables, reason = "a struct may have no members")]
            fn read(object: &mut $crate::http::reading::Object<'_, '_>, faults: &mut $crate::http::reading::Faults) -> Self {
                Self { $( $field: object.$presence(&$member, faults), )* }
            }

            #[allow(unused_variables, reason = "a struct may have no members")]
            fn check(object: &mut $crate::http::reading::Object<'_, '_>, faults: &mut $crate::http::reading::Faults) {
                $( let _ = object.optional(&$member, faults); )*
            }

            fn describe(schema: $crate::http::reading::ObjectSchema<'_>) -> $crate::http::reading::ObjectSchema<'_> {
                schema$( .$presence(&$member) )*
            }

            fn describe_form(schema: $crate::http::reading::ObjectSchema<'_>) -> $crate::http::reading::ObjectSchema<'_> {
                schema$( .optional(&$member) )*
            }
        }
    };
    ($(#[$doc:meta])* $vis:vis plain struct $name:ident / $slots:ident / $columns:ident {
        $( $field:ident: $presence:ident $member:ident: $kind:ty $(= ($wire:literal, $of_kind:expr, $about:literal))?, )+
    }) => {
        $crate::http::reading::members! {
            $(#[$doc])* $vis struct $name { $( $field: $presence $member: $kind $(= ($wire, $of_kind, $about))?, )+ }
        }

        #[doc = concat!("The values of [`", stringify!($name), "`] in one pass.")]
        #[derive(Debug, Clone, Copy, Default)]
        $vis struct $slots {
            $( $field: Option<<$kind as $crate::http::reading::PlainKind>::Plain>, )+
        }

        #[doc = concat!("Columns of the values of [`", stringify!($name), "`].")]
        #[derive(Debug, Default)]
        $vis struct $columns {
            $( $field: Option<<$kind as $crate::http::reading::PlainKind>::Column>, )+
        }

        impl $crate::http::reading::PlainMembers for $name {
            type Slots = $slots;
            type Columns = $columns;

            #[inline]
            fn fill(
                slots: &mut $slots,
                name: &str,
                json: &mut $crate::http::reading::PlainJson<'_>,
            ) -> Result<bool, $crate::http::reading::Unusual> {
                $(
                    if name == $member.name {
                        let earlier = slots.$field.replace($crate::http::reading::PlainValue::read(json)?);
                        return if earlier.is_none() { Ok(true) } else { Err($crate::http::reading::Unusual) };
                    }
                )+
                Ok(false)
            }

            fn are_absent(slots: &$slots) -> bool {
                $( slots.$field.is_none() )&&+
            }

            fn accept(slots: $slots) -> Option<Self> {
                Some(Self { $( $field: $crate::http::reading::members!(@accept $presence $member slots.$field), )+ })
            }

            fn read_columns(
                object: &mut $crate::http::reading::Object<'_, '_>,
                most: usize,
                faults: &mut $crate::http::reading::Faults,
            ) -> $columns {
                $columns { $( $field: object.column($member.name, most, faults), )+ }
            }

            fn columns_are_absent(columns: &$columns) -> bool {
                $( columns.$field.is_none() )&&+
            }

            fn read_plain_columns(columns: &mut $crate::http::reading::PlainColumns<'_>, most: usize) -> Option<$columns> {
                Some($columns {
                    $( $field: match columns.take($member.name) {
                        Some(items) => Some($crate::http::reading::PlainColumn::read_plain(items, most)?),
                        None => None,
                    }, )+
                })
            }

            fn describe_columns(schema: $crate::http::reading::ObjectSchema<'_>, most: usize) -> $crate::http::reading::ObjectSchema<'_> {
                schema$( .column(&$member, most) )+
            }

            fn check_rows(
                columns: &$columns,
                path: &$crate::http::reading::JsonPath<'_>,
                rows: &mut $crate::http::reading::Rows,
                faults: &mut $crate::http::reading::Faults,
            ) {
                $(
                    if let Some(column) = &columns.$field {
                        $crate::http::reading::PlainColumn::check_rows(column, $member.name, path.member($member.name), rows, faults);
                    }
                )+
            }

            fn row(columns: &$columns, index: usize) -> Option<$slots> {
                Some($slots {
                    $( $field: match columns.$field.as_ref().map(|column| $crate::http::reading::PlainColumn::get(column, index)) {
                        Some($crate::http::reading::Cell::Value(value)) => Some(value),
                        Some($crate::http::reading::Cell::Absent) | None => None,
                        Some($crate::http::reading::Cell::Faulty) => return None,
                    }, )+
                })
            }

            fn write_row(columns: &$columns, index: usize, row: &mut $crate::http::reading::RowText) {
                $(
                    if let Some(column) = &columns.$field {
                        $crate::http::reading::PlainColumn::write(column, index, $member.name, row);
                    }
                )+
            }
        }
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
