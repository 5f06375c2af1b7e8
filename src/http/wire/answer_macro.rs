//! The macro `answer!`, which declares the objects of answers: each member in one row, with its presence, its type, the
//! bounds for its schema and its value.

/// Declares objects of an answer: `answer! { struct Name of (source: &Source) { member: Type [bounds] = value, ... } }`.
/// A member with a question mark, `member?: Type`, is absent if it has no value; its field is an `Option`. The bounds
/// are those of utoipa's attribute `schema`. `Name::of` takes the members' values from its arguments; an object that is
/// made in several ways states neither `of` nor values.
macro_rules! answer {
    ($( $(#[$meta:meta])* $vis:vis struct $name:ident $(of ($($source:ident: $of:ty),+))? { $($members:tt)+ } )+) => {
        $( $crate::http::wire::answer! {
            @members [$(#[$meta])* $vis struct $name] [$($vis $name ($($source: $of),+))?] {} {} $($members)+
        } )+
    };
    (@members $head:tt $of:tt { $($fields:tt)* } { $($values:tt)* }
        $(#[$meta:meta])* $vis:vis $member:ident?: $kind:ty $([$($bounds:tt)+])? $(= $value:expr)?, $($others:tt)*) => {
        $crate::http::wire::answer! { @members $head $of {
            $($fields)*
            $(#[$meta])*
            #[serde(skip_serializing_if = "Option::is_none")]
            #[schema(nullable = false $(, $($bounds)+)?)]
            $vis $member: Option<$kind>,
        } { $($values)* $($member: $value,)? } $($others)* }
    };
    (@members $head:tt $of:tt { $($fields:tt)* } { $($values:tt)* }
        $(#[$meta:meta])* $vis:vis $member:ident: $kind:ty $([$($bounds:tt)+])? $(= $value:expr)?, $($others:tt)*) => {
        $crate::http::wire::answer! { @members $head $of {
            $($fields)*
            $(#[$meta])*
            $(#[schema($($bounds)+)])?
            $vis $member: $kind,
        } { $($values)* $($member: $value,)? } $($others)* }
    };
    (@members [$($head:tt)+] [] $fields:tt {}) => {
        #[derive(Debug, serde::Serialize, utoipa::ToSchema)]
        $($head)+ $fields
    };
    (@members $head:tt [$vis:vis $name:ident ($($source:ident: $of:ty),+)] $fields:tt $values:tt) => {
        $crate::http::wire::answer! { @members $head [] $fields {} }

        impl $name {
            $vis fn of($($source: $of),+) -> Self {
                Self $values
            }
        }
    };
}
pub(crate) use answer;
