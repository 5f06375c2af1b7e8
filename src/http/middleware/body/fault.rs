//! The rules that a request's body can break while it is received, before it is parsed.

use std::fmt;
use std::time::Duration;

use axum::response::{IntoResponse, Response};

use crate::http::codes::ServiceProblem;
use crate::http::problem::Problem;
use crate::memory_budget::BudgetExceeded;

/// The rule that a body broke.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum BodyFault {
    /// The body has more bytes than are accepted, counted after decompression.
    TooLarge {
        /// The number of bytes that are accepted.
        max_bytes: u64,
    },
    /// No data arrived for too long.
    Stalled {
        /// The longest pause that is accepted.
        longest: Duration,
    },
    /// The average rate was too low.
    TooSlow {
        /// The lowest average rate that is accepted.
        min_bytes_s: u64,
    },
    /// The body arrived in too many small chunks.
    Fragmented,
    /// The memory budget has no room for the body.
    Memory(BudgetExceeded),
    /// The body could not be read or decompressed.
    Unreadable(String),
}

impl fmt::Display for BodyFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLarge { max_bytes } => write!(f, "the body, counted decompressed, is larger than {max_bytes} bytes"),
            Self::Stalled { longest } => write!(f, "no data of the body arrived for {} s", longest.as_secs()),
            Self::TooSlow { min_bytes_s } => write!(f, "the body arrived at less than {min_bytes_s} bytes a second"),
            Self::Fragmented => write!(f, "the body arrived in too many chunks of a few bytes"),
            Self::Memory(exceeded) => write!(f, "{exceeded}"),
            Self::Unreadable(cause) => write!(f, "the body could not be read: {cause}"),
        }
    }
}

impl std::error::Error for BodyFault {}

impl IntoResponse for BodyFault {
    fn into_response(self) -> Response {
        let kind = match self {
            Self::TooLarge { .. } => ServiceProblem::TooLarge,
            Self::Stalled { .. } | Self::TooSlow { .. } => ServiceProblem::Timeout,
            Self::Unreadable(_) | Self::Fragmented => ServiceProblem::UnreadableBody,
            Self::Memory(exceeded) => return Problem::from(exceeded).into_response(),
        };
        Problem::new(kind, self.to_string()).into_response()
    }
}
