//! All codes of answers, one enumeration for each family: faults of a request, faults of a file, reasons without an
//! answer, problem types, warnings, reasons for less confidence, and reasons why a cutter is not ranked. Each code is
//! declared with its name, its meaning and a remedy; `docs/codes.md` is generated from the declarations.

mod answer_code;
mod problem_code;
#[cfg(test)]
mod table;

pub(crate) use answer_code::{ConfidenceCode, NotRankedCode, WarningCode};
pub(crate) use problem_code::{FaultCode, FileFaultCode, NoAnswerCode, ProblemFigure, ProblemType, RequestFault, ServiceProblem};

use axum::http::StatusCode;

/// A code's name, meaning, remedy and status.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Entry {
    /// The name on the wire, in kebab-case. It never changes.
    pub(crate) name: &'static str,
    /// The meaning; for a problem type, the title.
    pub(crate) meaning: &'static str,
    /// What a caller can do.
    pub(crate) remedy: &'static str,
    /// The HTTP status of a problem of this type; `None` if the code does not determine one.
    pub(crate) status: Option<StatusCode>,
}

/// A code of one family or of several.
pub(crate) trait Code: Copy + 'static {
    /// The code's name, meaning and remedy.
    fn entry(self) -> Entry;

    /// The names of all codes, each once.
    fn names() -> Vec<&'static str>;

    /// The name on the wire.
    fn name(self) -> &'static str {
        self.entry().name
    }
}

/// A family of codes.
pub(crate) trait CodeFamily: Code {
    /// All codes of the family.
    const ALL: &'static [Self];
}

/// Converts an enumeration of the domain to one on the wire: each variant to the one of the same name.
macro_rules! same_names {
    ($from:ident => $to:ident: $( $variant:ident ),+ $(,)?) => {
        impl From<$from> for $to {
            fn from(value: $from) -> Self {
                match value {
                    $( $from::$variant { .. } => Self::$variant, )+
                }
            }
        }
    };
}
pub(crate) use same_names;

/// Declares a family: for each code the variant, the name on the wire, the status of a problem of this type, the meaning
/// and the remedy. A family whose codes have the same status states it once, after its name. The status is `none` if the
/// code does not determine one.
macro_rules! codes {
    ($(#[doc = $about:literal])+ $family:ident: $status:ident { $( $variant:ident = $name:literal: $meaning:literal, $remedy:literal; )+ }) => {
        $crate::http::codes::codes! { $(#[doc = $about])+ $family { $( $variant = $name $status: $meaning, $remedy; )+ } }
    };
    ($(#[doc = $about:literal])+ $family:ident { $( $variant:ident = $name:literal $status:ident: $meaning:literal, $remedy:literal; )+ }) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum $family {
            $( #[doc = $meaning] $variant, )+
        }

        impl $crate::http::codes::CodeFamily for $family {
            const ALL: &'static [Self] = &[$( Self::$variant ),+];
        }

        impl $crate::http::codes::Code for $family {
            fn entry(self) -> $crate::http::codes::Entry {
                match self {
                    $( Self::$variant => $crate::http::codes::Entry {
                        name: $name, meaning: $meaning, remedy: $remedy, status: $crate::http::codes::codes!(@status $status),
                    }, )+
                }
            }

            fn names() -> Vec<&'static str> {
                vec![$( $name ),+]
            }
        }

        $crate::http::codes::on_the_wire! { $family, concat!($( $about ),+) }
    };
    (@status none) => { None };
    (@status $status:ident) => { Some(axum::http::StatusCode::$status) };
}
use codes;

/// Declares an enumeration that joins several families.
macro_rules! joined_codes {
    ($(#[doc = $about:literal])+ $set:ident { $( $family:ident ),+ $(,)? }) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum $set {
            $( #[doc = concat!("A code of the family `", stringify!($family), "`.")] $family($family), )+
        }

        impl $crate::http::codes::Code for $set {
            fn entry(self) -> $crate::http::codes::Entry {
                match self {
                    $( Self::$family(code) => $crate::http::codes::Code::entry(code), )+
                }
            }

            fn names() -> Vec<&'static str> {
                let mut names = Vec::new();
                for name in [$( <$family as $crate::http::codes::Code>::names() ),+].concat() {
                    if !names.contains(&name) {
                        names.push(name);
                    }
                }
                names
            }
        }

        $(
            impl From<$family> for $set {
                fn from(code: $family) -> Self {
                    Self::$family(code)
                }
            }
        )+

        $crate::http::codes::on_the_wire! { $set, concat!($( $about ),+) }
    };
}
use joined_codes;

/// Writes a code as its name, and describes the family as an enumeration in the OpenAPI document.
macro_rules! on_the_wire {
    ($codes:ident, $about:expr) => {
        impl serde::Serialize for $codes {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str($crate::http::codes::Code::name(*self))
            }
        }

        impl utoipa::PartialSchema for $codes {
            fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::Schema> {
                utoipa::openapi::ObjectBuilder::new()
                    .schema_type(utoipa::openapi::Type::String)
                    .description(Some($about.trim()))
                    .enum_values(Some(<Self as $crate::http::codes::Code>::names()))
                    .into()
            }
        }

        impl utoipa::ToSchema for $codes {}
    };
}
use on_the_wire;
