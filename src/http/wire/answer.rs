//! The macro `answer!`, which declares the objects of answers: each member in one row, with its presence, its type and
//! the bounds for its schema.

/// Declares objects of an answer: `answer! { struct Name { member: Type [bounds], other?: Type, ... } }`. A member with
/// a question mark is absent if it has no value; its field is an `Option`. The bounds are those of utoipa's attribute
/// `schema`.
macro_rules! answer {
    ($( $(#[$meta:meta])* $vis:vis struct $name:ident { $($members:tt)+ } )+) => {
        $( $crate::http::wire::answer! { @members [$(#[$meta])* $vis struct $name] {} $($members)+ } )+
    };
    (@members $head:tt { $($fields:tt)* }
        $(#[$meta:meta])* $vis:vis $member:ident?: $kind:ty $([$($bounds:tt)+])?, $($others:tt)*) => {
        $crate::http::wire::answer! { @members $head {
            $($fields)*
            $(#[$meta])*
            #[serde(skip_serializing_if = "Option::is_none")]
            #[schema(nullable = false $(, $($bounds)+)?)]
            $vis $member: Option<$kind>,
        } $($others)* }
    };
    (@members $head:tt { $($fields:tt)* }
        $(#[$meta:meta])* $vis:vis $member:ident: $kind:ty $([$($bounds:tt)+])?, $($others:tt)*) => {
        $crate::http::wire::answer! { @members $head {
            $($fields)*
            $(#[$meta])*
            $(#[schema($($bounds)+)])?
            $vis $member: $kind,
        } $($others)* }
    };
    (@members [$($head:tt)+] $fields:tt) => {
        #[derive(Debug, serde::Serialize, utoipa::ToSchema)]
        $($head)+ $fields
    };
}
pub(crate) use answer;
