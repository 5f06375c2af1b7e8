//! All codes of answers, one enumeration for each family: faults of a request, faults of a file, reasons without an
//! answer, problem types, warnings, reasons for less confidence, and reasons why a cutter is not ranked. Each code is
//! declared with its name, its meaning and a remedy; `docs/codes.md` is generated from the declarations.

mod confidence;
mod fault;
mod file;
mod no_answer;
mod not_ranked;
mod problem;
#[cfg(test)]
mod table;
mod warning;

pub(crate) use confidence::ConfidenceCode;
pub(crate) use fault::{FaultCode, RequestFault};
pub(crate) use file::FileFault;
pub(crate) use no_answer::{NoAnswerCode, ProblemFigure};
pub(crate) use not_ranked::NotRankedCode;
pub(crate) use problem::{ProblemType, ServiceProblem};
pub(crate) use warning::WarningCode;

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
    /// The HTTP status of a problem of this type; `None` if something else determines it.
    pub(crate) status: Option<StatusCode>,
}

/// A family of codes.
pub(crate) trait Code: Copy + 'static {
    /// All codes of the family.
    const ALL: &'static [Self];

    /// The code's name, meaning and remedy.
    fn entry(self) -> Entry;

    /// The name on the wire.
    fn name(self) -> &'static str {
        self.entry().name
    }

    /// The names of all codes of the family.
    fn names() -> Vec<&'static str> {
        Self::ALL.iter().map(|code| code.name()).collect()
    }
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

/// Declares a family: for each code the variant, the name on the wire, the status of a problem of this type if it has one
/// of its own, the meaning and the remedy.
macro_rules! codes {
    ($(#[doc = $about:literal])+ $family:ident { $( $variant:ident = $name:literal $($status:ident)?: $meaning:literal, $remedy:literal; )+ }) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum $family {
            $( #[doc = $meaning] $variant, )+
        }

        impl $crate::http::codes::Code for $family {
            const ALL: &'static [Self] = &[$( Self::$variant ),+];

            fn entry(self) -> $crate::http::codes::Entry {
                match self {
                    $( Self::$variant => $crate::http::codes::Entry {
                        name: $name, meaning: $meaning, remedy: $remedy, status: $crate::http::codes::codes!(@status $($status)?),
                    }, )+
                }
            }
        }

        $crate::http::codes::on_the_wire! { $family, concat!($( $about ),+) }
    };
    (@status) => { None };
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

        impl $set {
            /// The code's name, meaning and remedy.
            pub(crate) fn entry(self) -> $crate::http::codes::Entry {
                match self {
                    $( Self::$family(code) => $crate::http::codes::Code::entry(code), )+
                }
            }

            pub(crate) fn name(self) -> &'static str {
                self.entry().name
            }

            /// The names of all codes of the set, each once.
            pub(crate) fn names() -> Vec<&'static str> {
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
                #[allow(unused_imports, reason = "a joined set has the method itself")]
                use $crate::http::codes::Code as _;
                serializer.serialize_str(self.name())
            }
        }

        impl utoipa::PartialSchema for $codes {
            fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::Schema> {
                #[allow(unused_imports, reason = "a joined set has the method itself")]
                use $crate::http::codes::Code as _;
                utoipa::openapi::ObjectBuilder::new()
                    .schema_type(utoipa::openapi::Type::String)
                    .description(Some($about.trim()))
                    .enum_values(Some(Self::names()))
                    .into()
            }
        }

        impl utoipa::ToSchema for $codes {}
    };
}
use on_the_wire;
